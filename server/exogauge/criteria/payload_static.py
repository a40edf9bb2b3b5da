"""Payload, at rest: which samples are a posture, and what postures are asked to decide."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import convention, criterion, derived, judgement

RULES = "docs/payload.md"


@final
@dataclass(frozen=True)
class Standing:
    """Holds, their rank, and other readings of the same data."""

    window_s: float = criterion(0.2, "s", "over which a movement is told from noise", judgement(RULES))
    slowest: float = criterion(
        2e-3,
        "rad/s",
        "slower than that is standing: at 40 kg·m a centripetal force below a fifth of a millinewton",
        derived("m r ω²: 40 kg·m (2e-3 rad/s)² = 1.6e-4 N"),
    )
    noises: float = criterion(
        5.0, "std", "that noise alone does not reach in a million samples", derived("normal distribution, 6e-7")
    )
    shortest_hold_s: float = criterion(0.3, "s", "that a posture is held at least", judgement(RULES))
    swinging_s: float = criterion(0.1, "s", "cut off at both ends of a hold: what still swings there", judgement(RULES))
    unrest_stds: float = criterion(
        2.0,
        "std",
        "of chance by which halves of postures differ by more than white noise does, from which on it is coloured",
        convention("two standard deviations, 95 %"),
    )
    rank: float = criterion(
        1e-3,
        "1",
        "of the largest scaled singular value, above which a direction counts as seen",
        derived("three postures 1° apart have 6e-3, noise of a pose 1e-5"),
    )
    clearly: float = criterion(
        3.0, "1", "times by which another reading of the data must be better, to be named", judgement(RULES)
    )
    unexplained: float = criterion(
        0.02, "1", "of the largest force, left over: what a sensor's own errors do not reach", judgement(RULES)
    )
    unexplained_clearly: float = criterion(
        0.2,
        "1",
        "the same, where no weight on a fixed sensor explains it",
        judgement("a lean of 20° that is taken as level leaves that much"),
    )
    seen_axes: float = criterion(
        0.1,
        "1",
        "of the largest singular value of gravity's directions, above which other axes of a wrench are looked for",
        judgement(RULES),
    )
    aligned: float = criterion(
        0.1, "1", "that an entry may be from 0 or ±1, of axes that are exchanged: 6°", derived("sin 6° = 0.10")
    )
    turned_deg: float = criterion(
        1.0, "°", "from which on a turn of the wrench's axes is told: mounting is better than that", judgement(RULES)
    )
    alike_deg: float = criterion(
        5.0,
        "°",
        "by which gravity's directions differ at least, before equal forces say that nothing hangs there",
        judgement(RULES),
    )
    outlier: float = criterion(
        5.0,
        "1",
        "times what the others leave: a posture that is predicted worse was touched, and is left out",
        judgement(RULES),
    )
    outliers: float = criterion(
        0.2,
        "of the postures",
        "that may be left out: more are no touch but a model that does not hold",
        judgement(RULES),
    )
    latest_imu_s: float = criterion(
        0.03, "s", "by which an IMU's stamps may be late: those that are worse are another clock", judgement(RULES)
    )
    imu_gain: float = criterion(
        0.02,
        "1",
        "std of a gain of an IMU's axis, or of what it reads of another one, as mounted: makers give 1 to 3 %",
        judgement(RULES),
    )
    imu_place_m: float = criterion(
        0.1, "m", "std of where an IMU sits beside the sensor's origin, before motion says", judgement(RULES)
    )
    ft_crosstalk: float = criterion(
        0.01,
        "1",
        "std of what an axis reads of another one, where nobody states it: makers give 1 to 2 % at most",
        judgement(RULES),
    )


USUAL = Standing()
