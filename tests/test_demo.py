"""The demonstration's way from a person's motion to one that the sample plays."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.motion.captures import bow, bvh

from exogauge.client import Client
from exogauge.demo import SEED, Captured, plan_captured, running_server
from exogauge.settings import Settings
from exogauge.synthetic import refuse_fall
from exogauge.synthetic.played import read_motions

pytestmark = [pytest.mark.slow, pytest.mark.thorough]


def test_a_capture_becomes_a_table_that_the_sample_plays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a bow.bvh").write_bytes(bvh(bow()))
    monkeypatch.setenv("EXOGAUGE_DATA_DIR", str(tmp_path / "data"))
    with running_server(Settings()) as url, Client(url) as client:
        table = plan_captured(client, Captured(tmp_path / "a bow.bvh", slow=1.0), tmp_path / "sample")
        (plan,) = client.plans()
        found = client.plan(plan).found
    assert found is not None
    assert found["margins"]["pressure_inside_m"] >= 0.015
    refuse_fall(table, SEED)  # it stands in every run that a sample holds
    (motion,) = read_motions([table])
    assert motion.name == "a_bow"
    assert motion.source == table.read_bytes()
