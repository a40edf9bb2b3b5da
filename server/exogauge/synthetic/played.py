"""A planned motion of a file, as the sample's robot plays it: again and again, every run a little different."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from exogauge.errors import BadMotion, Fault
from exogauge.synthetic.mjcf import mujoco_model
from exogauge.synthetic.motion import (
    KNOT_RATE_HZ,
    LEG_JOINTS,
    STANCE_HALF_WIDTH,
    Plan,
    arriving,
    differing,
    leg_angles,
    with_lead,
)
from exogauge.synthetic.robot_facts import ANKLE_HEIGHT, FEET, HOME, JOINT_NAMES, JOINTS
from exogauge.synthetic.true_robot import a_priori_robot
from exogauge.synthetic.variation import Variation

Array = NDArray[np.float64]

SHORTEST_S, LONGEST_S = 2.0, 600.0
_FOOT_STAYS = 2e-3, 5e-3  # [m, rad]
_OVER = 1e-3  # of a joint's bound, what rounding may leave [rad]
_TAKEN = ("excitation",)
_STANDS = "stands."  # and the link of a foot: 1 where it stands


@final
@dataclass(frozen=True)
class PlayedMotion:
    """name: of the motion in study.yaml. angles: (K, 34) [rad] at `KNOT_RATE_HZ`, feet still. source: the file."""

    name: str
    angles: Array
    source: bytes

    @property
    def duration_s(self) -> float:
        return len(self.angles) / KNOT_RATE_HZ

    def plan(
        self, rng: np.random.Generator, again: np.random.Generator, varied: Variation | None, planner: mujoco.MjModel
    ) -> Plan:
        """Without `varied` the file's own angles. With it trunk, arms and base differ and legs keep the feet in place;
        before the log the robot arrives out of a motion, see `motion.Plan`."""
        angles, (base, R), feet = with_lead(self.angles), *_placed(planner, with_lead(self.angles))
        whole = np.concatenate([angles, base, Rotation.from_matrix(R).as_euler("ZYX")], axis=1)
        if varied is not None:
            whole = whole[0] + varied.profile(whole - whole[0], KNOT_RATE_HZ)
        angles, base, rpy = whole[:, :-6], whole[:, -6:-3], whole[:, :-4:-1]
        angles, rpy, height = arriving(rng, again, angles, rpy, base[:, 2])
        angles, rpy, along, height = differing(varied, angles, rpy, base[:, :2], height)
        base, R = np.column_stack([along, height]), Rotation.from_euler("ZYX", rpy[:, ::-1]).as_matrix()
        for prefix, side, (place, turn) in zip("lr", (1.0, -1.0), feet, strict=True):
            seen = (base - place) @ turn + [0.0, side * STANCE_HALF_WIDTH, ANKLE_HEIGHT]
            angles[:, _leg(prefix)] = leg_angles(side, seen, turn.T @ R)
        return Plan(angles, base, R)


def read_motions(paths: Sequence[Path]) -> list[PlayedMotion]:
    """Each under a name of its own, its feet still. Raises BadMotion."""
    planner, read = mujoco_model(a_priori_robot()), list[PlayedMotion]()
    for path in paths:
        motion = read_played(path)
        if any(other.name == motion.name for other in read):
            raise BadMotion(Fault("two motions have one name", "same_name", "Give the files other names", path.name))
        refuse_moved_feet(motion, planner, path.name)
        read.append(motion)
    return read


def read_played(path: Path) -> PlayedMotion:
    """Columns t [s] and q.<joint> [rad]; joints that are not named stay at home. Raises BadMotion, also where a foot
    would leave its place: nothing keeps this robot's balance but the plan."""
    if not path.is_file():
        raise BadMotion(Fault("there is no such file", "no_file", "Look at its name", path.name))
    source = path.read_bytes()
    name = re.sub(r"[^A-Za-z0-9_.+-]", "_", path.stem).lstrip(".+-") or "motion"
    if name in _TAKEN:
        advice = "Give the file another name"
        raise BadMotion(Fault("another motion of the sample has this name", "name_taken", advice, path.name))
    time, columns = _columns(path.name, source)
    known = [joint for joint in JOINTS if joint.name in columns]
    if not known:
        advice = "Columns t [s] and q.<joint>, as q.torso_pitch"
        raise BadMotion(
            Fault("no motion of the sample's robot is in it", "missing_column", advice, path.name, 0, "q.torso_pitch")
        )
    for joint in known:
        q = columns[joint.name]
        beyond = np.flatnonzero((q < joint.lower - _OVER) | (q > joint.upper + _OVER))
        if len(beyond):
            k = int(beyond[0])
            raise BadMotion(Fault(f"{joint.name} bears {joint.lower:g} to {joint.upper:g} rad", "beyond_bound",
                                  "Angles are in radians; plan it for this robot with `exogauge motion retarget`",
                                  path.name, k + 1, f"q.{joint.name}", f"{q[k]:.4g}"))  # fmt: skip
    knots = np.arange(int((time[-1] - time[0]) * KNOT_RATE_HZ + 1e-6) + 1) / KNOT_RATE_HZ
    angles = np.tile([HOME.get(joint, 0.0) for joint in JOINT_NAMES], (len(knots), 1))
    for joint in known:
        angles[:, JOINT_NAMES.index(joint.name)] = CubicSpline(time - time[0], columns[joint.name])(knots)
    return PlayedMotion(name, angles, source)


