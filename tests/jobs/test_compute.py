"""The compute child: whatever the other side does, an answer is the answer to what was asked."""

from __future__ import annotations

import time

import pytest

from exogauge.errors import Cancelled
from exogauge.jobs.compute import ComputeChild, ComputeChildDied, ComputeFailed, ComputeTimeout


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
