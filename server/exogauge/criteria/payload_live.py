"""Payload, live: which samples of a stream are used, and what is said of what is known by now."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import criterion, derived, judgement

RULES = "docs/payload.md"


@final
@dataclass(frozen=True)
class Streaming:
    """What decides on whole logs decides here too; these come beside it."""

    estimates_hz: float = criterion(10.0, "Hz", "at which it is told what is known", judgement(RULES))
    before_s: float = criterion(
        0.1, "s", "left out before an alarm: a contact begins below the threshold", judgement(RULES)
    )
    after_s: float = criterion(
        0.2, "s", "left out after an alarm: a contact ends below the threshold", judgement(RULES)
    )
    lately_s: float = criterion(0.5, "s", "without a sample that was used: the estimate is frozen", judgement(RULES))
    barred_s: float = criterion(
        5.0,
        "s",
        "of motion in alarm, more than was used: what rests on the payload so long may be another zero",
        judgement(RULES),
    )
    block: int = criterion(
        25,
        "samples",
        "whose scores are summed: longer than the smoother remembers, so that sums are independent",
        judgement(RULES),
    )
    blocks: int = criterion(
        100,
        "blocks",
        "that are judged by the newest estimate; older ones keep what they were judged by",
        judgement(RULES),
    )
    excited: float = criterion(
        9.0, "1", "times the noise's share in the columns of the inertia: below, they are noise", derived("3² = 9")
    )
    steady: int = criterion(10, "estimates", "over which numbers must stay to have converged", judgement(RULES))
    stays: float = criterion(2.0, "std", "within which a number must stay meanwhile", judgement(RULES))
    moves_again: float = criterion(
        6.0,
        "std",
        "by which a number must move in a second before what has converged is converging again: three times `stays`",
        judgement(RULES),
    )
    contradicts: float = criterion(
        8.0,
        "std",
        "of 16 numbers at once by which what is known differs from what was known before: another payload",
        derived("χ² of 16 is more than 64 once in 10⁷"),
    )
    late_explains: float = criterion(
        0.5,
        "1",
        "share of the square of what seems to be touched that a late wrench must explain, to be that: most of it",
        judgement(RULES),
    )
    thaws_s: float = criterion(
        0.3, "s", "of samples that are used, before what was frozen is no longer", judgement(RULES)
    )
    still_samples: float = criterion(
        100.0,
        "samples",
        "memory of the filter of what stands still: α errs by a hundredth of what it does in motion",
        judgement(RULES),
    )
    longest_gap: int = criterion(
        25, "samples", "that are stepped over; beyond, the filter begins anew", judgement(RULES)
    )
    density: float = criterion(
        10.0,
        "rad²/s⁵, m²/s⁵",
        "of jerk, where no log tells: what robots' motions have, 1 to 10",
        judgement(RULES),
    )
    late_s: float = criterion(
        0.1, "s", "behind the quickest sample so far: more than the smoother waits for", derived("its lag, 0.1 s")
    )
    straight_s: float = criterion(
        0.001,
        "s",
        "that a wrench may be later than it is taken to be, and a straight line still says what that does",
        derived("of a motion of 2 Hz the square leaves (2π · 2 · 0.001)² / 2 = 1e-4"),
    )
    judged_s: float = criterion(20.0, "s", "of a log, by which the density of its jerk is chosen", judgement(RULES))


USUAL = Streaming()
