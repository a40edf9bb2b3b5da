"""`make load`: what a request costs while many ask, with many studies stored and an evaluation running.

    python -m tests.load --database sqlite|postgresql|both --studies 10000 --clients 16 --seconds 5 --only lists,details

Printed for each route: CPU milliseconds of the server process per request (and of PostgreSQL's, which answers beside
it), 50th and 95th percentile of the time until the answer was there, errors. CPU is what decides: time depends on what
else the machine does. Then what listeners to events, one large upload and a worker with nothing to do cost. An aim that
was missed is marked, and ends it with 1.
"""

from __future__ import annotations

import argparse
import base64
import hashlib
import http.client
import os
import random
import shutil
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import timedelta
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit
from uuid import uuid4

import httpx
import psycopg
import sqlalchemy as sa
from tests.whole_service import SERVER, Service, database, descendants, small_study

from exogauge.jobs import schema
from exogauge.settings import Settings
from exogauge.storage import tables
from exogauge.storage.accounts import Accounts
from exogauge.storage.bundles import words_of
from exogauge.storage.database import make_engine
from exogauge.storage.store import open_installation

TICK_S = 1.0 / os.sysconf("SC_CLK_TCK")
SAMPLES = 60_000  # of a log, ten minutes at 100 Hz: what tiles are made of
AIMS = {"list": 4.0, "detail": 2.0, "tiles": 10.0}  # CPU ms of the server per request
LISTENERS, LISTENERS_AIM = 200, 5.0  # % of a core
UPLOAD_BYTES, UPLOAD_AIM = 2 * 1024**3, 200.0  # MB of memory
IDLE_S, IDLE_AIM = 60.0, 0.5  # % of a core
PARTS = ("lists", "details", "tiles", "listeners", "upload", "idle")
END_S = 600.0


@dataclass
class Stored:
    """What there is to ask for."""

    token: str
    studies: list[str] = field(default_factory=list)
    jobs: list[str] = field(default_factory=list)
    long_job: str = ""  # with ten minutes of series
    series: str = ""
    channels: str = ""


@dataclass
class Load:
    """What many clients saw. seconds: of each request."""

    seconds: list[float] = field(default_factory=list)
    errors: int = 0
    lock: threading.Lock = field(default_factory=threading.Lock)


def cpu_s(pid: int) -> float:
    """User and system, with all threads."""
    words = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) * TICK_S


def backends(url: str) -> list[int]:
    """PostgreSQL's processes that serve this database, where they run on this machine."""
    name = url.rpartition("/")[2] if url.startswith("postgresql") else None
    found = []
    for entry in Path("/proc").iterdir():
        if name is not None and entry.name.isdigit():
            try:
                told = (entry / "cmdline").read_bytes()
            except OSError:
                continue
            if told.startswith(b"postgres:") and f" {name} ".encode() in told:
                found.append(int(entry.name))
    return found


def spent(pids: list[int]) -> dict[int, float]:
    kept = {}
    for pid in pids:
        try:
            kept[pid] = cpu_s(pid)
        except OSError:
            continue
    return kept


def percentile(values: list[float], share: float) -> float:
    ordered = sorted(values)
    return ordered[min(int(share * len(ordered)), len(ordered) - 1)] if ordered else float("nan")


def told(what: str, found: float, aim: float, unit: str, more: str = "") -> bool:
    """Whether it keeps to its aim."""
    kept = found <= aim
    print(f"  {what:34} {found:8.2f} {unit} (aim {aim:g}){'' if kept else '  MISSED'}{more}", flush=True)
    return kept


def prepare(settings: Settings) -> str:
    """A lab with accounts; returns a token of its."""
    schema.prepare(settings)
    installation = open_installation(settings)
    with installation.session() as session:
        account = Accounts(session).add("a@load.example", "A", None)
        lab = Accounts(session).found_lab("load", "load")
        Accounts(session).join(account.id, lab.id, "admin", "load", "")
    with installation.of_lab("load").transaction() as store:
        _, token = store.tokens.add("load", "write", made_by=None, account_id=account.id, expires_at=None)
    installation.close()
    return token


