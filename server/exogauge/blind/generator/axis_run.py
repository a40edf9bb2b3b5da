"""One joint over all logs of a case: what it does, what it carries, and what its motor gives without hidden effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import interp1d
from scipy.signal import lfilter

from exogauge.blind.generator.dynamics import UP, joint_torques
from exogauge.blind.generator.motion import RATE_HZ, Motion
from exogauge.blind.generator.true_robot import TrueDrive, TrueRobot

Array = NDArray[np.float64]

_WIND_UP_S = 0.05  # of the position controller, before a joint breaks away
_AMBIENT, _WARM = 22.0, 24.0  # of the room, and how far above it a busy joint ends [°C]
_THERMAL_S = 150.0  # time constant of a joint
_NUDGE = 1e-4  # [rad] for the slope of gravity
_SELDOM = 20  # samples between two values of what changes slowly


@final
@dataclass(frozen=True)
class AxisRun:
    """L logs of T samples, (L, T) unless said otherwise.

    q, dq, ddq: [rad, rad/s, rad/s²]. direction: sign of dq, exactly 0 at rest. load: what bodies and bands ask.
    friction: Coulomb friction, or what friction takes at rest, positive against positive motion. motor: k_T i, the
    motor's torque [N·m]. temperature: [°C]. inertia: of what the joint carries, about its axis [kg·m²]. stiffness:
    slope of the load over q by gravity [N·m/rad]. time: (T,) [s] since the log began.
    """

    time: Array
    q: Array
    dq: Array
    ddq: Array
    direction: Array
    load: Array
    friction: Array
    motor: Array
    temperature: Array
    inertia: Array
    stiffness: Array
    drive: TrueDrive


def axis_runs(rng: np.random.Generator, robot: TrueRobot, motion: Motion, pull: Array | None = None) -> list[AxisRun]:
    """Every joint without any hidden effect of its own. A stiff position controller makes the motion what was planned.

    pull: (L, T, J) [N·m] that the joints must give beside what the bodies ask: against bands, pushes, a leaning base.
    """
    loads = _torques(robot, motion.q, motion.dq, motion.ddq)
    if pull is not None:
        loads = loads + pull
    inertia, stiffness = _links(robot, motion)
    warmth = np.sort(rng.uniform(0.0, 0.8, len(motion.q)))  # the session goes on from log to log
    runs = list[AxisRun]()
    for j, drive in enumerate(robot.drives):
        q, dq, ddq, load = (x[:, :, j] for x in (motion.q, motion.dq, motion.ddq, loads))
        direction = np.sign(dq)
        friction = np.array([_friction(rng, drive, *log) for log in zip(direction, load, strict=True)])
        motor = load + drive.J_r * ddq + drive.k_d * dq + friction - drive.tau_o
        temperature = _temperatures(drive, dq, warmth * rng.uniform(0.85, 1.15))
        felt = (direction, load, friction, motor, temperature, inertia[:, :, j], stiffness[:, :, j])
        runs.append(AxisRun(motion.time, q, dq, ddq, *felt, drive))
    return runs


def _torques(robot: TrueRobot, q: Array, dq: Array, ddq: Array, up: Array = UP) -> Array:
    """(L, T, J) [N·m] of the bodies."""
    flat = [x.reshape(-1, q.shape[2]) for x in (q, dq, ddq)]
    return joint_torques(robot.tree, robot.phi, flat[0], flat[1], flat[2], up).reshape(q.shape)


def _links(robot: TrueRobot, motion: Motion) -> tuple[Array, Array]:
    """inertia and stiffness of `AxisRun`, (L, T, J) each; they change slowly, so few samples serve."""
    samples = motion.q.shape[1]
    some = np.unique(np.append(np.arange(0, samples, _SELDOM), samples - 1))
    q, none = motion.q[:, some], np.zeros_like(motion.q[:, some])
    resting, inertia, stiffness = _torques(robot, q, none, none), none.copy(), none.copy()
    for j in range(q.shape[2]):
        unit = none.copy()
        unit[:, :, j] = 1.0
        inertia[:, :, j] = _torques(robot, q, none, unit, 0.0 * UP)[:, :, j]
        stiffness[:, :, j] = (_torques(robot, q + _NUDGE * unit, none, none) - resting)[:, :, j] / _NUDGE
    every = np.arange(samples)
    return np.asarray(interp1d(some, inertia, axis=1)(every)), np.asarray(interp1d(some, stiffness, axis=1)(every))


def _friction(rng: np.random.Generator, drive: TrueDrive, direction: Array, load: Array) -> Array:
    """(T,) of one log. At rest the controller's error does not change, so the motor's torque stays what it was and
    friction takes every change of the load, until it would exceed tau_s; then the motor follows. Shortly before the
    joint breaks away, the motor has wound up against tau_s.
    """
    friction = drive.tau_c * direction
    resting = np.concatenate([[False], direction == 0.0, [False]])
    edges = np.flatnonzero(np.diff(resting.astype(np.int8))).reshape(-1, 2)
    for start, stop in edges:
        held = float(friction[start - 1]) if start > 0 else float(rng.uniform(-drive.tau_s, drive.tau_s))
        motor = held + float(load[max(start - 1, 0)])
        for k in range(start, stop):
            motor = min(max(motor, load[k] - drive.tau_s), load[k] + drive.tau_s)
            friction[k] = motor - load[k]
        if stop < len(direction):
            length = min(round(_WIND_UP_S * RATE_HZ), stop - start)
            share = np.linspace(0.0, 1.0, length + 1)[1:]
            wound = friction[stop - length : stop]
            friction[stop - length : stop] = (1.0 - share) * wound + share * drive.tau_s * direction[stop]
    return friction


def _temperatures(drive: TrueDrive, dq: Array, start: Sequence[float] | Array) -> Array:
    """(L, T) [°C]: one thermal mass heated by friction, exact steps; start: (L,) warmth 0…1 at each log's beginning."""
    loss = drive.k_d * dq**2 + drive.tau_c * np.abs(dq)
    target = _WARM * loss / max(float(loss.mean()), 1e-9)
    keep = float(np.exp(-1.0 / (RATE_HZ * _THERMAL_S)))
    risen, _ = lfilter([1.0 - keep], [1.0, -keep], target, axis=1, zi=keep * _WARM * np.asarray(start)[:, None])
    return np.asarray(_AMBIENT + risen)
