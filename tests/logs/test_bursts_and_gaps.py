"""Clocks with bursts and gaps: the first are evened out, the second cut, and neither is taken for the other."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from exogauge.errors import BadLog
from exogauge.logs.bursts import evened
from exogauge.logs.doctor import examine
from exogauge.logs.model import Array, Log
from exogauge.logs.reading import read_log
from exogauge.logs.segments import segments

RATE = 200.0
T = 4000


def even(samples: int = T) -> Array:
    return np.arange(samples) / RATE


def in_bursts(true: Array, size: int, rng: np.random.Generator, identical: bool = True) -> Array:
    """Each message arrives with the last one of its burst, some of them a little later."""
    edges = [0, *sorted(rng.choice(np.arange(1, true.size), true.size // size, replace=False)), true.size]
    late = true.copy()
    for a, b in pairwise(edges):
        late[a:b] = true[b - 1] + (0.0 if identical else 1e-5 * np.arange(b - a))
    return late


@pytest.mark.parametrize("identical", [True, False])
@pytest.mark.parametrize("size", [2, 5, 12])
def test_bursts_give_back_the_clock_beneath_them(size: int, identical: bool) -> None:
    true = even()
    found, note = evened(in_bursts(true, size, np.random.default_rng(size), identical))
    assert note is not None
    assert "200 Hz" in note.detail
    assert np.max(np.abs(found - true)) < 0.5 / RATE
    assert np.max(np.abs(np.diff(found) * RATE - 1.0)) < 1e-3


def test_a_gap_among_bursts_stays_a_gap_where_it_was() -> None:
    true = even()
    true[2500:] += 0.8
    found, note = evened(in_bursts(true, 4, np.random.default_rng(1)))
    assert note is not None
    (place,) = np.flatnonzero(np.diff(found) > 5.0 / RATE)
    assert abs(place - 2499) <= 4  # the burst that the gap falls into may belong to either side
    assert abs(found[-1] - true[-1]) < 0.5 / RATE


def test_whole_nanoseconds_stay_whole() -> None:
    stamps = 1_700_000_000_000_000_000 + np.rint(1e9 * in_bursts(even(), 5, np.random.default_rng(2))).astype(np.int64)
    found, note = evened(stamps, 1e-9)
    assert note is not None
    assert "200 Hz" in note.detail
    assert found.dtype == np.int64
    assert np.max(np.abs((found - stamps[0]) * 1e-9 - even())) < 0.05


@pytest.mark.parametrize("kind", ["even", "jitter", "gap", "doubled row", "goes back", "event driven"])
def test_what_is_no_burst_is_left_as_it_is(kind: str) -> None:
    rng = np.random.default_rng(3)
    time = even()
    if kind == "jitter":
        time = time + rng.normal(scale=0.15 / RATE, size=T)
    elif kind == "gap":
        time[700:] += 0.4
    elif kind == "doubled row":
        time = np.insert(time, 900, time[900])
    elif kind == "goes back":
        time[2000:] -= 5.0
    elif kind == "event driven":
        time = np.cumsum(rng.exponential(1.0 / RATE, T)) + 0.2 * np.cumsum(rng.normal(size=T)).clip(0)
        time = np.maximum.accumulate(time)
    found, note = evened(time)
    assert note is None
    assert found is time


def test_a_log_that_arrived_in_bursts_is_read_and_the_doctor_says_what_was_done(tmp_path: Path) -> None:
    time = in_bursts(even(), 5, np.random.default_rng(4))
    rows = "".join(f"{t!r},{float(np.sin(t))!r}\n" for t in time.tolist())
    (tmp_path / "log.csv").write_text("t,q.a\n" + rows)
    log = read_log(tmp_path / "log.csv", "log")
    assert np.ptp(np.diff(log.time)) < 1e-9
    assert "bursts_evened" in {finding.rule for finding in examine(log)}


def recording(*missing: tuple[int, int], name: str = "walk") -> Log:
    kept = np.ones(T, dtype=bool)
    for start, stop in missing:
        kept[start:stop] = False
    time = even()[kept]
    return Log(name, time, {"q.a": np.sin(3.0 * time)})


def test_a_recording_is_cut_at_its_gaps_and_each_part_named_by_its_rows() -> None:
    whole = recording((1000, 1100), (2600, 2700))
    parts = segments(whole, first=50)
    assert [part.name for part in parts] == ["walk_50_1050", "walk_1050_2550", "walk_2550_3850"]
    assert {part.recording for part in parts} == {"walk"}
    assert np.array_equal(np.concatenate([part.time for part in parts]), whole.time)
    assert np.array_equal(np.concatenate([part.channels["q.a"] for part in parts]), whole.channels["q.a"])
    (note,) = [note for part in parts for note in part.notes]
    assert "2 gaps" in note.detail
    assert "3 logs" in note.detail


def test_a_part_too_short_to_use_is_left_out_and_told() -> None:
    parts = segments(recording((1000, 1100), (1300, 1400)))
    assert [part.name for part in parts] == ["walk_0_1000", "walk_1200_3800"]
    assert "1000-1200" in parts[0].notes[0].detail


def test_single_lost_samples_are_bridged_not_cut() -> None:
    (log,) = segments(recording((500, 501), (2000, 2003)))
    assert log.name == "walk"
    assert "4 samples are missing at 2 places" in log.notes[0].detail
    assert np.max(np.abs(log.time - even())) < 1e-9
    assert np.max(np.abs(log.channels["q.a"] - np.sin(3.0 * even()))) < 1e-6


def test_late_stamps_are_not_called_lost_samples() -> None:
    time = even()
    time[[300, 900]] += 0.8 / RATE
    (log,) = segments(Log("walk", time, {"q.a": np.sin(3.0 * time)}))
    assert "late at 2 places" in log.notes[0].detail
    assert np.max(np.abs(log.channels["q.a"] - np.sin(3.0 * log.time))) < 1e-6


def test_a_log_without_gaps_is_itself() -> None:
    log = recording()
    assert segments(log)[0] is log


def test_nothing_but_gaps_is_refused_with_the_longest() -> None:
    with pytest.raises(BadLog, match="leave no stretch of 2 s"):
        segments(recording(*((k, k + 20) for k in range(200, T, 220))))


def test_where_a_sensor_is_dead_a_log_is_cut_and_that_time_left_out() -> None:
    whole = recording((2000, 2040))
    dead = {"ft.foot": [slice(900, 1300)], "i.b": [slice(1250, 1400), slice(3400, 3460)]}
    parts = segments(whole, first=50, dead=dead)
    assert [part.name for part in parts] == ["walk_50_950", "walk_1450_2050", "walk_2050_3450", "walk_3510_4010"]
    for part, rows in zip(parts, [(0, 900), (1400, 2000), (2000, 3400), (3460, 3960)], strict=True):
        np.testing.assert_array_equal(part.time, whole.time[slice(*rows)])
        np.testing.assert_array_equal(part.channels["q.a"], whole.channels["q.a"][slice(*rows)])
    (note,) = parts[0].notes
    assert note.rule == "cut_at_gaps"
    for said in ("1 gap", "ft.foot", "i.b", "cut there into 4 logs"):
        assert said in note.detail


def test_where_a_dead_sensor_leaves_nothing_the_log_stays_whole() -> None:
    (log,) = segments(recording(), dead={"acc.x": [slice(k, k + 200) for k in range(300, T, 500)]})
    assert log.samples == T
    assert not log.notes
