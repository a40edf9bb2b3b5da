"""A lab with real worker processes, on each kind of database."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest
from tests.whole_service import small_study

from exogauge.jobs import recipes, requests
from exogauge.jobs.code_version import code_version
from exogauge.jobs.engine import JobQueue
from exogauge.jobs.supervisor import Supervisor
from exogauge.settings import Settings
from exogauge.storage.files import PinnedFile
from exogauge.storage.records import JobRecord
from exogauge.storage.store import Installation, Storage, open_installation

HERE = Path(__file__).parent
PROGRAM = HERE / "burning.py"
BURN = recipes.Recipe("burn", "burning:burn", timeout_s=60.0)
SAYS_WHICH = {"inputs", "configuration"}  # of results.json: both hold hashes of what was handed in
DEADLINE_S = 60.0  # for a machine that is busy with other things; nothing waits that long when all is well


class Workshop:
    """Submits burning jobs and starts, kills and stops workers that run them."""

    def __init__(self, settings: Settings, storage: Storage, folder: Path) -> None:
        self.settings, self.storage, self.folder = settings, storage, folder
        self.queue = JobQueue(storage.engine)
        self.workers: list[subprocess.Popen[bytes]] = []
        blob = storage.blobs.put(b"version: 1\n")
        with storage.transaction() as store:
            self.study, _ = store.studies.add("burning", [PinnedFile("study.yaml", blob, 11)], {})

    def environment(self, **more: str) -> dict[str, str]:
        ours = {
            "EXOGAUGE_DATA_DIR": str(self.settings.data_dir),
            "EXOGAUGE_DATABASE_URL": self.settings.database_url,
            "PYTHONPATH": str(HERE),
            "PYTHONWARNINGS": "default",
            "BURN_VERSION": code_version(),  # as it is here, also where somebody edits a file while tests run
        }
        return {**os.environ, **ours, **more}

    def start_worker(self, **environment: str) -> subprocess.Popen[bytes]:
        with (self.folder / "workers.log").open("ab") as log:
            worker = subprocess.Popen(
                [sys.executable, str(PROGRAM), "work"],
                env=self.environment(**environment),
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
            )
        self.workers.append(worker)
        return worker

    def ledger(self, name: str) -> Path:
        return self.folder / f"{name}.ledger"

    def words(self, name: str) -> list[str]:
        return self.ledger(name).read_text().split() if self.ledger(name).exists() else []

    def submit(self, name: str, **settings: Any) -> JobRecord:
        wanted = {"ledger": str(self.ledger(name)), **settings}
        with self.storage.transaction() as store:
            return requests.submit(store, self.queue, self.study.id, "burn", wanted)[0]

    def evaluate(self, name: str) -> JobRecord:
        """A real evaluation, of a small study whose name alone is its own."""
        with self.storage.transaction() as store:
            pinned = [
                PinnedFile(path, store.blobs.put(content), len(content)) for path, content in small_study(name).items()
            ]
            study, _ = store.studies.add(name, pinned, {})
        with self.storage.transaction() as store:
            return requests.submit(store, self.queue, study.id, "evaluate", {})[0]

    def numbers(self, job: JobRecord) -> dict[str, Any]:
        """Of results.json what does not say of which study, when and by which run."""
        with self.storage.reading() as store:
            (found,) = (each for each in store.results.artifacts(job.id) if each.name == "results.json")
            with store.blobs.stored(found.sha256) as stream:
                results = json.load(stream)
        return {key: results[key] for key in results if key not in SAYS_WHICH}

    def elsewhere(self, lab_id: str) -> Workshop:
        """The same installation, as another lab sees it: with a study of its own, and without workers of its own."""
        installation = Installation(self.storage.engine, self.storage.blobs)
        return Workshop(self.settings, installation.of_lab(lab_id), self.folder)

    def cancel(self, job: JobRecord) -> None:
        with self.storage.transaction() as store:
            requests.cancel(store, job.id)

    def job(self, job: JobRecord) -> JobRecord:
        with self.storage.reading() as store:
            return store.jobs.get(job.id)

    def until(self, job: JobRecord, holds: Callable[[JobRecord], bool], deadline_s: float = DEADLINE_S) -> JobRecord:
        """The job as soon as `holds`; fails with the workers' log after the deadline."""
        end = time.monotonic() + deadline_s
        while time.monotonic() < end:
            now = self.job(job)
            if holds(now):
                return now
            time.sleep(0.05)
        log = (self.folder / "workers.log").read_text()[-4000:] if self.workers else ""
        pytest.fail(f"the job did not get there in {deadline_s} s: {now}\n{log}")

    def ended(self, job: JobRecord) -> JobRecord:
        return self.until(job, lambda now: now.state in ("succeeded", "failed", "cancelled"))

    def artifacts(self, job: JobRecord) -> list[str]:
        with self.storage.reading() as store:
            return [artifact.name for artifact in store.results.artifacts(job.id)]

    def close(self) -> None:
        for worker in self.workers:
            if worker.poll() is None:
                worker.send_signal(signal.SIGCONT)
                worker.kill()
            worker.wait()
        self.queue.close()


@pytest.fixture
def workshop(
    settings: Settings, storage: Storage, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Workshop]:
    """A workshop of its own for one test, without workers."""
    monkeypatch.setitem(recipes.RECIPES, "burn", BURN)
    opened = Workshop(settings, storage, tmp_path)
    yield opened
    opened.close()


@pytest.fixture(scope="module")
def throw_away(
    throw_away_database: Callable[..., AbstractContextManager[str]], migrated_postgres: str
) -> Iterator[str]:
    """A PostgreSQL database for a module."""
    with throw_away_database(migrated_postgres) as url:
        yield url


@pytest.fixture(scope="module", params=["sqlite", "postgresql"])
def staffed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workshop]:
    """A workshop with one worker, shared by the tests of a module."""
    folder = tmp_path_factory.mktemp("staffed")
    if request.param == "sqlite":
        shutil.copy(request.getfixturevalue("migrated_sqlite"), folder / "test.sqlite")
        url = f"sqlite:///{folder / 'test.sqlite'}"
    else:
        url = request.getfixturevalue("throw_away")
    settings = Settings(data_dir=folder / "data", database_url=url, workers=0)
    installation = open_installation(settings)
    opened = Workshop(settings, installation.of_lab(settings.lab), folder)
    opened.start_worker(BURN_LIMIT="20")
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(recipes.RECIPES, "burn", BURN)
        yield opened
    opened.close()
    installation.close()


@pytest.fixture
def keep_alive(workshop: Workshop) -> Iterator[Callable[[int], Supervisor]]:
    """Start supervised workers."""
    supervisors = []

    def start(count: int) -> Supervisor:
        command = [sys.executable, str(PROGRAM), "work", "--with-parent"]
        supervisors.append(Supervisor(command, count, workshop.environment()))
        supervisors[-1].start()
        return supervisors[-1]

    yield start
    for supervisor in supervisors:
        supervisor.stop()
