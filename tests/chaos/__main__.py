"""`make chaos`: a service, its workers and their children are killed together at random moments, again and again.

    python -m tests.chaos --runs 50 --database sqlite|postgresql|both --seed 1

Each run: the service starts, clients send studies and ask for jobs until a random moment, then every process of the
service is killed with SIGKILL. At the end it starts once more, all that was acknowledged is asked for, every job has to
end, `gc` sweeps and `check` reads every blob. Printed: what was acknowledged, lost, corrupt, double and left over; the
exit code is 1 where any of these is not 0.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from uuid import uuid4

import httpx

TESTS = Path(__file__).parents[1]
PROGRAM = TESTS / "jobs" / "burning.py"
ANNOUNCED = "exogauge serves on "
CLIENTS = 3
SERVER = "postgresql://root@127.0.0.1:5432/postgres"
JOB_S = 0.3
START_S, END_S = 90.0, 240.0


@dataclass
class Ledger:
    """What the service has acknowledged. Guarded by its lock."""

    studies: dict[str, str] = field(default_factory=dict)  # id -> content hash
    jobs: dict[str, str] = field(default_factory=dict)  # id -> name of its own ledger of starts and ends
    lock: threading.Lock = field(default_factory=threading.Lock)


class Service:
    """The whole of it in a process group of its own, which a kill reaches as one."""

    def __init__(self, folder: Path, url: str) -> None:
        self.folder = folder
        self.environment = {
            **os.environ,
            "EXOGAUGE_DATA_DIR": str(folder / "data"),
            "EXOGAUGE_DATABASE_URL": url,
            "EXOGAUGE_PORT": "0",
            "EXOGAUGE_WORKERS": "2",
            "EXOGAUGE_REQUESTS_PER_S": "0",
            "PYTHONPATH": str(PROGRAM.parent),
        }
        self.log = folder / "service.log"

    def start(self) -> str:
        self.log.write_text("")
        with self.log.open("ab") as sink:
            self.process = subprocess.Popen(
                [sys.executable, str(PROGRAM), "serve"],
                env=self.environment, stdin=subprocess.DEVNULL, stdout=sink, stderr=sink, start_new_session=True,
            )  # fmt: skip
        end = time.monotonic() + START_S
        while time.monotonic() < end and self.process.poll() is None:
            for line in self.log.read_text().splitlines():
                if line.startswith(ANNOUNCED):
                    return line.removeprefix(ANNOUNCED)
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


def small_study(number: str) -> dict[str, bytes]:
    """Right in every way, and unlike any other."""
    found = importlib.util.spec_from_file_location("small", TESTS / "api" / "conftest.py")
    assert found is not None
    assert found.loader is not None
    small = importlib.util.module_from_spec(found)
    found.loader.exec_module(small)
    texts = {
        "study.yaml": f"{small.STUDY}\n# {number}\n",
        "robot.yaml": small.ROBOT,
        "robot.urdf": small.URDF,
        "logs/id.csv": small.table(0.0),
        "logs/val.csv": small.table(0.7),
    }
    return {path: text.encode() for path, text in texts.items()}


def work(url: str, ledger: Ledger, folder: Path, seed: int, stop: threading.Event) -> None:
    """Send studies, ask for jobs, and note only what was acknowledged."""
    chance = random.Random(seed)
    with httpx.Client(base_url=f"{url}/api/v1", timeout=30.0) as client:
        while not stop.is_set():
            name = uuid4().hex
            try:
                files = [("files", (path, content)) for path, content in small_study(name).items()]
                answer = client.post("/studies", files=files, headers={"Idempotency-Key": name})
                if answer.status_code not in (200, 201):
                    continue
                study = answer.json()
                with ledger.lock:
                    ledger.studies[study["id"]] = study["content_hash"]
                own = folder / f"{name}.ledger"
                settings = {"ledger": str(own), "seconds": chance.uniform(0.05, JOB_S), "bytes": 20_000}
                asked = client.post("/jobs", json={"study_id": study["id"], "kind": "burn", "settings": settings})
                if asked.status_code == 202:
                    with ledger.lock:
                        ledger.jobs[asked.json()["id"]] = str(own)
            except (httpx.HTTPError, ValueError):
                stop.wait(0.05)


def rounds(service: Service, ledger: Ledger, runs: int, chance: random.Random, longest_s: float) -> int:
    """Start, let clients work, kill; returns how many processes were killed."""
    killed = 0
    for run in range(runs):
        url, stop = service.start(), threading.Event()
        clients = [
            threading.Thread(target=work, args=(url, ledger, service.folder, chance.random(), stop))
            for _ in range(CLIENTS)
        ]
        for each in clients:
            each.start()
        time.sleep(chance.uniform(0.2, longest_s))
        killed += service.kill()
        stop.set()
        for each in clients:
            each.join()
        print(f"  kill {run + 1}: {len(ledger.studies)} studies, {len(ledger.jobs)} jobs acknowledged", flush=True)
    return killed


def judged(service: Service, ledger: Ledger) -> dict[str, Any]:
    """What has become of all that was acknowledged."""
    url = service.start()
    lost, corrupt, double, unfinished, failed, attempts = 0, 0, 0, 0, 0, 0
    with httpx.Client(base_url=f"{url}/api/v1", timeout=60.0) as client:
        for key, content_hash in ledger.studies.items():
            answer = client.get(f"/studies/{key}")
            lost += answer.status_code != 200
            corrupt += answer.status_code == 200 and answer.json()["content_hash"] != content_hash
        end, open_ = time.monotonic() + END_S + JOB_S * len(ledger.jobs), dict(ledger.jobs)
        while open_ and time.monotonic() < end:
            for key in list(open_):
                answer = client.get(f"/jobs/{key}")
                if answer.status_code == 404:
                    lost += 1
                    del open_[key]
                elif answer.json()["state"] in ("succeeded", "failed", "cancelled"):
                    job = answer.json()
                    failed += job["state"] != "succeeded"
                    attempts = max(attempts, job["attempts"])
                    names = [each["name"] for each in client.get(f"/jobs/{key}/artifacts").json()["items"]]
                    double += len(names) != len(set(names))
                    lost += job["state"] == "succeeded" and "results.json" not in names
                    del open_[key]
            time.sleep(0.2)
        unfinished = len(open_)
    service.kill()
    first = service.command("gc", "--stopped")
    service.command("gc", "--stopped")
    found = service.command("check")
    return {
        "lost": lost + found["missing"]["count"], "corrupt": corrupt + found["corrupt"]["count"], "double": double,
        "unfinished": unfinished, "failed": failed, "most_attempts": attempts,
        "orphans": found["orphans"]["count"], "left_over": found["left_over"]["count"],
        "faults": found["sizes"]["count"] + found["broken"]["count"], "blobs": found["blobs"],
        "swept": sum(first[each] for each in ("blobs", "incoming", "uploads", "scratch", "live", "shelves")),
    }  # fmt: skip


@contextmanager
def database(kind: str, folder: Path, server: str) -> Iterator[str]:
    if kind == "sqlite":
        yield ""
        return
    import psycopg

    name = f"chaos_{uuid4().hex[:12]}"
    with psycopg.connect(server, autocommit=True) as connection:
        connection.execute(f'CREATE DATABASE "{name}"')
    try:
        yield server.rpartition("/")[0] + f"/{name}"
    finally:
        with psycopg.connect(server, autocommit=True) as connection:
            connection.execute(f'DROP DATABASE IF EXISTS "{name}" WITH (FORCE)')


def main() -> int:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--runs", type=int, default=50)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--database", choices=("sqlite", "postgresql", "both"), default="both")
    options.add_argument(
        "--server", default="postgresql://root@127.0.0.1:5432/postgres", help="where databases are made"
    )
    options.add_argument("--longest", type=float, default=15.0, metavar="S", help="between a start and its kill")
    given = options.parse_args()
    bad = False
    for kind in ("sqlite", "postgresql") if given.database == "both" else (given.database,):
        folder = Path(tempfile.mkdtemp(prefix="exogauge-chaos-"))
        begun = time.monotonic()
        print(f"{kind}: {given.runs} kills, seed {given.seed}", flush=True)
        with database(kind, folder, given.server) as url:
            service, ledger = Service(folder, url), Ledger()
            killed = rounds(service, ledger, given.runs, random.Random(given.seed), given.longest)
            found = judged(service, ledger)
        told = {"studies": len(ledger.studies), "jobs": len(ledger.jobs), "processes_killed": killed, **found}
        print(f"{kind}: " + ", ".join(f"{key} {value}" for key, value in told.items()))
        print(f"{kind}: {time.monotonic() - begun:.0f} s")
        wrong = ("lost", "corrupt", "double", "unfinished", "failed", "orphans", "left_over", "faults")
        bad |= any(found[each] for each in wrong)
        shutil.rmtree(folder, ignore_errors=True)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
