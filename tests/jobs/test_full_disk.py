"""A job that meets a full disk waits for room and goes on; no fault is found with what was handed in."""

from __future__ import annotations

import shutil

import pytest

on_sqlite = pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
PAGE = 4096


@pytest.fixture
def scratch(workshop, small_disk):
    """The disk on which the workers compute."""
    workshop.settings.data_dir.mkdir(exist_ok=True)
    (workshop.settings.data_dir / "work").symlink_to(small_disk.folder)
    return small_disk


def waits(job) -> bool:
    return job.message.startswith("waits: ") and "the disk is full" in job.message


@pytest.mark.slow
@on_sqlite
def test_a_study_that_does_not_fit_into_the_scratch_folder_waits_for_room(workshop, scratch):
    workshop.start_worker()
    workshop.ended(workshop.submit("before"))  # the worker has its folder
    scratch.fill(but=2 * PAGE)  # room for two folders and no file
    job = workshop.submit("waiting")
    waiting = workshop.until(job, waits)
    assert (waiting.state, waiting.attempts) == ("running", 1)
    scratch.empty()
    done = workshop.ended(job)
    assert (done.state, done.attempts, done.reason) == ("succeeded", 1, None)


@pytest.mark.slow
@on_sqlite
@pytest.mark.parametrize("mode", ["ok", "hides"])
def test_a_computation_that_meets_a_full_disk_begins_anew(workshop, scratch, mode):
    """hides: its reader takes what the disk refused for a damaged file."""
    workshop.start_worker()
    workshop.ended(workshop.submit("before"))
    scratch.fill(but=60 * PAGE)
    job = workshop.submit("large", bytes=100 * PAGE, seconds=0.1, mode=mode)
    workshop.until(job, waits)
    scratch.empty()
    done = workshop.ended(job)
    assert (done.state, done.attempts, done.reason) == ("succeeded", 1, None)
    assert workshop.words("large").count("start") > 1
    assert workshop.words("large").count("end") == 1
    assert "load" in workshop.artifacts(job)


@pytest.mark.slow
@on_sqlite
def test_a_result_that_cannot_be_kept_is_kept_later_without_computing_again(workshop, small_disk):
    blobs = small_disk.folder / "blobs"
    shutil.copytree(workshop.settings.blobs, blobs)
    workshop.start_worker(EXOGAUGE_BLOB_DIR=str(blobs))
    workshop.ended(workshop.submit("before"))
    small_disk.fill(but=6 * PAGE)
    job = workshop.submit("kept", bytes=20 * PAGE)
    unwanted = workshop.submit("unwanted", bytes=20 * PAGE)
    workshop.until(job, waits)
    small_disk.empty()
    assert workshop.ended(job).state == "succeeded"
    assert workshop.words("kept") == ["start", "end"]
    small_disk.fill(but=6 * PAGE)
    workshop.until(unwanted, waits)
    workshop.cancel(unwanted)
    assert workshop.ended(unwanted).state == "cancelled"
