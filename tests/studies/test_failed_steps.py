"""What cannot be evaluated is refused and leaves no result; a later step that fails leaves what was found before."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from exogauge.cli import main
from exogauge.errors import BadInput, BadLog, Cancelled, NotIdentifiable
from exogauge.studies import evaluate as steps
from exogauge.studies.results.failed_step import FailedStep, keeping

Rewrite = Callable[[str, str, str], Path]


def failing(error: Exception) -> Callable[..., Any]:
    def fail(*_: Any, **__: Any) -> Any:
        raise error

    return fail


def restamped(folder: Path, step_s: float, rows: int | None = None) -> None:
    """Both logs with another clock."""
    for log in (folder / "logs").glob("*.parquet"):
        table = pq.read_table(log)[:rows]
        t = pa.array(np.arange(table.num_rows) * step_s)
        pq.write_table(table.set_column(table.column_names.index("t"), "t", t), log)


@pytest.mark.slow
@pytest.mark.parametrize(("error", "code"), [(ValueError("no such array"), 1), (NotIdentifiable("no answer"), 2)])
def test_the_identification_outlives_the_step_behind_it(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
    error: Exception, code: int,
) -> None:  # fmt: skip
    monkeypatch.setattr(steps, "find_missing_effects", failing(error))
    assert main(["run", str(folder), "--out", str(tmp_path / "out")]) == code
    assert str(error) in capsys.readouterr().err
    content = json.loads((tmp_path / "out" / "results.json").read_text())
    told = {each["step"]: each for each in content["steps"]}
    assert (told["identify"]["status"], told["discrepancy"]["status"]) == ("done", "failed")
    assert str(error) in told["discrepancy"]["reason"]
    assert content["identification"]["joints"]
    assert any(str(error) in warning for warning in content["warnings"])


def test_who_cancels_is_obeyed_inside_a_step_too() -> None:
    failed: list[FailedStep] = []
    with pytest.raises(Cancelled), keeping(failed, "support"):
        raise Cancelled("enough")
    assert not failed


@pytest.mark.slow
def test_a_robot_whose_torques_nobody_logs_is_searched_for_missing_effects_too(
    folder: Path, tmp_path: Path, rewrite: Rewrite
) -> None:
    robot = (folder / "robot.yaml").read_text()
    head, _ = robot.split("joints:\n", 1)
    names = ("torso_yaw", "torso_pitch", "r_elbow")
    (folder / "robot.yaml").write_text(
        head + "joints:\n" + "".join(f"  - {{name: {name}, actuation: none}}\n" for name in names)
    )
    assert not steps.evaluate(folder, tmp_path / "out", lambda *_: None)


def test_an_older_result_does_not_outlive_a_study_that_cannot_be_opened(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    for name in ("results.json", "report.html", "notes.txt"):
        (out / name).write_text("of an earlier run, or somebody's own")
    (folder / "study.yaml").write_text("version: 1\n")
    with pytest.raises(BadInput):
        steps.evaluate(folder, out, lambda *_: None)
    assert [each.name for each in out.iterdir()] == ["notes.txt"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("step_s", "rows", "rule"),
    [(5.0, None, "rate_impossible"), (120.0, None, "rate_impossible"), (5e-6, None, "rate_impossible"),
     (0.005, 40, "too_short")],
)  # fmt: skip
def test_a_clock_that_no_robot_has_is_refused_by_run_and_by_doctor(
    folder: Path, tmp_path: Path, step_s: float, rows: int | None, rule: str, capsys: pytest.CaptureFixture[str]
) -> None:
    restamped(folder, step_s, rows)
    with pytest.raises(BadLog) as refused:
        steps.evaluate(folder, tmp_path / "out", lambda *_: None)
    assert {(each.rule, each.column) for each in refused.value.faults} == {(rule, "t")}
    assert {each.file for each in refused.value.faults} == {"logs/id_1.parquet", "logs/val_1.parquet"}
    assert main(["doctor", str(folder)]) == 2
    assert "column 't'" in capsys.readouterr().err


def test_a_negative_torque_constant_is_refused_where_it_stands(folder: Path, rewrite: Rewrite) -> None:
    rewrite("robot.yaml", "prior: {k_T: 5.0, J_r: 0.3}", "prior: {k_T: -5.0, J_r: 0.3}")
    with pytest.raises(BadInput, match="turned in a mapping") as refused:
        steps.evaluate(folder, folder / "out", lambda *_: None)
    assert refused.value.faults[0].file == "robot.yaml"


def test_a_cut_off_that_a_log_is_too_slow_for_is_refused_before_anything_is_filtered(
    folder: Path, tmp_path: Path
) -> None:
    restamped(folder, 0.1)
    with pytest.raises(BadLog, match="too slow for the stated cut-off of 10 Hz"):
        steps.evaluate(folder, tmp_path / "out", lambda *_: None)
