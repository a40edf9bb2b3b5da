"""`exogauge payload live`: a log as if live, and lines from elsewhere."""

from __future__ import annotations

import io
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.csv as pacsv
import pyarrow.parquet as pq
import pytest
import yaml
from numpy.typing import NDArray
from tests.payload.conftest import generator

from exogauge.cli import main
from exogauge.errors import BadStudy
from exogauge.payload.contract import PayloadFile
from exogauge.payload.live import Start
from exogauge.payload.live_input import Arrivals, Columns
from exogauge.payload.live_lines import Stream
from exogauge.payload.live_start import open_start
from exogauge.synthetic.payload import write_payload

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def sample(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("payload") / "sample"
    write_payload(out, 3)
    return out


@pytest.fixture(scope="module")
def begun(sample: Path) -> tuple[PayloadFile, Start]:
    return open_start(sample)


def rows_of(folder: Path, log: str, file: PayloadFile, start: Start) -> Array:
    table = pq.read_table(folder / "logs" / f"{log}.parquet")
    names = Columns(file, start.pose.chain).names
    return np.column_stack([table[name].to_numpy() for name in names])


def said(capsys: pytest.CaptureFixture[str]) -> list[dict[str, Any]]:
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]


@pytest.mark.slow
def test_a_stream_begins_with_what_the_logs_say(begun: tuple[PayloadFile, Start], sample: Path) -> None:
    truth = json.loads((sample / "truth.json").read_text())
    start = begun[1]
    assert start.sign == -1
    assert start.prior.value[0] == pytest.approx(truth["mass"], abs=0.01)
    assert start.prior.value[4] == pytest.approx(truth["inertia_about_sensor"][0][0], abs=0.01)
    assert np.all(start.pose.density[3:] > 0.1)


