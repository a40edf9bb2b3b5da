"""Find where model and measurement disagree, name what is missing, add it, and go on until nothing qualifies.

Every candidate is fitted beside the whole baseline on the fitted logs; the best are judged on held-out logs.
What is claimed is added, the robot identified again with it, and the search repeated on that model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import final

from exogauge.detect.chain import lineage, link
from exogauge.detect.contact.contact import contacts, pushes
from exogauge.detect.device.as_drawn import as_drawn
from exogauge.detect.nominal.contradicted import contradicted
from exogauge.detect.nominal.finding import name_contradiction
from exogauge.detect.stored_filter.limit import band_limits
from exogauge.effects.flags import at_turns
from exogauge.experiment.design import with_motions
from exogauge.findings.as_told import by_importance, merged
from exogauge.findings.result import ChainStep, Discrepancy, Finding
from exogauge.findings.verdict import Caveat
from exogauge.identification.identify import identify
from exogauge.identification.model import Effect
from exogauge.identification.result import Identification
from exogauge.identification.settings import Progress, Recording, Settings
from exogauge.search.baseline import lay_ground
from exogauge.search.final_numbers import with_final_numbers
from exogauge.search.locate import located, seen
from exogauge.search.may_be_named import refused, told
from exogauge.search.odd_log import look_into_odd_logs
from exogauge.search.remainders import remainders
from exogauge.search.residual_correction import Bend, own_curves
from exogauge.search.search import Search
from exogauge.search.shape_doubt import with_doubt_of_shapes
from exogauge.search.shapes_again import shapes_again

CONTACT = "contact"
ALMOST = 0.99  # done, as it is told while all is sought once more


@final
@dataclass(frozen=True)
class Found:
    """The search's answer, and the identification with all that was named. recordings: with the band that they were
    stored in, and with the time in which something touched the robot, where either was found. settings: with the speeds
    below which joints creep."""

    discrepancy: Discrepancy
    identification: Identification
    recordings: tuple[Recording, ...]
    settings: Settings


def find_missing_effects(
    found: Identification,
    recordings: Sequence[Recording],
    effects: Sequence[Effect],
    settings: Settings,
    progress: Progress = lambda _fraction, _phrase: None,
    touched: bool = True,
    cannot: tuple[Caveat, ...] = (),
) -> Found:
    """found: identification without them, of the same recordings. effects: what may be missing. touched: whether
    something may have touched the robot. cannot: what could not be judged so far."""
    given = recordings
    recordings, models, findings = _filtered_alike(found, recordings, settings, progress)
    whole = recordings
    if touched:
        recordings, models, findings = _untouched(models, findings, recordings, settings, progress)
    search = Search(models[-1], recordings, _seen_in(recordings, effects), settings, progress)
    search.run()
    if search.creeping.below:
        settings = replace(settings, creeping={**settings.creeping, **search.creeping.below})
        at_speed = identify(found.model.robot, given, replace(settings, cutoff_hz=found.cutoff_hz))
        tick, cannot = partial(_still_at, progress), (*cannot, *search.creeping.open)
        return find_missing_effects(at_speed, given, effects, settings, tick, touched, cannot)
    search, joined = look_into_odd_logs(search)
    shapes_again(search)
    assert search.first is not None
    assert search.last is not None
    bends, steps = _steps_as_told(search)
    equations = search.base.model.equations
    last = bends[-1].found if bends else search.current
    looked_like_a_push = search.steps and any(each.effect == CONTACT for each in findings)
    if looked_like_a_push and not pushes(last.model, whole):  # what was named since explains it
        tick = partial(_still_at, progress)
        return find_missing_effects(found, given, effects, settings, tick, False, cannot)
    findings += [replace(each, rank=len(findings) + each.rank) for each in steps]
    models = [*models[:-1], search.base, *(step.found for step in search.steps), *(bend.found for bend in bends)]
    additions = [ChainStep("effect", each.effect, each.place) for each in findings]
    additions += [ChainStep(bend.what, bend.finding.effect, bend.finding.place) for bend in bends]
    current, left = models[-1], search.last.residuals
    if bends:
        left = lay_ground(current.model, search.recordings, (), lambda _fraction, _phrase: None).residuals
    current = with_doubt_of_shapes(current, [each.added for each in search.steps], search.recordings)
    before = located(equations, search.base, search.first.residuals)
    unexplained = located(equations, current, left)
    channels = [finding.held_out.channel for finding in findings] or [each.channel for each in before]
    logs = {each.log.name for each in recordings if each.held_out}
    steps_told = [ChainStep("robot"), *additions]
    chain = tuple(link(each, step, channels, logs) for each, step in zip(models, steps_told, strict=True))
    fitted = [each.log for each in search.recordings if not each.held_out]
    odd = contradicted(current.model, fitted)
    numbers = [name_contradiction(len(findings) + n, current, search.recordings, settings, each)
               for n, each in enumerate(odd, 1)]  # fmt: skip
    contradictions, doubtful = told(numbers, settings.criteria.judging)
    findings += contradictions
    undecided = {(each.finding.effect, each.finding.place): doubt for each in search.steps if (doubt := each.undecided)}
    notes = joined if any(each.held_out for each in recordings) else (Caveat("not_held_out"),)
    progress(1.0, "compared")
    return Found(
        Discrepancy(
            findings=with_motions(
                by_importance(merged(findings, len(current.model.robot.joints), settings.criteria.telling)),
                undecided,
                fitted,
            ),
            chain=chain,
            located=before,
            unexplained=unexplained,
            rejected=(*search.failed.values(), *search.rejected, *doubtful),
            lineage=lineage(additions),
            candidates=search.tried,
            notes=notes,
            before_after=(),
            seen=seen(equations, current),
            cannot=cannot,
            judging=settings.criteria.judging,
        ),
        current,
        tuple(recordings),
        settings,
    )


def _seen_in(recordings: Sequence[Recording], effects: Sequence[Effect]) -> Sequence[Effect]:
    """Without those that live at turns, where every log was low-passed there before it was stored."""
    if all(each.log.stored is not None for each in recordings):
        return [each for each in effects if not at_turns(each)]
    return effects


def _still_at(progress: Progress, _fraction: float, phrase: str) -> None:
    progress(ALMOST, phrase)


def _steps_as_told(search: Search) -> tuple[list[Bend], list[Finding]]:
    """Bends, and the findings of all steps. One that may not be named with all others there is not in the model."""
    judging = search.settings.criteria.judging
    while True:
        bends = own_curves(search)
        bends += remainders(search, bends)
        findings = _with_bends(search, bends)
        poor = next(
            ((number, reason) for number, each in enumerate(findings) if (reason := refused(each, judging))), None
        )
        if poor is None:
            told = zip(findings, search.steps, strict=True)
            return bends, [as_drawn(each, step.added.effect, judging) for each, step in told]
        search.take_back(*poor)


def _with_bends(search: Search, bends: Sequence[Bend]) -> list[Finding]:
    """The steps' findings, as their bends tell them, with the numbers of all formulas together."""
    bent = {(each.finding.effect, each.finding.place): each.finding for each in bends}
    findings = list[Finding]()
    for step in search.steps:
        finding = bent.get((step.finding.effect, step.finding.place), step.finding)
        finding = with_final_numbers(finding, step.added, search.current.model)
        findings.append(replace(finding, rank=len(findings) + 1))
    return findings


def _filtered_alike(
    found: Identification, recordings: Sequence[Recording], settings: Settings, progress: Progress
) -> tuple[Sequence[Recording], list[Identification], list[Finding]]:
    """Before anything else is sought: what a log's own low-pass has done looks like several effects."""
    limited = band_limits(found, recordings, lambda anew: identify(found.model.robot, anew, settings), progress)
    if limited is None or refused(limited.finding, settings.criteria.judging):
        return recordings, [found], []
    return limited.recordings, [limited.before, limited.identification], [limited.finding]


def _untouched(
    models: list[Identification],
    findings: list[Finding],
    recordings: Sequence[Recording],
    settings: Settings,
    progress: Progress,
) -> tuple[Sequence[Recording], list[Identification], list[Finding]]:
    """What happened once, such as a push, is left out before effects that are always there are sought."""
    robot = models[-1].model.robot
    touched = contacts(models[-1], recordings, lambda anew: identify(robot, anew, settings), progress)
    if touched is None or any(refused(each, settings.criteria.judging) for each in touched.findings):
        return recordings, models, findings
    named = [replace(each, rank=len(findings) + n) for n, each in enumerate(touched.findings, 1)]
    return touched.recordings, [*models, *([touched.identification] * len(named))], [*findings, *named]
