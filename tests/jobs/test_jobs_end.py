"""A real worker on a real database: jobs run, fail with a reason, are cancelled, and never twice."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
import sqlalchemy as sa

from exogauge.errors import NotFound
from exogauge.jobs import bell, claims, requests
from exogauge.jobs.claims import MAX_CRASHES
from exogauge.storage.scope import AllLabsSession
from exogauge.storage.tables import Artifact, AuditEntry, Job, Result


def test_a_job_runs_with_progress_and_keeps_what_it_made(staffed):
    job = staffed.submit("plain", seconds=1.0)
    assert job.state == "queued"
    half_way = staffed.until(job, lambda now: 0.0 < now.progress < 1.0)
    assert half_way.state == "running"
    assert half_way.message.endswith("s left")
    assert half_way.stage == "reading"
    done = staffed.ended(job)
    assert (done.state, done.progress, done.attempts) == ("succeeded", 1.0, 1)
    assert staffed.artifacts(job) == ["results.json", "series/a.csv"]
    assert staffed.words("plain") == ["start", "end"]


def test_bad_input_fails_with_what_is_wrong_and_a_defect_with_its_trace(staffed):
    bad, defect = staffed.submit("bad", mode="bad"), staffed.submit("defect", mode="defect")
    done = staffed.ended(bad)
    assert done.state == "failed"
    assert "logs/a.csv" in done.reason
    assert "Add it." in done.reason
    assert (done.failure["class"], done.failure["defect"]) == ("BadStudy", False)
    assert (done.message, done.progress) == ("bad: about to", 0.6)
    assert done.steps[-1]["message"] == "bad: about to"
    assert done.failure["faults"] == [
        {"detail": "the log has no column", "rule": "missing_column", "advice": "Add it.", "file": "logs/a.csv",
         "row": None, "column": "t", "value": None}
    ]  # fmt: skip
    done = staffed.ended(defect)
    assert done.state == "failed"
    assert "ZeroDivisionError" in done.reason
    assert "nobody foresaw this" in done.log
    assert done.failure == {"class": "ZeroDivisionError", "faults": [], "defect": True}
    assert staffed.words("bad") == ["start"]  # an answer, however bad, is not asked for again


def test_a_running_job_is_cancelled_within_a_second(staffed):
    took = []
    for attempt in range(3):  # a busy machine may be slow once
        job = staffed.submit(f"long {attempt}", seconds=60.0)
        staffed.until(job, lambda now: now.progress > 0.0)
        asked = time.monotonic()
        staffed.cancel(job)
        assert staffed.ended(job).state == "cancelled"
        took.append(time.monotonic() - asked)
        if took[-1] < 1.0:
            break
    assert min(took) < 1.0
    assert staffed.ended(staffed.submit("after")).state == "succeeded"  # the worker is still good


def test_a_queued_job_is_cancelled_at_once_and_never_runs(staffed):
    busy = staffed.submit("busy", seconds=60.0)
    staffed.until(busy, lambda now: now.state == "running")
    job = staffed.submit("queued")
    with staffed.storage.reading() as store:
        assert requests.places(store.session, [staffed.job(job)])[job.id].words == "next to start"
    staffed.cancel(job)
    assert staffed.job(job).state == "cancelled"
    staffed.cancel(busy)
    staffed.ended(busy)
    staffed.ended(staffed.submit("after the queued one"))
    assert staffed.words("queued") == []


def test_the_same_request_is_one_job_until_it_has_failed(staffed):
    first, second = staffed.submit("same"), staffed.submit("same")
    assert first.id == second.id
    done = staffed.ended(first)
    assert done.state == "succeeded", f"{done.reason}\n{done.log}"
    assert staffed.submit("same").id == first.id
    assert staffed.words("same") == ["start", "end"]
    failing = staffed.submit("failing", mode="bad")
    staffed.ended(failing)
    with staffed.storage.transaction() as store:
        again, new = requests.try_again(store, staffed.queue, failing.id)
    assert new
    assert again.id != failing.id
    assert staffed.job(failing).state == "failed"
    assert staffed.ended(again).state == "failed"


def test_a_crash_in_native_code_costs_an_attempt_and_not_the_worker(staffed):
    job = staffed.submit("once", mode="segfault_once", stdout="last words")
    done = staffed.ended(job)
    assert (done.state, done.attempts) == ("succeeded", 2)
    assert "signal 11" in done.log
    assert "last words" in done.log
    assert staffed.workers[0].poll() is None


def test_a_job_that_crashes_every_time_stops(staffed):
    job = staffed.submit("poison", mode="segfault")
    done = staffed.ended(job)
    assert done.state == "failed"
    assert f"{MAX_CRASHES} times" in done.reason
    assert staffed.words("poison") == ["start"] * MAX_CRASHES


def test_a_worker_works_in_the_lab_of_the_job_and_not_in_one_of_its_own(staffed):
    """The worker was started for the lab `local`; what it reads and writes for another lab's job is that lab's."""
    other = staffed.elsewhere("far")
    job = other.submit("of another lab")
    done = other.ended(job)
    assert (done.state, done.lab_id) == ("succeeded", "far")
    assert other.artifacts(job) == ["results.json", "series/a.csv"]
    with pytest.raises(NotFound):
        staffed.job(job)
    with AllLabsSession(staffed.storage.engine) as session:
        for table, key in ((Job, Job.id), (Result, Result.job_id), (Artifact, Artifact.job_id)):
            assert set(session.scalars(sa.select(table.lab_id).where(key == job.id))) == {"far"}, table
        said = sa.select(AuditEntry.action, AuditEntry.lab_id).where(AuditEntry.subject_id == job.id)
        assert set(session.execute(said).all()) == {("submit", "far"), ("succeed", "far")}
    other.queue.close()


def test_a_lab_with_one_job_does_not_wait_for_all_of_a_lab_with_many(staffed):
    """And the place that each is told is the order in which they start."""
    other = staffed.elsewhere("small")
    busy = staffed.submit("holds the worker", seconds=60.0)
    staffed.until(busy, lambda now: now.state == "running")
    many = [staffed.submit(f"one of many {k}") for k in range(3)]
    few = [other.submit(f"one of few {k}") for k in range(2)]
    with AllLabsSession(staffed.storage.engine) as session:
        places = requests.places(session, [*many, *few])
    told = sorted([*many, *few], key=lambda job: places[job.id].ahead)
    assert [places[job.id].ahead for job in told] == list(range(5))
    assert [job.id for job in told] == [each.id for each in (few[0], many[0], few[1], *many[1:])]
    staffed.cancel(busy)
    begun = {job.id: (other if job.lab_id == "small" else staffed).ended(job).started_at for job in told}
    assert sorted(begun, key=lambda key: begun[key]) == [job.id for job in told]
    other.queue.close()


@pytest.mark.slow
def test_a_job_that_went_back_into_the_queue_is_where_its_age_puts_it(staffed):
    first = staffed.submit("goes back", seconds=60.0)
    running = staffed.until(first, lambda now: now.state == "running")
    second = staffed.submit("came later", seconds=60.0)
    with staffed.storage.transaction() as store:
        assert claims.release(store.session, running.worker) == 1
    with staffed.storage.reading() as store:
        places = requests.places(store.session, [staffed.job(first), staffed.job(second)])
    assert {job.id: places[job.id].ahead for job in (first, second) if job.id in places} in (
        {first.id: 0, second.id: 1},
        {second.id: 0},  # taken again already
    )
    for job in (first, second):
        staffed.cancel(job)
        staffed.ended(job)


@pytest.mark.slow
def test_a_worker_that_has_nothing_to_do_sleeps_until_the_bell_rings(staffed):
    staffed.ended(staffed.submit("before"))
    time.sleep(bell.BUSY_S + 1.0)
    before = wakings(staffed.workers[0].pid)
    time.sleep(5.0)
    assert (wakings(staffed.workers[0].pid) - before) / 5.0 < MOST_WAKINGS
    took = []
    for again in range(
        3
    ):  # without a bell one of three would begin within five seconds by chance in one of eight cases
        asked = time.monotonic()
        staffed.until(staffed.submit(f"after {again}"), lambda now: now.state != "queued")
        took.append(time.monotonic() - asked)
        time.sleep(bell.BUSY_S + 1.0)
    assert max(took) < bell.QUIET_S / 2


MOST_WAKINGS = (
    20.0  # a second, where 8 and 13 were seen; while DBOS looked for schedules, and each thread whether to stop, 24
)


def wakings(pid: int) -> int:
    """How often any thread of a process had gone to sleep."""
    lines = "".join(each.read_text() for each in Path(f"/proc/{pid}/task").glob("*/status")).splitlines()
    return sum(int(line.split()[1]) for line in lines if line.startswith("voluntary_ctxt_switches"))
