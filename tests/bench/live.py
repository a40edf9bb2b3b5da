"""A live stream: the loops per sample, from sample to wrench through the real service, and memory over an hour."""

from __future__ import annotations

import json
import os
import struct
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np
import pyarrow.parquet as pq
import yaml
from numpy.typing import NDArray
from tests.bench.timing import in_turns, seconds_of
from tests.client.conftest import Service
from websockets.sync.client import connect

from exogauge.client import Client
from exogauge.payload.dynamics import dynamic_rows
from exogauge.payload.live import Live
from exogauge.payload.live_start import open_start
from exogauge.payload.live_track import Track
from exogauge.payload.total_least_squares import Recursion
from exogauge.synthetic.payload import JOINTS, RATE_HZ, write_payload

Array = NDArray[np.float64]
LAG = 25  # samples between what goes in and what comes out


@final
@dataclass(frozen=True)
class Loops:
    """[µs] CPU per sample, of six joints. grown_mb: of the engine's process over `hours` of stream."""

    tracked: float
    updated: float
    all: float
    grown_mb: float
    hours: float


@final
@dataclass(frozen=True)
class Through:
    """Of all samples of all streams: from sent to answered [ms]; share of a core per stream; samples that got no
    answer."""

    streams: int
    p50: float
    p99: float
    core: float
    unanswered: int


def sample(folder: Path) -> Path:
    write_payload(folder, 1)
    plain = yaml.safe_load((folder / "payload.yaml").read_text())
    plain["logs"] = [each for each in plain["logs"] if each["role"] == "postures"]
    (folder / "payload.yaml").write_text(yaml.safe_dump(plain))
    return folder


def rows_of(folder: Path, log: str = "fast") -> Array:
    """(2500, 13)"""
    table = pq.read_table(folder / "logs" / f"{log}.parquet")
    names = ["t", *(f"q.{joint}" for joint in JOINTS), "fx", "fy", "fz", "mx", "my", "mz"]
    return np.column_stack([table[name].to_numpy() for name in names])


def loops(hours: float) -> Loops:
    with tempfile.TemporaryDirectory() as scratch:
        folder = sample(Path(scratch) / "sample")
        _, start = open_start(folder)
        rows = rows_of(folder)
    time_, q, wrench = rows[:, 0], rows[:, 1:7], rows[:, 7:]
    motion = Track(start.pose, RATE_HZ, start.gravity).push(time_, q).motion
    wrench_then = np.ascontiguousarray(wrench[: len(motion.time)])

    def track() -> None:
        Track(start.pose, RATE_HZ, start.gravity).push(time_, q)

    def update() -> None:
        made = dynamic_rows(motion, wrench_then, start.gravity, start.sign, start.std)
        Recursion(16, start.prior.rows, start=start.prior.value).run(made.z, made.noise)

    def whole() -> None:
        list(Live(start).push(time_, q, wrench))

    spent = in_turns({"track": seconds_of(track), "update": seconds_of(update), "all": seconds_of(whole)}, 5)
    per = {name: 1e6 * each / len(rows) for name, each in spent.items()}
    return Loops(per["track"], per["update"], per["all"], growth(Live(start), rows, hours), hours)


def growth(live: Live, rows: Array, hours: float) -> float:
    """[MB] of resident memory, after the first minute."""
    count = round(3600.0 * hours * RATE_HZ / len(rows))
    before = 0.0
    for k in range(count):
        for first in range(0, len(rows), 250):
            part = rows[first : first + 250]
            for _ in live.push(part[:, 0] + k * len(rows) / RATE_HZ, part[:, 1:7], part[:, 7:]):
                pass
        if k == 6:
            before = resident_mb()
    return resident_mb() - before


