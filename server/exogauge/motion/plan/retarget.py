"""From a person's motion to what is asked of a robot that stands on its feet."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from exogauge.criteria.motion_plan import USUAL, MotionPlan
from exogauge.errors import BadMotion, BadRobot, Fault
from exogauge.logs.findings import runs
from exogauge.motion.person import LIMBS, Person
from exogauge.motion.plan.asked import Asked
from exogauge.motion.plan.outcome import slow
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.segments import Segment
from exogauge.robots.moving.standing import home_of, standing

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]

PULL = 0.03  # of a joint to its place at home against a limb that points elsewhere: what nothing asks stays there


def ask(robot: MotionRobot, person: Person, criteria: MotionPlan = USUAL) -> tuple[Asked, Array]:
    """What the person does, asked of the robot between rests at its home, feet where they are there whenever they
    stand; and the angle [rad] (N,) of the trunk's turn that no angles of the robot's joints express, bounds aside.
    """
    home = home_of(robot)
    for part in ("pelvis", "thorax"):
        if part not in robot.segments:
            raise _unmapped(robot, f"no link stands for the {part}", part)
    if not robot.torso:
        raise _unmapped(robot, "no joint lies between pelvis and thorax", "thorax")
    _refuse_flight(person)
    step = 1.0 / criteria.nodes_per_s
    rounding = 0.1  # of a node: files round the time of a frame, 16.667 ms of BVH is 1/60 s
    count = int(np.ceil(person.time[-1] / step - rounding)) + 1  # the last one holds the person's end
    time: Array = np.minimum(step * np.arange(count), person.time[-1])
    turn, trunk = (Slerp(person.time, Rotation.from_matrix(each))(time) for each in (person.turn, person.trunk))
    place = np.stack([np.interp(time, person.time, each) for each in person.pelvis.T], axis=1)
    limbs = {part: _unit(np.stack([np.interp(time, person.time, each) for each in along.T], axis=1))
             for part, along in person.limbs.items()}  # fmt: skip
    q = np.tile(home, (count, 1))
    model, data = robot.model, robot.data
    facing = _facing(robot)
    feet = standing(robot)
    heading = float(turn[0].as_euler("ZXY")[0])  # the person's first pelvis faces where the robot does
    level = Rotation.from_euler("z", -heading)
    ahead = Rotation.from_matrix(facing)
    q[:, 3:6] = np.unwrap((ahead * level * turn * ahead.inv()).as_euler("ZXY"), axis=0)
    scale = _hip_height(robot) / person.hip_height
    q[:, :3] = home[:3] + scale * level.apply(place - place[0]) @ facing.T
    rises = float(q[:, 2].max()) - home[2]
    if rises > _hip_height(robot) - _hip_height(robot, home):  # beyond straight legs: who sits or crouches at first
        q[:, 2] -= rises
    missed = np.empty(count)
    stray = np.full(model.nq, np.inf)
    stray[:3], stray[3:6] = criteria.pelvis_m, criteria.pelvis_rad
    torso = np.array(robot.torso, dtype=np.intp)
    stray[robot.base + torso] = criteria.trunk_rad
    known = {part: beyond for part, beyond in LIMBS if part in limbs and {part, beyond} <= set(robot.segments)}
    arms = sorted({k for beyond in known.values() for k in robot.chain("thorax", beyond)})
    stray[robot.base + np.array(arms, dtype=np.intp)] = criteria.limb_rad
    rest = [k for k in robot.beyond("thorax") if k not in arms]
    stray[robot.base + np.array(rest, dtype=np.intp)] = criteria.limb_rad
    pin.forwardKinematics(model, data, pin.neutral(model))
    upright = {part: facing.T @ pin.updateFramePlacement(model, data, robot.frame(link)).rotation
               for part, link in robot.segments.items()}  # fmt: skip
    now = home.copy()
    for t in range(count):
        now[: robot.base] = 0.0
        missed[t] = _turn_torso(robot, now, torso, trunk[t].as_matrix(), upright)
        if arms:
            _point_limbs(robot, now, home, np.array(arms), {part: limbs[part][t] for part in known}, upright)
        q[t, robot.base :] = now[robot.base :]
    lead = round(criteria.approach_s / step)
    s = np.arange(lead)[:, None] / lead
    ease = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    q = np.concatenate([home + ease * (q[0] - home), q, (home + ease * (q[-1] - home))[::-1]])
    missed = np.concatenate([np.zeros(lead), missed, np.zeros(lead)])
    stands, ways = _steps(person, time, level, scale, criteria)
    stands = np.pad(stands, ((lead, lead), (0, 0)), constant_values=True)
    ways = np.pad(ways, ((lead, lead), (0, 0), (0, 0))) @ facing.T
    poses = tuple(tuple(pin.SE3(foot.rotation, foot.translation + way) for foot, way in zip(feet, each, strict=True))
                  for each in ways)  # fmt: skip
    return Asked(q, stray, step, stands, poses), missed


def _steps(
    person: Person, time: Array, level: Rotation, scale: float, criteria: MotionPlan
) -> tuple[NDArray[np.bool_], Array]:
    """(N, 2) which feet stand, and (N, 2, 3) [m] the way of a lifted one from where it stands, in the body's axes: that
    of the person's foot from the straight line between where it leaves and where it comes down, in the robot's size.
    So the robot's foot comes down where it was; sideways it stays, as its feet are nearer to each other than a
    person's. Begins and ends are eased, from the first node at which it does not stand to the last; what is shorter
    than both stands.

    Raises BadMotion where a foot is up at either end.
    """
    N = len(time)
    stands, ways = np.ones((N, 2), dtype=bool), np.zeros((N, 2, 3))
    if person.contacts is None or person.feet is None:
        return stands, ways
    ease = round(criteria.lift_s * criteria.nodes_per_s)
    gently = ease + 2  # it is still at two nodes more; over one more G1's pressure left by 1.8 mm where it comes down
    for f, touches in enumerate((person.contacts.left, person.contacts.right)):
        up = np.interp(time, person.time, touches.astype(float)) < 0.5
        path = np.stack([np.interp(time, person.time, each) for each in person.feet[:, f].T], axis=1)
        for start, length in zip(*runs(up), strict=True):
            first, last = start, start + length - 1  # until the one, and from the other on, it may bear: still there
            if length < 2 * ease:
                continue
            if start == 0 or start + length == N:
                raise BadMotion(Fault(
                    f"the {('left', 'right')[f]} foot is up when the motion {'begins' if start == 0 else 'ends'}",
                    "foot_up", "Cut it where both feet stand", person.name, int(start) + 1, "contacts",
                    f"{time[start]:.2f} to {time[start + length - 1]:.2f} s",
                ))  # fmt: skip
            s = (np.arange(first, last + 1) - first) / (last - first)
            way = path[first : last + 1] - path[first] - s[:, None] * (path[last] - path[first])
            w = np.clip(np.minimum(s, 1.0 - s) * (last - first) / gently, 0.0, 1.0)
            way = level.apply(slow(way, 1.0 / criteria.nodes_per_s, criteria.smooth_hz))
            way[:, 1] = 0.0
            way *= (w**3 * (10.0 - 15.0 * w + 6.0 * w**2))[:, None]
            way[:, 2] = np.maximum(way[:, 2], 0.0)
            stands[start : start + length, f] = False
            ways[first : last + 1, f] = scale * way
    return stands, ways


def _unmapped(robot: MotionRobot, detail: str, part: str) -> BadRobot:
    advice = "Name its link in `human_map` of robot.yaml"
    return BadRobot(Fault(detail, "no_human_map", advice, robot.name, None, f"human_map.{part}"))


def _refuse_flight(person: Person) -> None:
    if person.contacts is None:
        return
    starts, lengths = runs(~(person.contacts.left | person.contacts.right))
    if not len(starts):
        return
    time = person.time
    spans = [f"{time[a]:.2f} to {time[a + n - 1]:.2f} s" for a, n in zip(starts, lengths, strict=True)]
    raise BadMotion(Fault(
        f"no foot stands in {len(spans)} stretches: {', '.join(spans[:3])}", "flight",
        "Cut them off: a robot that stands cannot fly", person.name, int(starts[0]) + 1, "contacts", spans[0],
    ))  # fmt: skip


def _unit(along: Array) -> Array:
    return np.asarray(along / np.linalg.norm(along, axis=1, keepdims=True))


def _facing(robot: MotionRobot) -> Array:
    """(3, 3) axes of the body, x forward, y left, z up, in the base with all joints at zero."""
    model, data = robot.model, robot.data
    pin.forwardKinematics(model, data, pin.neutral(model))
    left, right = (pin.updateFramePlacement(model, data, robot.frame(s.link)).translation.copy() for s in robot.soles)
    y = (left - right) * [1.0, 1.0, 0.0]
    y /= np.linalg.norm(y)
    return np.stack([np.cross(y, [0.0, 0.0, 1.0]), y, [0.0, 0.0, 1.0]], axis=1)


def _hip_height(robot: MotionRobot, posture: Array | None = None) -> float:
    """[m] of the hips over the soles' links, all joints at zero where no posture is given."""
    model, data = robot.model, robot.data
    pin.forwardKinematics(model, data, pin.neutral(model) if posture is None else posture)
    hip = data.oMi[int(robot.leg(0)[0]) + 1].translation[2]
    return float(hip - pin.updateFramePlacement(model, data, robot.frame(robot.soles[0].link)).translation[2])