def refuse_moved_feet(motion: PlayedMotion, planner: mujoco.MjModel, file: str) -> None:
    """Raises BadMotion where the right foot moves against the left, which stands, or both do not stand on one floor."""
    poses = _feet_seen(planner, motion.angles)
    away, turn = _against(poses)
    lift, tilt = abs(away[0, 2]), float(np.linalg.norm(Rotation.from_matrix(turn[0]).as_rotvec()[:2]))
    if lift > _FOOT_STAYS[0] or tilt > _FOOT_STAYS[1]:
        raise BadMotion(Fault("the soles do not stand on one floor when the motion begins", "feet_uneven",
                              "Begin at home", file, 1, value=f"{1e3 * lift:.1f} mm, {tilt:.3f} rad"))  # fmt: skip
    moved = np.linalg.norm(away - away[0], axis=1)
    turned = Rotation.from_matrix(np.swapaxes(turn[:1], 1, 2) @ turn).magnitude()
    wrong = np.flatnonzero((moved > _FOOT_STAYS[0]) | (turned > _FOOT_STAYS[1]))
    if len(wrong):
        k = int(wrong[0])
        raise BadMotion(Fault(
            f"a foot leaves its place from {k / KNOT_RATE_HZ:.2f} s on, by up to {1e3 * moved.max():.0f} mm and "
            f"{turned.max():.2f} rad", "foot_moves", "The sample plays motions with both feet where they stand",
            file, value=f"{1e3 * moved[k]:.1f} mm"))  # fmt: skip


