"""Short looks at the database have a few threads of their own, and read nothing that may be waited for."""

from __future__ import annotations

import threading
import time
from typing import Any

import anyio
import pytest
from fastapi.testclient import TestClient
from starlette.concurrency import run_in_threadpool

from exogauge.api import threads
from exogauge.api.threads import in_short_thread

FRAMEWORKS = 40  # threads, as anyio has them


def test_a_few_look_at_once_and_wait_for_nothing_slow() -> None:
    """Uploads that are read, or files that do not come, hold all the framework's threads for as long as they like."""
    free, now, most, lock = threading.Event(), [0], [0], threading.Lock()

    def look() -> None:
        with lock:
            now[0] += 1
            most[0] = max(most[0], now[0])
        time.sleep(0.005)
        with lock:
            now[0] -= 1

    async def ask() -> None:
        async with anyio.create_task_group() as slow:
            for _ in range(FRAMEWORKS):
                slow.start_soon(run_in_threadpool, free.wait)
            with anyio.fail_after(10.0):
                async with anyio.create_task_group() as quick:
                    for _ in range(5 * threads.AT_ONCE):
                        quick.start_soon(in_short_thread, look)
            free.set()

    anyio.run(ask)
    assert 1 < most[0] <= threads.AT_ONCE


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_what_is_short_reads_no_file(client: TestClient, finished_job: str, monkeypatch: pytest.MonkeyPatch) -> None:
    shorts = [route for route in client.app.router.routes if hasattr(getattr(route, "endpoint", None), threads.SHORT)]  # type: ignore[attr-defined]
    assert len(shorts) >= 5
    study = client.get(f"/api/v1/jobs/{finished_job}").json()["study_id"]
    blobs = type(client.app.state.installation.blobs)  # type: ignore[attr-defined]

    def read(*_: Any) -> None:
        raise AssertionError("a file is read")

    for name in ("open", "path_for"):
        monkeypatch.setattr(blobs, name, read)
    for route in shorts:
        path = route.path.format(job_id=finished_job, study_id=study)
        assert client.get(path).status_code == 200
    assert client.get(f"/api/v1/jobs/{finished_job}/results").status_code == 500  # one that does, seen
