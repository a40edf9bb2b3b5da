"""A file of joint angles as a motion of a robot on its feet, and which of them stand."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from exogauge.criteria.motion_import import USUAL as IMPORT
from exogauge.criteria.motion_plan import USUAL
from exogauge.errors import BadMotion, Fault
from exogauge.logs.open_table import open_table
from exogauge.logs.tables import read_names
from exogauge.motion.files.open import CAPTURES, TABLES
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.standing import base_on, home_of

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

FEWEST = 4  # samples that make a cubic
STANDS = "stands."  # and the link of a foot: 1 where it stands, 0 where it is up
SAME_S = 1e-6  # what rounding leaves of a time


@final
@dataclass(frozen=True)
class Written:
    """time: (T,) [s] from 0; q: (T, n). held: joints that the file does not name, at home throughout. stands: (T, F)
    feet in the order of the robot's soles. beside: columns q.<name> of which the robot has no such joint."""

    time: Array
    q: Array
    held: tuple[str, ...]
    stands: BoolArray
    beside: tuple[str, ...] = ()

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.time[-1])

    def at(self, time: Array) -> tuple[Array, Array, Array]:
        """q, q̇, q̈ (T, n) of the cubic spline through the samples."""
        whole = CubicSpline(self.time, self.q)
        return whole(time), whole(time, 1), whole(time, 2)

    def acceleration(self, time: Array) -> Array:
        """(T, n) at times (T,): second divided differences of three samples, the middle one at the time or before it;
        see `jerk`. Where the jerk of a plan jumps, the cubic through its samples swung 2 % beyond its acceleration."""
        return self._differences(2, time)

    def jerk(self, time: Array) -> Array:
        """(T, n) at times (T,): third divided differences of four samples, two on each side as far as there are. They
        are means, by a B-spline, of the jerk that was sampled, and so no larger; that of the cubic through the samples
        is, where the jerk jumps between them.

        de Boor, A Practical Guide to Splines, 1978, chapter IX (6).
        """
        return self._differences(3, time)

    def _differences(self, orders: int, time: Array) -> Array:
        rates, t = self.q, self.time
        for order in range(1, orders + 1):
            rates = order * np.diff(rates, axis=0) / (t[order:] - t[:-order])[:, None]
        before = np.searchsorted(t, time + SAME_S, side="right") - 2
        return np.asarray(rates[np.clip(before, 0, len(rates) - 1)])

    def standing(self, time: Array) -> BoolArray:
        """(T, F) at times (T,): a foot may bear from the sample before the one at which it stands to the one after;
        when between two samples it lifts, a table does not say."""
        before, after = self._around(time)
        return np.asarray(self.stands[before] | self.stands[after])

    def still(self, time: Array) -> BoolArray:
        """(T, F) at times (T,): a foot must not move where it stands at the samples before and after."""
        before, after = self._around(time)
        return np.asarray(self.stands[before] & self.stands[after])

    def _around(self, time: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """(T,) samples at or before, and at or after."""
        before = np.searchsorted(self.time, time + SAME_S, side="right") - 1
        after = np.searchsorted(self.time, time - SAME_S, side="left")
        last = len(self.time) - 1
        return np.clip(before, 0, last), np.clip(after, 0, last)

    def loads(self, time: Array) -> Array:
        """(T, 6 F) [N, N·m]: a table says nothing of them."""
        return np.zeros((len(time), 6 * self.stands.shape[1]))


def swing(robot: MotionRobot, table: Written, time: Array, q: Array) -> str | None:
    """The joint that swings farthest beyond its jerk, and by how much, where a table is written anew at times (T,) that
    lie closer than its rows: q (T, n) of the cubic through them. None where none does, or they do not."""
    if len(time) <= len(table.time):
        return None
    jerk = Written(time, q, (), np.ones((len(time), 0), dtype=bool)).jerk(time)
    share = np.abs(jerk[:, robot.base :]).max(axis=0) / robot.jerk
    worst = int(share.argmax())
    if share[worst] <= 1.0 + USUAL.beyond:
        return None
    return (f"jerk of {robot.joints[worst]} up to {100.0 * share[worst]:.4g} % of its bound: what is written is a "
            "cubic through them; a motion planned at this rate (`retarget --rate`) has none of it")  # fmt: skip


def read_written(robot: MotionRobot, path: Path) -> Written:
    """Columns t [s] and q.<joint> [rad or m]; the base is where the feet that stand put it: all, but those whose column
    stands.<link> says 0. Raises BadMotion, BadLog."""
    if path.is_dir():
        raise BadMotion(Fault("is a folder", "a_folder", "Name the table in it", path.name))
    if not path.is_file():
        raise BadMotion(Fault("there is no such file", "no_file", "Look at its name", path.name))
    if (kind := path.suffix.lower()) in CAPTURES and kind not in TABLES:
        raise BadMotion(Fault("this holds a person's motion, or OpenSim's angles", "a_capture",
                              "Give a table with t [s] and q.<joint> [rad or m]; `exogauge motion retarget` makes one "
                              "of a capture", path.name))  # fmt: skip
    table = open_table(path, path.name)
    names = read_names(table)
    known = [name for name in robot.joints if f"q.{name}" in names]
    if "t" not in names or not known:
        raise BadMotion(Fault("no motion of this robot is in the file", "missing_column",
                              f"Columns t [s] and q.<joint>, as q.{robot.joints[0]}", path.name, 0,
                              "t" if "t" not in names else f"q.{robot.joints[0]}"))  # fmt: skip
    _refuse_bare_names(robot, names, path.name)
    feet = _feet(robot, names, path.name)
    columns = table.read(["t", *(f"q.{name}" for name in known), *feet])
    for name, values in columns.items():
        wrong = np.flatnonzero(~(np.abs(values) < IMPORT.largest_number))
        if len(wrong):
            raise BadMotion(Fault("the cell is no finite number that a motion has", "not_a_number",
                                  "Correct it or cut the motion", path.name, int(wrong[0]) + 1, name,
                                  str(values[wrong[0]])))  # fmt: skip
    time = np.asarray(columns["t"], dtype=np.float64)
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if len(time) < FEWEST or len(back):
        row = int(back[0]) + 2 if len(back) else len(time)
        raise BadMotion(Fault("time does not run on" if len(back) else "too few samples for a motion", "bad_time",
                              f"At least {FEWEST} rows, each later than the one before", path.name, row, "t",
                              f"{time[row - 1]:g}" if len(time) else None))  # fmt: skip
    if (step := float(np.median(np.diff(time)))) > IMPORT.longest_frame_s:
        raise BadMotion(Fault(f"from one row to the next it is {step:.4g} s", "slow_clock",
                              "t is in seconds; a motion takes some rows a second", path.name, 2, "t",
                              f"{time[1]:g}"))  # fmt: skip
    home = home_of(robot) if robot.floating or robot.home is None else robot.home
    q = np.tile(home, (len(time), 1))
    for name in known:
        q[:, robot.base + robot.joints.index(name)] = columns[f"q.{name}"]
    _refuse_degrees(robot, q[:, robot.base :], path.name)
    stands = _stands(robot, {name: columns[name] for name in feet}, len(time), path.name)
    if robot.floating:
        q[:, : robot.base] = base_on(robot, q, stands)
    held = tuple(name for name in robot.joints if name not in known)
    beside = tuple(name for name in names if name.startswith("q.") and name[2:] not in known)
    return Written(time - time[0], q, held, stands, beside)


def _refuse_bare_names(robot: MotionRobot, names: Collection[str], file: str) -> None:
    """A joint whose column lacks `q.` would stay at home, and what is judged be another motion."""
    bare = next((name for name in robot.joints if name in names and f"q.{name}" not in names), None)
    if bare is not None:
        raise BadMotion(Fault("the column is named as a joint, without what it holds of it", "bare_name",
                              f"Write q.{bare} for its position", file, 0, bare))  # fmt: skip


def _refuse_degrees(robot: MotionRobot, q: Array, file: str) -> None:
    """Where two joints are far beyond their range, and none would be were they degrees. q: (T, J)."""
    turns = np.array(["P" not in robot.model.joints[1 + robot.base + j].shortname() for j in range(q.shape[1])])
    limits, own = robot.limits, np.where(turns, np.radians(q), q)
    beyond = np.where(turns, np.maximum(limits.lower - q, q - limits.upper), 0.0)
    out_of_range = (own < limits.lower - USUAL.round_rad) | (own > limits.upper + USUAL.round_rad)
    if (beyond > USUAL.no_bound_rad).any(axis=0).sum() < 2 or out_of_range.any():
        return
    row, j = np.unravel_index(int(beyond.argmax()), beyond.shape)
    raise BadMotion(Fault(
        f"the joint bears {limits.lower[j]:.4g} to {limits.upper[j]:.4g} rad; as degrees all angles are within what "
        "their joints bear", "degrees", "Write radians", file, int(row) + 1, f"q.{robot.joints[j]}", f"{q[row, j]:g}",
    ))  # fmt: skip


def _feet(robot: MotionRobot, names: Collection[str], file: str) -> list[str]:
    """The columns that say which feet stand."""
    known = [f"{STANDS}{sole.link}" for sole in robot.soles]
    for name in names:
        if name.startswith(STANDS) and name not in known:
            raise BadMotion(Fault("the robot has no such foot", "unknown_foot", f"Name one of {', '.join(known)}", file,
                                  0, name))  # fmt: skip
    return [name for name in known if name in names]


def _stands(robot: MotionRobot, columns: Mapping[str, Array], count: int, file: str) -> BoolArray:
    """(T, F)"""
    stands = np.ones((count, len(robot.soles)), dtype=bool)
    for f, sole in enumerate(robot.soles):
        name = f"{STANDS}{sole.link}"
        if name not in columns:
            continue
        wrong = np.flatnonzero((columns[name] != 0.0) & (columns[name] != 1.0))
        if len(wrong):
            raise BadMotion(Fault("the cell is neither 0 nor 1", "not_a_truth", "1 where the foot stands, else 0", file,
                                  int(wrong[0]) + 1, name, f"{columns[name][wrong[0]]:g}"))  # fmt: skip
        stands[:, f] = columns[name] == 1.0
    flies = np.flatnonzero(~stands.any(axis=1) & bool(robot.soles))
    if len(flies):
        raise BadMotion(Fault("no foot stands", "flight", "Cut the motion: a robot that stands cannot fly", file,
                              int(flies[0]) + 1, next(iter(columns))))  # fmt: skip
    return stands
