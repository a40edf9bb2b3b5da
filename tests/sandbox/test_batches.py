"""Logs that share a child: the same logs as one by one, and a bad file among them takes none of the others along."""

from __future__ import annotations

import os
import signal
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from exogauge.errors import BadInput, BadLog, TooLarge, Unavailable
from exogauge.logs.mapping_rules import Clock, FileMapping, LogMapping, Source, Values
from exogauge.logs.model import Log
from exogauge.logs.parquet_table import write_log
from exogauge.logs.reading import read_log
from exogauge.sandbox import LogRequest, batches, parse_log, parse_logs, read_each
from exogauge.sandbox.limits import Limits
from exogauge.sandbox.readers import readers

pytestmark = pytest.mark.slow

Children = Callable[[], list[int]]


def request(path: Path) -> LogRequest:
    return LogRequest(path.stem, {path.name: path})


@pytest.fixture
def logs(tmp_path: Path) -> list[LogRequest]:
    """Four short logs, of 20, 21, 22 and 23 samples."""
    return [request(table(tmp_path / f"log_{k}.csv", 20 + k)) for k in range(4)]


def table(path: Path, samples: int) -> Path:
    path.write_text("t,q.a\n" + "".join(f"{k / 100},{k * samples}\n" for k in range(samples)))
    return path


def samples(found: Sequence[object]) -> list[object]:
    """Samples of each log, or the place and rule of the first fault."""
    return [(each.faults[0].file, each.faults[0].rule) if isinstance(each, BadInput) else each for each in found]


def read(requests: Sequence[LogRequest], limits: Limits | None = None) -> list[object]:
    return samples(read_each(requests, lambda log: log.samples, limits))


def test_logs_read_together_equal_logs_read_alone_and_keep_their_order(tmp_path: Path, logs: list[LogRequest]) -> None:
    motor = tmp_path / "motor.csv"
    motor.write_text("p1\n" + "".join(f"{k}\n" for k in range(40)))
    rules = (Values(Source(("p1",)), ("q.a",), "rad", side="motor"),)
    mapping = LogMapping((FileMapping("motor.csv", Clock(rate_hz=10.0), rules),))
    gears = np.array([[2.0]])
    parquet = tmp_path / "log.parquet"
    write_log(Log("log", np.arange(30.0), {"q.b": np.sqrt(np.arange(30.0))}), parquet)
    one, two = ((k, k + 15) for k in (0, 5))
    mixed = [
        LogRequest("second half", {"motor.csv": motor}, mapping, ("a",), gears, (20, 40)),
        *logs,
        request(parquet),
        LogRequest("one", logs[0].paths, rows=one),
        LogRequest("two", logs[0].paths, rows=two),
        *reversed(logs),
    ]
    together = parse_logs(mixed)
    assert [log.name for log in together] == [each.name for each in mixed]
    for log, each in zip(together, mixed, strict=True):
        (path,) = each.paths.values()
        alone = read_log(path, each.name, each.rows) if each.mapping is None else parse_log(each)
        assert np.array_equal(log.time, alone.time)
        assert list(log.channels) == list(alone.channels)
        for channel, values in alone.channels.items():
            assert np.array_equal(log.channels[channel], values)


def test_no_log_is_no_log() -> None:
    assert parse_logs([]) == []


def test_a_damaged_log_gives_its_fault_and_the_others_are_read(logs: list[LogRequest]) -> None:
    logs[1].paths["log_1.csv"].write_text("t,q.a\n0,1\n1,abc\n")
    assert read(logs) == [20, ("log_1.csv", "not_a_number"), 22, 23]
    with pytest.raises(BadLog) as caught:
        parse_logs(logs)
    (fault,) = caught.value.faults
    assert (fault.file, fault.row, fault.column, fault.value) == ("log_1.csv", 2, "q.a", "abc")


