"""The report's section on supporting torque: figures, tables and the sentence at the top, as plain text and rows."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

from markupsafe import Markup

from exogauge.devices.result import Estimate
from exogauge.studies.report.doubt_table import DoubtTable, doubt_table
from exogauge.studies.report.figures import draw_support
from exogauge.studies.results.support_results import best_approach, equality, largest, main_joints, motions
from exogauge.studies.words.rounding import rounded, significant, with_std
from exogauge.support.result import Effort, JointSupport, SupportResult, Trial

COMPARED = ("a", "b", "paired", "prior")
MEASURED = ("a", "b", "paired")
NAMES = {"a": "A", "b": "B", "paired": "paired"}
SAID = {"a": "approach A", "b": "approach B", "paired": "the paired estimate"}
SAID |= {"A": SAID["a"], "B": SAID["b"]}


@final
@dataclass(frozen=True)
class SupportFigure:
    """An inline SVG, the words that stand in for it, and its caption."""

    svg: Markup
    words: str
    caption: str


@final
@dataclass(frozen=True)
class ErrorRow:
    """One device and joint: RMSE against the band model, of all samples and of steady motion; null test; spread."""

    device: str
    joint: str
    main: bool
    rmse: tuple[str, ...]
    steady: tuple[str, ...]
    null: tuple[str, ...]
    spread: tuple[str, ...]
    best: str


@final
@dataclass(frozen=True)
class EffortRow:
    """One phase: peak, mean and integral, each as (A, B, paired, band model) in text, empty where there is none."""

    phase: str
    duration: str
    cells: tuple[tuple[str, ...], ...]


@final
@dataclass(frozen=True)
class EffortTable:
    device: str
    joint: str
    main: bool
    rows: tuple[EffortRow, ...]


@final
@dataclass(frozen=True)
class EqualityRow:
    """How alike the motions with and without the device were; shares in per cent."""

    device: str
    joint: str
    main: bool
    verdict: str
    angle: str
    velocity: str
    share: str
    lag: str
    used: str
    rest: str
    half_width: str


@final
@dataclass(frozen=True)
class MotionView:
    motion: str
    joints: tuple[str, ...]
    repeats: int
    figures: tuple[SupportFigure, ...]
    errors: tuple[ErrorRow, ...]
    efforts: tuple[EffortTable, ...]
    equalities: tuple[EqualityRow, ...]
    doubts: DoubtTable | None


def motion_views(support: SupportResult) -> list[MotionView]:
    views = []
    for n, motion in enumerate(motions(support)):
        main = main_joints(support, motion)
        order = {joint: k for k, joint in enumerate(main)}
        found = [each for each in support.joints if each.motion == motion]
        found.sort(key=lambda each: order.get(each.joint, len(order)))
        views.append(
            MotionView(
                motion,
                main,
                max(len(each.logs) for each in found),
                tuple(_figure(support, motion, joint, f"s{n}{k}") for k, joint in enumerate(main)),
                tuple(_error_row(each, each.joint in main) for each in found),
                tuple(_effort_table(each, each.joint in main) for each in found),
                tuple(_equality_row(support.trials, each, each.joint in main) for each in found),
                _doubts([each for each in found if each.joint in main]),
            )
        )
    return views


def _doubts(joints: Sequence[JointSupport]) -> DoubtTable | None:
    """Of the headline's peak and mean."""
    several = len({each.device for each in joints}) > 1
    numbers: dict[tuple[str, str], Mapping[str, float]] = {}
    for each in joints:
        approach = best_approach(each)
        for name in ("peak", "mean") if each.decided and approach in each.by else ():
            whose = f", {each.device}" if several else ""
            numbers[each.joint, f"{name}, {NAMES[approach]}{whose} [{each.unit}]"] = getattr(
                each.by[approach], name
            ).parts
    return doubt_table("What the doubts of peak and mean are made of", numbers)


def _figure(support: SupportResult, motion: str, joint: str, key: str) -> SupportFigure:
    """The first trial of every device."""
    shown: dict[str, Trial] = {}
    for trial in support.trials:
        if trial.motion == motion and joint in trial.joints:
            shown.setdefault(trial.device, trial)
    by_device = {each.device: each for each in support.joints if (each.motion, each.joint) == (motion, joint)}
    notes = {device: rmse_note(each) for device, each in by_device.items()}
    drawn = ", ".join(f"{trial.log} ({device})" for device, trial in shown.items())
    said = "; ".join(f"{device}: {note}" for device, note in notes.items() if note)
    words = f"Angle of {joint} and supporting torques over time, motion {motion}, log {drawn}. {said}."
    caption = f"{motion}, {joint}: the first trial of {'each device' if len(shown) > 1 else 'the device'}, log {drawn}."
    return SupportFigure(Markup(draw_support(list(shown.values()), joint, notes, key)), words, caption)