def through(streams: int, seconds: float) -> Through:
    with tempfile.TemporaryDirectory() as scratch:
        folder = sample(Path(scratch) / "sample")
        rows = rows_of(folder)
        service = Service(Path(scratch), workers=0, EXOGAUGE_SILENCE_S="300")  # eight take a while to begin
        url, running = service.start(), service.process
        assert running
        try:
            with Client(url) as client:
                payload = client.upload_payload(folder).id
            address = f"{url.replace('http', 'ws', 1)}/api/v1/live/payload/{payload}"
            lines = [Line(address, rows, seconds) for _ in range(streams)]
            found = subprocess.run(["pgrep", "-P", str(running.pid), "-f", "live_process"], capture_output=True)
            processes = [int(each) for each in found.stdout.split()]
            began, before = time.monotonic(), sum(map(cpu_seconds, processes))
            for line in lines:
                line.start()
            time.sleep(0.9 * seconds)  # they are still there
            core = (sum(map(cpu_seconds, processes)) - before) / (time.monotonic() - began) / streams
            for line in lines:
                line.sender.join()
            for line in lines:
                line.receiver.join()
        finally:
            service.stop()
    waited = np.concatenate([line.waited() for line in lines])
    unanswered = sum(line.count - line.answered for line in lines)
    p50, p99 = 1e3 * np.percentile(waited, [50, 99])
    return Through(streams, float(p50), float(p99), core, unanswered)


ECHO = """
from websockets.sync.server import serve
with serve(lambda line: [line.send(each) for each in line], "127.0.0.1", 0, compression=None) as server:
    print(server.socket.getsockname()[1], flush=True)
    server.serve_forever()
"""


def echo(seconds: float) -> tuple[float, float]:
    """[ms] median and 99 % of a bare websocket that sends every sample back: what this machine gives by now."""
    server = subprocess.Popen([sys.executable, "-c", ECHO], stdout=subprocess.PIPE, text=True)
    try:
        assert server.stdout is not None
        port = int(server.stdout.readline())
        count = round(seconds * RATE_HZ)
        sent, got = np.zeros(count), np.zeros(count)
        with connect(f"ws://127.0.0.1:{port}", compression=None) as line:

            def hear() -> None:
                for k in range(count):
                    line.recv(60)
                    got[k] = time.monotonic()

            hearer = threading.Thread(target=hear)
            hearer.start()
            began = time.monotonic()
            for k in range(count):
                time.sleep(max(0.0, began + k / RATE_HZ - time.monotonic()))
                sent[k] = time.monotonic()
                line.send(bytes(112))
            hearer.join()
    finally:
        server.kill()
        server.wait()
    p50, p99 = 1e3 * np.percentile(got - sent, [50, 99])
    return float(p50), float(p99)


@final
class Line:
    """One client that sends a sample every 4 ms, and a thread that reads the answers."""

    def __init__(self, address: str, rows: Array, seconds: float) -> None:
        self.rows, self.count, self.answered = rows, round(seconds * RATE_HZ), 0
        self.sent, self.got = np.full(self.count, np.nan), np.full(self.count, np.nan)
        self.line = connect(address, open_timeout=60, compression=None, max_queue=None)
        while json.loads(self.line.recv(60))["type"] != "welcome":
            pass
        self.sender, self.receiver = threading.Thread(target=self.send), threading.Thread(target=self.receive)

    def start(self) -> None:
        self.sender.start()
        self.receiver.start()

    def send(self) -> None:
        began = time.monotonic()
        for k in range(self.count):
            time.sleep(max(0.0, began + k / RATE_HZ - time.monotonic()))
            row = self.rows[k % len(self.rows)].copy()
            row[0] = k / RATE_HZ
            self.sent[k] = time.monotonic()
            self.line.send(struct.pack("<Q", k) + row.tobytes())
        self.line.send('{"type": "end"}')

    def receive(self) -> None:
        while (message := json.loads(self.line.recv(60)))["type"] != "ended":
            now = time.monotonic()
            if message["type"] == "wrench":
                self.answered += len(message["seq"])
                for number in message["seq"]:
                    if number + LAG < self.count:
                        self.got[number + LAG] = now

    def waited(self) -> Array:
        """[s] from a sample to the wrench that it lets out."""
        waited = self.got - self.sent
        return np.asarray(waited[LAG:])


def resident_mb() -> float:
    """Of this process."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def cpu_seconds(process: int) -> float:
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
