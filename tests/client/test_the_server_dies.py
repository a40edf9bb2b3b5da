"""The server is killed in the middle of a job; started again, it finishes what it had accepted."""

from __future__ import annotations

import os
import signal
import time

import pytest

from exogauge.client import Client


@pytest.mark.slow
def test_a_killed_server_finishes_the_job_after_its_restart(make_service, database_url, study_folder, tmp_path):
    service = make_service(database_url=database_url)
    with Client(service.start()) as client:
        study = client.upload_study(study_folder)
        job = client.submit(study, "burn", {"ledger": str(tmp_path / "ledger"), "seconds": 5.0})
        waiting = client.submit(study, "burn", {"ledger": str(tmp_path / "ledger2"), "seconds": 0.1})
        while client.job(job).progress == 0.0:
            time.sleep(0.05)
    assert service.process is not None
    os.kill(service.process.pid, signal.SIGKILL)
    service.process.wait()
    with Client(service.start()) as client:
        done = client.wait(job, progress=False, timeout_s=90.0)
        assert client.wait(waiting, progress=False, timeout_s=90.0).attempts == 1
        assert [each.name for each in client.artifacts(job)] == ["results.json", "series/a.csv"]
    assert done.attempts <= 2
    assert (tmp_path / "ledger").read_text().split().count("end") == 1
