"""Motions that identify: CPU time of a plan, and how much less doubt it leaves than random motions in the same bounds.

`python -m tests.bench.excite [ROBOT ...]`. Random motions: of the same series and of one half as fast, every joint as
large as its own bounds bear, then all as large as the others do; of both kinds, the one that leaves less counts. They
may run into themselves: shrunk until they do not, they leave several times as much.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy is imported

import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from tests.motion.robots import ARMS, arm_folder, sample_folder

from exogauge.criteria.motion_excite import USUAL, MotionExcite
from exogauge.experiment.envelope import random_motion, within
from exogauge.motion.excite.plan import plan_excitation
from exogauge.motion.excite.search import Task
from exogauge.motion.excite.task import task_of
from exogauge.motion.robot_file import load_motion_robot
from exogauge.studies.intake.robot_file import load_robot
from exogauge.terminal import text_table

Array = NDArray[np.float64]

RANDOM, SECONDS = 12, 10.0


def report(names: tuple[str, ...] = (*ARMS, "sample")) -> None:
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            made = Path(folder) / name
            rows.append(row(name, arm_folder(made, name) if name in ARMS else sample_folder(made)))
    print(f"\nMotions of {SECONDS:g} s that identify, against {RANDOM} random ones within the same bounds")
    print(text_table(("robot", "CPU s", "nearest bound", "median std, random over planned", "of each"), rows))


def row(name: str, path: Path) -> list[str]:
    plan_excitation(path, 3.0, criteria=replace(USUAL, drawn=1, steps=3))  # loops are compiled once
    began = time.process_time()
    plan = plan_excitation(path, SECONDS)
    spent = time.process_time() - began
    planned = base_std(plan.planned.task, plan.planned.x)
    slower = replace(USUAL, top_hz=USUAL.top_hz / 2, standing_hz=USUAL.standing_hz / 2)
    found = []
    for criteria in (USUAL, slower):
        of = task(path, criteria)
        for seed in range(RANDOM):
            found.append(base_std(of, within(of, random_motion(of, np.random.default_rng(100 + seed)))))
    kinds = np.median(np.median(np.array(found).reshape(2, RANDOM, -1), axis=2), axis=1)
    better = np.array(found).reshape(2, RANDOM, -1)[int(kinds.argmin())]
    ratios = np.median(better, axis=1) / np.median(planned)
    return [name, f"{spent:.1f}", f"{100 * plan.nearest[0]:.1f} %", f"{np.median(ratios):.2f}",
            f"{ratios.min():.2f} to {ratios.max():.2f}"]  # fmt: skip


def task(path: Path, criteria: MotionExcite) -> Task:
    robot = replace(load_motion_robot(path), shapes=())
    return task_of(load_robot(path.parent, path.name), robot, SECONDS, criteria)


def base_std(of: Task, x: Array) -> Array:
    """(B,) of base parameters."""
    return np.sqrt(np.diag(of.told(x).covariance)[: of.information.equations.base_size])


if __name__ == "__main__":
    report(*([tuple(sys.argv[1:])] if sys.argv[1:] else []))
