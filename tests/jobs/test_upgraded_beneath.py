"""The program's files are replaced beneath processes that run: no result is made by code of two versions."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from tests.jobs.conftest import HERE, Workshop

from exogauge.jobs.code_version import OUTDATED, PACKAGE
from exogauge.settings import packaged_folder

LATE = "exogauge.terminal"  # nothing that serves or computes here imports it by itself
SAYS = "from exogauge.jobs.code_version import code_version\nprint(code_version())"


@pytest.fixture
def installed(tmp_path: Path) -> Path:
    """A copy of the package, as an upgrade may replace it."""
    ignored = shutil.ignore_patterns("_packaged", "*.nbc", "*.nbi")
    copied = shutil.copytree(PACKAGE, tmp_path / "installed" / "exogauge", ignore=ignored)
    shutil.copytree(packaged_folder("migrations"), copied / "_packaged" / "migrations")
    return copied.parent


def run(installed: Path, program: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(installed), "LATE": str(late(installed))}
    return subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, timeout=60)


def late(installed: Path) -> Path:
    return installed.joinpath(*LATE.split(".")).with_suffix(".py")


def upgrade(installed: Path) -> str:
    """As an installer does: another file in the place of the old one. Returns the version that it makes."""
    file = late(installed)
    new = file.with_suffix(".new")
    new.write_text(file.read_text() + "\nNEWER = True\n")
    new.rename(file)
    return version(installed)


def version(installed: Path) -> str:
    said = run(installed, SAYS)
    assert said.returncode == 0, said.stderr
    return said.stdout.strip()


REPLACE = "import os, pathlib\nfile = pathlib.Path(os.environ['LATE'])\nfile.write_text(file.read_text() + '#')\n"


@pytest.mark.slow
def test_a_process_that_first_asks_later_is_told_the_code_that_it_started_with(installed: Path) -> None:
    before = version(installed)
    said = run(installed, f"import exogauge.jobs.code_version\n{REPLACE}{SAYS}")
    assert said.stdout.strip() == before
    assert version(installed) != before


@pytest.mark.slow
@pytest.mark.parametrize("replace", [REPLACE, REPLACE + "file.unlink()\n"], ids=["other", "gone"])
def test_what_computes_ends_before_it_imports_a_file_of_other_code(installed: Path, replace: str) -> None:
    held = "from exogauge.jobs.code_version import *\nhold_to(code_version())\nimport exogauge.errors\n"
    tried = f"try:\n    import {LATE}\nexcept BaseException:\n    print('caught')\nprint('went on')\n"
    same = run(installed, held + tried)
    assert (same.returncode, same.stdout.split()) == (0, ["went", "on"]), same.stderr
    other = run(installed, held + replace + tried)
    assert (other.returncode, other.stdout) == (OUTDATED, ""), other.stderr


@pytest.mark.slow
@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_a_worker_computes_each_job_by_one_code_and_begins_anew_before_the_next(
    workshop: Workshop, installed: Path
) -> None:
    versions = [version(installed)]
    places = os.pathsep.join((str(installed), str(HERE)))
    worker = workshop.start_worker(PYTHONPATH=places, BURN_VERSION="")

    first = workshop.ended(workshop.submit("first"))
    assert (first.state, first.code_version) == ("succeeded", versions[0])

    versions.append(upgrade(installed))
    waited = workshop.ended(workshop.submit("after an upgrade"))
    assert (waited.state, waited.code_version, waited.attempts) == ("succeeded", versions[1], 1)

    met = workshop.submit("met by an upgrade", seconds=2.0, needs=LATE)
    loaded = workshop.submit("needs nothing more", seconds=2.0)
    for number, (job, ends_as, times) in enumerate(((met, 2, 2), (loaded, 2, 1)), 2):
        workshop.until(job, lambda now: now.progress > 0.0)
        versions.append(upgrade(installed))
        done = workshop.ended(job)
        assert (done.state, done.code_version, done.attempts) == ("succeeded", versions[ends_as], 1), number
        assert Path(job.settings["ledger"]).read_text().split() == [*["start"] * times, "end"]
    assert len(set(versions)) == 4
    last = workshop.ended(workshop.submit("last"))
    assert (last.state, last.code_version) == ("succeeded", versions[3])
    assert worker.poll() is None  # the same process all the while
    assert len({first.worker, waited.worker, done.worker, last.worker}) == 4
    worker.terminate()
    assert worker.wait(timeout=30) == 0
