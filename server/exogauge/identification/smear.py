"""What a low-pass makes of the bodies' load, beside what it makes of their motion.

A load is no linear function of motion: gravity turns with a sine, what is centrifugal grows with a square. So the
low-passed load of a motion is not the load of the low-passed motion. What is between them is known well enough from
what the maker states of the bodies.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.thinned import at_all, thinned
from exogauge.logs.derivatives import differentiate, differentiate_twice
from exogauge.logs.filtering import LowPass
from exogauge.logs.model import Log
from exogauge.logs.undoing import StoredPositions
from exogauge.robots.description import Robot
from exogauge.robots.motion import Motion
from exogauge.robots.regressor import cut_wrench, inverse_dynamics

Array = NDArray[np.float64]


def smeared(robot: Robot, log: Log, low_pass: LowPass, motion: Motion) -> Array:
    """(T, told rows) what bodies ask of the actuator axes [N·m] and of the sensors that carry some (force, moment, in
    their frames), low-passed as it was stored, less what they ask for `motion`, which was.

    None of a log that nothing has low-passed, nor of a floating robot, whose base moves by what an IMU says.
    """
    if log.stored is None or robot.floating:
        return np.broadcast_to(0.0, (log.samples, len(robot.rows.told)))  # takes no memory
    names = [f"q.{joint.name}" for joint in robot.joints]
    q = StoredPositions(log, names, low_pass).before(log.stored)
    rate_hz = log.rate_hz
    then = Motion(
        q, differentiate(q, rate_hz), differentiate_twice(q, rate_hz), motion.acc, motion.gyro, motion.gyro_dot
    )
    phi = robot.phi_in(log.recording)
    asked, asked_then = (_asked(robot, phi, each, low_pass) for each in (motion, then))
    return log.stored.let_through(asked_then, rate_hz) - asked


def _asked(robot: Robot, phi: Array, motion: Motion, low_pass: LowPass) -> Array:
    """Computed at some of the samples, with a cubic spline between: a load moves little faster than the motion."""
    at = thinned(motion.samples, low_pass.rate_hz, low_pass.cutoff_hz)
    return at_all(motion.samples, at, _asked_at(robot, phi, motion.rows(at)))


def _asked_at(robot: Robot, phi: Array, motion: Motion) -> Array:
    on_axes = inverse_dynamics(robot.tree, motion, phi) @ np.linalg.inv(robot.axes_from_joints)
    on_sensors = [cut_wrench(robot.tree, motion, sensor.frame, phi) for sensor in robot.cuts]
    return np.hstack([on_axes, *on_sensors])
