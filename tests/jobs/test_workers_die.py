"""Workers are killed, frozen, sent away and poisoned: a job ends all the same, and it ends once."""

from __future__ import annotations

import os
import signal
from contextlib import suppress
from pathlib import Path

import pytest
from tests.whole_service import descendants

from exogauge.jobs.claims import MAX_ATTEMPTS
from exogauge.jobs.code_version import code_version

on_sqlite = pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)


@pytest.mark.slow
def test_a_job_of_a_killed_worker_is_finished_by_another_and_ends_once(workshop):
    first = workshop.start_worker()
    job = workshop.submit("orphan", seconds=3.0)
    running = workshop.until(job, lambda now: now.progress > 0.0)
    workshop.start_worker()
    os.kill(first.pid, signal.SIGKILL)
    done = workshop.ended(job)
    assert (done.state, done.attempts) == ("succeeded", 2)
    assert done.worker != running.worker
    assert workshop.words("orphan").count("end") == 1
    assert workshop.artifacts(job) == ["results.json", "series/a.csv"]
    gone, succeeded = done.log.splitlines()
    assert f"attempt 1: its worker {running.worker} is gone" in gone
    assert "attempt 2 succeeded" in succeeded


@pytest.mark.slow
@on_sqlite
def test_an_evaluation_whose_processes_are_killed_on_the_way_ends_once_with_the_same_numbers(workshop):
    """What computes is killed first, then the worker itself; then another worker does it all."""
    first = workshop.start_worker()
    quiet = workshop.evaluate("quiet")
    assert workshop.ended(quiet).state == "succeeded"
    killed = workshop.evaluate("killed")
    workshop.until(killed, begun)
    child = the_child_of(first.pid)
    os.kill(child, signal.SIGKILL)
    again = workshop.until(killed, lambda now: now.attempts == 2 and begun(now))
    assert the_child_of(first.pid) != child
    assert "signal 9" in again.log
    os.kill(first.pid, signal.SIGKILL)
    workshop.start_worker()
    done = workshop.ended(killed)
    assert (done.state, done.attempts, done.crashes) == ("succeeded", 3, 1), done.log
    assert f"attempt 2: its worker {again.worker} is gone" in done.log
    assert workshop.artifacts(killed) == workshop.artifacts(quiet)
    assert workshop.numbers(killed) == workshop.numbers(quiet)


def begun(now) -> bool:
    """It computes, and is not done."""
    return now.state == "running" and 0.0 < now.progress < 0.9


def the_child_of(worker: int) -> int:
    """The process of a worker that computes."""
    found = []
    for pid in descendants(worker):
        with suppress(OSError):
            if b"exogauge.jobs.child" in Path(f"/proc/{pid}/cmdline").read_bytes():
                found.append(pid)
    (child,) = found
    return child


@pytest.mark.slow
def test_a_worker_that_was_frozen_and_replaced_writes_nothing_when_it_wakes(workshop):
    first = workshop.start_worker()
    job = workshop.submit("frozen", seconds=3.0)
    running = workshop.until(job, lambda now: now.progress > 0.0)
    workshop.start_worker()
    os.kill(first.pid, signal.SIGSTOP)
    taken = workshop.until(job, lambda now: now.worker != running.worker)
    os.kill(first.pid, signal.SIGCONT)
    done = workshop.ended(job)
    assert (done.state, done.worker) == ("succeeded", taken.worker)
    assert workshop.artifacts(job) == ["results.json", "series/a.csv"]
    assert first.wait(timeout=30) == 3  # it saw that it had been declared dead


@pytest.mark.slow
@on_sqlite
def test_a_worker_that_is_asked_to_leave_puts_its_job_back(workshop):
    first = workshop.start_worker()
    job = workshop.submit("handed over", seconds=4.0)
    workshop.until(job, lambda now: now.progress > 0.0)
    first.terminate()
    assert first.wait(timeout=30) == 0
    back = workshop.job(job)
    assert (back.state, back.attempts) == ("queued", 0)
    workshop.start_worker()
    done = workshop.ended(job)
    assert (done.state, done.attempts) == ("succeeded", 1)


@pytest.mark.slow
@on_sqlite
def test_a_job_that_kills_its_worker_every_time_stops(workshop, keep_alive):
    job = workshop.submit("killer", mode="kill_worker", seconds=0.1)
    keep_alive(4)  # each is started again later and later
    done = workshop.until(job, lambda now: now.state == "failed", deadline_s=180.0)
    assert f"{MAX_ATTEMPTS} times" in done.reason
    assert workshop.words("killer") == ["start"] * MAX_ATTEMPTS


@pytest.mark.slow
@on_sqlite
def test_a_job_that_takes_too_long_is_stopped(workshop):
    workshop.start_worker(BURN_LIMIT="1.0")
    done = workshop.ended(workshop.submit("slow", seconds=60.0))
    assert done.state == "failed"
    assert "limit" in done.reason


@pytest.mark.slow
def test_a_job_names_the_code_that_computed_it_and_no_equal_request_is_answered_by_other_code(workshop):
    old = workshop.start_worker(BURN_VERSION="0.0.9+old")
    job = workshop.submit("by old code", seconds=2.0)
    assert (job.code_version, job.requested_code_version) == (None, code_version())
    running = workshop.until(job, lambda now: now.progress > 0.0)
    assert running.code_version == "0.0.9+old"
    assert workshop.submit("by old code", seconds=2.0).id == job.id
    done = workshop.ended(job)
    assert (done.state, done.code_version, done.requested_code_version) == ("succeeded", "0.0.9+old", code_version())
    again = workshop.submit("by old code", seconds=2.0)
    assert again.id != job.id
    workshop.until(again, lambda now: now.progress > 0.0)
    old.terminate()
    old.wait(timeout=30)
    assert workshop.job(again).code_version is None  # back in the queue
    workshop.start_worker()
    done = workshop.ended(again)
    assert (done.state, done.code_version) == ("succeeded", code_version())
    assert workshop.submit("by old code", seconds=2.0).id == again.id
    assert workshop.job(job).state == "succeeded"
