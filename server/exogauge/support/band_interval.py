"""95 % intervals of fitted springs: along the profile of the likelihood, around every fit that is not surely worse."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from exogauge.criteria.criterion import Z95
from exogauge.support.band_doubt import inverted
from exogauge.support.band_fit import BandFit, downhill, starts
from exogauge.support.band_model import SMALL, Fitted, Reached, Setting, Wear, fit, lowest, residual, thinned

Array = NDArray[np.float64]

SKEWED = 0.02  # std over the value (over the stretch, for a length) from which a symmetric interval's ends are tried
SHORTEST = 1e-3  # [N/m or m] of either value


@final
@dataclass(frozen=True)
class Profiles:
    """95 % intervals of a fit's springs. covariance: (P, P) of theta about the truth. beside: (P,) variance of it that
    moves a value alone, whatever the fit: the profile is walked without it. A course that is longer throughout moves
    its band's natural length, and nothing else.

    The profile's square sum counts by how much the curvature overstates what coloured residuals really tell, so that
    both kinds of interval agree where the cost is a parabola. Neither value is below 0; an end beyond reach is 0 or
    infinite. Where another fit is not surely contradicted, the interval holds that one's too.
    """

    seen: BandFit
    covariance: Array
    beside: Array

    @property
    def setting(self) -> Setting:
        return self.seen.setting

    @property
    def fitted(self) -> Fitted:
        return self.seen.fitted

    def interval(self, index: int, relative_to: float) -> tuple[float, float]:
        """(low, high) of one value. relative_to: its size; with a std of less than a small share of it no doubt is
        skewed."""
        std, value = float(np.sqrt(self.covariance[index, index])), float(self.fitted.wear.springs[index])
        if not np.isfinite(std):
            return 0.0, np.inf
        if std < SKEWED * relative_to:
            return value - Z95 * std, value + Z95 * std
        if index not in self._found:
            ends = [self._walked(index)]
            for rival, worse in self._rivals:
                among = self._share(index) * (rival.fitted.cost - self.fitted.cost) <= Z95**2  # these ends already
                if worse < Z95**2 and not among:
                    ends.append(rival._walked(index, Z95**2 - worse))
            self._found[index] = self._widened(index, min(low for low, _ in ends), max(high for _, high in ends))
        return self._found[index]

    def of_band(self, k: int, stretch: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """Of stiffness and natural length. The pull is known, not what it is a product of: a length is as skewed as
        the stiffness that it goes with. stretch: [m] the largest."""
        wear = self.fitted.wear
        k_at, l_at = int(wear.layout.stiffness[k]), int(wear.layout.natural_length[k])
        value = float(wear.springs[k_at])
        skewed = self.covariance[k_at, k_at] >= (SKEWED * value) ** 2
        return self.interval(k_at, value), self.interval(l_at, 0.0 if skewed else stretch)

    def of_other_fits(self, index: int, sure: float) -> list[float]:
        """The same value by fits that end elsewhere and are not surely worse. sure: standard deviations. Of a hundred
        intervals five lie beside the truth, which is no reason for being off by half of it."""
        _, coarse = self._coarse
        shift = float(self.fitted.wear.springs[index]) - float(coarse.wear.springs[index])
        as_good = [each for each in self._elsewhere if self._share(index) * (each.cost - coarse.cost) <= sure**2]
        ends = [float(each.wear.springs[index]) + shift for each in as_good]
        rivals = [rival for rival, worse in self._rivals if worse < sure**2]
        return [*ends, *(float(rival.fitted.wear.springs[index]) for rival in rivals)]

    @cached_property
    def _found(self) -> dict[int, tuple[float, float]]:
        """Bands share values: what was walked along once."""
        return {}

    @cached_property
    def _coarse(self) -> tuple[Setting, Fitted]:
        few = thinned(self.setting)
        return few, fit(few, self.fitted.wear)

    @cached_property
    def _elsewhere(self) -> list[Reached]:
        """Where the fit ends if bands come taut earlier or later than it has them: harder and later is nearly alike."""
        few, coarse = self._coarse
        layout = coarse.wear.layout
        begin = starts(layout, few.wires[: len(layout.natural_length)], coarse.wear.effects)
        return downhill(few, [replace(coarse.wear, springs=each.springs) for each in begin], self._small)

    @cached_property
    def _small(self) -> float:
        """Share of the cost that moves an end by less than it is sought to: of its half, a two-thousandth."""
        return max(SMALL, 1e-3 * Z95**2 / max(self._coarse[1].cost, SMALL))

    @cached_property
    def _rivals(self) -> list[tuple[Profiles, float]]:
        """Fits that end elsewhere, each with a doubt of its own, and by how much they are worse: twice the logarithm of
        the likelihood along what the two say differently. Declared errors bend both, so that costs that differ by them
        say little."""
        found, few = [(self, 0.0)], self._coarse[1].wear
        for each in self._elsewhere:
            if _alike(each.wear, few):
                continue
            fitted = fit(self.setting, each.wear)
            if any(_alike(fitted.wear, one.fitted.wear) for one, _ in found):
                continue
            other = Profiles(replace(self.seen, fitted=fitted), self.seen.covariance(fitted), self.beside)
            worse = max(self._against(fitted) ** 2 - other._against(self.fitted) ** 2, 0.0)
            found.append((other, worse))
        return found[1:]

    def _against(self, other: Fitted) -> float:
        """Standard deviations by which the data speak against another fit and for this one: what that one leaves, along
        the difference of what both say, beside what its own springs could follow."""
        setting, weight, A = self.setting, self.setting.weight, other.A
        left, ours = (residual(setting.logs, setting.wires, each.wear) for each in (other, self.fitted))
        apart = left - ours
        followed = np.einsum("ndp,nd,nd->p", A, weight, setting.nuisances.without(apart))
        apart = apart - A @ (inverted(other.hessian) @ followed)
        columns = np.concatenate([A, apart[:, :, None]], axis=2)
        scores = replace(other, A=columns, hessian=np.eye(columns.shape[2]))  # whose covariance is that of the scores
        variance = float(replace(self.seen, null=None).covariance(scores)[-1, -1])
        return float(np.einsum("nd,nd,nd->", apart, weight, other.e) / np.sqrt(max(variance, 1e-300)))

    def _widened(self, index: int, low: float, high: float) -> tuple[float, float]:
        """With what is beside the profile."""
        value, beside = float(self.fitted.wear.springs[index]), Z95 * float(np.sqrt(self.beside[index]))
        return max(value - float(np.hypot(value - low, beside)), 0.0), value + float(np.hypot(high - value, beside))

    def _std(self, index: int) -> float:
        """Along the profile."""
        least = 0.01  # of a variance: it is a sum with what is beside, of which rounding may leave nothing
        whole = float(self.covariance[index, index])
        return float(np.sqrt(max(whole - float(self.beside[index]), least * whole)))

    def _share(self, index: int) -> float:
        """Of what the curvature tells of a value, what is really told."""
        _, coarse = self._coarse
        return float(inverted(coarse.hessian)[index, index] / max(self._std(index) ** 2, 1e-300))

    def _walked(self, index: int, level: float | None = None) -> tuple[float, float]:
        """level: from this fit alone, whatever others there are, to where it is so much worse."""
        std, value = self._std(index), float(self.fitted.wear.springs[index])
        if not std > 0.0:  # the band pulls nowhere in this fit
            return 0.0, np.inf
        few, coarse = self._coarse
        reach = 12.0  # standard deviations within which the ends of a profile are sought
        elsewhere, level = (self._elsewhere, Z95**2) if level is None else ([], level)
        share, half = self._share(index), np.sqrt(level) * std
        shift = value - float(coarse.wear.springs[index])
        also = [each.wear for each in elsewhere if share * (each.cost - coarse.cost) <= level]
        reached = {float(wear.springs[index]) + shift: wear for wear in also} | {value: coarse.wear}
        first, last = min(reached), max(reached)

        @cache  # both ends, and both of a search for either, ask for the same values again
        def deviations(candidate: float) -> float:
            """By which it is worse than the fit: straight lines where the profile is a parabola."""
            nearest = reached[min(reached, key=lambda other: abs(other - candidate))]
            starts = (
                [coarse.wear] if nearest is coarse.wear else [coarse.wear, nearest]
            )  # where bands go slack are dips
            at = {index: max(candidate - shift, SHORTEST)}
            held = min((lowest(few, start, at, self._small) for start in starts), key=lambda reached: reached.cost)
            reached[candidate] = held.wear
            return float(np.sqrt(max(share * (held.cost - coarse.cost), 0.0)))

        low, high = value - half, value + half
        straight = 0.2 * level  # of the cost at a symmetric interval's ends: they are off by a tenth of its half
        narrow = low <= first and last <= high
        if narrow and low > SHORTEST and all(abs(deviations(end) ** 2 - level) <= straight for end in (low, high)):
            return low, high
        end = float(np.sqrt(level))
        return (
            _crossing(deviations, end, first, -half, max(SHORTEST, first - reach * std)) or 0.0,
            _crossing(deviations, end, last, half, last + reach * std) or np.inf,
        )


def _alike(one: Wear, other: Wear) -> bool:
    """Whether two searches have ended in the same place."""
    return np.allclose(one.springs, other.springs, rtol=SKEWED)


def _crossing(
    deviations: Callable[[float], float], level: float, value: float, step: float, limit: float
) -> float | None:
    """Where the profile crosses its level, going from value by steps towards limit; None if it does not."""
    near = value
    while (limit - near) * np.sign(step) > 0.0:
        far = near + step
        far = min(far, limit) if step > 0.0 else max(far, limit)
        if deviations(far) > level:
            return float(brentq(lambda at: deviations(at) - level, near, far, xtol=1e-2 * abs(step)))
        near = far
        step *= 1.5
    return None