def evaluated(client: httpx.Client, files: dict[str, bytes]) -> tuple[str, str]:
    """The study and its job, once it has succeeded."""
    answer = client.post("/studies", files=[("files", (path, content)) for path, content in files.items()])
    study = answer.raise_for_status().json()["id"]
    job = client.post("/jobs", json={"study_id": study, "kind": "evaluate"}).raise_for_status().json()["id"]
    end = time.monotonic() + END_S
    while (seen := client.get(f"/jobs/{job}").json())["state"] in ("queued", "running"):
        if time.monotonic() > end:
            raise SystemExit(f"job {job} does not end: {seen}")
        time.sleep(0.2)
    if seen["state"] != "succeeded":
        raise SystemExit(f"job {job} {seen['state']}: {seen['reason']}")
    return study, job


def copy(url: str, study: str, count: int, chance: random.Random) -> tuple[list[str], list[str]]:
    """As many rows like those of one study that was handed in and evaluated; ids of studies and of jobs."""
    engine = make_engine(url, migrating=True)
    studies, jobs = [str(uuid4()) for _ in range(count)], [str(uuid4()) for _ in range(count)]
    other = [hashlib.sha256(key.encode()).hexdigest() for key in studies]
    of_study = (
        (tables.Study, "id"),
        (tables.StudyFile, "study_id"),
        (tables.Job, "study_id"),
        (tables.Result, "study_id"),
    )
    with engine.begin() as connection:
        job = connection.execute(sa.select(tables.Job.id).where(tables.Job.study_id == study)).scalar_one()
        for table, column in (*of_study, (tables.Artifact, "job_id")):
            shape: Any = table.__table__
            key = job if column == "job_id" else study
            for row in connection.execute(sa.select(shape).where(shape.c[column] == key)).mappings().all():
                made = []
                for k in range(count):
                    new = dict(row, id=str(uuid4()), created_at=row["created_at"] - timedelta(seconds=k + 1))
                    for name, keys in (("study_id", studies), ("job_id", jobs)):
                        if name in new:
                            new[name] = keys[k]
                    if table is tables.Study:
                        name = f"{row['name']} {chance.randrange(100)}"
                        new |= {"id": studies[k], "content_hash": other[k], "name": name}
                        new["words"] = words_of(name, row["summary"])
                    if table is tables.Job:
                        new |= {"id": jobs[k], "request_hash": other[k]}
                    made.append(new)
                connection.execute(sa.insert(shape), made)
    engine.dispose()
    if url.startswith("postgresql"):
        with psycopg.connect(url.replace("+psycopg", ""), autocommit=True) as line:
            line.execute("VACUUM ANALYZE")  # as the server does it by itself, some minutes later
    return studies, jobs


def ask(url: str, token: str, paths: Callable[[random.Random], str], until: float, seed: int, load: Load) -> None:
    chance, parts = random.Random(seed), urlsplit(url)
    assert parts.hostname is not None
    line = http.client.HTTPConnection(parts.hostname, parts.port, timeout=60)
    seconds, errors = list[float](), 0
    while time.monotonic() < until:
        begun = time.perf_counter()
        try:
            line.request("GET", f"/api/v1{paths(chance)}", headers={"Authorization": f"Bearer {token}"})
            answer = line.getresponse()
            answer.read()
            errors += answer.status != 200
        except (OSError, http.client.HTTPException):
            line.close()
            errors += 1
        seconds.append(time.perf_counter() - begun)
    line.close()
    with load.lock:
        load.seconds += seconds
        load.errors += errors


def loaded(
    name: str, aim: float, url: str, service: Service, token: str, paths: Callable[[random.Random], str], given: Any
) -> bool:
    """Many clients ask for one route; whether CPU per request keeps to its aim, without an error."""
    server, load = service.process.pid, Load()
    database_url = service.environment["EXOGAUGE_DATABASE_URL"]
    before, of_database = cpu_s(server), spent(backends(database_url))
    until = time.monotonic() + given.seconds
    clients = [
        threading.Thread(target=ask, args=(url, token, paths, until, seed, load)) for seed in range(given.clients)
    ]
    for each in clients:
        each.start()
    for each in clients:
        each.join()
    count = max(len(load.seconds), 1)
    cpu_ms = 1e3 * (cpu_s(server) - before) / count
    beside = spent(backends(database_url))
    database_ms = 1e3 * sum(used - of_database.get(pid, 0.0) for pid, used in beside.items()) / count
    p50, p95 = (1e3 * percentile(load.seconds, share) for share in (0.5, 0.95))
    said = (
        f", database {database_ms:.2f} ms; p50 {p50:.0f} ms, p95 {p95:.0f} ms; {count} requests, {load.errors} errors"
    )
    return told(name, cpu_ms, aim, "ms CPU", said) and load.errors == 0


