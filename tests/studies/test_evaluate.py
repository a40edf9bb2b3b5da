"""A study on files becomes a folder of results, or nothing."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from exogauge.errors import BadLog, Cancelled
from exogauge.progress import Stage
from exogauge.studies.evaluate import evaluate
from exogauge.studies.intake.open import open_study
from exogauge.studies.series.recorded_motion import read_logged

Rewrite = Callable[[str, str, str], Path]


@pytest.mark.slow
def test_a_study_becomes_results_with_growing_progress(folder: Path, tmp_path: Path) -> None:
    seen: list[tuple[float, str, Stage]] = []
    evaluate(folder / "study.yaml", tmp_path / "out", lambda *said: seen.append(said))
    fractions = [fraction for fraction, _, _ in seen]
    assert fractions == sorted(fractions)
    assert (fractions[0], fractions[-1]) == (0.0, 1.0)
    assert list(dict.fromkeys(stage for *_, stage in seen)) == ["reading", "identify", "discrepancy", "writing"]
    assert "predicting val_1" in [phrase for _, phrase, _ in seen]
    content = json.loads((tmp_path / "out" / "results.json").read_text(), parse_constant=pytest.fail)
    assert content["steps"][0] == {"step": "identify", "status": "done"}
    assert {each["log"] for each in content["identification"]["validation"]} == {"id_1", "val_1"}
    for name in ("id_1", "val_1"):
        log = pq.read_table(folder / "logs" / f"{name}.parquet")
        series = pq.read_table(tmp_path / "out" / "series" / f"{name}.parquet")
        assert series["t"].to_pylist() == log["t"].to_pylist()
        assert "measured.base.my" in series.column_names
        assert "predicted_prior.tau.torso_pitch" in series.column_names
    assert not list((tmp_path / "out").glob(".unfinished*"))


@pytest.mark.slow
def test_a_recording_with_a_gap_is_evaluated_in_parts_named_by_their_rows(
    folder: Path, tmp_path: Path, log_writer: Callable[..., None]
) -> None:
    path = folder / "logs" / "val_1.parquet"
    with open_study(folder) as study:
        log_writer(path, study.robot, samples=1200)
    table = pq.read_table(path)
    pq.write_table(pa.concat_tables([table.slice(0, 500), table.slice(600)]), path)
    evaluate(folder, tmp_path / "out", lambda *_: None)
    content = json.loads((tmp_path / "out" / "results.json").read_text())
    parts = ["val_1_0_500", "val_1_500_1100"]
    logs = content["configuration"]["logs"]
    assert [(each["log"], each["samples"]) for each in logs] == [("id_1", 400), (parts[0], 500), (parts[1], 600)]
    assert {each["role"] for each in logs[1:]} == {"validation"}
    assert {each["log"] for each in content["identification"]["validation"]} == {"id_1", *parts}
    (told,) = [each for each in content["doctor"] if each["rule"] == "cut_at_gaps"]
    assert (told["log"], "'val_1'" in told["detail"]) == (parts[0], True)
    with open_study(folder) as study:
        shown = read_logged(study.bundle, parts[1])  # for the 3D view, which asks by the names of the results
    assert shown.log.samples == 600


@pytest.mark.slow
def test_a_cancelled_evaluation_leaves_no_result(folder: Path, tmp_path: Path) -> None:
    def stop(fraction: float, *_: str) -> None:
        if fraction > 0.1:
            raise Cancelled("enough")

    with pytest.raises(Cancelled):
        evaluate(folder, tmp_path / "out", stop)
    assert not (tmp_path / "out" / "results.json").exists()


@pytest.mark.slow
def test_a_bad_log_is_told_before_anything_is_written(folder: Path, tmp_path: Path) -> None:
    (folder / "logs" / "val_1.parquet").write_bytes(b"PAR1 no")
    with pytest.raises(BadLog) as caught:
        evaluate(folder, tmp_path / "out", lambda *_: None)
    assert caught.value.faults[0].file == "logs/val_1.parquet"
    assert not (tmp_path / "out").exists()
