"""The zero of a force/torque sensor that carries bodies: what it reads beside them, estimated with everything else."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.effect import Quantity
from exogauge.identification.added_column import AddedColumn
from exogauge.robots.description import Robot

Array = NDArray[np.float64]

COMPONENTS = ("fx", "fy", "fz", "mx", "my", "mz")


def zero_columns(robot: Robot) -> tuple[AddedColumn, ...]:
    """Six for each sensor, in rows of its own: what it reads with nothing beyond it, in the log's own sign."""
    return tuple(
        AddedColumn(f"zero.{component}", sensor.name, (kind,), Quantity(f"zero.{component}", unit))
        for index, sensor in enumerate(robot.cuts)
        for kind, component, unit in zip(robot.rows.sensor(index), COMPONENTS, ("N",) * 3 + ("N·m",) * 3, strict=True)
    )


def zeros(robot: Robot, samples: int) -> Array:
    """(T, 6 C) what the columns take off their rows per unit: a row holds -s times the reading (`WrenchSensor`)."""
    return np.tile(np.repeat([sensor.sign for sensor in robot.cuts], 6).astype(np.float64), (samples, 1))
