"""What `make bench` compares must be the same problem."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.slow
@pytest.mark.thorough
def test_every_way_of_the_bench_finds_the_same_parameters():
    root = Path(__file__).parents[1]
    done = subprocess.run([sys.executable, "-m", "tests.bench", "--quick"], cwd=root, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "estimates differ by at most" in done.stdout
