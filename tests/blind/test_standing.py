"""Cases of a robot on two feet."""

from __future__ import annotations

from pathlib import Path

import pyarrow.parquet as pq
import pytest
import yaml

from exogauge.blind.answers import read_answers
from exogauge.blind.generator.foot_faults import KINDS
from exogauge.blind.generator.make import VISIBLE, make

pytest.importorskip("mujoco")
pytestmark = pytest.mark.slow


def test_a_case_hides_what_was_asked_for_and_says_nothing_of_it(tmp_path: Path) -> None:
    out = tmp_path / "two"
    make(out, 3, 2, robots="humanoid", effects=("ft_gain", "nothing"))
    first, second = read_answers(out)["cases"]
    assert [each["effect"] for each in first["effects"]] == ["ft_gain"]
    assert first["effects"][0]["ratio"] >= VISIBLE
    assert second["effects"] == []
    study = yaml.safe_load((out / "case_0001" / "study.yaml").read_text(encoding="utf-8"))
    assert "SYNTHETIC" in study["name"]
    assert {entry["role"] for entry in study["logs"]} == {"identification", "validation"}
    assert "ft.l_foot.fz" in pq.read_schema(out / "case_0001" / study["logs"][0]["file"]).names
    for path in (out / "case_0001").rglob("*"):
        assert not path.is_file() or not [name for name in KINDS if name.encode() in path.read_bytes()], path
