"""The true robot follows a plan under a position controller; what its sensors would say without noise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from exogauge.synthetic.mjcf import TIME_STEP
from exogauge.synthetic.motion import KNOT_RATE_HZ, LEAD_S, Plan
from exogauge.synthetic.robot_facts import JOINTS
from exogauge.synthetic.sensors import COMMAND_STEP, ENCODER_STEP
from exogauge.synthetic.true_robot import JointTruth, TrueRobot

Array = NDArray[np.float64]

LOG_RATE_HZ = 200.0
_SETTLE_S = 0.4  # for the soles to take the weight before the plan begins
_VELOCITY_FILTER_HZ = 120.0  # of the controller's differentiated encoder
_FALLEN_M = 0.2  # below where the plan has the base
_STATIC_SPEED = 0.0002  # below it friction rises from tau_c to tau_s [rad/s]


@final
@dataclass(frozen=True)
class Recording:
    """T samples at `LOG_RATE_HZ`, J joints, W bands, without noise.

    time: (T,) [s]; q, dq, ddq: (T, J); current: (T, J) [A]; friction: (T, J) [N·m] Coulomb or static, against motion;
    gyro_dot: (T, 3) [rad/s²] of the base, in its frame (no sensor has it); acc, gyro: (T, 3) in the IMU frame;
    wrench: (T, 2, 6) world on robot, force then moment, in the sensors' frames.
    What no log holds: band_torque (T, J) [N·m] of all bands on the joints, positive along the axis (a bend forward is
    supported by a negative one); band_length (T, W) [m], band_tension (T, W) [N]. Without a suit zeros, and W = 0.
    """

    time: Array
    q: Array
    dq: Array
    ddq: Array
    current: Array
    friction: Array
    gyro_dot: Array
    acc: Array
    gyro: Array
    wrench: Array
    band_torque: Array
    band_length: Array
    band_tension: Array


@final
@dataclass(frozen=True)
class DriveState:
    """How a drive is other than its record says.

    factors(seconds of the log): (J,) each, of k_T, of k_d, of tau_c, tau_s and tau_b; taken once a second. load: (J,)
    Coulomb friction grows by this share of the torque that the gear passes on.
    """

    factors: Callable[[float], tuple[Array, Array, Array]]
    load: Array


class FellOver(RuntimeError):
    """The plan was too wild for this robot: a fault of the generator."""


def simulate(
    model: mujoco.MjModel,
    robot: TrueRobot,
    plan: Plan,
    tick: Callable[[float], None],
    late_steps: int = 0,
    state: DriveState | None = None,
    encoder_step: float = ENCODER_STEP,
) -> Recording:
    """Follow the plan at 1 kHz, record every fifth step; tick(seconds of it simulated) now and then.

    model: a new `mujoco_model(robot)`; its friction is changed at every step, and with a state its drives. late_steps:
    how many the log begins late.
    """
    angle_goal, rate_goal = _goals(plan)
    steps, every = len(angle_goal), round(1.0 / (LOG_RATE_HZ * TIME_STEP))
    settle, first = round(_SETTLE_S / TIME_STEP), round(LEAD_S / TIME_STEP) + late_steps
    data, drives = mujoco.MjData(model), [robot.joints[joint.name] for joint in JOINTS]
    _stand(model, data, plan)
    servo = _Servo(angle_goal[0], encoder_step)
    k_T, tau_o = np.array([d.k_T for d in drives]), np.array([d.tau_o for d in drives])
    friction, load = _Friction(robot), None if state is None or not state.load.any() else state.load
    q, v, applied, lossy = data.qpos[7:], data.qvel[6:], data.qfrc_applied[6:], model.dof_frictionloss[6:]  # as it is
    log: list[Array] = []
    for step in range(-settle, steps):
        goal = max(step, 0)
        if state is not None and (step - first) % 1000 == 0:
            k_T = _warmed(model, drives, friction, *state.factors((step - first) * TIME_STEP))
        current = servo.current(q, angle_goal[goal], rate_goal[goal])
        applied[:] = k_T * current + tau_o
        lossy[:] = friction.limit(v)
        if load is not None:
            lossy += load * np.abs(_passed_on(model, data))
        kept = step >= first and (step - first) % every == 0
        before = (q.copy(), v.copy()) if kept else ()
        mujoco.mj_step(model, data)
        if kept:
            joints = (*before, data.qacc[6:], current, _friction_force(data), data.qfrc_spring[6:])
            log.append(np.concatenate([*joints, data.qacc[3:6], data.sensordata, data.ten_length]))
        if step % 1000 == 0:
            planned = plan.base[min(round(goal * TIME_STEP * KNOT_RATE_HZ), len(plan.base) - 1), 2]
            if data.xpos[1, 2] < planned - _FALLEN_M or not np.isfinite(data.qpos[2]):
                raise FellOver(f"the simulated robot fell after {step * TIME_STEP:.1f} s")
            tick(max(step - first, 0) * TIME_STEP)
    return _recording(np.array(log), model)


@final
class _Servo:
    """Proportional-derivative on quantised angles; believes the maker's motor constants; steps of `COMMAND_STEP`."""

    def __init__(self, start: Array, step: float) -> None:
        drives = [joint.drive for joint in JOINTS]
        self.stiffness = np.array([d.stiffness / d.k_T for d in drives])
        self.damping = np.array([d.damping / d.k_T for d in drives])
        self.most = np.array([d.effort / d.k_T for d in drives])
        self.least = -self.most
        self.step = step
        self.angle, self.rate = np.rint(start / step), np.zeros(len(start))
        self.share = 1.0 - np.exp(-2 * np.pi * _VELOCITY_FILTER_HZ * TIME_STEP)

    def current(self, angle: Array, angle_goal: Array, rate_goal: Array) -> Array:
        """(J,) [A]"""
        counts = np.rint(angle / self.step)
        self.rate += self.share * ((counts - self.angle) * (self.step / TIME_STEP) - self.rate)
        self.angle = counts
        wanted = self.stiffness * (angle_goal - counts * self.step) + self.damping * (rate_goal - self.rate)
        stepped = np.rint(wanted / COMMAND_STEP) * COMMAND_STEP
        return np.asarray(np.minimum(np.maximum(stepped, self.least), self.most))


