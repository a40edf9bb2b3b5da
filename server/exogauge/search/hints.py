"""Shapes that a grid cannot hold, such as the order of a ripple: read off the residuals, then tried like all others."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.model import Effect
from exogauge.identification.sites import AxisSite
from exogauge.search.baseline import Ground
from exogauge.search.candidates import Candidate

Array = NDArray[np.float64]


@runtime_checkable
class Promising(Protocol):
    """An effect that can read candidates for its first shape off residuals over the position."""

    def promising(self, position: Array, residual: Array, span: float) -> Sequence[float]: ...


def hinted(ground: Ground, effects: Sequence[Effect]) -> Iterator[Candidate]:
    """Candidates whose shape the fitted residuals suggest, where they would explain more than chance."""
    least = ground.model.criteria.search.hint
    fitted = [each for each in ground.residuals if not each.held_out]
    for effect in effects:
        if not isinstance(effect, Promising):
            continue
        for site in ground.candidates:
            if not isinstance(site, AxisSite) or not any(each.effect is effect for each in ground.candidates[site]):
                continue
            kind = ground.model.equations.layout.axis(site.axis)
            known = [each for each in fitted if kind in each.residual]
            if not known:
                continue
            residual = np.concatenate([each.residual[kind] for each in known])
            position = np.concatenate([each.axes[site.axis].position for each in known])
            ok, span = np.isfinite(residual), float(ground.model.sizes.range[site.axis])
            if ok.sum() < 100:
                continue
            for cycles in effect.promising(position[ok], residual[ok], span):
                if _gain(position[ok], residual[ok], 2.0 * np.pi * cycles / span, ground.memory[kind]) > least:
                    yield Candidate(effect, site, (cycles,))


def _gain(position: Array, residual: Array, order: float, memory: float) -> float:
    """Twice the log likelihood gained by a sine and a cosine of the position, with coloured residuals."""
    waves = np.column_stack([np.sin(order * position), np.cos(order * position), np.ones_like(position)])
    left = residual - waves @ np.linalg.lstsq(waves, residual, rcond=None)[0]
    centred = residual - residual.mean()
    return float(len(residual) / memory * np.log(max(centred @ centred, 1e-300) / max(left @ left, 1e-300)))
