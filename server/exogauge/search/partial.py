"""Names that leave most of what is there: the catalogue's nearest shape of something that it does not hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from exogauge.findings.result import Finding, HeldOut
from exogauge.findings.verdict import Objection, Why
from exogauge.identification.model import AddedEffect
from exogauge.identification.result import Identification
from exogauge.search.declared import left_over
from exogauge.search.final_numbers import coefficients
from exogauge.search.finding import channel_of
from exogauge.search.from_log_on import another_in_each_log
from exogauge.search.locate import pooled
from exogauge.search.state import Search
from exogauge.search.taken_out import taken_out


def without_partial_names(search: Search, found: Identification, findings: Sequence[Finding]) -> Search | None:
    """The search without findings that explain the lesser part of what was there before anything was named, at places
    that still stand far above their noise with all of it; None where there are none. found: with all of that, bends
    too. findings: of all steps.

    A law that is not quite right leaves a little of what it takes off. Where as much as the noise is left where it
    shows most, more than such laws leave and more than declared uncertainties explain, another law is there.

    A size at the edge of what such an effect can be is no measurement: something else pulls it there, where more is
    left than noise.

    What acts on many channels at once moves a little of each, also of one that lacks something else, and most shapes of
    a joint's are a little like each other. Where one explains hardly anything of any channel, one that stands above its
    noise is enough.

    Two effects at one place, each with its share, together reach the floor: then both stay. What is told of one log
    alone is judged there. What begins with a log and is another in each goes, however little is left.
    """
    poor = list[tuple[int, Objection]]()
    left = cache(lambda: {each.channel for each in left_over(found, search.last, search.problem.recordings)[0]})
    for number, finding in enumerate(findings):
        if why := another_in_each_log(found.model, search.steps[number].added, search.problem.recordings):
            poor.append((number, why))
        if why or finding.held_out.log:
            continue
        channels = _channels(search, number)
        why = _objection(search, found, finding, number, channels)
        if why is None and (held := _of_another_law(search, found, finding.held_out)) and held.channel in left():
            share = max(_share(search, finding, number, channels), 0.0)
            why = Objection(Why.OTHER_LAW, share, held.floors, of=(held.channel,))
        if why:
            poor.append((number, why))
    for number, why in reversed(poor):
        search = taken_out(search, number, why)
    return search if poor else None


def _channels(search: Search, number: int) -> list[str]:
    """In whose rows it acts."""
    equations = search.problem.base.model.equations
    return [channel_of(equations, kind) for kind in search.steps[number].added.site.kinds(equations)]


def _objection(
    search: Search, found: Identification, finding: Finding, number: int, channels: Sequence[str]
) -> Objection | None:
    criteria = search.problem.settings.criteria.judging
    share = _share(search, finding, number, channels)
    most = _most(search, number, channels) if len(channels) > 1 else share
    edge = _at_its_edge(search.steps[number].added, found)
    if share >= criteria.mostly and most >= criteria.hardly and not edge:
        return None
    bar = criteria.far_above if most >= criteria.hardly and not edge else criteria.above
    known = 1e-3  # of what is left: a lower floor is that of rounding
    for channel in channels:
        left, floor = _held_out(found, channel)
        if np.isfinite(left) and left >= bar * floor >= known * left:
            if edge:
                return Objection(Why.AT_ITS_EDGE, left / floor, of=(channel,))
            return Objection(Why.PARTIAL, max(share, 0.0), left / floor, of=(channel,))
    return None


def _of_another_law(search: Search, found: Identification, of: HeldOut) -> HeldOut | None:
    """What was there before anything was named, and is left with all of it, where that says so."""
    (there, floor), (left, _) = _held_out(search.problem.base, of.channel), _held_out(found, of.channel)
    held = replace(of, rmse_before=there, rmse_after=left, noise_floor=floor)
    return held if held.of_another_law(search.problem.settings.criteria.judging) else None


def _at_its_edge(added: AddedEffect, found: Identification) -> bool:
    """Whether a coefficient ends where its range does, of those whose range ends elsewhere than at none at all."""
    rounding = 1e-3  # of the range's end, as far as a bounded fit reaches it
    for quantity, value in zip(added.effect.coefficients, coefficients(found.model, added), strict=True):
        ends = [end for end in (quantity.low, quantity.high) if np.isfinite(end) and end != 0.0]
        if any(abs(value - end) <= rounding * abs(end) for end in ends):
            return True
    return False


def _share(search: Search, finding: Finding, number: int, channels: Sequence[str]) -> float:
    """Of the square error beyond the noise that was there before anything was named, in units of each row's noise."""
    held = finding.held_out
    if len(channels) == 1:  # with its own curve and the shape that was sought again
        there, floor = _held_out(search.problem.base, held.channel)
        return (held.rmse_before**2 - held.rmse_after**2) / max(there**2 - floor**2, 1e-300)
    first, then, now = (_beyond(each, channels) for each in _without_and_with(search, number))
    return (then - now) / max(first, 1e-300)


def _most(search: Search, number: int, channels: Sequence[str]) -> float:
    """The same of the channel that stood above its noise of which it explains most; 1 of a single channel, whose
    formula may be not quite right, and where none stood above."""
    base, before, now = _without_and_with(search, number)
    above = search.problem.settings.criteria.judging.above**2 - 1.0
    of_each = ((_beyond(base, [each]), _beyond(before, [each]) - _beyond(now, [each])) for each in channels)
    shares = [gone / there for there, gone in of_each if there >= above]
    return max(shares) if shares and len(channels) > 1 else 1.0


def _without_and_with(search: Search, number: int) -> tuple[Identification, Identification, Identification]:
    """Nothing named, all that was named before it, and what was added with it too."""
    base = search.problem.base
    return base, search.before(number), search.steps[number].found


def _beyond(found: Identification, channels: Sequence[str]) -> float:
    squares = [
        (rmse / floor) ** 2 - 1.0 for rmse, floor in (_held_out(found, each) for each in channels) if floor > 0.0
    ]
    return float(np.nansum(np.maximum(squares, 0.0)))


def _held_out(found: Identification, channel: str) -> tuple[float, float]:
    return pooled([fit for fit in found.validation if fit.held_out and fit.channel == channel])
