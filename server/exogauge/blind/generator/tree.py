"""A table of links as a tree of moving bodies.

Every link frame is parallel to the base frame at zero posture and every joint turns about x, y or z of its link.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.synthetic.inertia import Mass, joined
from exogauge.synthetic.robot_facts import Link

Array = NDArray[np.float64]

_AXIS = {"x": 0, "y": 1, "z": 2}


@final
@dataclass(frozen=True)
class Tree:
    """J moving bodies, parents before children.

    names: of their links. parent: index of the body it hangs on, -1 for the base. origin: (J, 3) [m] of the joint in
    the parent body's frame. axis: (J,) 0, 1, 2 for x, y, z.
    """

    names: tuple[str, ...]
    parent: tuple[int, ...]
    origin: Array
    axis: tuple[int, ...]


def tree_of(links: Sequence[Link]) -> Tree:
    """Links without a joint belong to the body they are fixed to."""
    moving = [link for link in links if link.joint is not None]
    names = [link.name for link in moving]
    parent, origin = [], []
    for link in moving:
        on, offset = carrier(links, link.parent)
        parent.append(names.index(on) if on in names else -1)
        origin.append(offset + link.origin)
    return Tree(
        tuple(names), tuple(parent), np.array(origin), tuple(_AXIS[link.joint.axis] for link in moving if link.joint)
    )


def bodies_of(links: Sequence[Link], masses: Mapping[str, Mass]) -> Array:
    """(J, 10) of the moving bodies, fixed links merged in; order m, mx … mz, Ixx, Ixy, Iyy, Ixz, Iyz, Izz."""
    moving = [link.name for link in links if link.joint is not None]
    return np.array([_body(links, masses, name).phi() for name in moving])


def _body(links: Sequence[Link], masses: Mapping[str, Mass], name: str) -> Mass:
    carriers = {link.name: carrier(links, link.name) for link in links if link.name in masses}
    return joined(masses[each].moved(offset) for each, (on, offset) in carriers.items() if on == name)


def carrier(links: Sequence[Link], name: str | None) -> tuple[str, Array]:
    """The link whose joint moves `name` (or the base), and the origin of `name` seen from it."""
    by_name = {link.name: link for link in links}
    link, offset = by_name[name or links[0].name], np.zeros(3)
    while link.joint is None and link.parent is not None:
        offset += link.origin
        link = by_name[link.parent]
    return link.name, offset
