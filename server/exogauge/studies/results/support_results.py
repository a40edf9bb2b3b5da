"""Supporting torque as results.json and support.csv hold it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from exogauge.devices.result import Estimate
from exogauge.studies.csv_table import csv_table
from exogauge.support.result import Effort, JointEquality, JointSupport, SupportResult, Trial, Verdict

APPROACHES = {"a": "A", "b": "B", "prior": "prior", "band_model": "band_model"}  # in the numerics: in the files
QUANTITIES = ("peak", "mean", "integral")
MOST_MAIN_JOINTS = 2
MAIN_SHARE = 0.3  # of the largest torque, from which a second joint counts as a main one
MOSTLY_AT_REST = 0.9  # share of the samples from which a joint does not count as moving
_WORST: tuple[Verdict, ...] = ("equal", "doubtful", "different")


def support_entries(support: SupportResult) -> list[dict[str, Any]]:
    """`support[]`: one entry per device, motion and joint."""
    main = {motion: main_joints(support, motion) for motion in motions(support)}
    return [
        {
            "device": each.device,
            "motion": each.motion,
            "joint": each.joint,
            "unit": each.unit,
            "main": each.joint in main[each.motion],
            "logs": list(each.logs),
            "references": list(each.references),
            **{f"rmse_{approach}": each.rmse.get(approach) for approach in ("a", "b", "prior")},
            "rmse_steady": {approach: each.rmse_steady.get(approach) for approach in ("a", "b", "prior")},
            "motion_equality": equality(support.trials, each),
            **_headline(each),
            "approaches": {
                APPROACHES[approach]: {**_effort(effort), "spread": each.spread.get(approach)}
                for approach, effort in each.by.items()
            },
            "phases": [
                {
                    "phase": part.phase,
                    "duration_s": part.duration_s,
                    "approaches": {APPROACHES[approach]: _effort(effort) for approach, effort in part.by.items()},
                }
                for part in each.phases
            ],
            "null": {approach: each.null.get(approach) for approach in ("a", "b")},
            "masked_share": each.masked_share,
            "rest_share": each.rest_share,
            "rest_half_width": each.rest_half_width,
            "band_model": support.band_model.get(each.device),
        }
        for each in support.joints
    ]


def equality(trials: Sequence[Trial], joint: JointSupport) -> dict[str, Any] | None:
    """How equal the compared motions are: pooled over the trials, the worst verdict, and each trial. None without A."""
    found: list[tuple[Trial, JointEquality]] = [
        (trial, each)
        for trial in trials
        if trial.reference is not None and (trial.device, trial.motion) == (joint.device, joint.motion)
        for each in trial.equality
        if each.joint == joint.joint
    ]
    if not found:
        return None

    def rms(name: str) -> float:
        return math.sqrt(sum(getattr(each, name) ** 2 for _, each in found) / len(found))

    return {
        "q_rms": rms("q_rms"),
        "dq_rms": rms("dq_rms"),
        "dq_share": rms("dq_share"),
        "units": {"q_rms": "m", "dq_rms": "m/s"} if joint.slides else {"q_rms": "rad", "dq_rms": "rad/s"},
        "verdict": max((each.verdict for _, each in found), key=_WORST.index),
        "lag_s": max((trial.lag_s for trial, _ in found), key=abs),
        "trials": [
            {
                "log": trial.log,
                "reference": trial.reference,
                "lag_s": trial.lag_s,
                "q_rms": each.q_rms,
                "dq_rms": each.dq_rms,
                "dq_share": each.dq_share,
                "verdict": each.verdict,
            }
            for trial, each in found
        ],
    }


def motions(support: SupportResult) -> tuple[str, ...]:
    """In the order of their first appearance."""
    return tuple(dict.fromkeys(each.motion for each in support.joints))


def devices(support: SupportResult) -> tuple[str, ...]:
    return tuple(dict.fromkeys(each.device for each in support.joints))


def main_joints(support: SupportResult, motion: str) -> tuple[str, ...]:
    """The moving joints on which the devices act most, the strongest first: one, or two of like size."""
    found = [each for each in support.joints if each.motion == motion]
    moving = [each for each in found if each.rest_share < MOSTLY_AT_REST] or found
    sizes: dict[str, float] = {}
    for each in moving:
        sizes[each.joint] = max(sizes.get(each.joint, 0.0), largest(each))
    ordered = sorted(sizes, key=lambda joint: -sizes[joint])[:MOST_MAIN_JOINTS]
    return tuple(joint for joint in ordered if sizes[joint] >= MAIN_SHARE * sizes[ordered[0]])


def largest(joint: JointSupport) -> float:
    """Size of the peak torque [N·m] by the band model, or by the best approach that there is."""
    for approach in ("band_model", "a", "b"):
        if approach in joint.by and math.isfinite(joint.by[approach].peak.value):
            return abs(joint.by[approach].peak.value)
    return 0.0


def best_approach(by: Mapping[str, Effort]) -> str:
    """A where there is one, else B."""
    return "a" if "a" in by else "b"


def support_table(support: SupportResult) -> bytes:
    """support.csv: one row per device, motion, joint, phase (empty: the whole motion) and approach."""
    columns = (
        *("device", "motion", "joint", "phase", "approach", "duration_s"),
        *(name for quantity in QUANTITIES for name in (quantity, f"{quantity}_std")),
        *("unit", "integral_unit", "spread", "rmse", "rmse_steady", "null"),
    )
    return csv_table(columns, (row for each in support.joints for row in _rows(each)))


def _rows(joint: JointSupport) -> Iterator[list[Any]]:
    key = [joint.device, joint.motion, joint.joint]
    for approach, effort in joint.by.items():
        compared = [each.get(approach) for each in (joint.spread, joint.rmse, joint.rmse_steady, joint.null)]
        yield [*key, "", APPROACHES[approach], None, *_numbers(effort), *compared]
    for part in joint.phases:
        for approach, effort in part.by.items():
            yield [*key, part.phase, APPROACHES[approach], part.duration_s, *_numbers(effort), *[None] * 4]


def _numbers(effort: Effort) -> list[Any]:
    found = [getattr(effort, quantity) for quantity in QUANTITIES]
    return [number for each in found for number in (each.value, each.std)] + [effort.peak.unit, effort.integral.unit]


def _headline(joint: JointSupport) -> dict[str, Any]:
    """Peak, mean and integral of the whole motion, by A where there is one."""
    approach = best_approach(joint.by)
    if approach not in joint.by:
        return dict.fromkeys(QUANTITIES)
    return {name: {**entry, "approach": APPROACHES[approach]} for name, entry in _effort(joint.by[approach]).items()}


def _effort(effort: Effort) -> dict[str, dict[str, Any]]:
    return {quantity: number(getattr(effort, quantity)) for quantity in QUANTITIES}


def number(estimate: Estimate) -> dict[str, Any]:
    return {"value": estimate.value, "std": estimate.std, "unit": estimate.unit}
