"""Motions through the client and the shell: handed in, planned by real workers, fetched."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import pytest
from tests.motion.captures import bow, bvh
from tests.motion.robots import sample_folder

from exogauge.cli import main
from exogauge.client import ClientProblem

pytestmark = pytest.mark.slow


@pytest.fixture
def capture(tmp_path: Path) -> Path:
    path = tmp_path / "bow.bvh"
    path.write_bytes(bvh(bow()))
    return path


def test_a_capture_is_planned_for_a_robot_and_fetched(client, service, capture, tmp_path, capsys):
    robot = sample_folder(tmp_path / "robot")
    out = tmp_path / "bow.npz"
    asked = ["motion", "retarget", str(capture), "--robot", str(robot), "--slow", "1.5", "--format", "mujoco"]
    assert main([*asked, "--out", str(out), "--json", "--server", service.url]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["broken"] == []
    with zipfile.ZipFile(tmp_path / "bow.zip") as archive:
        assert {Path(name).suffix for name in archive.namelist()} == {".npz", ".json"}
    plan = client.plan(said["plan"])
    assert plan.found["seconds"] == pytest.approx(2.0 + 3.0 + 2.0)
    table = client.export_plan(plan, "csv", tmp_path / "bow.csv").read_text()
    assert table.startswith("t,q.")
    job = client.wait(client.fit_motion(plan.motion_id), progress=False)
    assert (job.kind, job.motion_id) == ("human_fit", plan.motion_id)
    with pytest.raises(ClientProblem, match="plans were made of it"):
        client.delete_by_id("motions", plan.motion_id)
    client.delete(plan)
    client.delete_by_id("motions", plan.motion_id)
    assert [each.id for each in client.plans()] == []
