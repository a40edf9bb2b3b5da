"""The compute child: whatever the other side does, an answer is the answer to what was asked."""

from __future__ import annotations

import time
from types import SimpleNamespace

import pytest
import sqlalchemy as sa

from exogauge.errors import Cancelled
from exogauge.jobs.attempt import LOOK_EVERY_S, Runner
from exogauge.jobs.compute import ComputeChild, ComputeChildDied, ComputeFailed, ComputeTimeout
from exogauge.storage.blobs import FolderBlobs
from exogauge.storage.database import make_engine
from exogauge.storage.store import Installation


@pytest.fixture
def child(monkeypatch, request):
    monkeypatch.setenv("PYTHONPATH", str(request.path.parent))
    made = ComputeChild()
    yield made
    made.kill()


def call(child, folder, watch=lambda *_: None, timeout_s=30.0, **settings):
    out = folder / "out"
    out.mkdir(exist_ok=True)
    wanted = {"ledger": str(folder / "ledger"), "seconds": 0.05, **settings}
    child.call("burning:burn", folder, out, wanted, watch, timeout_s)


def test_what_the_computation_raises_is_told_apart_from_defects(child, tmp_path):
    with pytest.raises(ComputeFailed) as bad:
        call(child, tmp_path, mode="bad")
    assert bad.value.expected
    assert bad.value.faults[0]["file"] == "logs/a.csv"
    with pytest.raises(ComputeFailed) as defect:
        call(child, tmp_path, mode="defect")
    assert not defect.value.expected
    assert "ZeroDivisionError" in defect.value.trace


def test_an_interrupted_request_leaves_no_answer_for_the_next(child, tmp_path):
    def stop(fraction, message, stage):
        raise Cancelled("enough")

    with pytest.raises(Cancelled):
        call(child, tmp_path, watch=stop, seconds=0.3)
    with pytest.raises(ComputeFailed):  # and not the end of the first
        call(child, tmp_path, mode="bad")


def test_time_that_telling_of_it_takes_is_not_the_computations(child, tmp_path):
    """As where each look waits for a database that is away."""
    told = []

    def slow(fraction, message, stage):
        told.append(fraction)
        if len(told) < 4:
            time.sleep(0.5)

    call(child, tmp_path, watch=slow, seconds=0.8, timeout_s=1.0)
    assert len(told) >= 4


def test_a_database_that_is_away_is_looked_for_seldom_while_something_is_computed(tmp_path):
    """Else what is computed would wait for whoever looks, at a line that is cut for five seconds each time."""
    engine = make_engine("postgresql://nobody@127.0.0.1:1/nothing")
    tries = []
    sa.event.listen(engine, "do_connect", lambda *_: tries.append(time.monotonic()))
    runner = Runner(Installation(engine, FolderBlobs(tmp_path / "blobs")), "worker", tmp_path)
    job = SimpleNamespace(id="job", lab_id="lab")
    for k in range(10):
        runner._watch(job, k / 10, "so far", None)
        time.sleep(LOOK_EVERY_S / 2)
    assert len(tries) == 1


def test_a_crash_tells_the_signal_and_the_last_words(child, tmp_path):
    with pytest.raises(ComputeChildDied, match="signal 11") as died:
        call(child, tmp_path, mode="segfault", stdout="last words")
    assert "last words" in died.value.stderr
    assert "Segmentation fault" in died.value.stderr


def test_a_computation_that_takes_too_long_is_killed(child, tmp_path):
    began = time.monotonic()
    with pytest.raises(ComputeTimeout):
        call(child, tmp_path, seconds=60.0, timeout_s=1.0)
    assert time.monotonic() - began < 20.0
