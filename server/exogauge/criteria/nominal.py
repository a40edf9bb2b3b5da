"""When data are said to contradict a number of the maker."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import criterion, derived, judgement

RULES = "docs/decisions/0005-missing-effects.md, 0011"


@final
@dataclass(frozen=True)
class Contradicting:
    """Which link or motor is asked, what may be wrong with it, and which odds are enough."""

    sure: float = criterion(
        9.0,
        "evidence",
        "for letting a number go: odds of 90, as some twenty numbers are looked at",
        derived("2 ln 90 = 9.0"),
    )
    most: int = criterion(
        2, "numbers", "named in one study: with more it is the description that is wrong", judgement(RULES)
    )
    base_turns: float = criterion(
        0.02,
        "rad/s",
        "rms angular velocity of a floating base, below which its accelerometer says nothing beside gravity",
        judgement(RULES),
    )
    tilts: float = criterion(
        0.15, "rad", "rms turn of gravity in a body's frame that shows its weight", judgement(RULES)
    )
    mass_kg: float = criterion(
        1.0, "kg", "what might hang on a link, one standard deviation of a broad belief", judgement(RULES)
    )
    reach_m: float = criterion(0.1, "m", "how far from the link's frame it might hang", judgement(RULES))
    broad_share: float = criterion(0.5, "1", "by which a link may be of another density", judgement(RULES))
    broad_gain: float = criterion(0.25, "1", "by which a motor may give something else", judgement(RULES))
    centre: float = criterion(
        0.1, "1", "of a first moment's doubt that is about where the centre lies, at least", judgement(RULES)
    )
    second_moments: float = criterion(
        2.0,
        "1",
        "times the doubt of a mass: how far the model's prior lets inertias go",
        derived("identification.prior"),
    )
    torque_doubt: float = criterion(
        0.02, "1", "of a logged torque: what a calibration leaves, of which no maker writes", judgement(RULES)
    )
    most_alike: int = criterion(2, "numbers", "told beside one that was named, as also possible", judgement(RULES))
