"""What may be said of the gap between model and measurement: the one place that decides it, from plain facts.

Headline, report, page, terminal and comparison read the answer; none of them decides again.

Why a candidate was not named, as data.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Literal, final

from exogauge.criteria.judging import Judging
from exogauge.devices.result import Estimate

Verdict = Literal["effects", "unexplained", "undecided", "none"]
Left = Literal["above", "open", "nothing"]


@final
@dataclass(frozen=True)
class Caveat:
    """What was not judged, or has to be kept in mind. of: the channel, joint, log or device that it is about.

    not_held_out; joined: a log had to be fitted. too_short: `value` [s] of the `needed` [s] of
    steady motion, of `others` more channels too little, too; far: `value` noise floors in `seconds` [s], or of a
    channel without name. creeping: below `value` [unit], unless there is the rival (effect; kind, name and part of its
    place). feet_alike: these contact sensors read too much by the share `value` ± `needed`, or all else gives and
    weighs as much more. declared: this channel and `others` stand above the noise, no further than what is declared
    uncertain lets them; rival: the sources of that. spoiled: no log is fitted but such as this one, which the doctor
    holds for wrong. Of the bands of a device: no_steady_motion, nothing_left_out,
    unclear_course. Of a payload: noise_unknown, no_motion; not_foretold:
    what was fitted leaves open what this log should read.
    """

    why: Literal[
        "not_held_out", "joined", "too_short", "far", "creeping", "feet_alike", "declared", "spoiled",
        "no_steady_motion", "nothing_left_out", "unclear_course", "noise_unknown", "no_motion", "not_foretold",
    ]  # fmt: skip
    of: str = ""
    value: float = math.nan
    seconds: float = math.nan
    others: int = 0
    needed: float = math.nan
    rival: tuple[str, ...] = ()
    unit: str = ""


@final
@dataclass(frozen=True)
class Seen:
    """One channel on logs that were not fitted, in steady motion. ratio: its RMSE over its noise floor, NaN where none
    is steady. steady_s: how long that is. moved_s: how long it moved in all logs, fitted or not."""

    channel: str
    ratio: float
    steady_s: float
    moved_s: float


@final
@dataclass(frozen=True)
class Facts:
    """named: effects that were. above: channels that stand above their floors surely, with all that was named. seen:
    all channels that were looked at. told: the other ratios of RMSE to noise floor that a reader is shown of the last
    model, such as the ends of chains. cannot: why something else was not judged. declared: channels that stand above
    their floors no further than uncertainties of these sources let them. judging: by what it is decided."""

    named: int
    above: tuple[str, ...]
    seen: tuple[Seen, ...]
    told: tuple[float, ...] = ()
    cannot: tuple[Caveat, ...] = ()
    declared: tuple[str, ...] = ()
    sources: tuple[str, ...] = ()
    judging: Judging = field(default_factory=Judging)


@final
@dataclass(frozen=True)
class Decision:
    """left: what stands above the noise with all that was named: some channels surely, nothing, or it is open, for the
    reason given."""

    verdict: Verdict
    left: Left
    reason: Caveat | None


def decide(facts: Facts) -> Decision:
    """What is left is judged alike whether or not something was named before. Of a spoiled fit nothing is said."""
    for each in facts.cannot:
        if each.why == "spoiled":
            return Decision("undecided", "open", each)
    reason = _open(facts)
    left: Left = "above" if facts.above else "open" if reason else "nothing"
    without: dict[Left, Verdict] = {"above": "unexplained", "open": "undecided", "nothing": "none"}
    return Decision("effects" if facts.named else without[left], left, reason if left == "open" else None)


def _open(facts: Facts) -> Caveat | None:
    """Why it cannot be said that nothing is left."""
    if facts.cannot:
        return facts.cannot[0]
    if not facts.seen:
        return Caveat("not_held_out")
    if facts.declared:
        return Caveat("declared", facts.declared[0], others=len(facts.declared) - 1, rival=facts.sources)
    judging = facts.judging
    asked = [each for each in facts.seen if each.moved_s >= judging.needed_s]
    short = [each for each in asked or _longest(facts.seen) if each.steady_s < judging.needed_s]
    if short:
        worst = min(short, key=lambda each: each.steady_s)
        return Caveat("too_short", worst.channel, worst.steady_s, others=len(short) - 1, needed=judging.needed_s)
    far = [each for each in facts.seen if _is_far(each.ratio, judging)]
    if far:
        worst = max(far, key=lambda each: each.ratio)
        return Caveat("far", worst.channel, worst.ratio, worst.steady_s)
    told = [ratio for ratio in facts.told if _is_far(ratio, judging)]
    return Caveat("far", value=max(told)) if told else None


def _longest(seen: Sequence[Seen]) -> list[Seen]:
    """Where nothing moved for long, what moved longest speaks for all."""
    return [max(seen, key=lambda each: each.steady_s)]


def _is_far(ratio: float, judging: Judging) -> bool:
    return math.isfinite(ratio) and ratio >= judging.above


@final
class Why(StrEnum):
    """Behind each: what `value`, `beside` and `of` of its objection are."""

    TOO_SHORT = "too_short"  # [s] of steady motion that was not fitted, and that are needed
    FEW_MOMENTS = "few_moments"  # standard errors by which the fitted logs ask for it
    LITTLE = "little"  # share of the error that it explains
    NOT_SURE = "not_sure"  # standard errors by which the held-out error falls, and that are asked for
    NOT_SURE_ONCE = "not_sure_once"  # the same in the one log that has it
    WORSE = "worse"  # standard errors by which the error grows; of: a regime
    NOT_FALLING = "not_falling"  # held-out error without and with it [unit]; of: channel, and the one log that has it
    NOT_FALLING_AGAIN = "not_falling_again"  # the same, low-passed, with the robot identified again
    MAY_BE_NONE = "may_be_none"  # sizes: of what may as well be zero
    SIZE_NOT_SURE = "size_not_sure"  # standard deviations from zero, and that are asked for
    TOO_SMALL = "too_small"  # RMS that it takes off, and noise floor
    SMALL_BESIDE = "small_beside"  # of: the effect that was named there, if it is one
    UNDER_SUPPORT = "under_support"  # share of the support that it would have to be
    AT_FLOOR = "at_floor"
    NOISE_ALONE = "noise_alone"  # share of the fall that is noise which the effect smooths
    ONCE = "once"
    DECLARED = "declared"  # of: channels
    BETTERED = "bettered"  # of: effects with which another one explains more
    PARTIAL = "partial"  # share of the excess that it explains, and noise floors that are left; of: channel
    OTHER_LAW = "other_law"  # as partial
    ANOTHER_IN_EACH_LOG = "another_in_each_log"  # share that a step takes of what changes from log to log
    SLOWER_ALONE = (
        "slower_alone"  # standard errors by which earlier logs, at the speeds of the later ones, contradict it
    )
    AT_ITS_EDGE = "at_its_edge"  # noise floors that are left; of: channel
    NOT_NEEDED = "not_needed"  # of: effects with which it is not needed
    ALIKE = "alike"
    LESS = "less"
    LESS_LIKELY = "less_likely"
    ONE_FACTOR = "one_factor"  # on every motor's gain
    ONE_BODY = "one_body"  # a heavier link, and a load fixed to it


@final
@dataclass(frozen=True)
class Objection:
    """value, beside [unit], of, sizes: as `Why` says."""

    why: Why
    value: float = math.nan
    beside: float = math.nan
    unit: str = ""
    of: tuple[str, ...] = ()
    sizes: Mapping[str, Estimate] = field(default_factory=dict)
