"""A via point on the other side of a robot that is built alike on both: the base link's x-z plane is the mirror."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.device import ViaPoint
from exogauge.devices.posture import Posture
from exogauge.errors import BadInput, Fault
from exogauge.robots.tree import RigidTree

Array = NDArray[np.float64]

TWINS_APART_M = 0.005  # twin links may lie that far from each other's mirror image at zero posture
WORDS = {"left": "right", "Left": "Right", "LEFT": "RIGHT", "l": "r", "L": "R"}
WORDS |= {right: left for left, right in WORDS.items()}
SIDE = re.compile(r"left|right|Left|Right|LEFT|RIGHT|(?<![A-Za-z])[lrLR](?![A-Za-z])")


def mirrored(tree: RigidTree, point: ViaPoint, links: Mapping[str, str]) -> ViaPoint:
    """The point's mirror image at zero posture, on the twin of its link; a link without a side keeps it.

    links: twins by the user's word, believed. Raises BadInput where a link has a side but no twin, or where the origin
    of the twin found by name is not the mirror image of its own.
    """
    twin, advice = links.get(point.link) or twin_of(point.link), "Name its twin in `links`."
    if twin not in tree.frames:
        raise _refused(f"link {point.link!r} has no twin on the other side", "no_twin", advice, twin)
    posture = Posture(tree)
    apart = np.linalg.norm(_reflected(posture.pose(point.link).translation) - posture.pose(twin).translation)
    if twin != point.link and point.link not in links and apart > TWINS_APART_M:
        detail = f"links {point.link!r} and {twin!r} do not lie opposite each other at zero posture"
        raise _refused(f"{detail} ({1e3 * apart:.0f} mm off)", "not_symmetric", advice, twin)
    x, y, z = posture.pose(twin).actInv(_reflected(posture.place(point))).tolist()
    return ViaPoint(twin, (x, y, z))


def twin_of(link: str) -> str:
    """The name with left and right exchanged: `l_thigh` to `r_thigh`; a name without a side is its own twin."""
    return SIDE.sub(lambda side: WORDS[side.group()], link)


def _reflected(place: Array) -> Array:
    x, y, z = place
    return np.array([x, -y, z])


def _refused(detail: str, rule: str, advice: str, value: str) -> BadInput:
    return BadInput(Fault(detail, rule, advice, column="band", value=value))
