"""What is drawn of a plan: the robot, the centre of pressure and what the feet stand on, the nearest pair, joints at a
bound, and where in the capture the person is."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from exogauge.criteria.motion_excite import USUAL as EXCITE
from exogauge.criteria.motion_plan import USUAL
from exogauge.motion.channels import bound_shares
from exogauge.motion.contract import RetargetEntry
from exogauge.motion.plan.judge import Judged
from exogauge.motion.retargeting import Retargeted, with_margin
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.standing import standing
from exogauge.robots.moving.touching import Pairs

Array = NDArray[np.float64]
DRAWN_HZ = 50.0  # of what is kept: more than is drawn
AT_BOUND = 0.99  # share from which a joint counts as being at its bound


@final
@dataclass(frozen=True)
class Played:
    """T samples. time: (T,) [s]. base: (T, 7) x, y, z [m], qx, qy, qz, qw of the root link. q: (T, J) in the order of
    `MotionRobot.joints`. pressure: (T, 3) [m], NaN where nothing stands. inside: (T,) [m] of it from the edge of what
    the feet stand on. outline: (K, 3) [m] corners of all soles where they stand; foot: (K,) whose each is; stands:
    (T, F). inner: (1,) [m] how far inside the pressure has to stay.

    pairs: (T, 2, 3) [m] nearest points of the nearest pair, NaN where none is near; apart: (T,) [m]. at_bound: (T, J).
    moment: (T,) [s] of the capture. person: (2,) heading of the person's first pelvis [rad], and 1 where left and right
    are exchanged. moment and person are empty where nobody was captured.

    ghost_base, ghost_q: as base and q, of the motion in which each frame was taken by itself; empty where there is
    none.
    """

    time: Array
    base: Array
    q: Array
    pressure: Array
    inside: Array
    outline: Array
    foot: Array
    stands: Array
    inner: Array
    pairs: Array
    apart: Array
    at_bound: Array
    moment: Array
    person: Array
    ghost_base: Array
    ghost_q: Array

    def write(self, path: Path) -> None:
        arrays = {each.name: getattr(self, each.name).astype(np.float32) for each in fields(self)}
        np.savez_compressed(path, **(arrays | {"time": self.time}))

    @classmethod
    def read(cls, path: Path) -> Played:
        """A file of an older version says nothing of feet: they stand as one; nor has it a ghost."""
        with np.load(path) as file:
            arrays = {name: file[name].astype(np.float64) for name in file.files}
        one = {"foot": np.zeros(len(arrays["outline"])), "stands": np.ones((len(arrays["time"]), 1))}
        one |= {"ghost_base": np.zeros((0, 7)), "ghost_q": np.zeros((0, arrays["q"].shape[1]))}
        return cls(**(one | arrays))


def of_retargeted(found: Retargeted, wanted: RetargetEntry) -> Played:
    judged = found.judged
    played = of_judged(found.robot, judged, found.planned.spline.at(judged.time)[2])
    heading = float(Rotation.from_matrix(found.person.turn[0]).as_euler("ZXY")[0])
    moment = moments(played.time - found.lead, found.person.time[-1], wanted)
    person = np.array([-heading if wanted.mirror else heading, float(wanted.mirror)])
    inner = np.array([with_margin(wanted.margin_m).inside_m])
    ghost = {}
    if found.alone is not None:
        other = found.alone[0].spline.at(played.time)[0]
        ghost = {"ghost_base": _pose(found.robot, other), "ghost_q": other[:, found.robot.base :]}
    return Played(**{**vars(played), "moment": moment, "person": person, "inner": inner, **ghost})


def moments(time: Array, whole: float, wanted: RetargetEntry) -> Array:
    """(T,) [s] of the capture at times (T,) from where the person's motion begins; `whole`: [s] it takes as asked."""
    times, pause = wanted.repeat, USUAL.approach_s
    once = (whole - (times - 1) * pause) / times
    turn = np.clip(time // (once + pause), 0, times - 1)
    return np.asarray(wanted.begin + np.clip(time - turn * (once + pause), 0.0, once) / wanted.slow)


def of_judged(robot: MotionRobot, judged: Judged, acceleration: Array) -> Played:
    """Without a person, and with the margin of a motion that excites. acceleration: (T, n) at the judged times."""
    every = max(1, round(1.0 / ((judged.time[1] - judged.time[0]) * DRAWN_HZ)))
    kept = slice(None, None, every)
    q, base = judged.q[kept], robot.base
    shares = bound_shares(robot, judged, acceleration)
    at_bound = np.max(np.stack(list(shares.values())), axis=0) >= AT_BOUND
    outline, foot = np.zeros((0, 3)), np.zeros(0)
    if robot.floating and len(robot.soles) > 1:
        placed = zip(robot.soles, standing(robot), strict=True)
        foot = np.repeat(np.arange(len(robot.soles)), [len(sole.outline) for sole in robot.soles]).astype(np.float64)
        outline = np.concatenate([sole.outline @ at.rotation.T + at.translation for sole, at in placed])
    pairs, apart = _nearest(robot, q)
    none = np.zeros(0)
    return Played(
        judged.time[kept], _pose(robot, q), q[:, base:], judged.pressure[kept], judged.inside[kept], outline, foot,
        judged.stands[kept].astype(np.float64),
        np.array([EXCITE.margin_m]), pairs, apart, at_bound[kept].astype(np.float64), none, none, np.zeros((0, 7)),
        np.zeros((0, len(robot.joints))),
    )  # fmt: skip


def _pose(robot: MotionRobot, q: Array) -> Array:
    """(T, 7) as `Played.base`."""
    if not robot.base:
        return np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], (len(q), 1))
    return np.concatenate([q[:, :3], Rotation.from_euler("ZXY", q[:, 3 : robot.base]).as_quat()], axis=1)


def _nearest(robot: MotionRobot, q: Array) -> tuple[Array, Array]:
    """(T, 2, 3), (T,) [m]"""
    points, apart = np.full((len(q), 2, 3), np.nan), np.full(len(q), USUAL.look_m)
    pairs = Pairs(robot, USUAL.clearance_m)
    near = pairs.near(q, USUAL.look_m)
    where = pairs.where(q, near)
    for k in np.argsort(-near.distance):
        points[near.sample[k]], apart[near.sample[k]] = where[k, :2], near.distance[k]
    return points, apart