@pytest.mark.slow
def test_a_log_is_followed_and_its_pushes_are_told_with_their_times(
    sample: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log, out = "contact.parquet", tmp_path / "wrench.csv"
    assert main(["payload", "live", str(sample), "--log", log, "--out", str(out)]) == 0
    told = capsys.readouterr().out
    contacts = [line for line in told.splitlines() if line.startswith("contact ")]
    assert len(contacts) == len(generator.PUSHES)
    for line, (begin, length, _, _) in zip(contacts, generator.PUSHES, strict=True):
        first, last = float(line.split()[1]), float(line.split()[3])
        assert begin < first < begin + 0.1
        assert begin + length - 0.1 < last < begin + length
    assert "converged" in told
    assert "received 2500, taken 2500" in told
    written = pacsv.read_csv(out)
    assert written.num_rows == 2500
    assert np.sum(written["alarm"].to_numpy()) > 200


@pytest.mark.slow
@pytest.mark.parametrize("form", ["object", "array", "csv", "csv with names"])
def test_lines_of_every_form_say_what_the_log_says(
    sample: Path, begun: tuple[PayloadFile, Start], form: str, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    file, start = begun
    names, rows = Columns(file, start.pose.chain).names, rows_of(sample, "slow", file, start)[:200]
    turned = names[::-1]
    lines = {
        "object": [json.dumps(dict(zip(names, row.tolist(), strict=True))) for row in rows],
        "array": [json.dumps(row.tolist()) for row in rows],
        "csv": [",".join(map(repr, row.tolist())) for row in rows],
        "csv with names": [",".join(turned), *(",".join(map(repr, row.tolist()[::-1])) for row in rows)],
    }[form]
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n".join(lines)))
    assert main(["payload", "live", str(sample), "--json"]) == 0
    found = np.concatenate([each["wrench"] for each in said(capsys) if each["type"] == "wrench"])
    stream = Stream(file, start, 250.0)
    told = [*stream.take(np.arange(len(rows)), rows), *stream.end()]
    assert found == pytest.approx(np.concatenate([each["wrench"] for each in told if each["type"] == "wrench"]))


@pytest.mark.slow
def test_what_cannot_be_read_is_told_and_counted_and_the_rest_goes_on(
    sample: Path, begun: tuple[PayloadFile, Start], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file, start = begun
    names, rows = Columns(file, start.pose.chain).names, rows_of(sample, "slow", file, start)[:60]
    lines = [json.dumps(dict(zip(names, row.tolist(), strict=True))) for row in rows]
    lines[10] = "no sample at all"
    lines[20] = lines[20].replace('"fx"', '"f_x"')
    lines[30] = lines[30].replace(f'"fx": {rows[30, 7].item()!r}', '"fx": NaN')
    lines[40] = json.dumps(rows[40].tolist()[:-1])
    lines[50] = lines[49]
    lines[55] = lines[55].replace(f'"fy": {rows[55, 8].item()!r}', '"fy": 1e300')
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n".join(lines)))
    assert main(["payload", "live", str(sample), "--json"]) == 1
    found = said(capsys)
    faults = [each for each in found if each["type"] == "error"]
    assert [each["rule"] for each in faults] == ["no_sample", "missing_column", "not_finite", "no_sample", "not_finite"]
    assert [each["row"] for each in faults] == [11, 21, 31, 41, 56]
    assert faults[2]["column"] == "fx"
    assert sum(len(each["t"]) for each in found if each["type"] == "wrench") == 54
    counts = [each for each in found if each["type"] == "payload"][-1]["counts"]
    assert (counts["refused"], counts["out_of_order"]) == (5, 1)


@pytest.mark.slow
@pytest.mark.parametrize("count", [0, 1, 2, 60])
def test_a_stream_of_which_too_few_samples_count_says_so(
    count: int, sample: Path, begun: tuple[PayloadFile, Start], monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    """It ended without a word; so did one whose stamps all are the same."""
    file, start = begun
    rows = rows_of(sample, "slow", file, start)[:count]
    rows[:, 0] = rows[:1, 0]
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n".join(json.dumps(row.tolist()) for row in rows)))
    assert main(["payload", "live", str(sample)]) == 1
    assert f"of {count} samples {min(count, 1)} count" in capsys.readouterr().out


@pytest.mark.slow
def test_a_column_that_a_log_lacks_is_named(sample: Path, tmp_path: Path) -> None:
    (tmp_path / "short.csv").write_text("t,q.a1,fx\n0,1,2\n0.004,1,2\n")
    assert main(["payload", "live", str(sample), "--log", str(tmp_path / "short.csv")]) == 2


def test_a_log_that_is_not_there_is_named_with_advice(sample: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["payload", "live", str(sample), "--log", "nowhere.csv"]) == 2
    assert "nowhere.csv" in capsys.readouterr().err


def test_samples_are_counted_by_number_and_by_time() -> None:
    arrivals = Arrivals()

    def admit(*numbers: int, clock: float | None = None) -> list[bool]:
        return arrivals.admit(np.array(numbers), np.array(numbers) / 250.0, clock).tolist()

    assert admit(0, 1, 2) == [True, True, True]
    assert admit(5, 6) == [True, True]
    assert arrivals.counts.missing == 2
    assert admit(6, 5) == [False, False]
    assert admit(3) == [False]
    counts = arrivals.counts
    assert (counts.doubled, counts.out_of_order, counts.missing, counts.taken) == (2, 1, 1, 5)
    assert admit(7, clock=100.0) == [True]
    assert admit(8, clock=100.05) == [True]
    assert counts.late == 0
    assert admit(9, clock=100.2) == [True]
    assert counts.late == 1
    assert arrivals.admit(np.array([10]), np.array([0.0])).tolist() == [False]
    assert counts.out_of_order == 2


def test_a_gap_is_said_and_survived(sample: Path, begun: tuple[PayloadFile, Start]) -> None:
    file, start = begun
    rows = rows_of(sample, "fast", file, start)
    numbers = np.arange(len(rows))
    keep = (numbers < 1000) | (numbers >= 1200) & (numbers % 50 != 0)
    stream = Stream(file, start, 250.0)
    found = [*stream.take(numbers[keep], rows[keep]), *stream.end()]
    wrenches = [each for each in found if each["type"] == "wrench"]
    seq, settled, alarm = (np.concatenate([each[key] for each in wrenches]) for key in ("seq", "settled", "alarm"))
    assert np.array_equal(seq, numbers[keep])
    assert not settled[(seq >= 1200) & (seq < 1220)].any()
    assert settled[(seq >= 1300) & (seq < 2400)].all()
    assert not alarm.any()
    assert stream.arrivals.counts.missing == np.sum(~keep)


def test_units_and_axes_of_payload_yaml_hold_live(sample: Path, begun: tuple[PayloadFile, Start]) -> None:
    file, start = begun
    rows = rows_of(sample, "slow", file, start)[:50]
    plain = yaml.safe_load((sample / "payload.yaml").read_text())
    plain["time"] = {"column": "t", "unit": "ms"}
    plain["pose"]["angle_unit"] = "deg"
    plain["sensor"] |= {"axes": "base", "force_unit": "kN", "moment_unit": "Nmm"}
    other = Columns(PayloadFile.model_validate(plain, strict=False), start.pose.chain)
    R = start.pose.chain.rotations(rows[:, 1:7])
    turned = np.einsum("tij,taj->tai", R, rows[:, 7:].reshape(-1, 2, 3)).reshape(-1, 6)
    there = np.column_stack([1e3 * rows[:, 0], np.degrees(rows[:, 1:7]), 1e-3 * turned[:, :3], 1e3 * turned[:, 3:]])
    for found, told in zip(other.read(there), Columns(file, start.pose.chain).read(rows), strict=True):
        assert found == pytest.approx(told, rel=1e-9, abs=1e-9)


def test_a_pose_without_a_position_is_refused_live(sample: Path, tmp_path: Path) -> None:
    plain = yaml.safe_load((sample / "payload.yaml").read_text())
    plain["pose"] = {"rotation": [f"r{i}{j}" for i in "123" for j in "123"], "noise_rad": 1e-5}
    plain["logs"] = []
    (tmp_path / "payload.yaml").write_text(yaml.safe_dump(plain))
    with pytest.raises(BadStudy, match="live"):
        open_start(tmp_path)