def routes(stored: Stored, only: list[str]) -> Iterator[tuple[str, float, Callable[[random.Random], str]]]:
    if "lists" in only:
        for path in ("/studies?limit=50", "/jobs?limit=50"):
            yield path, AIMS["list"], lambda _, path=path: path  # type: ignore[misc]
        yield (
            "/studies?limit=50&search=arm",
            AIMS["list"],
            lambda chance: f"/studies?search=arm+{chance.randrange(100)}",
        )
    if "details" in only:
        yield "/studies/ID", AIMS["detail"], lambda chance: f"/studies/{chance.choice(stored.studies)}"
        yield "/jobs/ID", AIMS["detail"], lambda chance: f"/jobs/{chance.choice(stored.jobs)}"
        yield "/jobs/ID/artifacts", AIMS["detail"], lambda chance: f"/jobs/{chance.choice(stored.jobs)}/artifacts"

    def tile(chance: random.Random) -> str:
        start = chance.uniform(0.0, 0.5 * SAMPLES / 100)
        window = f"start={start:.2f}&end={start + chance.uniform(1.0, 0.5 * SAMPLES / 100):.2f}"
        return f"/jobs/{stored.long_job}/series/{stored.series}/tiles?{stored.channels}&{window}&width=1200"

    if "tiles" in only:
        yield "/jobs/ID/series/NAME/tiles", AIMS["tiles"], tile


@contextmanager
def evaluating(url: str, token: str) -> Iterator[None]:
    """One evaluation after the other."""
    stop = threading.Event()

    def go_on() -> None:
        with asking(url, token) as client:
            while not stop.is_set():
                evaluated(client, small_study(uuid4().hex, SAMPLES))

    thread = threading.Thread(target=go_on)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()


def asking(url: str, token: str) -> httpx.Client:
    return httpx.Client(base_url=f"{url}/api/v1", headers={"Authorization": f"Bearer {token}"}, timeout=60.0)


def listened(service: Service, stored: Stored, seconds: float = 20.0) -> bool:
    """Listeners to events of jobs that wait: no worker runs."""
    url = service.start()
    parts = urlsplit(url)
    assert parts.hostname is not None
    with asking(url, stored.token) as client:
        waiting = []
        for key in stored.studies[:20]:  # with other settings than those that have succeeded
            body = {"study_id": key, "kind": "evaluate", "settings": {"cutoff_hz": 7.0}}
            answer = client.post("/jobs", json=body)
            waiting.append(answer.raise_for_status().json()["id"])
    lines = []
    for k in range(LISTENERS):
        line = http.client.HTTPConnection(parts.hostname, parts.port, timeout=60)
        path = f"/api/v1/jobs/{waiting[k % len(waiting)]}/events"
        line.request("GET", path, headers={"Authorization": f"Bearer {stored.token}"})
        lines.append((line, line.getresponse()))
    if wrong := [answer.status for _, answer in lines if answer.status != 200]:
        raise SystemExit(f"listeners were answered {wrong}")
    time.sleep(3.0)
    before = cpu_s(service.process.pid)
    time.sleep(seconds)
    share = 100.0 * (cpu_s(service.process.pid) - before) / seconds
    for line, _ in lines:
        line.close()
    service.kill()
    return told(f"{LISTENERS} listeners", share, LISTENERS_AIM, "% of a core")


