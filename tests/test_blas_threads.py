"""Processes beside each other use one thread of linear algebra each, unless somebody asked for more."""

import os
import subprocess
import sys

from exogauge.blas_threads import LIMITS, limit_children, one_thread


def test_what_was_asked_for_stays():
    assert one_thread({"OPENBLAS_NUM_THREADS": "4", "HOME": "x"})["OPENBLAS_NUM_THREADS"] == "4"
    assert one_thread({"HOME": "x"}) == {"HOME": "x", **dict.fromkeys(LIMITS, "1")}


def test_children_start_with_one_thread(monkeypatch):
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    for name in LIMITS:
        monkeypatch.setenv(name, os.environ.get(name, "1"))
    monkeypatch.delenv("OPENBLAS_NUM_THREADS")
    limit_children()
    said = subprocess.run(
        [sys.executable, "-c", "import os; print(os.environ['OPENBLAS_NUM_THREADS'])"], capture_output=True, check=True
    )
    assert said.stdout.split() == [b"1"]
