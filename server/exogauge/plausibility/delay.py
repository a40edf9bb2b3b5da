"""Whether efforts were stored later, or earlier, than the positions they belong to."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.examining import Comparing
from exogauge.plausibility.axis_fit import Likelihood
from exogauge.plausibility.expectation import Expected
from exogauge.plausibility.pooling import together
from exogauge.plausibility.summit import summit

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Delay:
    """seconds: > 0 late. axes: alike so. before, after: of the first one, share of its effort that is left.

    log: the only one that is so; empty where all are. far: later than drives and buses are, or earlier. or_friction:
    friction that turns round over a longer way than joints slide by explains as much.
    """

    seconds: float
    axes: tuple[int, ...]
    before: float
    after: float
    log: str = ""
    far: bool = False
    or_friction: bool = False


def find_delays(expected: Sequence[Expected]) -> Iterator[Delay]:
    """One delay that the axes share, where all of them together gain surely by it; then axes with one of their own.

    Where there is none in all logs: logs whose efforts are of another clock, on most of the axes at once.
    """
    alike = [each for each in _of_all_logs([one.in_any_motion() for one in expected]) if _gains_sliding(expected, each)]
    yield from (replace(each, or_friction=not _gains_over_bristles(expected, each)) for each in alike)
    for each in () if alike else expected:
        other = of_another_clock(each)
        if other is not None:
            yield other


def _of_all_logs(expected: Sequence[Expected]) -> Iterator[Delay]:
    """By as much as drives and buses are late; where there is none, by as much as clocks that began apart."""
    axes = [a for a in range(len(expected[0].robot.joints)) if any(each.tells(a) for each in expected)]
    criteria, rate_hz = expected[0].seen.criteria, expected[0].seen.rate_hz
    every = min((each.seen.lags for each in expected), key=len)
    if not axes or any(not np.isin(every, each.seen.lags).all() for each in expected):
        return  # logs of other rates were shifted otherwise
    near = every[np.abs(every) < criteria.delay_far_s + 0.5 / rate_hz]
    told = set[int]()
    for lags in (near, every) if len(every) > len(near) else (near,):
        profiles = [] if told else _profiles(expected, lags, axes)
        for some in (profiles, *([each] for each in profiles)) if profiles else ():
            found = _sure(lags, some, rate_hz, criteria)
            if found is not None and told.isdisjoint(found.axes) and (lags is near or _believed(found, criteria)):
                told.update(found.axes)
                yield found


def _gains_sliding(expected: Sequence[Expected], found: Delay) -> bool:
    """Whether joints that slide ask for it as surely: friction that builds up after a turn comes late by itself."""
    lags = min((each.seen.lags for each in expected), key=len)
    expected = [each.between_turns() for each in expected]
    telling = [axis for axis in found.axes if any(each.tells(axis) for each in expected)]
    gain = np.sum([each.gain for each in _profiles(expected, lags, telling)], axis=0)
    return bool(telling) and float(np.interp(found.seconds, lags, gain)) > expected[0].seen.criteria.delay


def _gains_over_bristles(expected: Sequence[Expected], found: Delay) -> bool:
    """Whether all that moves asks for it as surely, were friction a bristle of whatever way."""
    criteria = expected[0].seen.criteria
    stiff = [each.in_any_motion() for each in expected]
    ways = [stiff, *([each.with_friction_over(way) for each in stiff] for way in criteria.bristles)]

    def likeliest(axis: int, seconds: float) -> float:
        each_way = list[float]()
        for own in ways:
            telling = [each for each in own if each.tells(axis)]
            late = [each.late_likelihood(axis, int(np.argmin(np.abs(each.seen.lags - seconds)))) for each in telling]
            each_way.append(together(late, criteria.as_good_as).described)
        return max(each_way)

    return sum(likeliest(axis, found.seconds) - likeliest(axis, 0.0) for axis in found.axes) > criteria.delay


def _believed(found: Delay, criteria: Comparing) -> bool:
    """A wrong model gains by a shift as well: of a long one more is asked."""
    return not found.far or found.after <= criteria.delay_far_falls * found.before


def _profiles(expected: Sequence[Expected], lags: Array, axes: Sequence[int]) -> list[_Profile]:
    kept = [np.flatnonzero(np.isin(each.seen.lags, lags)) for each in expected]
    return [_Profile(expected, kept, lags, a) for a in axes]


def of_another_clock(expected: Expected) -> Delay | None:
    """Of one log, on half of its axes or more."""
    sliding, expected = expected, expected.in_any_motion()
    axes = [a for a in range(len(expected.robot.joints)) if expected.tells(a)]
    lags, criteria = expected.seen.lags, expected.seen.criteria
    profiles = _profiles([expected], lags, axes)
    found = _sure(lags, profiles, expected.seen.rate_hz, criteria) if profiles else None
    if found is None or 2 * len(found.axes) < len(axes) or not _believed(found, criteria):
        return None
    if not (_gains_sliding([sliding], found) and _gains_over_bristles([sliding], found)):
        return None
    return replace(found, log=expected.seen.log)


@final
class _Profile:
    """gain: (LAGS,) log likelihood over no delay. misfit: (LAGS,) share of the effort that is left.

    Of an axis that loses by both of the shortest shifts longer ones are not tried, and stand as these: who is late by
    more gains by less already, since a shift of 20 ms is a small part of what an 8 Hz low-pass lets through.
    """

    def __init__(self, expected: Sequence[Expected], kept: Sequence[NDArray[np.intp]], lags: Array, axis: int) -> None:
        """kept: places of the lags among those of each log."""
        self.axis = axis
        telling = [(each, own) for each, own in zip(expected, kept, strict=True) if each.tells(axis)]
        at_once = int(np.argmin(np.abs(lags)))
        as_good_as = expected[0].seen.criteria.as_good_as
        tried = [k for k in (at_once - 1, at_once, at_once + 1) if 0 <= k < len(lags)]

        def likelihood(k: int) -> Likelihood:
            return together([each.late_likelihood(axis, int(own[k])) for each, own in telling], as_good_as)

        found = {k: likelihood(k) for k in tried}
        if max(each.described for each in found.values()) > found[at_once].described:
            for k in set(range(len(lags))) - set(tried):
                found[k] = likelihood(k)
        each = [found[int(np.clip(k, min(found), max(found)))] for k in range(len(lags))]
        self.gain = np.array([one.described for one in each]) - found[at_once].described
        self.misfit = np.array([one.misfit for one in each])


def _sure(lags: Array, profiles: Sequence[_Profile], rate_hz: float, criteria: Comparing) -> Delay | None:
    total = np.sum([each.gain for each in profiles], axis=0)
    k, at_once = int(np.argmax(total)), int(np.argmin(np.abs(lags)))
    if total[k] < criteria.delay or k in (0, len(lags) - 1):
        return None
    alike = sorted((each for each in profiles if each.gain[k] > criteria.delay_agrees), key=lambda each: -each.gain[k])
    left = [each.misfit[k] / each.misfit[at_once] for each in alike]
    seconds = summit(lags[k - 1 : k + 2], total[k - 1 : k + 2])
    if (
        not alike
        or np.median(left) > criteria.delay_falls
        or abs(seconds) < max(criteria.delay_least_s, criteria.delay_samples / rate_hz)
    ):
        return None
    worst, far = alike[0], abs(seconds) > criteria.delay_far_s
    before, after = float(worst.misfit[at_once]), float(worst.misfit[k])
    return Delay(seconds, tuple(each.axis for each in alike), before, after, far=far)
