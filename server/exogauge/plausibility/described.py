"""What the bodies as described ask of base and axes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.description import Robot
from exogauge.robots.motion import Motion
from exogauge.robots.row_blocks import BodyLoads

Array = NDArray[np.float64]


def asked_of(robot: Robot, motion: Motion, recording: str) -> Array:
    """(N, rows) force and moment at the base where it floats, torque at each actuator axis."""
    phi = robot.phi_in(recording).ravel()
    loads = BodyLoads(robot.tree, np.arange(len(phi)), robot.axes_from_joints, ())
    return np.asarray(loads.of(motion, phi[:, None])[0].T)