def rmse_note(joint: JointSupport) -> str:
    """Like the captions of Figs 12 and 13: RMSE of every approach against the band model."""
    words = {"a": "A", "b": "B", "paired": "paired", "prior": "maker’s values"}
    parts = [
        f"{words[approach]} {significant(joint.rmse[approach])}"
        for approach in COMPARED
        if math.isfinite(joint.rmse.get(approach, math.nan))
    ]
    return f"RMSE {' · '.join(parts)} {joint.unit}" if parts else ""


def _error_row(joint: JointSupport, main: bool) -> ErrorRow:
    return ErrorRow(
        joint.device,
        joint.joint,
        main,
        tuple(_text(joint.rmse, approach) for approach in COMPARED),
        tuple(_text(joint.rmse_steady, approach) for approach in COMPARED),
        tuple(_text(joint.null, approach, 2) for approach in MEASURED),
        tuple(_text(joint.spread, approach, 2) for approach in MEASURED),
        "" if joint.best is None else NAMES[joint.best.approach],
    )


def _text(values: Mapping[str, float], approach: str, digits: int = 3) -> str:
    return significant(values.get(approach, math.nan), digits)


def _effort_table(joint: JointSupport, main: bool) -> EffortTable:
    rows = [EffortRow("whole motion", "", _cells(joint.by))]
    rows += [EffortRow(part.phase, f"{significant(part.duration_s, 2)} s", _cells(part.by)) for part in joint.phases]
    return EffortTable(joint.device, joint.joint, main, tuple(rows))


def _cells(by: Mapping[str, Effort]) -> tuple[tuple[str, ...], ...]:
    """Peak, mean, integral; the band model's without its std, which is that between trials alone."""

    def cell(approach: str, quantity: str) -> str:
        return plus_minus(getattr(by[approach], quantity)) if approach in by else ""

    def model(quantity: str) -> str:
        return significant(getattr(by["band_model"], quantity).value) if "band_model" in by else ""

    return tuple((*(cell(one, each) for one in MEASURED), model(each)) for each in ("peak", "mean", "integral"))


def plus_minus(estimate: Estimate) -> str:
    """`5.03 ± 0.12`; the value alone where there is no standard deviation, in brackets where the data say nothing."""
    if not math.isfinite(estimate.value):
        return "–"
    if math.isinf(estimate.std):
        return f"({significant(estimate.value)})"
    if not (math.isfinite(estimate.std) and estimate.std > 0.0):
        return significant(estimate.value)
    return " ± ".join(with_std(estimate.value, estimate.std))


def _equality_row(trials: Sequence[Trial], joint: JointSupport, main: bool) -> EqualityRow:
    found = equality(trials, joint)
    return EqualityRow(
        device=joint.device,
        joint=joint.joint,
        main=main,
        verdict=found["verdict"] if found else "no run without it",
        angle=f"{significant(math.degrees(found['q_rms']), 2)}°" if found else "",
        velocity=f"{significant(math.degrees(found['dq_rms']), 2)}°/s" if found else "",
        share=f"{significant(100 * found['dq_share'], 2)} %" if found else "",
        lag=f"{rounded(1000 * found['lag_s'], 0)} ms" if found else "",
        used=_percent(1.0 - joint.masked_share) if found else "",
        rest=_percent(joint.rest_share),
        half_width=f"± {significant(joint.rest_half_width, 2)}" if joint.rest_share > 0.0 else "",
    )


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if math.isfinite(share) else "–"


def strongest(support: SupportResult, device: str) -> JointSupport | None:
    """The motion and main joint on which a device acts most."""
    main = {motion: main_joints(support, motion) for motion in motions(support)}
    chosen = [each for each in support.joints if each.device == device and each.joint in main[each.motion]]
    return max(chosen, key=largest, default=None)


def support_sentence(joint: JointSupport) -> str:
    """`Normal suit (bend): up to 5.1 ± 0.2 N·m of support at torso_pitch by approach A (band model 5.0).`"""
    approach = best_approach(joint)
    if not joint.decided:
        return f"{joint.device}: what it gives is not decided."
    if approach not in joint.by:
        return ""
    peak = joint.by[approach].peak
    size = plus_minus(Estimate(abs(peak.value), peak.std, peak.unit))
    text = f"{joint.device} ({joint.motion}): up to {size} {joint.unit} of support at {joint.joint} by "
    text += SAID[approach]
    if "band_model" in joint.by:
        text += f" (band model {significant(abs(joint.by['band_model'].peak.value))})"
    return f"{text}."
