"""`smart_suit_lite`: two back bands and two waist bands, after [Evaluator] section 4.1, as worn by `hrp4_like`.

Bands A run from the shoulders over the back to the thighs and are stretched by bending; the short bands B run round the
sides of the waist, past the axis of torso_pitch, and are stretched by twisting. The robot wears a soft layer over its
hard parts; the bands lie on it. The course of the bands is our estimate, the stiffness is the published one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.synthetic.robot_facts import Vector

NAME = "Smart Suit Lite"
LAYER = 0.025  # of the soft layer over every hard shape [m]
STIFFNESS = 197.8  # of one band of group A, from its force test; assumed for group B, as the paper does [N/m]
STIFFNESS_BY_KIND = {"normal": {"A": STIFFNESS, "B": STIFFNESS}, "modified": {"A": 2 * STIFFNESS, "B": STIFFNESS}}
STRETCH_STANDING = (0.005, 0.015)  # least, most: every band is just taut when the robot stands [m]


@final
@dataclass(frozen=True)
class ViaPoint:
    """A point that the band passes. xyz [m] in the link's frame, on the soft layer over the link's shape."""

    link: str
    xyz: Vector


@final
@dataclass(frozen=True)
class BandFacts:
    """A band's course. tested: its stiffness was measured on the bare band."""

    name: str
    group: str
    via_points: tuple[ViaPoint, ...]
    tested: bool


def _left_bands() -> tuple[BandFacts, ...]:
    back = (
        ViaPoint("chest", (0.050, 0.085, 0.385)),  # on the shoulder
        ViaPoint("chest", (-0.060, 0.085, 0.385)),
        ViaPoint("computer", (-0.050, 0.070, 0.110)),
        ViaPoint("computer", (-0.050, 0.060, -0.100)),
        ViaPoint("waist", (-0.0901, 0.030, 0.050)),  # turns with the waist: the lever to torso_pitch stays in a twist
        ViaPoint("BODY", (-0.120, 0.060, 0.045)),
        ViaPoint("BODY", (-0.120, 0.070, -0.100)),
        ViaPoint("l_thigh", (-0.070, 0.010, -0.140)),
    )
    side = (
        ViaPoint("BODY", (-0.120, 0.090, 0.020)),
        ViaPoint("BODY", (-0.090, 0.145, 0.050)),
        ViaPoint("chest", (0.100, 0.160, 0.045)),
        ViaPoint("chest", (0.125, 0.090, 0.075)),
    )
    return BandFacts("A_left", "A", back, tested=True), BandFacts("B_left", "B", side, tested=False)


def _mirrored(band: BandFacts) -> BandFacts:
    points = (
        ViaPoint(f"r_{p.link[2:]}" if p.link.startswith("l_") else p.link, (p.xyz[0], -p.xyz[1], p.xyz[2]))
        for p in band.via_points
    )
    return BandFacts(band.name.replace("left", "right"), band.group, tuple(points), band.tested)


BANDS: tuple[BandFacts, ...] = tuple(twin for band in _left_bands() for twin in (band, _mirrored(band)))
