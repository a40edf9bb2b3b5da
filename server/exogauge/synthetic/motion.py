"""Planned motions: both feet stay, the centre of mass stays over them, everything else moves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np
from numpy.typing import NDArray

from exogauge.synthetic.robot_facts import ANKLE_HEIGHT, HIP_DROP, HIP_HALF_WIDTH, JOINT_NAMES, JOINTS, SHANK, THIGH
from exogauge.synthetic.variation import Variation

Array = NDArray[np.float64]

KNOT_RATE_HZ = 100.0
_STANCE_HEIGHT = 0.715  # of the base, knees a little bent [m]
_COM_FORWARD = 0.02  # where the centre of mass is kept, ahead of the ankles [m]
_RAMP_S = 2.5  # a motion grows out of standing and ends in it
# joint -> (middle, largest deviation) of the excitation [rad]; right arm mirrored
_EXCITED = {
    "torso_yaw": (0.0, 0.45), "torso_pitch": (0.12, 0.28), "neck_yaw": (0.0, 0.9), "neck_pitch": (0.1, 0.45),
    "shoulder_pitch": (-0.3, 0.8), "shoulder_roll": (0.45, 0.45), "shoulder_yaw": (0.0, 0.8),
    "elbow_pitch": (-0.9, 0.7), "wrist_yaw": (0.0, 1.0), "wrist_pitch": (0.0, 0.7), "wrist_roll": (0.0, 0.6),
    "hand_thumb": (-0.3, 0.5), "hand_fingers": (-0.6, 0.6),
}  # fmt: skip
_BASE_ROTATION = (0.11, 0.16, 0.22)  # largest roll, pitch, yaw [rad]
_COM_SWAY = (0.025, 0.045)  # largest forward, sideways [m]
_SQUAT = 0.08  # [m]
LEAD_S = 1.6  # before the log begins: the end of the motion that brought the robot here
_ARRIVAL = 0.12  # how far away it began, joints and base [rad]; half as far down [m]
_ARRIVAL_VARIES = 0.05  # relative, from one repetition to the next
_METRES = 0.5  # of a translation per radian, where a run differs from the plan [m/rad]


@final
@dataclass(frozen=True)
class Plan:
    """What the controller is asked to follow, K knots at `KNOT_RATE_HZ`.

    angles: (K, 34) [rad] in the order of `JOINT_NAMES`; base: (K, 3) [m]; R_base: (K, 3, 3). The first `LEAD_S` are
    not logged: they bring every joint to the first logged posture out of a motion, so that friction at rest is what a
    stop leaves behind.
    """

    angles: Array
    base: Array
    R_base: Array


def standing(planner: mujoco.MjModel) -> Plan:
    """One knot: the posture in which bends and twists begin and end."""
    com = np.array([[_COM_FORWARD, 0.0]])
    return _balanced(_standing(1), np.zeros((1, 3)), com, np.full(1, _STANCE_HEIGHT), planner)


def excitation(
    rng: np.random.Generator,
    duration: float,
    planner: mujoco.MjModel,
    again: np.random.Generator | None = None,
    varied: Variation | None = None,
) -> Plan:
    """Every joint on its own random sum of sines, squats, sway and tilts of the base; slow parts and pauses between.

    rng: of the motion. again, here and below: of one of its repetitions, which arrives a little differently; varied:
    how that repetition differs from the plan all along.
    """
    phase, grown = with_lead(_phase(rng, duration)), with_lead(_envelope(duration))
    angles = _standing(len(phase))
    for j, name in enumerate(JOINT_NAMES):
        kind = name[2:] if name[:2] in ("l_", "r_") else name
        if kind in _EXCITED:
            middle, size = _EXCITED[kind]
            sign = -1.0 if name.startswith("r_") and JOINTS[j].axis != "y" else 1.0
            goal = sign * middle + size * _sines(rng, phase)
            angles[:, j] += grown * (goal - angles[:, j])
    rpy = np.column_stack([grown * size * _sines(rng, phase) for size in _BASE_ROTATION])
    sway = np.column_stack([grown * size * _sines(rng, phase) for size in _COM_SWAY])
    com = sway + np.array([_COM_FORWARD, 0.0])
    height = _STANCE_HEIGHT - _SQUAT * grown * (0.5 + 0.5 * _sines(rng, phase))
    angles, rpy, height = arriving(rng, again, angles, rpy, height)
    return _balanced(*differing(varied, angles, rpy, com, height), planner)


def bend(
    rng: np.random.Generator,
    duration: float,
    planner: mujoco.MjModel,
    again: np.random.Generator | None = None,
    varied: Variation | None = None,
) -> Plan:
    """Forward bends of the torso, held and raised again; the hips follow a little."""
    angle = with_lead(_visits(rng, duration, sizes=(0.5, 0.75), alternate=False))
    return _torso_motion(rng, again, varied, "torso_pitch", angle, np.array([0.0, 0.2, 0.0]), planner)


def twist(
    rng: np.random.Generator,
    duration: float,
    planner: mujoco.MjModel,
    again: np.random.Generator | None = None,
    varied: Variation | None = None,
) -> Plan:
    """Twists of the torso to either side, held and turned back."""
    angle = with_lead(_visits(rng, duration, sizes=(0.5, 0.8), alternate=True))
    return _torso_motion(rng, again, varied, "torso_yaw", angle, np.array([0.0, 0.0, 0.15]), planner)


def _torso_motion(
    rng: np.random.Generator,
    again: np.random.Generator | None,
    varied: Variation | None,
    joint: str,
    angle: Array,
    follows: Array,
    planner: mujoco.MjModel,
) -> Plan:
    """follows: (3,) roll, pitch, yaw of the base per angle of the joint."""
    if varied is not None:
        angle = varied.profile(angle, KNOT_RATE_HZ)
    angles, rpy = _standing(len(angle)), np.outer(angle, follows)
    angles[:, JOINT_NAMES.index(joint)] = angle
    angles, rpy, height = arriving(rng, again, angles, rpy, np.full(len(angle), _STANCE_HEIGHT))
    com = np.tile([_COM_FORWARD, 0.0], (len(angle), 1))
    return _balanced(*differing(varied, angles, rpy, com, height), planner)


def with_lead(profile: Array) -> Array:
    """The profile's first value for `LEAD_S`, then the profile."""
    return np.concatenate([np.repeat(profile[:1], round(LEAD_S * KNOT_RATE_HZ), axis=0), profile])


