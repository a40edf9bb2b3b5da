"""Compiles every loop ahead, on as many processors as there are: `python -m exogauge.loops`.

Without it the first process that needs a loop compiles it, and so does every other that starts meanwhile.
"""

from __future__ import annotations

import importlib
import os
import pkgutil
from concurrent.futures import ProcessPoolExecutor

from numba.core.sigutils import normalize_signature

import exogauge.loops
from exogauge.loops import compiled


def every_loop() -> list[tuple[str, str]]:
    """Module and name of every loop with types to compile for; those that take longest first."""
    modules = [m.name for m in pkgutil.iter_modules(exogauge.loops.__path__) if m.name not in ("compiled", "__main__")]
    for module in modules:
        importlib.import_module(f"exogauge.loops.{module}")
    loops = dict.fromkeys((loop.__module__, loop.__name__) for loop, _ in compiled.ahead)
    return sorted(loops, key=lambda at: "fill" not in at[1])


def compile_ahead(module: str, name: str) -> None:
    importlib.import_module(module)
    for loop, types in compiled.ahead:
        if (loop.__module__, loop.__name__) == (module, name):
            arguments, _ = normalize_signature(types)  # what is kept is found by the types, not by how they are written
            loop.compile(arguments)


if __name__ == "__main__":
    with ProcessPoolExecutor(os.cpu_count()) as processes:
        list(processes.map(compile_ahead, *zip(*every_loop(), strict=True)))
