"""The child process: same results as reading in place, and an error that helps whatever happens to it."""

from __future__ import annotations

import dataclasses
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import h5py
import numpy as np
import pyarrow.parquet as pq
import pytest

from exogauge.errors import BadInput, BadLog, BadRobot, TooLarge, Unavailable
from exogauge.logs.mapping_rules import Clock, FileMapping, LogMapping, Source, Values
from exogauge.logs.model import Log
from exogauge.logs.parquet_table import write_log
from exogauge.logs.reading import read_log
from exogauge.sandbox import LogRequest, RobotRequest, asking, canonicalise, check_robot, parse_log
from exogauge.sandbox.limits import Limits

URDF = b"""<robot name="arm">
<link name="base"/>
<link name="fore"><inertial><mass value="2"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="elbow" type="revolute"><parent link="base"/><child link="fore"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="9" velocity="9"/></joint></robot>"""


@pytest.fixture
def table(tmp_path: Path) -> Path:
    path = tmp_path / "log.csv"
    path.write_text("t,q.a\n" + "".join(f"{k / 100},{k * k}\n" for k in range(30_000)))
    return path


def request(path: Path) -> LogRequest:
    return LogRequest("log", {"user's name.csv": path})


def test_a_log_read_in_the_child_equals_the_log_read_here(table: Path) -> None:
    here, there = read_log(table, "log"), parse_log(request(table))
    assert np.array_equal(here.time, there.time)
    assert np.array_equal(here.channels["q.a"], there.channels["q.a"])


def test_a_mapping_travels_to_the_child(tmp_path: Path) -> None:
    path = tmp_path / "motor.csv"
    path.write_text("p1,p2\n" + "".join(f"{k},{2 * k}\n" for k in range(20)))
    rules = tuple(Values(Source((f"p{k}",)), (f"q.{joint}",), "rad", side="motor") for k, joint in ((1, "a"), (2, "b")))
    mapping = LogMapping((FileMapping("motor.csv", Clock(rate_hz=10.0), rules),))
    gears = np.array([[2.0, 0.0], [1.0, 1.0]])
    log = parse_log(LogRequest("log", {"motor.csv": path}, mapping, ("a", "b"), gears, (5, 20)))
    assert np.allclose(log.channels["q.b"], np.arange(5, 20) * 1.5)


def test_the_canonical_file_appears_whole_with_its_summary(table: Path, tmp_path: Path) -> None:
    out = tmp_path / "kept" / "log.parquet"
    out.parent.mkdir()
    summary = canonicalise(request(table), out)
    assert (summary.channels, summary.samples, summary.t0, summary.t1) == (("q.a",), 30_000, 0.0, 299.99)
    assert summary.rate_hz == pytest.approx(100.0)
    footer = pq.ParquetFile(out).metadata
    assert [footer.row_group(k).num_rows for k in range(footer.num_row_groups)] == [12_000, 12_000, 6_000]
    assert [path.name for path in out.parent.iterdir()] == ["log.parquet"]


