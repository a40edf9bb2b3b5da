"""A whole service as an operator starts it, in processes of its own, for what measures it or kills it."""

from __future__ import annotations

import importlib.util
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from uuid import uuid4

TESTS = Path(__file__).parent
ANNOUNCED = "exogauge serves on "
SERVER = "postgresql://root@127.0.0.1:5432/postgres"
START_S = 90.0
EXOGAUGE = ("-m", "exogauge.cli")


class Service:
    """The whole of it in a process group of its own, which a kill reaches as one."""

    def __init__(self, folder: Path, url: str, program: Sequence[str] = EXOGAUGE, **settings: str) -> None:
        """program: what `serve` is said to. settings: as in the environment, without what all begin with."""
        self.folder, self.program = folder, program
        said = {"data_dir": str(folder / "data"), "database_url": url, "port": "0", "requests_per_s": "0", **settings}
        self.environment = {**os.environ, **{f"EXOGAUGE_{name.upper()}": value for name, value in said.items()}}
        self.log, self.url = folder / "service.log", ""

    def running(self) -> bool:
        return hasattr(self, "process") and self.process.poll() is None

    def start(self) -> str:
        """Its address."""
        self.log.write_text("")
        with self.log.open("ab") as sink:
            self.process = subprocess.Popen(
                [sys.executable, *self.program, "serve"],
                env=self.environment, stdin=subprocess.DEVNULL, stdout=sink, stderr=sink, start_new_session=True,
            )  # fmt: skip
        end = time.monotonic() + START_S
        while time.monotonic() < end and self.process.poll() is None:
            for line in self.log.read_text().splitlines():
                if line.startswith(ANNOUNCED):
                    self.url = line.removeprefix(ANNOUNCED)
                    return self.url
            time.sleep(0.05)
        raise SystemExit(f"the service did not start:\n{self.log.read_text()[-3000:]}")

    def kill(self) -> int:
        """Every process below it, readers of uploads in sessions of their own too; how many there were."""
        found = descendants(self.process.pid)
        for pid in [self.process.pid, *found]:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        self.process.wait()
        return 1 + len(found)

    def command(self, *words: str) -> Any:
        done = subprocess.run(
            [sys.executable, "-m", "exogauge.cli", *words, "--json"],
            env=self.environment,
            capture_output=True,
            text=True,
        )
        if not done.stdout:
            raise SystemExit(f"exogauge {' '.join(words)}: {done.stderr}")
        return json.loads(done.stdout)


def descendants(pid: int) -> list[int]:
    children: dict[int, list[int]] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            except (OSError, IndexError):
                continue
            children.setdefault(parent, []).append(int(entry.name))
    found, left = list[int](), [pid]
    while left:
        below = children.get(left.pop(), [])
        found += below
        left += below
    return found


def small_study(number: str, samples: int = 400) -> dict[str, bytes]:
    """Right in every way, and unlike any other; samples of each log, at 100 Hz."""
    found = importlib.util.spec_from_file_location("small", TESTS / "api" / "conftest.py")
    assert found is not None
    assert found.loader is not None
    small = importlib.util.module_from_spec(found)
    found.loader.exec_module(small)
    texts = {
        "study.yaml": f"{small.STUDY}\n# {number}\n",
        "robot.yaml": small.ROBOT,
        "robot.urdf": small.URDF,
        "logs/id.csv": small.table(0.0, samples),
        "logs/val.csv": small.table(0.7, samples),
    }
    return {path: text.encode() for path, text in texts.items()}


@contextmanager
def database(kind: str, server: str = SERVER) -> Iterator[str]:
    if kind == "sqlite":
        yield ""
        return
    import psycopg

    name = f"exogauge_{uuid4().hex[:12]}"
    with psycopg.connect(server, autocommit=True) as connection:
        connection.execute(f'CREATE DATABASE "{name}"')
    try:
        yield server.rpartition("/")[0] + f"/{name}"
    finally:
        with psycopg.connect(server, autocommit=True) as connection:
            connection.execute(f'DROP DATABASE IF EXISTS "{name}" WITH (FORCE)')
