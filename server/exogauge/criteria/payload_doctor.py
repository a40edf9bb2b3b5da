"""Payload: when a recording is complained of before it is believed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import criterion, derived, judgement

RULES = "docs/payload.md"


@final
@dataclass(frozen=True)
class Complaining:
    """The rest of what a doctor asks is in `Carrying`."""

    coarse: float = criterion(
        2.0, "std", "that a step of the converter may be: beyond, noise is no longer white", judgement(RULES)
    )
    noise_ratio: tuple[float, float] = criterion(
        (0.5, 1.5), "1", "found over stated, between which the statement holds", judgement(RULES)
    )
    clear: float = criterion(
        5.0, "std", "by which a drift, a step or a delay is beyond chance", derived("normal distribution, 6e-7")
    )
    fewest_beside: int = criterion(3, "postures", "on either side of a step of the zero", judgement(RULES))
    other_axes_deg: float = criterion(
        5.0, "°", "between an IMU's axes and the sensor's: mounting is better than that", judgement(RULES)
    )
    gain: float = criterion(0.02, "1", "of an accelerometer, as makers state it", judgement(RULES))
    other_gain: float = criterion(
        1.3, "1", "times that an accelerometer may read gravity: beyond, its unit is wrong", judgement(RULES)
    )
    orthonormal: float = criterion(
        1e-3, "1", "by which RᵀR may differ from 1: entries with four printed digits", derived("2 · 5e-4 of one entry")
    )
    fewest_samples: int = criterion(
        20, "samples", "of a log: fewer hold no motion that a filter settles in", judgement(RULES)
    )
    rates_hz: tuple[float, float] = criterion(
        (5.0, 20_000.0),
        "Hz",
        "of a log, that a wrist sensor may have: they give 50 Hz to 7 kHz; time in another unit is beyond",
        judgement(RULES),
    )
    most_turn_rad: float = criterion(
        8.0, "rad", "of an angle: more than any joint turns; 460 in degrees is more", judgement(RULES)
    )


USUAL = Complaining()
