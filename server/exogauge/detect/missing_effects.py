"""Effects that are always there: searched for on joints, sensors, links and the base, one after the other.

Every candidate is fitted beside the whole baseline on the fitted logs; the best are judged on held-out logs.
What is claimed is added, the robot identified again with it, and the search repeated on that model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from exogauge.detect.so_far import Question, Searched, SoFar
from exogauge.effects.shaped import at_turns
from exogauge.findings.as_told import as_drawn
from exogauge.findings.result import ChainStep, Finding
from exogauge.findings.verdict import Caveat
from exogauge.identification.identify import identify
from exogauge.identification.model import Effect
from exogauge.identification.result import Identification
from exogauge.identification.settings import Recording
from exogauge.progress import Rising, still, unwatched
from exogauge.search.afterwards import has_joined, look_into_odd_logs, shapes_again
from exogauge.search.baseline import lay_ground
from exogauge.search.creeping import Creeping
from exogauge.search.declared import left_over
from exogauge.search.final_numbers import with_doubt_of_shapes, with_doubt_of_what_is_left, with_final_numbers
from exogauge.search.judge import refused
from exogauge.search.locate import located, seen
from exogauge.search.partial import without_partial_names
from exogauge.search.residual_correction import Bend, own_curves, remainders
from exogauge.search.search import searched
from exogauge.search.state import Problem, Search, rounds_of
from exogauge.search.taken_out import taken_back


def missing_effects(so_far: SoFar) -> SoFar:
    """With all that may be named in the model. Where joints creep, all is sought anew without what creeps."""
    asked, recordings = so_far.question, so_far.recordings
    effects = _seen_in(recordings, asked.effects)
    search = searched(Problem(so_far.current, recordings, effects, asked.settings, Rising(asked.progress)))
    if search.creeping.below:
        return replace(so_far, anew=_at_speed(asked, search.creeping))
    all_held_out = search
    search, joined = look_into_odd_logs(search)
    search, bends, findings = _as_told(shapes_again(search))
    if joined and not has_joined(search):  # nothing is named for which it had to be fitted
        joined, (search, bends, findings) = (), _as_told(shapes_again(all_held_out))
    base = search.problem.base
    rounds = rounds_of(search.steps)
    models = (*so_far.models[:-1], base, *(each[-1].found for each in rounds), *(each.found for each in bends))
    current = with_doubt_of_shapes(models[-1], search.added, search.problem.recordings)
    notes = joined if any(each.held_out for each in recordings) else (Caveat("not_held_out"),)
    told = _told(search, current, with_bends=bool(bends), notes=notes)
    current = with_doubt_of_what_is_left(current, told.after)
    so_far = replace(so_far, models=(*models[:-1], current)).having(findings, [len(each) for each in rounds])
    unnamed = tuple(ChainStep(each.what, each.finding.effect, each.finding.place) for each in bends)
    return replace(
        so_far,
        additions=(*so_far.additions, *unnamed),
        searched=told,
    )


def _told(search: Search, current: Identification, with_bends: bool, notes: tuple[Caveat, ...]) -> Searched:
    """current: the last model, which the last ground lacks bends of."""
    problem, equations, left = search.problem, search.problem.base.model.equations, search.last
    if with_bends:
        left = lay_ground(current.model, problem.recordings, (), unwatched).residuals
    undecided = {(each.finding.effect, each.finding.place): each.undecided for each in search.steps if each.undecided}
    joined = {each.of for each in notes if each.why == "joined"}
    unexplained, declared = left_over(current, left, problem.recordings, joined)
    return Searched(
        recordings=tuple(problem.recordings),
        before=located(equations, problem.base, search.first),
        after=unexplained,
        declared=declared,
        seen=seen(equations, current),
        rejected=(*search.failed.values(), *search.rejected),
        candidates=search.tried,
        notes=notes,
        undecided=undecided,
    )


def _at_speed(asked: Question, creeping: Creeping) -> Question:
    """The same of the logs without what creeps."""
    settings = replace(asked.settings, creeping={**asked.settings.creeping, **creeping.below})
    found = identify(asked.found.model.robot, asked.recordings, replace(settings, cutoff_hz=asked.found.cutoff_hz))
    cannot = (*asked.cannot, *creeping.open)
    return replace(asked, found=found, settings=settings, cannot=cannot, progress=still(asked.progress))


def _seen_in(recordings: Sequence[Recording], effects: Sequence[Effect]) -> Sequence[Effect]:
    """Without those that live at turns, where every log was low-passed there before it was stored."""
    if all(each.log.stored is not None for each in recordings):
        return [each for each in effects if not at_turns(each)]
    return effects


def _as_told(search: Search) -> tuple[Search, list[Bend], list[Finding]]:
    """The search without what may not be named with all others there, bends, and the findings of all steps."""
    judging = search.problem.settings.criteria.judging
    while True:
        bends = own_curves(search)
        bends += remainders(search, bends)
        findings = _with_bends(search, bends)
        without = without_partial_names(search, bends[-1].found if bends else search.current, findings)
        if without is not None:
            search, ground = without.screened(without.current)
            search = search.on(ground)
            continue
        objections = (refused(each, judging) for each in findings)
        poor = next(((number, why) for number, why in enumerate(objections) if why), None)
        if poor is None:
            drawn = [as_drawn(each, added, judging) for each, added in zip(findings, search.added, strict=True)]
            return search, bends, drawn
        search = taken_back(search, *poor)


def _with_bends(search: Search, bends: Sequence[Bend]) -> list[Finding]:
    """The steps' findings, as their bends tell them, with the numbers of all formulas together."""
    bent = {(each.finding.effect, each.finding.place): each.finding for each in bends}
    told = (bent.get((each.finding.effect, each.finding.place), each.finding) for each in search.steps)
    return [
        with_final_numbers(finding, added, search.current.model)
        for finding, added in zip(told, search.added, strict=True)
    ]
