"""The wrench at a force/torque sensor that carries links of the robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.blind.generator.dynamics import Kinematics, Tree, body_wrench, carrier, path_down, seen_from_parent
from exogauge.synthetic.inertia import Mass, joined
from exogauge.synthetic.robot_facts import Link

Array = NDArray[np.float64]

AXES = ("fx", "fy", "fz", "mx", "my", "mz")


@final
@dataclass(frozen=True)
class Cut:
    """Where the sensor sits: on moving body `body`, -1 for the base, at `place` (3,) [m] of its frame, axes parallel.

    bodies: the moving ones that it carries. rigid: (10,) of what is fixed to it, in the frame of `body`.
    """

    body: int
    place: Array
    bodies: tuple[int, ...]
    rigid: Array


def cut_at(links: Sequence[Link], frame: str, tree: Tree, masses: Mapping[str, Mass]) -> Cut:
    """The sensor at a link `frame`; masses: of the links that have one."""
    beyond = links_beyond(links, frame)
    on, place = carrier(links, frame)
    fixed = [(masses[name], carrier(links, name)) for name in sorted(beyond) if name in masses]
    rigid = [mass.moved(offset) for mass, (body, offset) in fixed if body == on]
    return Cut(
        tree.names.index(on) if on in tree.names else -1,
        place,
        tuple(n for n, name in enumerate(tree.names) if name in beyond),
        joined(rigid).phi() if rigid else np.zeros(10),
    )


def links_beyond(links: Sequence[Link], frame: str) -> frozenset[str]:
    """All that hangs on `frame`, itself left out. Parents come before children."""
    beyond = set[str]()
    for link in links:
        if link.parent == frame or link.parent in beyond:
            beyond.add(link.name)
    return frozenset(beyond)


def cut_wrench(tree: Tree, phi: Array, cut: Cut, moving: Kinematics) -> Array:
    """(T, 6) force and moment that the carried links exert on the sensor, in its frame: at rest their weight, which
    points downwards. phi: (J, 10)."""
    total = _at_place(cut, *body_wrench(moving, cut.body, cut.rigid))
    for body in cut.bodies:
        total += _column(tree, cut, moving, body, phi[body])
    return -total


def cut_columns(tree: Tree, cut: Cut, moving: Kinematics) -> Array:
    """(T, 6, P) of the same wrench by ten parameters of every carried body and of what is fixed to the sensor."""
    units = np.eye(10)
    columns = [_column(tree, cut, moving, body, unit) for body in cut.bodies for unit in units]
    columns += [_at_place(cut, *body_wrench(moving, cut.body, unit)) for unit in units]
    return -np.stack(columns, axis=2)


def _column(tree: Tree, cut: Cut, moving: Kinematics, body: int, phi: Array) -> Array:
    force, moment = body_wrench(moving, body, phi)
    for each in path_down(tree, body, cut.body) or ():
        force, moment = seen_from_parent(tree, moving, each, force, moment)
    return _at_place(cut, force, moment)


def _at_place(cut: Cut, force: Array, moment: Array) -> Array:
    """(T, 6) from the carrying body's origin to the sensor's."""
    return np.hstack([force, moment - np.cross(cut.place, force)])
