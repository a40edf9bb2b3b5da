"""Coefficients beside those of bodies and joints: the zeros of sensors that carry bodies, estimated with everything
else; and known loads, ten each, with what was stated of them, in the logs that carry it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.effect import Quantity
from exogauge.robots.body_rows import body_rows
from exogauge.robots.description import Robot
from exogauge.robots.motion import Motion
from exogauge.robots.parameters import SYMBOLS, UNITS
from exogauge.robots.rows import RowType

Array = NDArray[np.float64]

COMPONENTS = ("fx", "fy", "fz", "mx", "my", "mz")
PREFIX = "load."
MASS = PREFIX + "m"


@final
@dataclass(frozen=True)
class AddedColumn:
    """name: `stribeck.tau_b`. place: the joint or sensor, in words. kinds: of the rows (`RowLayout`) that hold it.

    measured: (value, std) where it was measured otherwise than by the logs; None where nothing is known of it.
    """

    name: str
    place: str
    kinds: tuple[int, ...]
    coefficient: Quantity
    measured: tuple[float, float] | None = None


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


def kinds_of_body(robot: Robot, body: int) -> tuple[int, ...]:
    """Row kinds (`RowLayout`) that feel a body: base rows, axes on the way to the base, sensors that carry it."""
    above = robot.tree.subtree[:, body] & (robot.tree.dof >= 0)
    acts = robot.axes_from_joints[:, robot.tree.dof[above]] != 0.0
    felt = [axis for axis, joint in enumerate(robot.joints) if acts[axis].any() and joint.actuation != "none"]
    carrying = [index for index, sensor in enumerate(robot.cuts) if body in robot.tree.cuts[sensor.frame]]
    rows = robot.rows
    read = (kind for sensor in carrying for kind in rows.sensor(sensor))
    return (*rows.numbers(RowType.BASE), *map(rows.axis, felt), *read)


def load_columns(robot: Robot) -> tuple[AddedColumn, ...]:
    """`load.m[flange]` … of every load."""
    return tuple(
        AddedColumn(
            PREFIX + symbol,
            load.name,
            kinds_of_body(robot, load.body),
            Quantity(PREFIX + symbol, unit, low=0.0 if symbol == "m" else -np.inf),
            (float(value), float(std)),
        )
        for load in robot.loads
        for symbol, unit, value, std in zip(SYMBOLS, UNITS, load.mean, load.doubt, strict=True)
    )


def load_entries(robot: Robot, recording: str, motion: Motion) -> Array:
    """(T, entries) what these columns take off their rows per unit: a load is something to hold. Of low-passed motion,
    as the columns of the bodies, and not low-passed again."""
    entries = [np.zeros((motion.samples, 0))]
    for load in robot.loads:
        kinds = kinds_of_body(robot, load.body)
        if recording not in load.logs:
            entries.append(np.zeros((motion.samples, 10 * len(kinds))))
            continue
        cuts = [sensor.frame for sensor in robot.cuts]
        rows = (
            body_rows(robot.tree, robot.axes_from_joints, motion, load.body, cuts)[:, robot.rows.in_told(kinds)]
            @ load.columns
        )
        entries.append(-rows.transpose(0, 2, 1).reshape(motion.samples, -1))
    return np.hstack(entries)


def of_loads(added: Sequence[AddedColumn], values: Array) -> Array:
    """(loads, 10) of the values (E,) of added columns."""
    own = [e for e, column in enumerate(added) if column.name.startswith(PREFIX)]
    return np.asarray(values[own].reshape(-1, 10))


def parts_of_links(robot: Robot, recordings: Sequence[str], relative_std: Array) -> Robot:
    """The robot, with loads that the fitted recordings cannot tell from their links as uncertain as these links are.

    What a link carries in all of them is regrouped with its own mass, of which the maker's doubt is a share. As sure as
    it was weighed, it would tell the factor that currents leave open by how little the maker gave that link, and what
    he left out there would be taken for a wrong factor. relative_std: (N,) of the bodies.
    """
    if not robot.loads:
        return robot
    inseparable = inseparable_loads(robot, recordings)
    loads = (
        replace(load, std=max(load.std, float(relative_std[load.body]) * load.mass))
        if load.name in inseparable
        else load
        for load in robot.loads
    )
    return replace(robot, loads=tuple(loads))


def inseparable_loads(robot: Robot, recordings: Sequence[str]) -> tuple[str, ...]:
    """Loads of bodies that carry the same mass in all of the recordings, by name."""
    found = []
    for load in robot.loads:
        same = [other for other in robot.loads if other.body == load.body]
        total = [sum(other.mass for other in same if name in other.logs) for name in recordings]
        if np.ptp(total) <= np.sqrt(sum(other.std**2 for other in same)):
            found.append(load.name)
    return tuple(found)
