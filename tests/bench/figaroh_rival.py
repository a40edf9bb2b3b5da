"""figaroh as a rival: a process in `.venv-bench` that is given the same log and reports its own CPU seconds."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import final

import numpy as np
from numpy.typing import NDArray
from tests.bench.problems import Problem

Array = NDArray[np.float64]

ROOT = Path(__file__).parents[2]
PYTHON = ROOT / ".venv-bench" / "bin" / "python"


@final
class Figaroh:
    """Fixed-base robots only: figaroh's joint mode takes no free-flyer."""

    def __init__(self, problem: Problem, folder: Path) -> None:
        q, v, a = problem.pinocchio()
        self._file = folder / f"{problem.name}.npz"
        held = np.array(problem.held, dtype=np.str_)
        np.savez(self._file, urdf=str(problem.urdf), held=held, q=q, v=v, a=a, tau=problem.forces)
        command = [str(PYTHON), str(Path(__file__).with_name("figaroh_side.py")), str(self._file)]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def run(self, mode: str) -> Callable[[], float]:
        """A call that identifies once and returns its CPU seconds. mode: full or decimated."""

        def call() -> float:
            assert self._process.stdin is not None
            assert self._process.stdout is not None
            print(mode, file=self._process.stdin, flush=True)
            for line in self._process.stdout:  # figaroh may print of its own
                try:
                    return float(line)
                except ValueError:
                    continue
            raise RuntimeError("figaroh ended without an answer")

        return call

    def difference(self, mode: str, problem: Problem, phi_base: Array) -> float:
        """Largest difference of its base parameters from ours, relative to the largest of its own."""
        answer = np.load(f"{self._file}.{mode}.npz")
        phi = np.zeros(10 * problem.model.nv)
        phi[problem.columns] = phi_base  # any standard parameters that give these base parameters will do
        theirs = answer["phi_base"]
        return float(np.abs(answer["M"] @ phi[answer["columns"]] - theirs).max() / np.abs(theirs).max())

    def __enter__(self) -> Figaroh:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait(timeout=30)
