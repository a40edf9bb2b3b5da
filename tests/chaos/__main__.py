"""`make chaos`: a service, its workers and their children are killed together at random moments, again and again.

    python -m tests.chaos --runs 50 --database sqlite|postgresql|both --blobs folder|s3 --seed 1

Each run: the service starts, clients send studies and ask for jobs until a random moment, then every process of the
service is killed with SIGKILL. At the end it starts once more, all that was acknowledged is asked for, every job has to
end, `gc` sweeps and `check` reads every blob. Printed: what was acknowledged, lost, corrupt, double and left over; the
exit code is 1 where any of these is not 0.
"""

from __future__ import annotations

import argparse
import random
import shutil
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from uuid import uuid4

import httpx
from tests.object_store import BUCKET, KEYS, s3_server
from tests.whole_service import SERVER, Service, database, small_study

PROGRAM = Path(__file__).parents[1] / "jobs" / "burning.py"
CLIENTS = 3
JOB_S = 0.3
END_S = 240.0


@dataclass
class Ledger:
    """What the service has acknowledged. Guarded by its lock."""

    studies: dict[str, str] = field(default_factory=dict)  # id -> content hash
    jobs: dict[str, str] = field(default_factory=dict)  # id -> name of its own ledger of starts and ends
    lock: threading.Lock = field(default_factory=threading.Lock)


def whole(folder: Path, url: str, **stored: str) -> Service:
    """stored: settings of an object store."""
    service = Service(folder, url, [str(PROGRAM)], workers="2", **stored)
    service.environment["PYTHONPATH"] = str(PROGRAM.parent)
    return service


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
def object_store(kind: str) -> Iterator[dict[str, str]]:
    """Settings of a real S3 server that is not killed; of none."""
    if kind == "folder":
        yield {}
        return
    with s3_server() as port:
        yield {"blob_url": f"s3://{BUCKET}/chaos", "s3_endpoint": f"http://127.0.0.1:{port}", **KEYS}


def main() -> int:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--runs", type=int, default=50)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--database", choices=("sqlite", "postgresql", "both"), default="both")
    options.add_argument("--blobs", choices=("folder", "s3"), default="folder", help="where bytes are kept")
    options.add_argument("--server", default=SERVER, help="where databases are made")
    options.add_argument("--longest", type=float, default=15.0, metavar="S", help="between a start and its kill")
    given = options.parse_args()
    bad = False
    for kind in ("sqlite", "postgresql") if given.database == "both" else (given.database,):
        folder = Path(tempfile.mkdtemp(prefix="exogauge-chaos-"))
        begun = time.monotonic()
        print(f"{kind}: {given.runs} kills, seed {given.seed}", flush=True)
        with database(kind, given.server) as url, object_store(given.blobs) as stored:
            service, ledger = whole(folder, url, **stored), Ledger()
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