def _standing(knots: int) -> Array:
    """(K, 34) arms hanging, elbows a little bent."""
    rest = dict.fromkeys(JOINT_NAMES, 0.0)
    for side, sign in (("l", 1.0), ("r", -1.0)):
        rest |= {f"{side}_shoulder_roll": 0.15 * sign, f"{side}_elbow_pitch": -0.35}
    return np.tile(list(rest.values()), (knots, 1))


def _phase(rng: np.random.Generator, duration: float) -> Array:
    """(K,) [s] the motion's own time: it runs, runs slowly, and stands still for about a tenth of the log each."""
    knots = round(duration * KNOT_RATE_HZ)
    rate = np.ones(knots)
    breaks = max(1, round(duration / 14.0))
    for n in range(breaks):
        start = (n + rng.uniform(0.25, 0.4)) * duration / breaks
        for speed, length in ((0.0, rng.uniform(1.2, 1.8)), (0.2, rng.uniform(1.5, 2.5))):
            rate[round(start * KNOT_RATE_HZ) : round((start + length) * KNOT_RATE_HZ)] = speed
            start += length
    window = np.hanning(round(0.6 * KNOT_RATE_HZ) + 2)[1:-1]
    smooth = np.convolve(np.pad(rate, len(window), mode="edge"), window / window.sum(), mode="same")
    return np.cumsum(smooth[len(window) : -len(window)]) / KNOT_RATE_HZ


