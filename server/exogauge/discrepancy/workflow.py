"""Find where model and measurement disagree, name what is missing, add it, and go on until nothing qualifies.

Every candidate is fitted beside the whole baseline on the fitted logs; the best are judged on held-out logs.
What is claimed is added, the robot identified again with it, and the search repeated on that model.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

from exogauge.discrepancy.axis_rows import AxisRows, collect_rows, sums_of
from exogauge.discrepancy.band_limit import band_limits
from exogauge.discrepancy.candidates import Candidate
from exogauge.discrepancy.chain import lineage, link
from exogauge.discrepancy.everywhere import merged
from exogauge.discrepancy.finding import name_effect, objection, rejection
from exogauge.discrepancy.ground import Ground, lay_ground
from exogauge.discrepancy.hints import hinted
from exogauge.discrepancy.judge import Judgement, judge
from exogauge.discrepancy.link_finding import name_link
from exogauge.discrepancy.links import odd_links
from exogauge.discrepancy.locate import located
from exogauge.discrepancy.refine import refined
from exogauge.discrepancy.result import Alternative, Discrepancy, Excess, Finding, Verdict
from exogauge.discrepancy.score import Score, score
from exogauge.effects.shaped import ShapedEffect
from exogauge.identification.added import AddedEffect, Extension
from exogauge.identification.identify import identify
from exogauge.identification.result import Identification
from exogauge.identification.settings import Progress, Recording, Settings

MOST_EFFECTS = 6
WORTH_JUDGING = 6.0  # evidence (BIC): odds of twenty to one before the number of candidates is counted
JUDGED = 12  # candidates per round
NOT_HELD_OUT = (
    "No log was held out, so nothing can be claimed: give at least one log of the same kind of motion the role "
    "`validation`."
)


@final
@dataclass(frozen=True)
class Found:
    """The search's answer, and the identification with all that was named."""

    discrepancy: Discrepancy
    identification: Identification


def find_missing_effects(
    found: Identification,
    recordings: Sequence[Recording],
    effects: Sequence[ShapedEffect],
    settings: Settings,
    progress: Progress = lambda _fraction, _phrase: None,
) -> Found:
    """found: identification without them, of the same recordings. effects: what may be missing."""
    recordings, models, findings = _filtered_alike(found, recordings, settings, progress)
    found = models[-1]
    base, current = found.model, found
    floors = {(fit.log, fit.channel): fit.noise_floor for fit in found.validation}
    added: tuple[AddedEffect, ...] = ()
    rejected: list[Alternative] = []
    failed: dict[tuple[str, int], Alternative] = {}
    tried = 0
    before: tuple[Excess, ...] = ()
    while True:
        share = min(len(findings) / 3.0, 0.9)
        ground = lay_ground(current.model, recordings, effects, _part(progress, share))
        tried = sum(len(each) for each in ground.candidates.values())
        before = before or located(base.robot, found, ground.residuals)
        judged, rows = _judged(ground, recordings, effects)
        rejected = [rejection(base, each) for each in judged if each.objection]
        claimed = [each for each in judged if not each.objection and key_of(each) not in failed]
        again = None
        for winner in _widest_first(claimed) if len(findings) < MOST_EFFECTS else []:
            progress(share + 0.25, f"adding {winner.score.candidate.effect.name}")
            wider = (*added, _as_added(winner.score.candidate))
            again = identify(base.robot, recordings, settings, extension=Extension(base, wider, floors))
            finding = name_effect(len(findings) + 1, ground, winner, judged, current, again, rows)
            refused = objection(finding)
            if not refused:
                break
            failed[key_of(winner)] = replace(rejection(base, winner), reason=refused)
            again = None
        if again is None:
            break
        added = wider
        findings.append(finding)
        models.append(again)
        current = again
    unexplained = located(base.robot, current, ground.residuals)
    channels = [finding.held_out.channel for finding in findings] or [each.channel for each in before]
    chain = tuple(link(each, findings[:k], channels) for k, each in enumerate(models))
    family = lineage(findings)
    fitted = [each.log for each in recordings if not each.held_out]
    for odd in odd_links(current.model, fitted):
        findings.append(name_link(len(findings) + 1, current.model, odd, current))
    verdict: Verdict = "effects" if findings else ("unexplained" if unexplained else "none")
    notes = () if any(each.held_out for each in recordings) else (NOT_HELD_OUT,)
    progress(1.0, "compared")
    return Found(
        Discrepancy(
            verdict=verdict,
            findings=merged(findings, len(base.robot.joints)),
            chain=chain,
            located=before,
            unexplained=unexplained,
            rejected=(*failed.values(), *rejected),
            lineage=family,
            candidates=tried,
            notes=notes,
            before_after={},
        ),
        current,
    )


def _filtered_alike(
    found: Identification, recordings: Sequence[Recording], settings: Settings, progress: Progress
) -> tuple[Sequence[Recording], list[Identification], list[Finding]]:
    """Before anything else is sought: what a log's own low-pass has done looks like several effects."""
    limited = band_limits(found, recordings, lambda anew: identify(found.model.robot, anew, settings), progress)
    if limited is None:
        return recordings, [found], []
    return limited.recordings, [limited.before, limited.identification], [limited.finding]


def key_of(judged: Judgement) -> tuple[str, int]:
    """Effect and axis."""
    candidate = judged.score.candidate
    return candidate.effect.name, candidate.axis


def _widest_first(claimed: Sequence[Judgement]) -> list[Judgement]:
    """Of each axis the effect with most evidence; of those first the one that closes the largest gap, relative to what
    is left. Then the others, by evidence."""
    best = {each.score.candidate.axis: each for each in sorted(claimed, key=lambda one: one.score.evidence)}
    first = sorted(best.values(), key=lambda each: -each.before / max(each.after, 1e-300))
    return first + [each for each in claimed if each not in first]


def _part(progress: Progress, start: float) -> Progress:
    return lambda fraction, phrase: progress(start + 0.2 * fraction, phrase)


def _judged(
    ground: Ground, recordings: Sequence[Recording], effects: Sequence[ShapedEffect]
) -> tuple[list[Judgement], Mapping[int, Sequence[AxisRows]]]:
    """The best shape of every effect and axis that is worth it, refined and judged, most evidence first; and the rows
    of their axes."""
    best: dict[tuple[str, int], Score] = {}
    for each in ground.scores:
        key = (each.candidate.effect.name, each.candidate.axis)
        if each.evidence > WORTH_JUDGING and key not in best and len(best) < JUDGED:
            best[key] = each
    hints = list(hinted(ground, effects))
    axes = sorted({axis for _, axis in best} | {candidate.axis for candidate in hints})
    rows = collect_rows(ground.model, recordings, axes)
    for candidate in hints:
        key, sums = (
            (candidate.effect.name, candidate.axis),
            sums_of(rows[candidate.axis], candidate.effect, candidate.shape),
        )
        tried = score(ground.model, candidate, sums, ground.memory[candidate.axis])
        if tried is not None and tried.evidence > (best[key].evidence if key in best else WORTH_JUDGING):
            best[key] = tried
    judged = []
    for (_, axis), each in best.items():
        finer = refined(ground.model, each, rows[axis], ground.memory[axis])
        judged.append(judge(ground.model, finer, rows[axis]))
    return sorted(judged, key=lambda one: -one.score.evidence), rows


def _as_added(candidate: Candidate) -> AddedEffect:
    return AddedEffect(candidate.effect, candidate.axis, candidate.shape)
