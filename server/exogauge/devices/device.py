"""A device as its maker describes it: bands through via points, and what is believed of each before any data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final


@final
@dataclass(frozen=True)
class ViaPoint:
    """A point that the band passes. link: a link or frame of the robot; xyz [m] in that link's frame."""

    link: str
    xyz: tuple[float, float, float]


@final
@dataclass(frozen=True)
class BenchTest:
    """A force-length test of the bare band: length [m], force [N], pairs in any order.

    is_truth: what estimates are compared with; otherwise a prior that the estimate starts from.
    """

    length: tuple[float, ...]
    force: tuple[float, ...]
    is_truth: bool = False


@final
@dataclass(frozen=True)
class Band:
    """One elastic band, a wire through two or more via points in order.

    group: bands of one group share their stiffness. law: name of a force law (`effects.band_laws`), law_values: its
    other parameters. stiffness [N/m], natural_length [m]: nominal values, None where unknown; true ones where
    ground_truth. point_std [m]: standard uncertainty of each coordinate of a via point; donning_std [m]: of how much
    longer the band is in one log than in another, as the device was put on; 0: known.
    """

    name: str
    group: str
    via_points: tuple[ViaPoint, ...]
    stiffness: float | None = None
    natural_length: float | None = None
    ground_truth: bool = False
    law: str = "linear"
    law_values: Mapping[str, float] = field(default_factory=dict)
    bench: BenchTest | None = None
    point_std: float = 0.0
    donning_std: float = 0.0


@final
@dataclass(frozen=True)
class Device:
    """tied: groups whose bands have one natural length by the user's word."""

    name: str
    bands: tuple[Band, ...]
    tied: frozenset[str] = frozenset()

    @property
    def groups(self) -> tuple[str, ...]:
        """In the order of their first band."""
        return tuple(dict.fromkeys(band.group for band in self.bands))
