"""How much memory a pass over T samples adds. In a process of its own: `python -m tests.bench.memory T`.

The log is 1000 samples long and walked through again and again, so that it does not count itself.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from tests.bench.problems import make
from tests.bench.study import equations_of

ROOT = Path(__file__).parents[2]
LOOP = 1000  # samples


def measure(samples: int) -> float:
    """[MB] peak of resident memory during `Equations.collect` on Talos above what was resident before, in a child."""
    command = [sys.executable, "-m", "tests.bench.memory", str(samples)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return float(done.stdout)


def extra_megabytes(samples: int) -> float:
    """The same in this process."""
    equations, prepared = equations_of(make("Talos", LOOP + 500))
    x = np.zeros(equations.size)
    equations.collect(replace(prepared, kept=np.arange(2)), x, folds=1)  # imports, compilation
    looped = replace(prepared, kept=np.resize(np.arange(200, 200 + LOOP), samples))
    return added(lambda: equations.collect(looped, x, folds=1))


def added(call: Callable[[], object]) -> float:
    """[MB] peak of resident memory during a call above what was resident before. Linux."""
    before = _status("VmRSS")
    Path("/proc/self/clear_refs").write_text("5")  # forget the peak so far
    call()
    return _status("VmHWM") - before


def _status(name: str) -> float:
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(name)) / 1024.0


if __name__ == "__main__":
    print(extra_megabytes(int(sys.argv[1])))
