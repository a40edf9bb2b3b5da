"""A log of a planned motion is known again, and how far the robot strayed is told."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from exogauge.errors import BadLog, BadStudy
from exogauge.studies.evaluate import evaluate, withdraw
from exogauge.studies.results.plan_results import FOLLOWED

pytestmark = pytest.mark.slow

JOINTS = ("torso_yaw", "torso_pitch", "r_elbow")
BEGINS, SECONDS = 0.3, 1.5


def table(share: float = 1.0, rate: float = 1.0) -> bytes:
    """What the small robot's logs hold from `BEGINS` on, but for torso_pitch around 1 s. rate: of another motion."""
    t = np.arange(round(SECONDS * 200) + 1) / 200.0
    q = 0.1 * np.sin(rate * (t + BEGINS)[:, None] + np.arange(3))
    q[:, 1] -= 0.01 * np.exp(-(((t + BEGINS - 1.0) / 0.05) ** 2))
    head = ",".join(["t", *(f"q.{name}" for name in JOINTS)])
    return "\n".join([head, *(",".join(f"{x:.6f}" for x in row) for row in np.column_stack([t, share * q]))]).encode()


OTHER = table(rate=4.0)


@pytest.fixture
def played(folder: Path) -> Path:
    """Both logs are of the plan."""
    (folder / "plans").mkdir()
    (folder / "plans" / "any name.csv").write_bytes(table())
    return folder


def plans_of(folder: Path, out: Path) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    evaluate(folder, out, lambda *_: None)
    content = json.loads((out / "results.json").read_text())
    return content, content["plans"]


def name_plans(folder: Path, *files: str) -> None:
    path = folder / "study.yaml"
    path.write_text(path.read_text() + f"plans: {json.dumps(list(files))}\n")


def lay(folder: Path, **tables: bytes) -> None:
    (folder / ".plans").mkdir()
    for name, content in tables.items():
        (folder / ".plans" / f"{name}.csv").write_bytes(content)
    listed = {f"{name}.csv": [f"id of {name}", name] for name in tables}
    (folder / ".plans" / "plans.json").write_text(json.dumps(listed))


def test_a_named_plan_is_found_in_its_log_with_how_far_the_robot_strayed(played: Path, tmp_path: Path) -> None:
    name_plans(played, "plans/any name.csv")
    content, (plan,) = plans_of(played, tmp_path / "out")
    assert (plan["plan"], plan["file"], plan["plan_id"]) == ("any name", "plans/any name.csv", None)
    assert plan["sha256"] == hashlib.sha256(table()).hexdigest()
    assert [each["log"] for each in plan["logs"]] == ["id_1", "val_1"]
    log = plan["logs"][1]
    assert (log["state"], log["or_plans"]) == ("follows", [])
    assert log["begins_s"] == pytest.approx(BEGINS, abs=5e-3)
    worst = log["joints"][0]
    assert (worst["joint"], worst["unit"]) == ("torso_pitch", "rad")
    assert worst["most"] == pytest.approx(0.01, rel=0.1)
    assert worst["at_s"] == pytest.approx(1.0, abs=0.02)
    told = r"2 logs follow any name; farthest from it is torso_pitch, by 0\.5\d° at 1\.00 s of id_1"
    assert re.match(told, plan["sentence"])
    report = (tmp_path / "out" / "report.html").read_text()
    assert plan["sentence"] in report
    assert "How far the robot strayed" in report
    assert content["files"]["followed_plan_1"] == "followed_plan_1.csv"
    assert (tmp_path / "out" / "followed_plan_1.csv").read_bytes() == table()
    withdraw(tmp_path / "out")
    assert not list((tmp_path / "out").glob(FOLLOWED))


def test_a_plan_of_the_service_is_found_by_content_and_others_are_not_told(played: Path, tmp_path: Path) -> None:
    head, *rows = table().decode().splitlines()  # which foot stands tells nothing of what was followed
    stepped = "\n".join([f"{head},stands.l_foot", *(f"{row},{k % 2}" for k, row in enumerate(rows))]).encode()
    lay(played, wrong=OTHER, right=stepped, broken=b"t,q.torso_yaw,broken\n0,0,1\n")
    _, (plan,) = plans_of(played, tmp_path / "out")
    assert (plan["plan"], plan["plan_id"], plan["file"]) == ("right", "id of right", None)
    assert [(log["log"], log["state"]) for log in plan["logs"]] == [("id_1", "follows"), ("val_1", "follows")]


def test_a_named_plan_that_no_log_is_of_is_said(played: Path, tmp_path: Path) -> None:
    (played / "plans" / "other.csv").write_bytes(OTHER)
    name_plans(played, "plans/other.csv")
    content, (plan,) = plans_of(played, tmp_path / "out")
    assert (plan["logs"], plan["sentence"]) == ([], "No log is of other.")
    assert "followed_plan_1" not in content["files"]


def test_plans_too_much_alike_are_left_undecided(played: Path, tmp_path: Path) -> None:
    name_plans(played, "plans/any name.csv")
    lay(played, nearly=table(share=0.995), same=table())
    content, plans = plans_of(played, tmp_path / "out")
    assert [plan["plan"] for plan in plans] == ["any name", "nearly"], "the same content is one plan"
    assert plans[0]["plan_id"] == "id of same"
    assert {log["state"] for plan in plans for log in plan["logs"]} == {"undecided"}
    assert "too much alike" in plans[0]["sentence"]
    assert "followed_plan_1" not in content["files"]


def test_a_plan_that_cannot_be_read_is_refused_with_its_file(played: Path, tmp_path: Path) -> None:
    name_plans(played, "plans/any name.csv", "plans/none.csv")
    with pytest.raises(BadStudy) as missing:
        evaluate(played, tmp_path / "out", lambda *_: None)
    assert (missing.value.faults[0].column, missing.value.faults[0].value) == ("plans.1", "plans/none.csv")
    (played / "plans" / "none.csv").write_text("t,q.torso_yaw\n0,0\n0.1,x\n")
    with pytest.raises(BadLog) as unreadable:
        evaluate(played, tmp_path / "out", lambda *_: None)
    assert unreadable.value.faults[0].file == "plans/none.csv"
