"""Payload, in motion: what is believed of an inertia before, what data decide, what μ says, what counts as a touch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import convention, criterion, derived, judgement

RULES = "docs/payload.md"


@final
@dataclass(frozen=True)
class Moving:
    """μ: residual over what the noise model says, 1 where it holds."""

    gyration_m: float = criterion(
        1.0,
        "m",
        "std of unknown inertia, as radius of gyration: only a payload of some metres has more",
        judgement(RULES),
    )
    released: float = criterion(
        1000.0, "N, N·m", "std of a zero that is not that of the postures: next to nothing known", judgement(RULES)
    )
    decided: float = criterion(
        0.1,
        "1",
        "of the std that was believed before: what data leave less sure than that, they do not decide",
        judgement(RULES),
    )
    mu_stds: float = criterion(3.0, "std", "by which μ must be from 1 to be told: beyond chance", judgement(RULES))
    mu_floor: float = criterion(
        0.05, "1", "by which μ must be from 1 at least: no noise is known better", judgement(RULES)
    )
    misfit: float = criterion(
        9.0,
        "1",
        "of μ, three standard deviations of every sample, from which on clocks are compared",
        derived("3² = 9"),
    )
    farthest_clock_s: float = criterion(
        2.0, "s", "that two clocks are looked for apart: more is another motion", judgement(RULES)
    )
    memories: float = criterion(
        24.0,
        "correlation times",
        "over which coloured residuals are summed: errors of smoothed accelerations swing back",
        judgement(RULES),
    )
    agree: float = criterion(
        2.0,
        "std",
        "within which LS and GTLS count as one",
        convention("two standard deviations, 95 %"),
    )
    zero_s: float = criterion(0.5, "s", "averaged for the secondary zero", judgement(RULES))
    farthest_zero_deg: float = criterion(
        60.0,
        "°",
        "gravity may have turned: beyond, a zero taken before is worse than none",
        derived("|δm| g 2 sin(θ/2) > |δm| g"),
    )
    zero_alarms: float = criterion(
        0.001,
        "of the samples",
        "that alarm by chance, where it is asked whether a log has a zero of its own",
        judgement(RULES),
    )
    still_noises: float = criterion(
        20.0, "std", "between the ends of a joint's course: with less it stands still", judgement(RULES)
    )
    noisier: float = criterion(
        1.5,
        "times the stated noise",
        "that a joint shows while it moves, or a channel of the wrench, from which on what it shows is taken: less is "
        "within a statement's doubt",
        judgement(RULES),
    )
    settled_rows: float = criterion(
        3.0, "rows per parameter", "before a recursion without a prior tells anything", judgement(RULES)
    )
    freeze: float = criterion(
        0.5,
        "1",
        "of the information that forgetting takes per sample: one that brings less changes nothing",
        judgement(RULES),
    )
    bridged_s: float = criterion(0.05, "s", "between two alarms of one contact", judgement(RULES))
    pushing: float = criterion(
        0.5, "1", "share of a push's time, at least, in which its force alarms: single jumps are none", judgement(RULES)
    )


USUAL = Moving()