@pytest.mark.parametrize(
    ("limits", "count", "rule"),
    [(Limits(memory=450 << 20), 400_000, "memory_limit"), (Limits(file=10_000), 10_000, "too_many_bytes")],
)
def test_a_log_beyond_its_limits_gives_its_fault_and_the_others_are_read(
    logs: list[LogRequest], limits: Limits, count: int, rule: str
) -> None:
    large = logs[2].paths["log_2.csv"]
    write_log(Log("log", np.arange(count * 1.0), {f"q.{k}": np.zeros(count) for k in range(60)}), large)
    assert read(logs, limits) == [20, 21, ("log_2.csv", rule), 23]


def test_faults_of_all_logs_are_told_at_once_whatever_their_kinds(logs: list[LogRequest]) -> None:
    logs[0].paths["log_0.csv"].write_text("")
    logs[3].paths["log_3.csv"].write_text("t," + ",".join(f"q.{k}" for k in range(5000)) + "\n")
    logs[1] = LogRequest("two files", {"a": logs[1].paths["log_1.csv"], "b": logs[2].paths["log_2.csv"]})
    with pytest.raises(BadLog) as caught:
        parse_logs(logs)
    rules = [fault.rule for fault in caught.value.faults]
    assert rules == ["empty_file", "mapping_missing", "too_many_columns"]


def test_when_the_shared_child_crashes_each_log_has_a_child_of_its_own(
    logs: list[LogRequest], children: Children
) -> None:
    """The first child is everybody's; of the four that follow one by one, the second crashes again."""
    for k, log in enumerate(logs):  # long enough to be met while they are read
        table(log.paths[f"log_{k}.csv"], 400_000 + k)
    found = list[object]()
    reader = threading.Thread(target=lambda: found.extend(read(logs)))
    reader.start()
    seen = list[int]()
    deadline = time.monotonic() + 60.0
    while reader.is_alive() and time.monotonic() < deadline:
        for pid in children():
            if pid not in seen:
                seen.append(pid)
                if len(seen) in (1, 3):
                    os.kill(pid, signal.SIGSEGV)
        time.sleep(0.002)
    reader.join()
    assert found == [400_000, ("log_1.csv", "reader_crashed"), 400_002, 400_003]
    assert len(seen) == 5


def test_logs_for_which_time_is_short_are_named_and_too_large(logs: list[LogRequest]) -> None:
    with pytest.raises(TooLarge) as caught:
        parse_logs(logs, Limits(wall_s=0.01))
    assert [(fault.file, fault.rule) for fault in caught.value.faults] == [
        (f"log_{k}.csv", "time_limit") for k in range(4)
    ]


def test_nothing_is_left_behind(logs: list[LogRequest], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place = tmp_path / "temporary"
    place.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(place))
    logs[1].paths["log_1.csv"].write_text("")
    read(logs)
    assert list(place.iterdir()) == []


def test_neighbours_share_a_batch_up_to_its_number_and_its_bytes(tmp_path: Path) -> None:
    def sizes(*megabytes: int) -> list[int]:
        paths = [tmp_path / f"{k}.csv" for k in range(len(megabytes))]
        for path, size in zip(paths, megabytes, strict=True):
            path.touch()
            os.truncate(path, size << 20)
        return [len(batch) for batch in batches.batches_of([request(path) for path in paths])]

    assert sizes(*[0] * 70) == [32, 32, 6]
    assert sizes(20, 12, 1, 500, 1, 1) == [2, 1, 1, 2]
    assert sizes(500) == [1]


def test_a_log_too_large_for_a_batch_is_read_among_short_ones(tmp_path: Path, logs: list[LogRequest]) -> None:
    path, noise = tmp_path / "long.parquet", np.random.default_rng(3).normal(size=(10, 500_000))
    write_log(Log("long", np.arange(500_000.0), {f"q.{k}": values for k, values in enumerate(noise)}), path)
    assert path.stat().st_size > batches.MAX_BYTES
    assert read([logs[0], request(path), logs[1]]) == [20, 500_000, 21]


def test_what_is_no_fault_of_a_file_is_raised_as_it_is(
    logs: list[LogRequest], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    readers.end()
    monkeypatch.setattr("sys.executable", str(tmp_path / "nowhere"))
    with pytest.raises(Unavailable):
        parse_logs(logs)
