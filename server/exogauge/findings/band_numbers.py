"""Stiffness and natural length as the model with the named effects of the bands has them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

from exogauge.devices.result import Approach, BandEstimate, Estimate, StiffnessResult

Z_95 = 1.959963984540054  # standard normal quantile of 97.5 %


@final
@dataclass(frozen=True)
class BandNumbers:
    """One band of a device beside the effects that were named, by the approach that they were found with."""

    device: str
    approach: Approach
    band: str
    stiffness: Estimate
    natural_length: Estimate


def with_effects(stiffness: Sequence[StiffnessResult], found: Sequence[BandNumbers]) -> tuple[StiffnessResult, ...]:
    """stiffness: of bands as springs alone. What no effect was named beside stays."""
    numbers = {(each.device, each.approach, each.band): each for each in found}

    def told(result: StiffnessResult) -> StiffnessResult:
        bands = tuple(_told(band, numbers.get((result.device, result.approach, band.band))) for band in result.bands)
        return replace(result, bands=bands)

    return tuple(told(each) for each in stiffness)


def _told(band: BandEstimate, now: BandNumbers | None) -> BandEstimate:
    if now is None:
        return band
    truth, k = band.true_stiffness, now.stiffness.value
    return replace(
        band,
        stiffness=now.stiffness,
        natural_length=now.natural_length,
        stiffness_interval=_interval(now.stiffness),
        natural_length_interval=_interval(now.natural_length),
        error_percent=100.0 * (k - truth) / truth if truth else None,
        with_effects=True,
    )


def _interval(found: Estimate) -> tuple[float, float]:
    return found.value - Z_95 * found.std, found.value + Z_95 * found.std
