"""A suit as this robot wears it: stiffness and natural length of every band, and the file that describes it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

import mujoco
import numpy as np
from numpy.typing import NDArray

from exogauge.synthetic.motion import standing
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


Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class WornBand:
    """stiffness [N/m]; natural_length [m]: below it the band is slack."""

    facts: BandFacts
    stiffness: float
    natural_length: float


@final
@dataclass(frozen=True)
class Suit:
    name: str
    bands: tuple[WornBand, ...]


def fitted_suit(kind: str, planner: mujoco.MjModel, rng: np.random.Generator) -> Suit:
    """A suit that is just taut when the robot stands; kind: a key of `STIFFNESS_BY_KIND`.

    Natural lengths are whole millimetres, and the same for every kind from equal random numbers.
    """
    lengths = np.round(_standing_lengths(planner) - rng.uniform(*STRETCH_STANDING, len(BANDS)), 3)
    bands = (
        WornBand(facts, STIFFNESS_BY_KIND[kind][facts.group], float(length))
        for facts, length in zip(BANDS, lengths, strict=True)
    )
    return Suit(f"{NAME}, {kind}", tuple(bands))


def device_file(suit: Suit, uncertainty: Mapping[str, float | str] | str = "none") -> Mapping[str, Any]:
    """device.yaml as a tree of plain values."""
    return {"version": 1, "uncertainty": uncertainty, "name": suit.name, "bands": [_entry(band) for band in suit.bands]}


def bands_record(suit: Suit) -> dict[str, dict[str, float]]:
    """What truth.json says of the bands."""
    return {
        band.facts.name: {"stiffness_n_per_m": band.stiffness, "natural_length_m": band.natural_length}
        for band in suit.bands
    }


def _entry(band: WornBand) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "name": band.facts.name,
        "group": band.facts.group,
        "via_points": [{"link": point.link, "xyz": list(point.xyz)} for point in band.facts.via_points],
        "stiffness_n_per_m": band.stiffness,
        "natural_length_m": band.natural_length,
    }
    return {**entry, "ground_truth": True} if band.facts.tested else entry


def _standing_lengths(planner: mujoco.MjModel) -> Array:
    """(W,) [m] of `BANDS` along their via points."""
    posture, data = standing(planner), mujoco.MjData(planner)
    data.qpos[:3], data.qpos[7:] = posture.base[0], posture.angles[0]
    mujoco.mj_kinematics(planner, data)
    lengths = []
    for band in BANDS:
        points = [data.body(p.link).xpos + data.body(p.link).xmat.reshape(3, 3) @ p.xyz for p in band.via_points]
        lengths.append(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    return np.array(lengths)