def test_a_fault_keeps_its_place_and_leaves_nothing_behind(tmp_path: Path) -> None:
    path, out = tmp_path / "log.csv", tmp_path / "kept" / "log.parquet"
    path.write_text("t,q.a\n0,1\n1,abc\n")
    out.parent.mkdir()
    with pytest.raises(BadLog) as caught:
        canonicalise(request(path), out)
    (found,) = caught.value.faults
    assert (found.file, found.row, found.column, found.value) == ("user's name.csv", 2, "q.a", "abc")
    assert list(out.parent.iterdir()) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("limits", "rule"),
    [
        (Limits(memory=450 << 20), "memory_limit"),
        (Limits(wall_s=0.05), "time_limit"),
        (Limits(file=10_000), "too_many_bytes"),
    ],
)
def test_what_needs_more_than_its_limits_is_too_large(limits: Limits, rule: str, tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    write_log(Log("log", np.arange(400_000.0), {f"q.{k}": np.zeros(400_000) for k in range(60)}), path)
    with pytest.raises(TooLarge) as caught:
        parse_log(request(path), limits)
    assert caught.value.faults[0].rule == rule
    assert caught.value.faults[0].advice


@pytest.mark.slow
def test_a_reader_that_computes_too_long_is_stopped(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    numbers = ",0.123456" * 100
    with path.open("w") as table:
        table.write("t," + ",".join(f"q.{k}" for k in range(100)) + "\n")
        table.writelines(f"{k}{numbers}\n" for k in range(350_000))
    with pytest.raises(TooLarge) as caught:
        parse_log(request(path), Limits(cpu_s=1))
    assert caught.value.faults[0].rule == "time_limit"


def killed_while_reading(
    table: Path, children: Callable[[], list[int]], with_what: signal.Signals
) -> tuple[BaseException, bytes]:
    """What became of it, and the child's environment. One that has ended before it was seen is followed by another."""
    ended = list[BaseException]()

    def read() -> None:
        try:
            parse_log(request(table))
        except BaseException as problem:
            ended.append(problem)

    for _ in range(100):
        reader, pids, environment = threading.Thread(target=read), list[int](), b""
        reader.start()
        while reader.is_alive() and not (pids := children()):
            time.sleep(0.002)
        with suppress(OSError):
            for pid in pids[:1]:
                environment = Path(f"/proc/{pid}/environ").read_bytes()
                os.kill(pid, with_what)
        reader.join()
        if ended:
            return ended[0], environment
    raise AssertionError("every child had read its file before it was seen")


def test_a_crash_of_the_reader_is_a_fault_of_the_file_and_the_child_knows_no_secret(
    table: Path, children: Callable[[], list[int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("EXOGAUGE_DATABASE_URL", "postgresql://user:secret@nowhere/db")
    problem, environment = killed_while_reading(table, children, signal.SIGSEGV)
    assert environment
    assert b"secret" not in environment
    assert isinstance(problem, BadLog)
    assert problem.faults[0].rule == "reader_crashed"


@pytest.mark.parametrize(("short", "told"), [(0, "does not tell which"), (1, "for want of memory")])
def test_a_reader_that_is_killed_from_outside_says_nothing_of_its_file(
    short: int, told: str, table: Path, children: Callable[[], list[int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    counts = iter((3, 3 + short))
    monkeypatch.setattr(asking, "times_short_of_memory", lambda: next(counts))
    problem, _ = killed_while_reading(table, children, signal.SIGKILL)
    assert isinstance(problem, Unavailable)
    assert "user's name.csv" in str(problem)
    assert told in str(problem)
    assert "nothing is known" in str(problem)


def test_the_kernel_is_asked_how_often_memory_ran_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told = tmp_path / "vmstat"
    monkeypatch.setattr(asking, "VMSTAT", told)
    assert asking.times_short_of_memory() == 0
    told.write_text("nr_free 7\noom_kill 41\noom_kill_other 5\n")
    assert asking.times_short_of_memory() == 41


@pytest.mark.slow
def test_a_sound_robot_is_summed_up_and_a_broken_one_refused() -> None:
    summary = check_robot(RobotRequest(URDF, ["elbow"], "base"))
    assert (summary.bodies, summary.joints, summary.mass) == (("fore",), ("elbow",), 2.0)
    with pytest.raises(BadRobot) as caught:
        check_robot(RobotRequest(URDF.replace(b'mass value="2"', b'mass value="-2"'), file="mine.urdf"))
    assert caught.value.faults[0].file == "mine.urdf"


def test_a_chain_of_four_thousand_links_takes_nobody_down() -> None:
    links = "".join(f'<link name="l{k}"/>' for k in range(4000))
    joints = "".join(
        f'<joint name="j{k}" type="continuous"><parent link="l{k}"/><child link="l{k + 1}"/></joint>'
        for k in range(3999)
    )
    with pytest.raises((BadRobot, TooLarge)):
        check_robot(RobotRequest(f'<robot name="snake">{links}{joints}</robot>'.encode(), ["j0"], "l0"))


def test_an_external_link_never_shows_another_file(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "secret.h5", "w") as secret:
        secret["q.a"] = np.arange(20.0)
    with h5py.File(tmp_path / "a.h5", "w") as target:
        target["t"] = np.arange(20.0)
        target["q.a"] = h5py.ExternalLink(str(tmp_path / "secret.h5"), "/q.a")
    with pytest.raises(BadLog) as caught:
        parse_log(request(tmp_path / "a.h5"))
    assert caught.value.faults[0].rule == "hdf5_link"


@pytest.mark.slow
def test_damaged_hdf5_and_urdf_give_a_result_or_a_fault_and_nothing_else(tmp_path: Path) -> None:
    rng = np.random.default_rng(7)
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as target:
        target["t"] = np.arange(20.0)
        target.create_dataset("q.a", data=np.arange(20.0), compression="gzip")
    whole = path.read_bytes()
    for _ in range(12):
        data = bytearray(whole)
        for at in rng.integers(0, len(data), 12):
            data[at] = rng.integers(256)
        path.write_bytes(bytes(data))
        try:
            parse_log(request(path))
        except BadInput as bad:
            places = [fault.file for fault in bad.faults]
            if set(places) != {"user's name.csv"}:
                pytest.fail(f"no place: {bad}")
    for _ in range(8):
        data = bytearray(URDF)
        for at in rng.integers(0, len(data), 4):
            data[at] = rng.integers(256)
        try:
            check_robot(RobotRequest(bytes(data), ["elbow"], "base"))
        except BadInput as bad:
            if not bad.faults:
                pytest.fail("no fault")


def test_the_child_says_nothing_on_the_terminal(table: Path, capfd: pytest.CaptureFixture[str]) -> None:
    parse_log(request(table))
    assert capfd.readouterr() == ("", "")


def test_an_answer_is_one_where_the_disk_has_no_room_for_what_was_said_on_the_way(tmp_path: Path) -> None:
    """It was told as a study that makes its reader crash."""
    says = "import sys; from exogauge.sandbox.answering import serve\n"
    says += "def task():\n    sys.stderr.write('no end of line')\n    return {'read': 1}\nserve({'read': task})"
    asked = {"task": "read", "options": {}, "limits": dataclasses.asdict(Limits())}
    buffered = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-c", says],
            input=json.dumps(asked), text=True, cwd=tmp_path, stderr=full, env=buffered, timeout=60,
        )  # fmt: skip
    assert json.loads((tmp_path / "answer.json").read_text()) == {"result": {"read": 1}}
    assert done.returncode == 0