def _columns(name: str, source: bytes) -> tuple[Array, dict[str, Array]]:
    """t and what joints the table names; a comma, a semicolon or a tab between the cells."""
    try:
        text = source.decode()
        split = csv.reader(text.splitlines(), csv.Sniffer().sniff(text.partition("\n")[0], ",;\t"))
        head, *rows = [[cell.strip() for cell in row] for row in split if row]
    except (UnicodeDecodeError, csv.Error, ValueError) as wrong:
        raise BadMotion(Fault("it is not a table", "not_a_table", "A CSV with t and q.<joint>", name)) from wrong
    if "t" not in head:
        raise BadMotion(Fault("there is no time", "missing_column", "Columns t [s] and q.<joint>", name, 0, "t"))
    uneven = next((k for k, row in enumerate(rows, 1) if len(row) != len(head)), None)
    if uneven is not None:
        raise BadMotion(Fault(f"the row has {len(rows[uneven - 1])} cells, the header {len(head)}", "uneven_row",
                              "Write it again", name, uneven))  # fmt: skip
    columns = {}
    for j, column in enumerate(head):
        if column == "t" or column.startswith(("q.", _STANDS)):
            columns[column] = np.array([_number(name, k, column, row[j]) for k, row in enumerate(rows, 1)])
    time = columns.pop("t")
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if len(back):
        raise BadMotion(Fault("time does not run on", "bad_time", "Each row later than the one before", name,
                              int(back[0]) + 2, "t", f"{time[back[0] + 1]:g}"))  # fmt: skip
    if len(time) < 4 or not SHORTEST_S <= time[-1] - time[0] <= LONGEST_S:
        took = f"{time[-1] - time[0]:g} s" if len(time) else "0 rows"
        raise BadMotion(Fault(f"a motion takes {SHORTEST_S:g} to {LONGEST_S:g} s", "bad_duration",
                              "Cut or repeat it", name, column="t", value=took))  # fmt: skip
    for column in [each for each in columns if each.startswith(_STANDS)]:
        up = np.flatnonzero(columns.pop(column) != 1.0)
        if len(up):
            raise BadMotion(Fault(
                f"the plan lifts {column.removeprefix(_STANDS)} from {time[up[0]]:.2f} s on", "foot_lifts",
                "The sample plays motions with both feet where they stand: cut it before", name, int(up[0]) + 1, column,
            ))  # fmt: skip
    return time, {column.removeprefix("q."): values for column, values in columns.items()}


def _number(name: str, row: int, column: str, cell: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise BadMotion(Fault("the cell is not a finite number", "not_a_number", "Correct it or cut the motion", name,
                              row, column, cell[:40]))  # fmt: skip
    return value


def _leg(prefix: str) -> list[int]:
    return [JOINT_NAMES.index(f"{prefix}_{joint}") for joint in LEG_JOINTS]


def _feet_seen(planner: mujoco.MjModel, angles: Array) -> list[tuple[Array, Array]]:
    """(K, 3) [m] and (K, 3, 3) of each foot's ankle in the base."""
    data = mujoco.MjData(planner)
    out = [(np.empty((len(angles), 3)), np.empty((len(angles), 3, 3))) for _ in FEET]
    for k, q in enumerate(angles):
        data.qpos[:3], data.qpos[3:7], data.qpos[7:] = 0.0, [1.0, 0.0, 0.0, 0.0], q
        mujoco.mj_kinematics(planner, data)
        for (place, turn), foot in zip(out, FEET, strict=True):
            place[k], turn[k] = data.body(foot).xpos, data.body(foot).xmat.reshape(3, 3)
    return out


def _against(poses: list[tuple[Array, Array]]) -> tuple[Array, Array]:
    """(K, 3) [m], (K, 3, 3) of the right foot in the left one."""
    (left, R_left), (right, R_right) = poses
    back = np.swapaxes(R_left, 1, 2)
    return np.einsum("kij,kj->ki", back, right - left), back @ R_right


def _placed(planner: mujoco.MjModel, angles: Array) -> tuple[tuple[Array, Array], list[tuple[Array, Array]]]:
    """(K, 3) [m], (K, 3, 3) of the base where the left foot stands level at y = 0 of the world; then (3,), (3, 3) of
    either foot there."""
    poses = _feet_seen(planner, angles)
    (left, R_left), (away, turn) = poses[0], _against(poses)
    R = np.swapaxes(R_left, 1, 2)
    ankle = np.array([0.0, 0.0, ANKLE_HEIGHT])
    base = ankle - np.einsum("kij,kj->ki", R, left)
    return (base, R), [(ankle, np.eye(3)), (ankle + away[0], turn[0])]
