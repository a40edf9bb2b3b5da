"""Where model and measurement disagree, and what is missing: every detector in its order, then what is told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from exogauge.detect.contact.detector import contact, contact_again
from exogauge.detect.missing_effects import missing_effects
from exogauge.detect.nominal.detector import nominal_values
from exogauge.detect.so_far import Detector, Question, SoFar, lineage, link
from exogauge.detect.stored_filter.detector import stored_filter
from exogauge.experiment.design import with_motions
from exogauge.findings.as_told import by_importance, merged
from exogauge.findings.result import ChainStep, Discrepancy, Link
from exogauge.findings.verdict import Caveat
from exogauge.identification.model import Effect
from exogauge.identification.result import Identification
from exogauge.identification.settings import Recording, Settings
from exogauge.progress import Doing, Progress, unwatched
from exogauge.robots.moving.robot import MotionRobot

DETECTORS: tuple[Detector, ...] = (stored_filter, contact, missing_effects, contact_again, nominal_values)
"""What spoils logs or moments of them comes first: it looks like effects. What no residual shows comes last."""


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
    progress: Progress = unwatched,
    moving: MotionRobot | None = None,
    spoiled: str = "",
) -> Found:
    """found: identification without them, of the same recordings. effects: what may be missing. Where a detector asks
    for another question, all begin again with it. moving: the robot as motions are planned for it. spoiled: a log that
    is fitted though it is; then errors are told, and nothing is named."""
    detectors = (missing_effects,) if spoiled else DETECTORS
    cannot = (Caveat("spoiled", spoiled),) if spoiled else ()
    sought = () if spoiled else effects
    question = Question(found, tuple(recordings), sought, settings, progress, cannot=cannot)
    so_far, left = SoFar.of(question), detectors
    while left:
        so_far, left = left[0](so_far), left[1:]
        if so_far.anew is not None:
            so_far, left = SoFar.of(so_far.anew), detectors
    progress(1.0, Doing.COMPARED)
    return Found(_discrepancy(so_far, moving), so_far.current, so_far.recordings, so_far.question.settings)


def _discrepancy(so_far: SoFar, moving: MotionRobot | None) -> Discrepancy:
    searched, criteria = so_far.searched, so_far.criteria
    assert searched is not None
    joints = len(so_far.current.model.robot.joints)
    fitted = [each.log for each in searched.recordings if not each.held_out]
    told = by_importance(merged([*so_far.findings, *so_far.beside], joints, criteria.telling))
    return Discrepancy(
        findings=with_motions(told, searched.undecided, fitted, moving),
        chain=_chain(so_far),
        located=searched.before,
        unexplained=searched.after,
        declared=searched.declared,
        rejected=(*searched.rejected, *so_far.doubtful),
        lineage=lineage(so_far.additions),
        candidates=searched.candidates,
        notes=searched.notes,
        before_after=(),
        seen=searched.seen,
        cannot=so_far.question.cannot,
        judging=criteria.judging,
    )


def _chain(so_far: SoFar) -> tuple[Link, ...]:
    searched = so_far.searched
    assert searched is not None
    channels = [each.held_out.channel for each in so_far.findings] or [each.channel for each in searched.before]
    logs = {each.log.name for each in so_far.recordings if each.held_out}
    steps = [ChainStep("robot"), *so_far.additions]
    return tuple(link(each, step, channels, logs) for each, step in zip(so_far.models, steps, strict=True))