@final
class _Friction:
    """The largest friction each joint can hold or slides against at a velocity [N·m]."""

    def __init__(self, robot: TrueRobot) -> None:
        truths = [robot.joints[joint.name] for joint in JOINTS]
        self.tau_c, self.tau_s = np.array([t.tau_c for t in truths]), np.array([t.tau_s for t in truths])
        self.tau_b, self.v_s = np.array([t.tau_b for t in truths]), np.array([t.v_s for t in truths])
        self.peaked = bool(np.any(self.tau_b > 0.0))
        self.factor: Array | float = 1.0  # of a warmer drive

    def limit(self, velocity: Array) -> Array:
        most = np.where(np.abs(velocity) < _STATIC_SPEED, self.tau_s, self.tau_c)
        most = most + self.tau_b * np.exp(-np.square(velocity / self.v_s)) if self.peaked else most
        return np.asarray(self.factor * most)


def _friction_force(data: mujoco.MjData) -> Array:
    """(J,) [N·m] of the friction constraints, positive against positive motion."""
    count = len(JOINTS)
    return np.asarray(-data.efc_force[:count])


def _passed_on(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """(J,) [N·m] of the last step, from the motor through the gear to the link: what friction and rotor leave."""
    if data.nefc < len(JOINTS):
        return np.zeros(len(JOINTS))  # before the first step
    resisted = _friction_force(data) + model.dof_damping[6:] * data.qvel[6:] + model.dof_armature[6:] * data.qacc[6:]
    return np.asarray(data.qfrc_applied[6:] - resisted)


def _warmed(
    model: mujoco.MjModel, drives: list[JointTruth], friction: _Friction, gain: Array, viscous: Array, coulomb: Array
) -> Array:
    """(J,) k_T from now on; friction and the model's damping become what they are (see `mujoco_model`)."""
    k_d = viscous * np.array([drive.k_d for drive in drives])
    friction.factor = coulomb
    model.dof_damping[6:] = k_d
    model.dof_armature[6:] = np.array([drive.J_r for drive in drives]) + k_d * TIME_STEP / 2
    return np.asarray(gain * np.array([drive.k_T for drive in drives]))


def _goals(plan: Plan) -> tuple[Array, Array]:
    """Plan at every step: (S, J) [rad], (S, J) [rad/s]."""
    knots = np.arange(len(plan.angles)) / KNOT_RATE_HZ
    spline = CubicSpline(knots, plan.angles)
    t = np.minimum(np.arange(round(len(knots) / KNOT_RATE_HZ / TIME_STEP)) * TIME_STEP, knots[-1])
    return np.asarray(spline(t)), np.asarray(spline(t, 1))


def _stand(model: mujoco.MjModel, data: mujoco.MjData, plan: Plan) -> None:
    """On the ground, at rest, in the plan's first posture."""
    data.qpos[:3] = plan.base[0] + [0.0, 0.0, 0.0005]
    mujoco.mju_mat2Quat(data.qpos[3:7], plan.R_base[0].ravel())
    data.qpos[7:] = plan.angles[0]
    mujoco.mj_forward(model, data)


def _recording(rows: Array, model: mujoco.MjModel) -> Recording:
    q, dq, ddq, current, friction, band_torque, rest = np.split(rows, len(JOINTS) * np.arange(1, 7), axis=1)
    gyro_dot, sensors, length = np.split(rest, [3, 3 + model.nsensordata], axis=1)
    wrench = -sensors[:, :12].reshape(-1, 2, 6)  # MuJoCo gives that of the foot on the sole
    time = np.arange(len(rows)) / LOG_RATE_HZ
    stretch = np.maximum(length - model.tendon_lengthspring[:, 1], 0.0)
    bands = (band_torque, length, model.tendon_stiffness * stretch)
    return Recording(
        time, q, dq, ddq, current, friction, gyro_dot, sensors[:, 12:15], sensors[:, 15:18], wrench, *bands
    )
