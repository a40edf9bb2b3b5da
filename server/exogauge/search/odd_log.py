"""What begins with a held-out log, or sits in it alone: no fitted log has it, so that log joins the fitted ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from exogauge.criteria.criteria import Criteria
from exogauge.findings.verdict import Caveat
from exogauge.identification.identify import identify
from exogauge.identification.result import ChannelFit
from exogauge.identification.settings import Recording
from exogauge.search.search import resumed
from exogauge.search.state import Search


def look_into_odd_logs(search: Search) -> tuple[Search, tuple[Caveat, ...]]:
    """What it finds once a log that differs from all others is fitted, and notes; or the same search."""
    problem = search.problem
    for recording in odd_logs(search):
        joined = [replace(each, held_out=False) if each is recording else each for each in problem.recordings]
        number = problem.base.model.order.get(recording.log.name, -1)
        base = identify(problem.base.model.robot, joined, problem.settings)
        with_it = replace(problem, base=base, recordings=joined, only=number)
        again = resumed(replace(search, problem=with_it), search.steps)
        if len(again.steps) > len(search.steps):
            return again, (Caveat("joined", recording.log.name),)
    return search, ()


def odd_logs(search: Search) -> Iterator[Recording]:
    """Held-out ones, in the order of the study, in which some channel errs more than noise and more than where it was
    fitted."""
    problem = search.problem
    order, criteria = problem.base.model.order, problem.settings.criteria
    fits = search.current.validation
    fitted = {fit.channel: _mean_square([each for each in fits if each.channel == fit.channel and not each.held_out])
              for fit in fits}  # fmt: skip
    for recording in sorted(problem.recordings, key=lambda each: order.get(each.log.name, -1)):
        own = [fit for fit in fits if fit.log == recording.log.name and fit.rmse_moving is not None]
        if recording.held_out and any(_is_odd(fit, fitted[fit.channel], criteria) for fit in own):
            yield recording


def _is_odd(fit: ChannelFit, fitted: float, criteria: Criteria) -> bool:
    assert fit.rmse_moving is not None
    above = fit.rmse_moving > criteria.judging.above * fit.noise_floor
    return above and fit.rmse_moving**2 > criteria.search.odd**2 * fitted


def _mean_square(fits: list[ChannelFit]) -> float:
    moving = [fit.rmse_moving for fit in fits if fit.rmse_moving is not None]
    return float(np.mean(np.square(moving))) if moving else 0.0
