"""Workers on a machine of their own: with the server they share the database and an object store, and no disk."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.jobs.conftest import BURN, PROGRAM, Workshop
from tests.object_store import BUCKET, KEYS, Line, s3_server
from tests.slurm import slurm

from exogauge.jobs import recipes
from exogauge.settings import Settings
from exogauge.storage.store import open_installation


@pytest.fixture
def line() -> Iterator[Line]:
    with s3_server() as port:
        line = Line(port)
        yield line
        line.close()


@pytest.fixture
def apart(line: Line, tmp_path: Path, own_postgres_url: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[Workshop]:
    """A workshop whose files are in an object store."""
    monkeypatch.setitem(recipes.RECIPES, "burn", BURN)
    store: dict[str, Any] = {"blob_url": f"s3://{BUCKET}", "s3_endpoint": line.endpoint, **KEYS}
    settings = Settings(data_dir=tmp_path / "server", database_url=own_postgres_url, workers=0, **store)
    installation = open_installation(settings)
    opened = Workshop(settings, installation.of_lab(settings.lab), tmp_path)
    yield opened
    opened.close()
    installation.close()


def elsewhere(folder: Path, line: Line) -> dict[str, str]:
    """Settings of a worker on another machine."""
    store = {"blob_url": f"s3://{BUCKET}", "s3_endpoint": line.endpoint, **KEYS}
    return {"EXOGAUGE_DATA_DIR": str(folder), **{f"EXOGAUGE_{name.upper()}": value for name, value in store.items()}}


@pytest.mark.slow  # starts servers and workers
def test_a_job_is_computed_without_a_shared_disk_and_waits_for_a_store_that_is_cut_off(
    apart: Workshop, line: Line, tmp_path: Path
) -> None:
    apart.start_worker(**elsewhere(tmp_path / "worker", line))
    apart.start_worker(**elsewhere(tmp_path / "another", line))
    first = apart.ended(apart.submit("first", bytes=20_000))
    assert (first.state, first.attempts, first.reason) == ("succeeded", 1, None)
    with apart.storage.reading() as store:
        made = {each.name: each for each in store.results.artifacts(first.id)}
    assert made["load"].size == 20_000
    with apart.storage.blobs.open(made["load"].sha256) as stream:
        assert hashlib.sha256(stream.read()).hexdigest() == made["load"].sha256

    job = apart.submit("second", bytes=30_000, seconds=3.0)
    apart.until(job, lambda now: apart.words("second") == ["start"])
    line.cut()
    apart.until(job, lambda now: now.message.startswith("waits: ") and "object store" in now.message)
    line.mend()
    second = apart.ended(job)
    assert (second.state, second.attempts, second.reason) == ("succeeded", 1, None)
    assert apart.words("second") == ["start", "end"]
    assert sorted(path.name for path in (tmp_path / "server").iterdir()) == ["blob-copies", "scratch"]


@pytest.mark.slow  # starts servers and workers
def test_a_job_that_begins_while_the_store_is_cut_off_ends_once(apart: Workshop, line: Line, tmp_path: Path) -> None:
    line.cut()
    apart.start_worker(**elsewhere(tmp_path / "worker", line))
    job = apart.submit("early")
    apart.until(job, lambda now: now.message.startswith("waits: ") and "object store" in now.message)
    line.mend()
    done = apart.ended(job)
    assert (done.state, done.reason) == ("succeeded", None)
    assert apart.words("early") == ["start", "end"]


@pytest.mark.slow  # starts a worker
def test_a_worker_leaves_when_there_is_nothing_to_do(apart: Workshop, line: Line, tmp_path: Path) -> None:
    job = apart.submit("alone", seconds=2.0)
    worker = apart.start_worker(**elsewhere(tmp_path / "worker", line), BURN_UNTIL_IDLE="6")
    assert worker.wait(60.0) == 0
    assert apart.job(job).state == "succeeded"
    assert not any((tmp_path / "worker" / "work").iterdir())


@pytest.mark.slow  # starts servers and workers
def test_workers_are_slurm_jobs(apart: Workshop, line: Line, tmp_path: Path) -> None:
    jobs = [apart.submit(f"batch-{k}", seconds=0.5) for k in range(4)]
    (tmp_path / "slurm").mkdir()
    with slurm(tmp_path / "slurm") as ours:
        place = elsewhere(tmp_path / "node", line)
        environment = apart.environment(**place, **ours, BURN_UNTIL_IDLE="6")
        asked = ["sbatch", "--array=1-2", "--wait", f"--output={tmp_path}/slurm-%a.out", f"--chdir={tmp_path}"]
        work = f'--wrap="{sys.executable}" "{PROGRAM}" work'
        subprocess.run([*asked, work], env=environment, check=True, capture_output=True, timeout=120.0)
    assert [apart.job(job).state for job in jobs] == ["succeeded"] * 4
    assert [apart.words(f"batch-{k}") for k in range(4)] == [["start", "end"]] * 4
    assert all("takes jobs" in (tmp_path / f"slurm-{k}.out").read_text() for k in (1, 2))
