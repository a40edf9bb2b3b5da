"""A file of joint angles as a motion of a robot whose left foot stands."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from exogauge.errors import BadMotion, Fault
from exogauge.logs.open_table import open_table
from exogauge.logs.tables import read_names
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.standing import base_on, home_of

Array = NDArray[np.float64]

FEWEST = 4  # samples that make a cubic


@final
@dataclass(frozen=True)
class Written:
    """time: (T,) [s] from 0; q: (T, n). held: joints that the file does not name, at home throughout."""

    time: Array
    q: Array
    held: tuple[str, ...]

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.time[-1])

    def at(self, time: Array) -> tuple[Array, Array, Array]:
        """q, q̇, q̈ (T, n) of the cubic spline through the samples."""
        whole = CubicSpline(self.time, self.q)
        return whole(time), whole(time, 1), whole(time, 2)


def read_written(robot: MotionRobot, path: Path) -> Written:
    """Columns t [s] and q.<joint> [rad or m]; the base is where the left foot puts it. Raises BadMotion, BadLog."""
    if not path.is_file():
        raise BadMotion(Fault("there is no such file", "no_file", "Look at its name", path.name))
    table = open_table(path, path.name)
    names = read_names(table)
    known = [name for name in robot.joints if f"q.{name}" in names]
    if "t" not in names or not known:
        raise BadMotion(Fault("no motion of this robot is in the file", "missing_column",
                              f"Columns t [s] and q.<joint>, as q.{robot.joints[0]}", path.name, 0,
                              "t" if "t" not in names else f"q.{robot.joints[0]}"))  # fmt: skip
    columns = table.read(["t", *(f"q.{name}" for name in known)])
    for name, values in columns.items():
        wrong = np.flatnonzero(~np.isfinite(values))
        if len(wrong):
            raise BadMotion(Fault("the cell is not a finite number", "not_a_number", "Correct it or cut the motion",
                                  path.name, int(wrong[0]) + 1, name, str(values[wrong[0]])))  # fmt: skip
    time = np.asarray(columns["t"], dtype=np.float64)
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if len(time) < FEWEST or len(back):
        row = int(back[0]) + 2 if len(back) else len(time)
        raise BadMotion(Fault("time does not run on" if len(back) else "too few samples for a motion", "bad_time",
                              f"At least {FEWEST} rows, each later than the one before", path.name, row, "t",
                              f"{time[row - 1]:g}" if len(time) else None))  # fmt: skip
    q = np.tile(home_of(robot), (len(time), 1))
    for name in known:
        q[:, robot.base + robot.joints.index(name)] = columns[f"q.{name}"]
    q[:, : robot.base] = base_on(robot, q)
    return Written(time - time[0], q, tuple(name for name in robot.joints if name not in known))
