"""A suit as this robot wears it: stiffness and natural length of every band, and the file that describes it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

import mujoco
import numpy as np
from numpy.typing import NDArray

from exogauge.synthetic.motion import standing
from exogauge.synthetic.suit_facts import BANDS, NAME, STIFFNESS_BY_KIND, STRETCH_STANDING, BandFacts

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


def device_file(suit: Suit, uncertainty: Mapping[str, float] | str = "none") -> Mapping[str, Any]:
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
