"""What a planned motion does between the nodes: judged at the rate at which it is written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol, final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from exogauge.criteria.motion_plan import USUAL, MotionPlan
from exogauge.motion.plan.spline import Trajectory
from exogauge.motion.plan.written import Written
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.strain import EVENLY
from exogauge.robots.moving.touching import Pairs, hulls_alone

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


class Feet(Protocol):
    """What a plan, or a table of one, says of F feet at times (T,) [s]."""

    def standing(self, time: Array) -> BoolArray:
        """(T, F) which stand, and may bear."""
        ...

    def still(self, time: Array) -> BoolArray:
        """(T, F) which surely stand, and must not move."""
        ...

    def loads(self, time: Array) -> Array:
        """(T, 6 F) [N, N·m] of the world on each, as far as it is said: what lacks is added evenly."""
        ...


@final
@dataclass(frozen=True)
class Judged:
    """T samples. time: (T,) [s]; q, dq: (T, n). stands: (T, F) feet in the order of the robot's soles. pressure: (T, 3)
    [m] its centre, in the world. inside: (T,) [m] of the centre of pressure from the edge of what the feet stand on,
    negative outside. Both are NaN where the feet carry less than `MotionPlan.least_weight`: a force that is next to
    nothing has its centre anywhere. carried: (T,) share of the weight. torque: (T, J) [N·m or N]; the legs' hang on how
    two feet share the load. most: (J,) largest share of the joint's bound on velocity, acceleration, jerk and torque.
    feet_m, feet_rad: largest way of a standing foot. apart: (T,) [m] of the nearest pair,
    `MotionPlan.look_m` where none is nearer; nearest: that of all times, and when, None without shapes or where none
    comes nearer; left_out: pairs that were not looked at. broken: what does not hold, as time, place, value and bound
    in words.
    """

    time: Array
    q: Array
    dq: Array
    stands: BoolArray
    pressure: Array
    inside: Array
    carried: Array
    torque: Array
    feet_m: float
    feet_rad: float
    apart: Array
    nearest: tuple[str, str, float] | None
    left_out: tuple[tuple[str, str], ...]
    broken: tuple[str, ...] = field(default_factory=tuple)
    most: Mapping[str, Array] = field(default_factory=dict)

    @property
    def least_inside(self) -> float | None:
        """[m] of the centre of pressure, wherever there is one."""
        known = self.inside[np.isfinite(self.inside)]
        return float(known.min()) if len(known) else None

    @property
    def outside(self) -> float:
        """Share of samples in which the centre of pressure lies outside what the feet stand on."""
        return float((self.inside < 0.0).mean())


def judge(
    robot: MotionRobot, motion: Trajectory, place: Sequence[pin.SE3], criteria: MotionPlan = USUAL,
    rate: float | None = None, planned: Feet | None = None,
) -> Judged:  # fmt: skip
    """place: of the soles' links, where each stands whenever it does; none of a robot that is bolted down. rate: [Hz],
    `judged_hz` where none is given.

    planned: which feet stand, and how two share the load; without it all do, so that the loads are smallest.
    """
    rate = rate or criteria.judged_hz
    time = np.arange(int(motion.duration * rate + 1e-6) + 1) / rate
    q, v, a = motion.at(time)
    model, data, base = robot.model, robot.data, robot.base
    frames = [robot.frame(sole.link) for sole in robot.soles]
    corners = np.concatenate([np.zeros((0, 3)), *(sole.outline @ at.rotation.T + at.translation
                                                  for sole, at in zip(robot.soles, place, strict=True))])  # fmt: skip
    stands = np.ones((len(time), len(frames)), dtype=bool) if planned is None else planned.standing(time)
    still = stands if planned is None else planned.still(time)
    edges = _edges(robot, corners, stands) if robot.floating else {}
    floor = float(corners[:, 2].mean()) if robot.floating else 0.0
    T, J = len(time), len(robot.joints)
    shared = np.zeros((T, 6 * len(frames))) if planned is None else planned.loads(time)
    pressure, inside = np.full((T, 3), np.nan), np.full(T, np.nan)
    carried, torque, strays = np.ones(T), np.empty((T, J)), np.zeros((T, 2))
    share = np.tile(EVENLY, len(frames))
    for t in range(T):
        tau = pin.rnea(model, data, q[t], v[t], a[t])
        if not robot.floating:
            torque[t] = tau
            continue
        pin.computeJointJacobians(model, data, q[t])
        rows = np.concatenate([pin.getFrameJacobian(model, data, k, pin.LOCAL) for k in frames])
        driven = rows[:, :base]
        borne = share * np.repeat(stands[t], 6)
        lacks = np.linalg.solve(driven.T @ (borne[:, None] * driven), tau[:base] - driven.T @ shared[t])
        loads = shared[t] + borne * (driven @ lacks)
        torque[t] = tau[base:] - rows[:, base:].T @ loads
        total = pin.Force.Zero()
        for f, k in enumerate(frames):
            at = pin.updateFramePlacement(model, data, k)
            total += at.act(pin.Force(loads[6 * f : 6 * f + 6]))
            if not still[t, f]:
                continue
            moved = place[f].inverse() * at
            strays[t] = np.maximum(
                strays[t], [np.linalg.norm(moved.translation), np.linalg.norm(pin.log3(moved.rotation))]
            )
        force, moment = total.linear, total.angular
        carried[t] = force[2] / robot.weight
        if carried[t] < criteria.least_weight:
            continue
        cop = np.array([-moment[1] + floor * force[0], moment[0] + floor * force[1]]) / force[2]
        pressure[t] = [*cop, floor]
        normals = edges[tuple(stands[t])]  # outward, and offsets
        inside[t] = -(normals[:, :2] @ cop + normals[:, 2]).max()
    most, broken = _over_bounds(robot, motion, time, (q[:, base:], v[:, base:], a, torque), rate, criteria)
    broken += _not_standing(time, inside, carried, strays, criteria)
    apart, nearest, left_out, touching = _distances(robot, time, q, criteria)
    feet_m, feet_rad = strays.max(axis=0).tolist()
    return Judged(
        time,
        q,
        v,
        stands,
        pressure,
        inside,
        carried,
        torque,
        feet_m,
        feet_rad,
        apart,
        nearest,
        left_out,
        (*broken, *touching),
        most,
    )


def _over_bounds(
    robot: MotionRobot, motion: Trajectory, time: Array, moved: tuple[Array, ...], rate: float, criteria: MotionPlan
) -> tuple[dict[str, Array], list[str]]:
    """`Judged.most`, and joints beyond what they bear. moved: positions (T, J), velocities (T, J), accelerations of all
    that moves, torques (T, J)."""
    angle, v, a, torque = moved
    limits, base = robot.limits, robot.base
    slopes = np.diff(a, axis=0, append=a[-1:]) * rate
    if isinstance(motion, Written):
        a, slopes = motion.acceleration(time), motion.jerk(time)
    a, jerk = a[:, base:], slopes[:, base:]
    outside = np.maximum(limits.lower - angle, angle - limits.upper)
    aside = np.where(angle > limits.upper, limits.upper, limits.lower)
    sizes = (  # what, share of the bound, what is counted, its bound
        ("position", 1.0 + outside * criteria.beyond / criteria.beyond_rad, angle, aside),
        ("velocity", np.abs(v) / limits.velocity, v, limits.velocity),
        ("acceleration", np.abs(a) / limits.acceleration, a, limits.acceleration),
        ("jerk", np.abs(jerk) / robot.jerk, jerk, robot.jerk),
        ("torque", np.abs(torque) / limits.torque, torque, limits.torque),
    )
    most, broken = dict[str, Array](), list[str]()
    for what, ratio, value, bounds in sizes:
        most |= {} if what == "position" else {what: ratio.max(axis=0)}
        every = np.broadcast_to(bounds, value.shape)
        for j in np.flatnonzero((ratio > 1.0 + criteria.beyond).any(axis=0)):
            t = int(ratio[:, j].argmax())
            often = 100.0 * float((ratio[:, j] > 1.0 + criteria.beyond).mean())
            share = f"{100.0 * ratio[t, j]:.4g} % of its bound {every[t, j]:.4g}"
            share = f"its bound is {every[t, j]:.4g}" if what == "position" else share
            broken.append(f"{what} of {robot.joints[j]}: {value[t, j]:.4g} at {time[t]:.3f} s, {share}, beyond it in "
                          f"{often:.2g} % of samples")  # fmt: skip
    return most, broken


def _not_standing(time: Array, inside: Array, carried: Array, strays: Array, criteria: MotionPlan) -> list[str]:
    """Where the robot would tip over, or its feet would come off or slip. strays: (T, 2) [m, rad]."""
    broken = []
    for what, low, least, unit in (
        ("centre of pressure inside the soles", inside, criteria.inside_m, "m"),
        ("weight on the feet", carried, criteria.least_weight, "of the weight"),
    ):
        if (low < least).any():
            t = int(np.nanargmin(low))
            broken.append(f"{what}: {low[t]:.4g} {unit} at {time[t]:.3f} s, at least {least:g} is asked")
    for what, far, most, unit in (
        ("way", strays[:, 0], criteria.feet_m, "m"),
        ("turn", strays[:, 1], criteria.feet_rad, "rad"),
    ):
        if far.max() > most:
            broken.append(f"{what} of a standing foot: {far.max():.3g} {unit} at {time[far.argmax()]:.3f} s")
    return broken


def _distances(
    robot: MotionRobot, time: Array, q: Array, criteria: MotionPlan
) -> tuple[Array, tuple[str, str, float] | None, tuple[tuple[str, str], ...], list[str]]:
    """(T,) [m] of the nearest pair, at most `look_m`; that pair and when; pairs that may touch; pairs too near."""
    pairs = Pairs(robot, criteria.clearance_m)
    near = pairs.near(q, criteria.look_m)
    apart, nearest, broken = np.full(len(time), criteria.look_m), None, list[str]()
    np.minimum.at(apart, near.sample, near.distance)
    if len(near.distance):
        k = int(near.distance.argmin())
        nearest = (*pairs.names[near.pair[k]], float(time[near.sample[k]]))
    for p in np.unique(near.pair[near.distance < criteria.clearance_m]):
        own = near.pair == p
        k = int(near.distance[own].argmin())
        often = 100.0 * float((near.distance[own] < criteria.clearance_m).sum()) / len(time)
        then, pair = int(near.sample[own][k]), pairs.names[p]
        hollow = hulls_alone(replace(robot, home=q[then]), [pair], criteria.clearance_m)
        hulls = "".join(f"; as convex hulls, the surfaces of their meshes are {gap:.4g} m apart then"
                        for gap in hollow.values())  # fmt: skip
        broken.append(f"distance of {' and '.join(pair)}: {near.distance[own][k]:.4g} m at {time[then]:.3f} s, at "
                      f"least {criteria.clearance_m:g} is asked, less in {often:.2g} % of samples{hulls}")  # fmt: skip
    return apart, nearest, pairs.left_out, broken


def _edges(robot: MotionRobot, corners: Array, stands: NDArray[np.bool_]) -> dict[tuple[bool, ...], Array]:
    """Of every set of feet that stands at some time: outward normals and offsets of what they stand on."""
    foot = np.repeat(np.arange(len(robot.soles)), [len(sole.outline) for sole in robot.soles])
    return {
        tuple(each): ConvexHull(corners[np.asarray(each)[foot], :2]).equations for each in np.unique(stands, axis=0)
    }
