"""Everything that could be missing: each effect of the catalogue on each axis, at each of its shapes."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.shaped import AxisSignals, ShapedEffect
from exogauge.identification.preparation import Prepared

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Candidate:
    """One effect on one axis at one shape."""

    effect: ShapedEffect
    axis: int
    shape: tuple[float, ...]

    @property
    def width(self) -> int:
        """Number of its columns."""
        return len(self.effect.coefficients)


def candidates_on(axis: int, effects: Sequence[ShapedEffect]) -> list[Candidate]:
    return [Candidate(effect, axis, shape) for effect in effects for shape in grid(effect)]


def grid(effect: ShapedEffect) -> Iterator[tuple[float, ...]]:
    """All combinations of the shapes' grid values; the empty one where it has none."""
    yield from itertools.product(*(shape.grid for shape in effect.shapes))


def torques(candidates: Sequence[Candidate], signals: AxisSignals, prepared: Prepared) -> Array:
    """(n, C) what they deliver to the joint per unit of each coefficient, at the log's kept samples, as the drive sees
    it: low-passed alike."""
    if not candidates:
        return np.zeros((len(prepared.kept), 0))
    raw = np.hstack([each.effect.columns(signals, each.shape) for each in candidates])
    return np.asarray(prepared.low_pass.apply(raw)[prepared.kept])
