"""What may be said of the gap between model and measurement: the one place that decides it, from plain facts.

Headline, report, page, terminal and comparison read the answer; none of them decides again.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, final

Verdict = Literal["effects", "unexplained", "undecided", "none"]
Left = Literal["above", "open", "nothing"]

ABOVE = 1.25  # times the noise floor: below, the floor itself is not known better
NEEDED_S = 5.0  # steady held-out motion of a channel: five independent parts of a second, with which errors are judged
NOT_HELD_OUT = "cannot judge: no log was held out"


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
    model, such as the ends of chains. cannot: why something else was not judged, in words."""

    named: int
    above: tuple[str, ...]
    seen: tuple[Seen, ...]
    told: tuple[float, ...] = ()
    cannot: tuple[str, ...] = ()


@final
@dataclass(frozen=True)
class Decision:
    """left: what stands above the noise with all that was named: some channels surely, nothing, or it is open, for the
    reason given, in numbers."""

    verdict: Verdict
    left: Left
    reason: str


def decide(facts: Facts) -> Decision:
    """What is left is judged alike whether or not something was named before."""
    reason = _open(facts)
    left: Left = "above" if facts.above else "open" if reason else "nothing"
    without: dict[Left, Verdict] = {"above": "unexplained", "open": "undecided", "nothing": "none"}
    return Decision("effects" if facts.named else without[left], left, reason if left == "open" else "")


def _open(facts: Facts) -> str:
    """Why it cannot be said that nothing is left, or ""."""
    if facts.cannot:
        return facts.cannot[0]
    if not facts.seen:
        return NOT_HELD_OUT
    asked = [each for each in facts.seen if each.moved_s >= NEEDED_S]
    short = [each for each in asked or _longest(facts.seen) if each.steady_s < NEEDED_S]
    if short:
        return _too_short(short)
    far = [each for each in facts.seen if _is_far(each.ratio)]
    if far:
        worst = max(far, key=lambda each: each.ratio if math.isfinite(each.ratio) else math.inf)
        return (
            f"cannot judge: {_name(worst)} stands at {worst.ratio:.3g} noise floors, and {worst.steady_s:.1f} s of "
            "steady held-out motion are too short to be sure of that"
        )
    if any(_is_far(ratio) for ratio in facts.told):
        worst_told = max(ratio for ratio in facts.told if _is_far(ratio))
        return f"cannot judge: a channel stands at {worst_told:.3g} noise floors, and nothing says that it surely does"
    return ""


def _longest(seen: Sequence[Seen]) -> list[Seen]:
    """Where nothing moved for long, what moved longest speaks for all."""
    return [max(seen, key=lambda each: each.steady_s)]


def _too_short(short: Sequence[Seen]) -> str:
    worst = min(short, key=lambda each: each.steady_s)
    others = len(short) - 1
    more = f"; {others} other channel{'s have' if others > 1 else ' has'} less than that, too" if others else ""
    return f"cannot judge: {worst.steady_s:.1f} of {NEEDED_S:.0f} s of steady held-out motion at {_name(worst)}{more}"


def _is_far(ratio: float) -> bool:
    return math.isfinite(ratio) and ratio >= ABOVE


def _name(seen: Seen) -> str:
    return seen.channel.removeprefix("tau.").removeprefix("ft.")
