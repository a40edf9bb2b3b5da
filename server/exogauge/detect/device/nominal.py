"""Bands that are stiffer, softer, longer or shorter than stated, by more than anybody doubts.

Stiffness and natural length are fitted in any case, so such a band leaves no residual. What shows it is the distance
from what is stated, measured in what is doubted of it and in what the data leave open. Bands of a group are nearly
alike: one is news if it is far from what the others let expect, or if it is surely beyond all doubt of its own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import Criteria
from exogauge.detect.device.baseline import Ground
from exogauge.detect.device.judge import Folds, left_out_residual, rmse
from exogauge.search.sums import summed, sureness
from exogauge.support.band_model import (
    LENGTH_DOUBT,
    STIFFNESS_DOUBT,
    Belief,
    Fitted,
    Setting,
    Wear,
    believed,
    fit,
    lowest,
)

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Contradicted:
    """One value that the data contradict. band: place; of: `stiffness` or `natural_length`. stated, value, std [N/m or
    m]. gain: what holding it at the stated value costs, in independent errors. z: standard errors by which the error on
    what was left out falls once it is let go; before, after: (N, D) [N·m] there. joint: the one that shows it most.
    setting, fitted: with the value let go."""

    band: int
    of: str
    stated: float
    value: float
    std: float
    gain: float
    z: float
    before: Array
    after: Array
    joint: int
    fitted: Fitted
    setting: Setting

    @property
    def effect(self) -> str:
        return "band_stiffness" if self.of == "stiffness" else "band_length"


def contradicted(ground: Ground, wear: Wear, folds: Folds) -> list[Contradicted]:
    """The widest first; each is let go before the next is looked for. Of a band with another law than a spring nothing
    is said: its values are then that formula's."""
    found: list[Contradicted] = []
    free: frozenset[int] = frozenset()
    other_law = {each.wire for each in wear.added}
    while folds.left_out:
        tried = [
            one
            for place in range(2 * len(ground.device.bands))
            if place not in free
            and place % len(ground.device.bands) not in other_law
            and (one := _tried(ground, wear, place, free, folds)) is not None
        ]
        best = max(tried, key=lambda each: each.gain, default=None)
        if best is None:
            return found
        found.append(best)
        free |= {best.band + (len(ground.device.bands) if best.of != "stiffness" else 0)}
        wear = best.fitted.wear
    return found


def _tried(ground: Ground, wear: Wear, place: int, free: frozenset[int], folds: Folds) -> Contradicted | None:
    """None where nothing is stated, or what is stated may be true."""
    bands, W = ground.device.bands, len(ground.device.bands)
    b, of = place % W, "stiffness" if place < W else "natural_length"
    stated = bands[b].stiffness if place < W else bands[b].natural_length
    if stated is None:
        return None
    doubt = stated * (STIFFNESS_DOUBT if place < W else LENGTH_DOUBT)
    travel = np.array([wire.travel for wire in ground.setting.wires[:W]])
    setting = replace(ground.setting, belief=believed(bands, wear, travel, free | {place}))
    let_go = fit(setting, wear)
    value, doubtful = float(let_go.wear.theta[place]), replace(ground, setting=setting).fit.covariance(let_go)
    std = float(np.sqrt(max(doubtful[place, place], 0.0)))
    off = abs(value - stated)
    sure, beyond = ground.model.criteria.judging.sure, ground.model.criteria.device.beyond
    surely = off - beyond * doubt > sure * std
    known = believed(bands, wear, travel, free)
    if not (surely or _unlike(known, let_go.wear.theta, doubtful, place, ground.model.criteria)):
        return None
    as_stated = lowest(setting, let_go, held={place: stated})
    before = left_out_residual(setting, as_stated.wear, folds, held={place: stated})
    after = left_out_residual(setting, let_go, folds)
    gained = (before**2 - after**2) / ground.sigma**2
    counts = np.isfinite(before).any(axis=1)
    z = sureness(summed(np.nansum(gained, axis=1)[counts], setting.logs.block[counts]))
    joint = int(np.argmax(np.nansum(gained, axis=0)))
    if z < sure or not rmse(after, joint) < rmse(before, joint):
        return None
    return Contradicted(
        band=b,
        of=of,
        stated=stated,
        value=value,
        std=std,
        gain=as_stated.cost - let_go.cost,
        z=z,
        before=before,
        after=after,
        joint=joint,
        fitted=let_go,
        setting=setting,
    )


def _unlike(belief: Belief, theta: Array, doubtful: Array, place: int, criteria: Criteria) -> bool:
    """Whether a value is far from what is stated of it once the others of its group are known, and surely so.
    doubtful: covariance of theta."""
    W2 = len(belief.mean)
    share = belief.precision[place] / belief.precision[place, place]
    off = abs(float(share @ (theta[:W2] - belief.mean)))
    std = float(np.sqrt(max(share @ doubtful[:W2, :W2] @ share, 0.0)))
    least = criteria.device.beyond / np.sqrt(belief.precision[place, place])
    return bool(off > least and off > criteria.judging.sure * std)
