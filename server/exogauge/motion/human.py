"""What was captured of a person, whatever the file was: the canonical form that everything else reads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.moving.segments import Segment

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
DOUBTS = (
    "rate_doubt",
    "unit_doubt",
    "duplicates",
    "far_away",
    "exchanged",
    "held",
    "joined",
    "slips",
    "strays",
    "leaps",
)
"""Keys of `told` that whoever fits or retargets the motion has to read too."""


@final
@dataclass(frozen=True)
class Markers:
    """M labelled points. position: (T, M, 3) [m], world, z up; NaN where the point was not seen.

    filled: (T, M) where a position was filled in and not measured. segment: of a label, which part of the body it is
    on; a label that is not in it is of no known part.
    """

    labels: tuple[str, ...]
    position: Array
    filled: BoolArray
    segment: Mapping[str, Segment] = field(default_factory=dict)


@final
@dataclass(frozen=True)
class JointTree:
    """J bones of a skeleton, parents before children. parent: (J,) index or -1.

    position: (T, J, 3) [m] of the bones' proximal joint centres, world, z up. rotation: (T, J, 3, 3) R_world_bone.
    end: (T, J, 3) [m] the bones' distal ends. rest_rotation: (J, 3, 3) R_world_bone and rest_position, rest_end: (J, 3)
    [m] in the file's own rest posture (all angles zero), root at its own place.
    segment: of a bone's name, which part of the body it is.
    """

    names: tuple[str, ...]
    parent: NDArray[np.intp]
    position: Array
    rotation: Array
    end: Array
    rest_rotation: Array
    rest_position: Array
    rest_end: Array
    segment: Mapping[str, Segment] = field(default_factory=dict)


@final
@dataclass(frozen=True)
class Angles:
    """K coordinates over time as another program gave them (MOT). value: (T, K) [rad or m], rotational: (K,)."""

    names: tuple[str, ...]
    value: Array
    rotational: BoolArray


@final
@dataclass(frozen=True)
class Contacts:
    """(T,) for each foot: does it stand?"""

    left: BoolArray
    right: BoolArray


@final
@dataclass(frozen=True)
class HumanMotion:
    """time: (T,) [s], evenly spaced, from 0. What the file holds is given, the rest is None.

    told: what the reader decided or guessed (up axis, unit, prefix, sides …), by key, in the words of `files.told`.
    """

    name: str
    time: Array
    markers: Markers | None = None
    tree: JointTree | None = None
    angles: Angles | None = None
    contacts: Contacts | None = None
    told: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def rate(self) -> float:
        """[Hz]"""
        return float((len(self.time) - 1) / (self.time[-1] - self.time[0]))