def _sines(rng: np.random.Generator, phase: Array) -> Array:
    """(K,) five sines between 0.08 and 0.7 Hz at random phases, scaled to reach ±1."""
    frequency = np.exp(np.linspace(np.log(0.08), np.log(0.65), 5) + rng.uniform(-0.1, 0.1, 5))
    shift = rng.uniform(0.0, 2 * np.pi, 5)
    wave = np.sin(2 * np.pi * np.outer(phase, frequency) + shift) @ (rng.uniform(0.6, 1.0, 5) * frequency**-0.4)
    return np.asarray(wave / np.abs(wave).max())


def _envelope(duration: float) -> Array:
    """(K,) 0 while standing at both ends, 1 between."""
    t = np.arange(round(duration * KNOT_RATE_HZ)) / KNOT_RATE_HZ
    return _smooth_step((t - 0.8) / _RAMP_S) * _smooth_step((duration - 0.8 - t) / _RAMP_S)


def _visits(rng: np.random.Generator, duration: float, sizes: tuple[float, float], alternate: bool) -> Array:
    """(K,) [rad] zero, a random size, hold, back to zero, hold, again; to alternating sides if asked."""
    angle = np.zeros(round(duration * KNOT_RATE_HZ))
    t = np.arange(len(angle)) / KNOT_RATE_HZ
    start, sign = 1.0, 1.0
    while start + 5.5 < duration:
        move, hold, back = rng.uniform(1.4, 2.2), rng.uniform(0.7, 1.2), rng.uniform(1.4, 2.2)
        rise, fall = _smooth_step((t - start) / move), _smooth_step((t - start - move - hold) / back)
        angle += sign * rng.uniform(*sizes) * (rise - fall)
        start += move + hold + back + rng.uniform(0.5, 0.9)
        sign = -sign if alternate else sign
    return angle


def _smooth_step(x: Array) -> Array:
    """0 to 1 with no jump in acceleration."""
    x = np.clip(x, 0.0, 1.0)
    return np.asarray(x**3 * (10.0 - 15.0 * x + 6.0 * x**2))


def arriving(
    rng: np.random.Generator, again: np.random.Generator | None, angles: Array, rpy: Array, height: Array
) -> tuple[Array, Array, Array]:
    """The same plan, begun `_ARRIVAL` away on a random side of every joint, and reached before the log begins."""
    joints = angles.shape[1]
    size = np.ones(joints + 4) if again is None else 1.0 + _ARRIVAL_VARIES * again.uniform(-1.0, 1.0, joints + 4)
    away = _ARRIVAL * (1.0 - _smooth_step(np.arange(len(angles)) / (0.8 * LEAD_S * KNOT_RATE_HZ)))[:, None] * size
    angles = angles + away[:, :joints] * rng.choice([-1.0, 1.0], joints)
    rpy = rpy + away[:, joints:-1] * rng.choice([-1.0, 1.0], 3) * [0.5, 0.5, 1.0]
    return angles, rpy, height - 0.5 * away[:, -1]


def differing(
    varied: Variation | None, angles: Array, rpy: Array, com: Array, height: Array
) -> tuple[Array, Array, Array, Array]:
    """What this run does beside the plan, with every joint that is not in a leg and with the base; legs follow."""
    if varied is None:
        return angles, rpy, com, height
    joints = angles.shape[1]
    more = varied.added(len(angles), joints + 6, KNOT_RATE_HZ)
    sway, rise = _METRES * more[:, joints + 3 : joints + 5], _METRES * more[:, -1]
    return angles + more[:, :joints], rpy + more[:, joints : joints + 3], com + sway, height + rise