def _turn_torso(robot: MotionRobot, q: Array, torso: IntArray, wanted: Array, upright: dict[Segment, Array]) -> float:
    """Writes the torso's joints (base at zero) that come nearest to the turn; the angle [rad] that is left."""
    model, data = robot.model, robot.data
    below, above = (robot.frame(robot.segments[part]) for part in ("pelvis", "thorax"))
    at = robot.base + torso
    error = np.zeros(3)
    for _ in range(10):
        pin.computeJointJacobians(model, data, q)
        R_p = pin.updateFramePlacement(model, data, below).rotation @ upright["pelvis"].T
        R_t = pin.updateFramePlacement(model, data, above).rotation @ upright["thorax"].T
        error = pin.log3((R_p.T @ R_t).T @ wanted)
        J = R_t.T @ pin.getFrameJacobian(model, data, above, pin.LOCAL_WORLD_ALIGNED)[3:, at]
        step = np.linalg.lstsq(J, error, rcond=1e-6)[0]
        q[at] += step
        if np.abs(step).max() < 1e-8:
            break
    return float(np.linalg.norm(error))


def _point_limbs(
    robot: MotionRobot, q: Array, home: Array, arms: IntArray, limbs: dict[Segment, Array],
    upright: dict[Segment, Array],
) -> None:  # fmt: skip
    """Writes the arms' joints (base at zero) whose limbs point as asked, seen from the thorax."""
    model, data = robot.model, robot.data
    at = robot.base + arms
    for _ in range(4):
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        thorax = robot.frame(robot.segments["thorax"])
        R = data.oMf[thorax].rotation @ upright["thorax"].T
        rows, left = [], []
        for part, beyond in LIMBS:
            if part not in limbs:
                continue
            ends = [robot.frame(robot.segments[each]) for each in (part, beyond)]
            along = data.oMf[ends[1]].translation - data.oMf[ends[0]].translation
            J = np.subtract(
                *(pin.getFrameJacobian(model, data, k, pin.LOCAL_WORLD_ALIGNED)[:3, at] for k in ends[::-1])
            )
            size = np.linalg.norm(along)
            rows.append(J / size)
            left.append(R @ limbs[part] - along / size)
        J, error = np.concatenate(rows), np.concatenate(left)
        hold = PULL * np.eye(len(at))
        step = np.linalg.lstsq(
            np.concatenate([J, hold]), np.concatenate([error, PULL * (home[at] - q[at])]), rcond=None
        )[0]
        limits = robot.limits
        q[at] = np.clip(q[at] + np.clip(step, -0.5, 0.5), limits.lower[arms], limits.upper[arms])
