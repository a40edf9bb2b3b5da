"""How many connections to PostgreSQL a worker holds: a server gives a hundred, to all workers and servers together."""

from __future__ import annotations

import time
from collections import Counter

import psycopg
import pytest
from tests.jobs.conftest import Workshop

OURS, ENGINES = "the-worker", "dbos_transact"
HELD = {OURS: 3, ENGINES: 1}  # the bell's, the lease's, the job's; the queue's


@pytest.mark.parametrize("database_url", ["postgresql"], indirect=True)
def test_a_worker_holds_four_connections_whatever_it_does(workshop: Workshop) -> None:
    workshop.start_worker(PGAPPNAME=OURS)
    assert workshop.ended(workshop.submit("first")).state == "succeeded"
    most = most_held(workshop, 2.0)
    asked = [
        workshop.submit(mode, mode=mode, seconds=0.3) for mode in ("ok", "bad", "segfault_once", "differ", "defect")
    ]
    asked.append(workshop.submit("cancelled", seconds=30.0))
    for job in asked[:-1]:
        while workshop.job(job).state in ("queued", "running"):
            most |= most_held(workshop, 0.1)
    workshop.until(asked[-1], lambda job: job.state == "running")
    workshop.cancel(asked[-1])
    while workshop.job(asked[-1]).state == "running":
        most |= most_held(workshop, 0.1)
    most |= most_held(workshop, 1.0)
    ended = [workshop.job(job).state for job in asked]
    assert ended == ["succeeded", "failed", "succeeded", "failed", "failed", "cancelled"]
    assert most[ENGINES] == HELD[ENGINES], most
    assert 1 < most[OURS] <= HELD[OURS], most


def most_held(workshop: Workshop, seconds: float) -> Counter[str]:
    """Connections by name, the most that were seen at once."""
    most, end = Counter[str](), time.monotonic() + seconds
    with psycopg.connect(workshop.settings.database_url, autocommit=True) as asking:
        while time.monotonic() < end:
            found = asking.execute(
                "SELECT application_name FROM pg_stat_activity WHERE datname = current_database()"
            ).fetchall()
            most |= Counter(name for (name,) in found if name in HELD)
            time.sleep(0.02)
    return most
