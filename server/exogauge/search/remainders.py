"""What is left at a place where something was named and looks like another effect, too small beside it for a name.

It is no reason to leave it in the residual: it goes into the model without a name, if held-out logs ask for it.
"""

from __future__ import annotations

from collections.abc import Sequence

from exogauge.identification.model import Site
from exogauge.identification.sites import AxisSite, SensorSite
from exogauge.search.baseline import lay_ground
from exogauge.search.effect_size import gone
from exogauge.search.finding import channel_of
from exogauge.search.residual_correction import Bend, held_out_rmse
from exogauge.search.screen import as_added, judge_best
from exogauge.search.state import Search, Step


def remainders(search: Search, bends: Sequence[Bend]) -> list[Bend]:
    """At most one for each place, after the effects' own curves."""
    every = list(bends)
    last: dict[Site, Step] = {each.added.site: each for each in search.steps}
    for site, step in last.items():
        if isinstance(site, AxisSite | SensorSite):
            every += _remainder(search, step, every)
    return every[len(bends) :]


def _remainder(search: Search, step: Step, bends: Sequence[Bend]) -> list[Bend]:
    before = bends[-1].found if bends else search.current
    finding = next((each.finding for each in reversed(bends) if each.of is step), step.finding)
    problem = search.problem
    criteria = problem.settings.criteria.search
    rmse, floor = held_out_rmse(finding, finding.held_out.channel, before)
    if rmse < criteria.remainder_above * floor:
        return []
    site = step.added.site
    ground = lay_ground(before.model, problem.recordings, problem.effects, lambda _fraction, _phrase: None, at=site)
    judged, _ = judge_best(ground, problem.recordings, problem.effects, site)
    best = next((each for each in judged if not each.objection), None)
    if best is None:
        return []
    added = as_added(best.score.candidate)
    there = [*search.added, *(each.added for each in bends)]
    after = search.identified([*there, added])
    channel = channel_of(before.model.equations, best.kind)
    sizes = [held_out_rmse(finding, channel, each) for each in (before, after)]
    if gone(*(rmse for rmse, _ in sizes)) < criteria.bend_least * sizes[1][1]:
        return []
    rmse, _ = held_out_rmse(finding, finding.held_out.channel, after)
    return [Bend(step, added, finding.refined_by("remainder", rmse, added.effect.name), after, "remainder")]
