"""Loops run where nothing can be kept, and are compiled ahead for the types with which they are called."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

BEND = """
import numpy as np
from exogauge.loops.bristle import bend
out = np.empty(3)
bend(np.array([0.0, 1.0, 3.0]), 10.0, out)
print(np.isfinite(out).all())
"""
COMPILED = """
from exogauge.loops.__main__ import compile_ahead
compile_ahead("exogauge.loops.bristle", "bend")
"""
MISSED = "print(sum(bend.stats.cache_hits.values()), sum(bend.stats.cache_misses.values()))"
AHEAD = """
from exogauge.loops.__main__ import every_loop
from exogauge.loops.compiled import ahead
from numba.core.sigutils import normalize_signature
every_loop()
for loop, types in ahead:
    arguments, _ = normalize_signature(types)
    names = loop.py_func.__code__.co_varnames[: loop.py_func.__code__.co_argcount]
    assert len(arguments) == len(names), (loop, names)
print(len(ahead))
"""


def said(script: str, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", script], env={**os.environ, **environment}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.slow
def test_a_loop_runs_where_what_is_compiled_cannot_be_kept(tmp_path):
    (tmp_path / "file").write_text("no folder")
    assert said(BEND, NUMBA_CACHE_DIR=str(tmp_path / "file" / "below")) == "True"


@pytest.mark.slow
def test_every_loop_that_others_call_says_for_which_types_it_is_compiled():
    assert int(said(AHEAD)) > 15


@pytest.mark.slow
def test_what_was_compiled_ahead_is_not_compiled_again(tmp_path):
    """It was kept under another name than the one that a call looks for, so that every new installation, and every
    process of one that keeps nothing, compiled for half a minute in the midst of its first job."""
    said(COMPILED, NUMBA_CACHE_DIR=str(tmp_path))
    assert said(BEND + MISSED, NUMBA_CACHE_DIR=str(tmp_path)).splitlines()[1] == "1 0"