def uploaded(service: Service, stored: Stored) -> bool:
    """One large file in pieces, as the page sends it; the most memory that the server held meanwhile."""
    url, piece, size = service.start(), 8 * 1024 * 1024, UPLOAD_BYTES
    pid = service.process.pid
    tus, name = {"Tus-Resumable": "1.0.0"}, base64.b64encode(b"large.csv").decode()
    block = os.urandom(piece)
    with asking(url, stored.token) as client:
        begun = {**tus, "Upload-Length": str(size), "Upload-Metadata": f"filename {name}"}
        place = client.post("/uploads", headers=begun).raise_for_status().headers["Location"]
        Path(f"/proc/{pid}/clear_refs").write_text("5")  # the peak begins anew
        before = cpu_s(pid)
        for offset in range(0, size, piece):
            headers = {**tus, "Upload-Offset": str(offset), "Content-Type": "application/offset+octet-stream"}
            client.patch(f"{url}{urlsplit(place).path}", headers=headers, content=block).raise_for_status()
        used = cpu_s(pid) - before
        status = Path(f"/proc/{pid}/status").read_text()
        client.delete(f"{url}{urlsplit(place).path}", headers=tus).raise_for_status()
    service.kill()
    peak = int(status.partition("VmHWM:")[2].split()[0]) / 1e3
    return told("upload of 2 GiB, most memory", peak, UPLOAD_AIM, "MB", f", {used:.1f} s CPU")


def idled(service: Service) -> bool:
    """A worker with nothing to do, what computes for it included."""
    service.start()
    time.sleep(15.0)
    workers = [pid for pid in descendants(service.process.pid) if b"work" in Path(f"/proc/{pid}/cmdline").read_bytes()]
    if len(workers) != 1:
        raise SystemExit(f"there are {len(workers)} workers")
    of_worker = [*workers, *descendants(workers[0])]
    of_server, before = cpu_s(service.process.pid), sum(spent(of_worker).values())
    time.sleep(IDLE_S)
    share = 100.0 * (sum(spent(of_worker).values()) - before) / IDLE_S
    beside = 100.0 * (cpu_s(service.process.pid) - of_server) / IDLE_S
    service.kill()
    return told("a worker with nothing to do", share, IDLE_AIM, "% of a core", f"; the server beside it {beside:.2f} %")


def measure(kind: str, given: argparse.Namespace, folder: Path, url: str) -> bool:
    only = given.only.split(",")
    settings = Settings(data_dir=folder / "data", database_url=url)
    token = prepare(settings)
    stored = Stored(token)

    def service(**more: str) -> Service:
        return Service(folder, settings.database_url, accounts="1", **more)

    kept = True
    if set(only) - {"idle"}:
        serves = service(workers="1")
        address = serves.start()
        with asking(address, token) as client:
            study, _ = evaluated(client, small_study("short"))
            _, stored.long_job = evaluated(client, small_study("long", SAMPLES))
            series = client.get(f"/jobs/{stored.long_job}/series").raise_for_status().json()["items"]
        longest = max(series, key=lambda each: each["samples"])
        stored.series = longest["name"]
        stored.channels = "&".join(f"channels={each['name']}" for each in longest["channels"][:4])
        begun = time.monotonic()
        stored.studies, stored.jobs = copy(settings.database_url, study, given.studies, random.Random(1))
        print(
            f"{kind}: {given.studies} studies, {time.monotonic() - begun:.0f} s; {longest['samples']} samples",
            flush=True,
        )
        with evaluating(address, token):
            for name, aim, paths in routes(stored, only):
                kept &= loaded(name, aim, address, serves, token, paths, given)
        serves.kill()
    if "listeners" in only:
        kept &= listened(service(workers="0"), stored)
    if "upload" in only:
        kept &= uploaded(service(workers="0"), stored)
    if "idle" in only:
        engine = make_engine(settings.database_url, migrating=True)
        with engine.begin() as connection:
            going = sa.update(tables.Job).where(tables.Job.state.in_(("queued", "running")))
            connection.execute(going.values(state="cancelled"))
        engine.dispose()
        kept &= idled(service(workers="1"))
    return kept


def main() -> int:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--database", choices=("sqlite", "postgresql", "both"), default="both")
    options.add_argument("--server", default=SERVER, help="where databases are made")
    options.add_argument("--studies", type=int, default=10_000)
    options.add_argument("--clients", type=int, default=16)
    options.add_argument("--seconds", type=float, default=5.0, help="for which each route is asked")
    options.add_argument("--only", default=",".join(PARTS), help="of " + ", ".join(PARTS))
    given = options.parse_args()
    kept = True
    for kind in ("sqlite", "postgresql") if given.database == "both" else (given.database,):
        folder = Path(tempfile.mkdtemp(prefix="exogauge-load-"))
        with database(kind, given.server) as url:
            kept &= measure(kind, given, folder, url)
        shutil.rmtree(folder, ignore_errors=True)
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main())