def _balanced(angles: Array, rpy: Array, com: Array, height: Array, planner: mujoco.MjModel) -> Plan:
    """Legs by inverse kinematics, base shifted until the planner's centre of mass lies where it shall."""
    R = rotations(rpy)
    base = np.column_stack([com, height])
    for _ in range(4):
        _set_legs(angles, base, R)
        base[:, :2] += com - _centres_of_mass(planner, base, R, angles)
    _set_legs(angles, base, R)
    return Plan(angles, base, R)


def _set_legs(angles: Array, base: Array, R: Array) -> None:
    """Write the leg angles that keep both feet in place into `angles`."""
    for side, prefix in ((1.0, "l"), (-1.0, "r")):
        columns = [JOINT_NAMES.index(f"{prefix}_{name}") for name in LEG_JOINTS]
        angles[:, columns] = leg_angles(side, base, R)


def _centres_of_mass(model: mujoco.MjModel, base: Array, R: Array, angles: Array) -> Array:
    """(K, 2) [m] horizontal position of the whole body's centre of mass."""
    data = mujoco.MjData(model)
    quaternion, out = np.zeros(4), np.zeros((len(angles), 2))
    for k in range(len(angles)):
        mujoco.mju_mat2Quat(quaternion, R[k].ravel())
        data.qpos[:3], data.qpos[3:7], data.qpos[7:] = base[k], quaternion, angles[k]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        out[k] = data.subtree_com[1, :2]
    return out


STANCE_HALF_WIDTH = 0.11  # of the ankles [m]
LEG_JOINTS = ("hip_yaw", "hip_roll", "hip_pitch", "knee_pitch", "ankle_pitch", "ankle_roll")


def rotations(rpy: Array) -> Array:
    """(T, 3, 3) Rz(yaw) Ry(pitch) Rx(roll) for rpy (T, 3) [rad]."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy).T, np.sin(rpy).T
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def leg_angles(side: float, position: Array, R: Array) -> Array:
    """(T, 6) [rad] in the order of `LEG_JOINTS`; side +1 left, -1 right.

    position: (T, 3) [m], R: (T, 3, 3) of the base in the world; the foot is level and points forward at
    (0, side · STANCE_HALF_WIDTH). A leg that would have to be longer than it is, is stretched.
    """
    ankle = np.array([0.0, side * STANCE_HALF_WIDTH, ANKLE_HEIGHT])
    hip = position + R @ np.array([0.0, side * HIP_HALF_WIDTH, -HIP_DROP])
    x, y, z = (hip - ankle).T  # hip seen from the ankle; the foot frame is the world's
    distance = np.sqrt(x**2 + y**2 + z**2)
    cosine = np.clip((distance**2 - THIGH**2 - SHANK**2) / (2 * THIGH * SHANK), -1.0, 1.0)
    knee = np.arccos(cosine)
    shank_angle = np.arcsin(np.clip(THIGH * np.sin(np.pi - knee) / distance, -1.0, 1.0))
    ankle_roll = np.arctan2(y, z)
    ankle_pitch = -np.arctan2(x, np.hypot(y, z)) - shank_angle

    c, s, zero, one = np.cos(ankle_roll), np.sin(ankle_roll), np.zeros_like(x), np.ones_like(x)
    roll_back = np.moveaxis(np.array([[one, zero, zero], [zero, c, s], [zero, -s, c]]), 2, 0)
    c, s = np.cos(ankle_pitch + knee), np.sin(ankle_pitch + knee)
    pitch_back = np.moveaxis(np.array([[c, zero, -s], [zero, one, zero], [s, zero, c]]), 2, 0)
    H = np.swapaxes(R, 1, 2) @ roll_back @ pitch_back  # hip yaw, roll, pitch together
    yaw = np.arctan2(-H[:, 0, 1], H[:, 1, 1])
    roll = np.arctan2(H[:, 2, 1], -H[:, 0, 1] * np.sin(yaw) + H[:, 1, 1] * np.cos(yaw))
    pitch = np.arctan2(-H[:, 2, 0], H[:, 2, 2])
    return np.column_stack([yaw, roll, pitch, knee, ankle_pitch, ankle_roll])
