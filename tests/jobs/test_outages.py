"""What a job or a request needs is away for a while: nothing is lost or fails, and nothing has to be started again."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from uuid import uuid4

import httpx
import psycopg
import pytest
from tests.conftest import migrate_all
from tests.jobs.conftest import PROGRAM, Workshop
from tests.object_store import BUCKET, KEYS, Line, s3_server
from tests.own_postgres import Server, own_server
from tests.whole_service import Service, descendants, small_study

from exogauge.errors import Away, Unavailable
from exogauge.jobs import recipes
from exogauge.jobs.attempt import until_it_works
from exogauge.settings import Settings
from exogauge.storage.store import open_installation

AT_ONCE = 12
DEADLINE_S = 60.0
CUT_S = float(os.environ.get("EXOGAUGE_TEST_CUT_S", "8"))
ENDED = ("succeeded", "failed", "cancelled")


def test_a_store_that_is_away_is_waited_for_longer_than_a_broken_disk() -> None:
    for kind, tries in ((Away, 4), (Unavailable, 1)):
        left = [kind("not now")] * 3
        waited = []

        def ask(left: list[Unavailable] = left) -> str:
            if left:
                raise left.pop()
            return "done"

        try:
            found = until_it_works(ask, -1.0, lambda pause_s, _, waited=waited: waited.append(pause_s))
        except Unavailable:
            found = "given up"
        assert (found, len(waited) + 1) == (("done", tries) if kind is Away else ("given up", tries))


class Asked:
    """A whole service and what is asked of it."""

    def __init__(self, folder: Path, url: str, **stored: str) -> None:
        self.folder = folder
        self.service = Service(folder, url, [str(PROGRAM)], workers="1", **stored)
        self.service.environment |= {"PYTHONPATH": str(PROGRAM.parent), "PYTHONWARNINGS": "default"}
        self.client = httpx.Client(base_url=f"{self.service.start()}/api/v1", timeout=60.0)
        self.processes = {self.service.process.pid, *descendants(self.service.process.pid)}

    def study(self) -> httpx.Response:
        files = [("files", (path, content)) for path, content in small_study(uuid4().hex).items()]
        return self.client.post("/studies", files=files)

    def burn(self, study: str, name: str, seconds: float) -> str:
        settings = {"ledger": str(self.folder / name), "seconds": seconds, "bytes": 20_000}
        asked = self.client.post("/jobs", json={"study_id": study, "kind": "burn", "settings": settings})
        return str(asked.raise_for_status().json()["id"])

    def until(self, job: str, holds: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        end, now = time.monotonic() + DEADLINE_S, dict[str, Any]()
        while time.monotonic() < end:
            now = self.client.get(f"/jobs/{job}").raise_for_status().json()
            if holds(now):
                return now
            time.sleep(0.1)
        pytest.fail(f"{now}\n{self.service.log.read_text()[-4000:]}")

    def ended(self, job: str) -> dict[str, Any]:
        return self.until(job, lambda now: now["state"] in ENDED)

    def lists(self) -> list[httpx.Response]:
        with ThreadPoolExecutor(AT_ONCE) as threads:
            return list(threads.map(lambda _: self.client.get("/studies"), range(AT_ONCE)))

    def words(self, name: str) -> list[str]:
        return (self.folder / name).read_text().split()

    def nothing_was_started_again(self) -> bool:
        return self.processes <= {self.service.process.pid, *descendants(self.service.process.pid)}


@pytest.fixture
def asked(tmp_path: Path) -> Iterator[Callable[..., Asked]]:
    with ExitStack() as opened:

        def start(url: str, **stored: str) -> Asked:
            made = Asked(tmp_path, url, **stored)
            opened.callback(made.service.kill)
            opened.callback(made.client.close)
            return made

        yield start


@pytest.fixture
def server() -> Iterator[Server]:
    """Not below tmp_path: it runs as somebody else, who may not look in there."""
    with tempfile.TemporaryDirectory(prefix="exogauge-pg-") as folder, own_server(Path(folder)) as started:
        yield started


def told_to_wait(answer: httpx.Response) -> bool:
    kind = answer.headers["content-type"]
    return answer.status_code == 503 and kind == "application/problem+json" and int(answer.headers["retry-after"]) > 0


@pytest.mark.slow
def test_a_database_that_stops_ends_nothing_and_all_goes_on_when_it_is_back(
    server: Server, asked: Callable[..., Asked]
) -> None:
    there = asked(server.url())
    study = there.study().raise_for_status().json()["id"]
    job = there.burn(study, "meanwhile", 4.0)
    there.until(job, lambda now: now["progress"] > 0)
    assert {each.status_code for each in there.lists()} == {200}

    server.stop()
    assert [told_to_wait(each) for each in there.lists()] == [True] * AT_ONCE
    assert told_to_wait(there.study())
    assert [there.client.get(f"{there.service.url}{path}").status_code for path in ("/healthz", "/readyz")] == [
        200,
        503,
    ]
    time.sleep(5.0)  # the job has nobody to tell that it is done
    server.start()

    assert [each.status_code for each in there.lists()] == [200] * AT_ONCE  # the first that ask, and all of them
    done = there.ended(job)
    assert (done["state"], done["attempts"], there.words("meanwhile")) == ("succeeded", 1, ["start", "end"])
    assert there.ended(there.burn(study, "after", 0.1))["state"] == "succeeded"
    server.stop()
    server.start()  # as an upgrade of it does: nobody asked meanwhile
    assert [each.status_code for each in there.lists()] == [200] * AT_ONCE
    assert there.nothing_was_started_again()


@pytest.mark.slow
def test_an_object_store_that_stops_holds_up_only_what_needs_it(
    used_postgres_url: str, asked: Callable[..., Asked]
) -> None:
    with s3_server() as port:
        line = Line(port)
        there = asked(used_postgres_url, blob_url=f"s3://{BUCKET}/away", s3_endpoint=line.endpoint, **KEYS)
        study = there.study().raise_for_status().json()["id"]
        job = there.burn(study, "meanwhile", 2.0)
        there.until(job, lambda now: now["progress"] > 0)
        line.cut()
        refused = there.study()
        assert told_to_wait(refused)
        assert "object store" in refused.json()["detail"]
        assert there.client.get("/studies").status_code == 200
        waiting = there.until(job, lambda now: now["message"].startswith("waits: "))
        assert "object store" in waiting["message"]
        other = there.burn(study, "asked meanwhile", 0.1)
        line.mend()
        for name, key in (("meanwhile", job), ("asked meanwhile", other)):
            done = there.ended(key)
            assert (done["state"], done["attempts"], there.words(name)) == ("succeeded", 1, ["start", "end"])
        assert there.study().status_code == 201
        assert there.nothing_was_started_again()
        line.close()


class Cable:
    """Between this machine and a network namespace, which has nothing else. Only root may lay one."""

    def __init__(self) -> None:
        number = os.getpid() % 250
        self.name, self.plug, far = f"exg{os.getpid()}", f"exh{os.getpid()}", f"exf{os.getpid()}"
        self.here, there = f"10.213.{number}.1", f"10.213.{number}.2"
        inside = ["ip", "-n", self.name]
        for command in (
            ["ip", "netns", "add", self.name],
            ["ip", "link", "add", self.plug, "type", "veth", "peer", "name", far, "netns", self.name],
            ["ip", "address", "add", f"{self.here}/30", "dev", self.plug],
            ["ip", "link", "set", self.plug, "up"],
            [*inside, "address", "add", f"{there}/30", "dev", far],
            [*inside, "link", "set", far, "up"],
            [*inside, "link", "set", "lo", "up"],
        ):
            if shutil.which("ip") is None or subprocess.run(command, capture_output=True).returncode != 0:
                self.remove()
                pytest.skip("no network namespace can be made here")

    def cut(self) -> None:
        subprocess.run(["ip", "link", "set", self.plug, "down"], check=True)

    def mend(self) -> None:
        subprocess.run(["ip", "link", "set", self.plug, "up"], check=True)

    def remove(self) -> None:
        if shutil.which("ip") is not None:
            subprocess.run(["ip", "netns", "delete", self.name], capture_output=True)


@pytest.fixture
def cable() -> Iterator[Cable]:
    laid = Cable()
    yield laid
    laid.remove()


class Far:
    """A workshop whose first worker is another machine: a network of its own, a disk of its own, and a cable to the
    database."""

    def __init__(self, workshop: Workshop, cable: Cable, server: Server, folder: Path) -> None:
        self.workshop, self.cable = workshop, cable
        more = {
            "EXOGAUGE_DATABASE_URL": server.url(cable.here),
            "EXOGAUGE_DATA_DIR": str(folder / "far"),
            "EXOGAUGE_BLOB_DIR": str(workshop.settings.blobs),
            "BURN_LIMIT": str(CUT_S),  # to wait for the database is no part of the computation
        }
        with (folder / "workers.log").open("ab") as log:
            self.worker = subprocess.Popen(
                ["ip", "netns", "exec", cable.name, sys.executable, str(PROGRAM), "work"],
                env=workshop.environment(**more), stdin=subprocess.DEVNULL, stdout=log, stderr=log,
            )  # fmt: skip
        workshop.workers.append(self.worker)


@pytest.fixture
def far(tmp_path: Path, cable: Cable, monkeypatch: pytest.MonkeyPatch) -> Iterator[Far]:
    monkeypatch.setitem(recipes.RECIPES, "burn", recipes.Recipe("burn", "burning:burn", timeout_s=200.0))
    with tempfile.TemporaryDirectory(prefix="exogauge-pg-") as folder, ExitStack() as opened:
        server = opened.enter_context(own_server(Path(folder), ("127.0.0.1", cable.here)))
        migrate_all(server.url())
        settings = Settings(data_dir=tmp_path / "data", database_url=server.url(), workers=0)
        installation = open_installation(settings)
        opened.callback(installation.close)
        workshop = Workshop(settings, installation.of_lab(settings.lab), tmp_path)
        opened.callback(workshop.close)
        yield Far(workshop, cable, server, tmp_path)


@pytest.mark.slow
def test_a_worker_that_is_cut_off_alone_goes_on_with_its_job(far: Far) -> None:
    job = far.workshop.submit("cut", seconds=CUT_S / 2)
    far.workshop.until(job, lambda now: now.progress > 0.0)
    far.cable.cut()
    time.sleep(CUT_S)
    assert far.workshop.job(job).state == "running"
    far.cable.mend()
    done = far.workshop.until(job, lambda now: now.state in ENDED, CUT_S + DEADLINE_S)
    assert (done.state, done.attempts, far.workshop.words("cut")) == ("succeeded", 1, ["start", "end"])
    assert far.worker.poll() is None


@pytest.mark.slow
def test_a_job_of_a_worker_that_is_cut_off_is_ended_once_by_another(far: Far) -> None:
    job = far.workshop.submit("cut", seconds=CUT_S / 2)
    running = far.workshop.until(job, lambda now: now.progress > 0.0)
    far.cable.cut()
    far.workshop.start_worker()  # afterwards: on a busy machine that takes as long as the job
    time.sleep(CUT_S)
    far.cable.mend()
    done = far.workshop.until(job, lambda now: now.state in ENDED, CUT_S + DEADLINE_S)
    assert (done.state, done.attempts) == ("succeeded", 2)
    assert done.worker != running.worker
    assert far.worker.wait(timeout=DEADLINE_S) == 3  # it saw that it had been declared dead
    assert far.workshop.artifacts(job) == ["results.json", "series/a.csv"]
    assert far.workshop.job(job) == done
    with psycopg.connect(far.workshop.settings.database_url) as database:
        ends = "SELECT count(*) FROM audit WHERE action = 'succeed' AND subject_id = %s"
        assert database.execute(ends, [job.id]).fetchone() == (1,)
