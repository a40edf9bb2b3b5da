"""What an effect of a band would gain with all bands' springs fitted again beside it: one small solve per shape."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.device import Band
from exogauge.effects.band import BandEffect
from exogauge.effects.shaped import Shape
from exogauge.estimation.least_squares import bounded_least_squares
from exogauge.support.band_model import Added, Fitted, Setting
from exogauge.support.band_rows import Wire

Array = NDArray[np.float64]
Wires = tuple[int, ...]  # places among the wires


@final
@dataclass(frozen=True)
class BandScore:
    """gain: of the cost, in independent errors. evidence: twice the log likelihood gained, less a price per value that
    was chosen (BIC). left: share of the effect that the springs cannot take the place of, 0…1. also: further wires that
    have the same, with the same values."""

    added: Added
    gain: float
    evidence: float
    left: float
    also: tuple[int, ...] = ()

    @property
    def members(self) -> tuple[Added, ...]:
        """The effect at each of its wires."""
        return tuple(replace(self.added, wire=wire) for wire in (self.added.wire, *self.also))


@final
class Scorer:
    """Candidates beside one fit."""

    def __init__(self, setting: Setting, fitted: Fitted) -> None:
        self.setting, self.fitted = setting, fitted
        self._root = np.sqrt(setting.weight)
        self._A = (setting.nuisances.whitened(fitted.A) * self._root[:, :, None]).reshape(-1, fitted.A.shape[2])
        self._e = (fitted.e * self._root).ravel()
        self._H = fitted.hessian
        self._square = float(self._e @ self._e)

    def beside(self, wire: Wire) -> Scorer:
        """The same with a further wire behind the others."""
        other = object.__new__(Scorer)
        other.__dict__.update(self.__dict__)
        other.setting = replace(self.setting, wires=(*self.setting.wires, wire))
        return other

    def score(self, effect: BandEffect, wire: int, shape: tuple[float, ...]) -> BandScore | None:
        """None where the springs take its place, or nothing of it shows."""
        return next(iter(self._scores(effect, (wire,), [shape])), None)

    def _scores(self, effect: BandEffect, wires: Wires, shapes: Sequence[tuple[float, ...]]) -> Iterator[BandScore]:
        """Of those that show and that the springs cannot take the place of."""
        held = 2_000_000  # values of columns at once: 16 MB
        together = max(1, held // (self._e.size * len(effect.coefficients)))
        for some in (shapes[first : first + together] for first in range(0, len(shapes), together)):
            of_each = [self._columns(effect, wire, some) for wire in wires]
            for shape, columns in zip(some, zip(*of_each, strict=True), strict=True):
                if (scored := self._scored(effect, wires, shape, np.asarray(sum(columns)))) is not None:
                    yield scored

    def _columns(self, effect: BandEffect, wire: int, shapes: Sequence[tuple[float, ...]]) -> Iterable[Array]:
        return self.setting.wires[wire].columns_of_all(effect, shapes, *self.fitted.wear.spring(wire))

    def _scored(self, effect: BandEffect, wires: Wires, shape: tuple[float, ...], X: Array) -> BandScore | None:
        blind = 1e-6  # share of a column that the springs cannot take the place of, below which nothing can be told
        pull = (X * self._root[:, :, None]).reshape(-1, X.shape[2]).T @ self._e  # e is without offsets already
        X = self.setting.nuisances.whitened(X)
        X = (X * self._root[:, :, None]).reshape(-1, X.shape[2])
        own, cross = X.T @ X, self._A.T @ X
        if np.any(np.diag(own) <= 0.0):
            return None
        size = np.sqrt(np.diag(own))
        S = (own - cross.T @ np.linalg.lstsq(self._H, cross, rcond=1e-13)[0]) / np.outer(size, size)
        left = float(np.min(np.linalg.eigvalsh(S)))
        if left < blind:
            return None
        c = _bounded(S, pull / size, effect, size)
        gain = float(2.0 * c @ (pull / size) - c @ S @ c)
        chosen = X.shape[1] + len(effect.shapes)
        added, worth = Added(effect, wires[0], shape, c / size), evidence(self.setting, gain, self._square, chosen)
        return BandScore(added, gain, worth, left, wires[1:])

    def best(self, effect: BandEffect, *wires: int) -> tuple[BandScore | None, int]:
        """The best shape of the grid, and how many were tried. wires: which have it, with the same values."""
        shapes = list(itertools.product(*(one.grid for one in effect.shapes)))
        return max(self._scores(effect, wires, shapes), key=lambda each: each.evidence, default=None), len(shapes)

    def refined(self, start: BandScore) -> BandScore:
        """Shapes between their neighbours on the grid, one value after the other, each time closer."""
        refinements = 2
        best, effect = start, start.added.effect
        reach = [np.diff(one.grid).max(initial=0.0) for one in effect.shapes]
        for _ in range(refinements):
            for place, one in enumerate(effect.shapes):
                before, behind = best.added.shape[:place], best.added.shape[place + 1 :]
                values = _around(one, best.added.shape[place], float(reach[place]))
                shapes = [(*before, value, *behind) for value in values if value != best.added.shape[place]]
                tried = self._scores(effect, (best.added.wire, *best.also), shapes)
                best = max([best, *tried], key=lambda each: each.evidence)
            reach = [each / 9 for each in reach]
        return best


def evidence(setting: Setting, gain: float, square: float, chosen: int) -> float:
    nearly_all = 0.999
    share = float(np.clip(gain / max(square, 1e-300), 0.0, nearly_all))
    return float(-setting.independent * np.log1p(-share) - chosen * np.log(max(setting.independent, 2.0)))


def candidates(
    scorer: Scorer, effects: Mapping[str, BandEffect], bands: Sequence[Band]
) -> Iterator[tuple[BandEffect, Wires]]:
    """Every other law at every declared band that it applies to and does not have yet, and at all bands of a group
    together: they are of one make. What happens once happens to one."""
    there = {each.key for each in scorer.fitted.wear.added}
    groups = [
        tuple(b for b, each in enumerate(bands) if each.group == name) for name in {each.group: 0 for each in bands}
    ]
    for effect in (each for each in effects.values() if each.sort == "law"):
        lacking = {
            wire
            for wire in range(len(bands))
            if (effect.name, wire) not in there
            and scorer.setting.wires[wire].applies(effect, *scorer.fitted.wear.spring(wire))
        }
        yield from ((effect, (wire,)) for wire in sorted(lacking))
        if not effect.once:
            yield from ((effect, group) for group in groups if len(group) > 1 and lacking.issuperset(group))


def _around(one: Shape, value: float, reach: float) -> Iterator[float]:
    if one.of_two:
        yield from one.grid
        return
    if one.low > 0.0:  # sizes over decades: by ratios
        ratio = max(float(np.max(np.divide(one.grid[1:], one.grid[:-1]), initial=1.0)), 1.0)
        ratio **= reach / max(float(np.diff(one.grid).max(initial=0.0)), 1e-300)
        values = value * ratio ** np.linspace(-1.0, 1.0, 9)
    else:
        values = value + reach * np.linspace(-1.0, 1.0, 9)
    yield from (float(v) for v in values if one.low <= v <= one.high)


def _bounded(S: Array, g: Array, effect: BandEffect, size: Array) -> Array:
    """(C,) least squares in scaled coefficients, each within its physical range."""
    low, high = (np.array([getattr(each, end) for each in effect.coefficients]) * size for end in ("low", "high"))
    return bounded_least_squares(S, g, low, high)
