"""What a robot may do about a posture of its logs, as far as its file says: touch, balance and torque known or not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from exogauge.criteria.motion_excite import USUAL
from exogauge.criteria.planning import Planning
from exogauge.errors import NotIdentifiable
from exogauge.experiment.envelope import Envelope, random_motion
from exogauge.experiment.workspace_limits import Room
from exogauge.findings.planned_motion import Bound
from exogauge.identification.model import RobotModel
from exogauge.robots.description import Robot
from exogauge.robots.joint_limits import JointLimits
from exogauge.robots.motion import Motion
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.stance import Fixed, Standing, Three
from exogauge.robots.moving.standing import base_on, standing
from exogauge.robots.moving.strain import Bounds
from exogauge.robots.moving.touching import Pairs
from exogauge.robots.series import Series

Array = NDArray[np.float64]
Loads = Callable[[Motion], Array]


@final
@dataclass(frozen=True)
class Reach(Envelope):
    """unknown: what of a motion is not known to hold, in which case it is not asked for either."""

    asked: Loads = field(kw_only=True)
    planning: Planning = field(kw_only=True)
    unknown: tuple[Bound, ...] = field(kw_only=True)

    def loads(self, motion: Motion) -> Array:
        return self.asked(motion)

    @property
    def kept(self) -> tuple[Bound, ...]:
        asked: tuple[Bound, ...] = ("touch", "torque", "balance") if self.stance.robot.floating else ("touch", "torque")
        return tuple(each for each in asked if each not in self.unknown)

    @property
    def moves(self) -> bool:
        """Whether several joints, and the base of a robot that stands, may move at once."""
        return "balance" not in self.unknown

    @cached_property
    def drawn(self) -> tuple[tuple[Reach, Array], ...]:
        """Random motions within every bound, (free, 2N-2) of the series of the reach beside it: calm ones, which move
        steadily, and brisk ones, which load what they carry."""
        if not self.moves:
            return ()
        criteria, rng, found = self.planning, np.random.default_rng(0), list[tuple[Reach, Array]]()
        for hz in (criteria.calm_hz, USUAL.top_hz):
            paced = replace(self, series=Series(criteria.shortest_s, round(hz * criteria.shortest_s)))
            try:
                found += [(paced, random_motion(paced, rng, criteria.of_top)) for _ in range(criteria.drawn)]
            except NotIdentifiable:
                return ()
        return tuple(found)

    def keeps(self, q: Array, rate_hz: float, at_hz: float) -> bool:
        """Whether joints q (T, J), whose base goes where the left foot stands, are within every bound; looked at with
        `at_hz`."""
        robot, base = self.stance.robot, self.stance.robot.base
        assert robot.home is not None
        whole = np.tile(robot.home, (len(q), 1))
        whole[:, base + self.order] = q
        moved = np.flatnonzero(np.ptp(q, axis=0) > 0.0)
        if isinstance(self.stance, Standing) and np.isin(base + self.order[moved], self._legs).any():
            whole[:, :base] = base_on(robot, whole)
        path = CubicSpline(np.arange(len(q)) / rate_hz, whole)
        time = np.arange(int((len(q) - 1) * at_hz / rate_hz) + 1) / at_hz
        jerk = np.abs(np.diff(whole[:, base:], 3, axis=0)) * rate_hz**3
        return bool((jerk <= robot.jerk).all()) and self.within((path(time), path(time, 1), path(time, 2)))

    @cached_property
    def _legs(self) -> NDArray[np.intp]:
        robot = self.stance.robot
        return np.concatenate([robot.leg(k) for k in range(len(robot.soles))])

    def within(self, whole: Three) -> bool:
        """Whether q, q̇, q̈ (T, n) keep every bound."""
        parts = self.bounds.parts(*whole, self.loads(self.motion(whole)))
        return all(float(part.share.max(initial=0.0)) <= 1.0 for part in parts)


def asked_of(model: RobotModel) -> Loads:
    """Of what was identified."""
    equations = model.equations
    rows = (6 if equations.robot.floating else 0) + len(equations.robot.joints)
    phi = equations.base.regroup @ model.identified.phi.ravel()
    return lambda motion: np.ascontiguousarray(equations.of_bodies(motion, phi)[:, :rows])


def reach_of(moving: MotionRobot, robot: Robot, here: Room, asked: Loads, criteria: Planning) -> Reach:
    """moving: the same robot. asked: what a motion asks of base and axes. What is broken in the posture of the logs
    itself counts as not known: the file is not of the robot as it stood there."""
    order = np.array([moving.joints.index(joint.name) for joint in robot.joints], dtype=np.intp)
    stands = moving.floating and len(moving.soles) > 1 and moving.home is not None
    home = np.zeros(moving.model.nq) if moving.home is None else moving.home.copy()
    pairs = Pairs(moving, USUAL.clearance_m)  # what touches by construction, touches at the home of the file
    home[moving.base + order] = here.posture
    if stands:
        home[: moving.base] = base_on(moving, home[None])[0]

    def of_joints(values: Array) -> Array:
        out = np.empty_like(values)
        out[order] = values
        return out

    stated = robot.tree.velocity_limit < criteria.no_limit
    unseen = np.where(stated, criteria.unseen * criteria.of_top * robot.tree.velocity_limit, 0.0)
    fast = np.maximum(np.maximum(here.top_speed, unseen), 1e-3)
    torque = np.where(moving.limits.torque < criteria.no_limit, moving.limits.torque, np.inf)
    limits = JointLimits(
        of_joints(here.low), of_joints(here.high), of_joints(fast),
        moving.limits.acceleration, criteria.of_top * torque, moving.limits.jerk,
    )  # fmt: skip
    own = replace(moving, home=home, limits=limits)
    place = standing(own) if stands else ()
    corners = [sole.outline @ at.rotation.T + at.translation for sole, at in zip(own.soles, place, strict=False)]
    level = stands and float(np.ptp(np.concatenate(corners)[:, 2])) <= criteria.level_m
    at_root = robot.tree.bodies[0] == next(iter(moving.links))
    loaded = level and at_root and _loaded(robot, here, own)
    unknown: list[Bound] = []
    if not pairs.names or moving.shapeless:
        unknown.append("touch")
    if moving.floating and not loaded:
        unknown.append("balance")
    if not np.isfinite(torque).all():
        unknown.append("torque")
    bounds = Bounds(own, order, USUAL, pairs, np.concatenate(corners) if loaded else np.zeros((0, 3)))
    stance = Standing(own) if loaded else Fixed(own)
    series = Series(criteria.shortest_s, round(USUAL.top_hz * criteria.shortest_s))
    made = Reach(stance, series, bounds, USUAL, asked=asked, planning=criteria, unknown=tuple(unknown))
    return _as_it_stood(made)


def _loaded(robot: Robot, here: Room, own: MotionRobot) -> bool:
    """Whether the feet carried the robot in the logs."""
    forces = [[here.resting.get(f"ft.{sensor.name}.f{axis}", 0.0) for axis in "xyz"] for sensor in robot.contacts]
    return sum(float(np.linalg.norm(force)) for force in forces) >= USUAL.least_weight * own.weight


def _as_it_stood(reach: Reach) -> Reach:
    """Without the bounds that the posture itself breaks."""
    robot = reach.stance.robot
    assert robot.home is not None
    q = robot.home[None]
    still = q, np.zeros_like(q), np.zeros_like(q)
    parts = reach.bounds.parts(*still, reach.loads(reach.motion(still)))
    broken = {name.split()[0] for part in parts for name, share in zip(part.names, part.share[0], strict=True)
              if share > 1.0}  # fmt: skip
    lost: dict[str, Bound] = {"distance": "touch", "torque": "torque", "centre": "balance", "friction": "balance",
                                "weight": "balance"}  # fmt: skip
    unknown = tuple(dict.fromkeys([*reach.unknown, *(lost[what] for what in sorted(broken) if what in lost)]))
    bounds = reach.bounds
    if "touch" in unknown and "distance" in broken:
        bounds = replace(bounds, pairs=Pairs(replace(robot, shapes=()), USUAL.clearance_m))
    if "torque" in broken:
        none = np.full(len(robot.joints), np.inf)
        bounds = replace(bounds, robot=replace(robot, limits=replace(robot.limits, torque=none)))
    if "balance" in unknown:
        bounds = replace(bounds, corners=np.zeros((0, 3)))
    return replace(reach, bounds=bounds, unknown=unknown)
