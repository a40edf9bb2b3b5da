"""The device that a robot wears in some of its logs: its bands as they are, and as their maker states them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from exogauge.blind.generator.dynamics import Tree, carrier
from exogauge.blind.generator.motion import Motion
from exogauge.blind.generator.places import Point, Poses, poses, wire
from exogauge.blind.generator.robot_kind import Wire
from exogauge.blind.generator.true_robot import FURTHEST
from exogauge.synthetic.robot_facts import Link

Array = NDArray[np.float64]

STIFFNESS_STD, LENGTH_STD = 0.1, 0.007  # relative, of the truth about what the maker states; `FURTHEST` times at most
_STIFFNESS = (150.0, 450.0)  # least and most [N/m]
_TAUT_FROM = 0.12  # share of the samples at which a band is slack, about


@final
@dataclass(frozen=True)
class Band:
    """lengths: (W, T, S) [m] of its stretches in the logs in which it is worn, slopes: (W, T, S, J) [m/rad],
    wraps: (W, T, S-1) [rad] by which it bends between them.

    stiffness [N/m], natural_length [m], which may change over time: (W, T): true ones; stated: what device.yaml says of
    the two.
    """

    wire: Wire
    lengths: Array
    slopes: Array
    wraps: Array
    stiffness: float
    natural_length: float | Array
    stated: tuple[float, float]

    @property
    def length(self) -> Array:
        """(W, T) [m]"""
        return np.asarray(self.lengths.sum(axis=2))

    @property
    def slope(self) -> Array:
        """(W, T, J) [m/rad]"""
        return np.asarray(self.slopes.sum(axis=2))

    @property
    def stretch(self) -> Array:
        """(W, T) [m], 0 where it is slack."""
        return np.asarray(np.maximum(self.length - self.natural_length, 0.0))

    @property
    def tension(self) -> Array:
        """(W, T) [N]"""
        return self.stiffness * self.stretch

    def pull(self, tension: Array) -> Array:
        """(W, T, J) [N·m] that joints must give against a tension, one for the band (W, T) or for each stretch."""
        if tension.ndim == 2:
            return tension[:, :, None] * self.slope
        return np.asarray(np.einsum("wts,wtsj->wtj", tension, self.slopes))


@final
@dataclass(frozen=True)
class Wear:
    """bands: of device.yaml. spare: courses that no band of it takes. worn: (L,) whether a log has the device on."""

    bands: tuple[Band, ...]
    spare: tuple[Band, ...]
    worn: NDArray[np.bool_]

    def in_all_logs(self, values: Array) -> Array:
        """(L, T, J) from (W, T, J): nothing in logs without the device."""
        out = np.zeros((len(self.worn), *values.shape[1:]))
        out[self.worn] = values
        return out

    def pull(self) -> Array:
        """(L, T, J) [N·m] against all bands."""
        return self.in_all_logs(np.asarray(sum(band.pull(band.tension) for band in self.bands)))

    def device_file(self, name: str) -> Mapping[str, Any]:
        """device.yaml as a tree of plain values."""
        return {"version": 1, "uncertainty": "none", "name": name, "bands": [_entry(band) for band in self.bands]}

    def record(self) -> Mapping[str, Mapping[str, float]]:
        """For the answers."""
        return {
            band.wire.name: {"stiffness_n_per_m": band.stiffness, "natural_length_m": float(band.natural_length)}
            for band in self.bands
        }


def draw_wear(
    rng: np.random.Generator,
    wires: Sequence[Wire],
    size: float,
    links: Sequence[Link],
    tree: Tree,
    motion: Motion,
    worn: NDArray[np.bool_],
) -> Wear:
    """One or two pairs of bands. size: of this robot, relative to the one that the wires were laid on."""
    at = poses(tree, motion.q[worn].reshape(-1, motion.q.shape[2]))
    groups = list(dict.fromkeys(wire.group for wire in wires))
    chosen = {str(group) for group in rng.choice(groups, int(rng.integers(1, 3)), replace=False)}
    drawn = {group: _drawn_stiffness(rng) for group in groups}
    bands = [_drawn(rng, wire, size, links, at, int(worn.sum()), drawn[wire.group]) for wire in wires]
    return Wear(
        tuple(band for band in bands if band.wire.group in chosen),
        tuple(band for band in bands if band.wire.group not in chosen),
        worn,
    )


def _drawn_stiffness(rng: np.random.Generator) -> tuple[float, float]:
    """What is true of one group, and what is stated [N/m]."""
    stated = round(float(np.exp(rng.uniform(*np.log(_STIFFNESS)))), 0)
    return stated * (1.0 + STIFFNESS_STD * _deviation(rng)), stated


def _drawn(
    rng: np.random.Generator,
    course: Wire,
    size: float,
    links: Sequence[Link],
    at: Poses,
    logs: int,
    stiffness: tuple[float, float],
) -> Band:
    laid = scaled(course, size)
    points = [_point(links, at.tree, link, np.array(xyz)) for link, xyz in laid.points]
    lengths, slopes, wraps = (x.reshape(logs, len(x) // logs, *x.shape[1:]) for x in wire(at, points))
    length = lengths.sum(axis=2)
    stated = round(float(np.quantile(length, _TAUT_FROM)), 3)
    natural_length = stated * (1.0 + LENGTH_STD * _deviation(rng))
    return Band(laid, lengths, slopes, wraps, stiffness[0], natural_length, (stiffness[1], stated))


def scaled(course: Wire, size: float) -> Wire:
    """Laid on a robot of another size, to the tenth of a millimetre."""
    points = tuple(
        (link, (round(x * size, 4), round(y * size, 4), round(z * size, 4))) for link, (x, y, z) in course.points
    )
    return Wire(course.name, course.group, points)


def _point(links: Sequence[Link], tree: Tree, link: str, xyz: Array) -> Point:
    on, offset = carrier(links, link)
    return (tree.names.index(on) if on in tree.names else -1), offset + xyz


def _deviation(rng: np.random.Generator) -> float:
    return float(np.clip(rng.standard_normal(), -FURTHEST, FURTHEST))


def _entry(band: Band) -> dict[str, Any]:
    stiffness, length = band.stated
    points = [{"link": link, "xyz": list(xyz)} for link, xyz in band.wire.points]
    return {
        "name": band.wire.name,
        "group": band.wire.group,
        "via_points": points,
        "stiffness_n_per_m": stiffness,
        "natural_length_m": length,
    }
