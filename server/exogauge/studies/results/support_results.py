"""Supporting torque as results.json and support.csv hold it.

Stiffness and natural length of the bands as results.json and stiffness.csv hold them.

What a named effect does to supporting torque and stiffness: the same logs with the model before and after.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from exogauge.criteria.criterion import Z95
from exogauge.devices.result import CrossCheck, Estimate, StiffnessResult
from exogauge.findings.result import Consequence
from exogauge.studies.csv_table import csv_table
from exogauge.studies.words.doubt_words import source_advice, source_words
from exogauge.studies.words.finding_sentences import band_note
from exogauge.studies.words.remark_words import sentence
from exogauge.support.evaluate import Consequences
from exogauge.support.result import Effort, JointEquality, JointSupport, SupportResult, Trial, Verdict

APPROACHES = {"a": "A", "b": "B", "paired": "paired", "prior": "prior", "band_model": "band_model"}  # as in the files
WITH_ERROR = ("a", "b", "paired", "prior")
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
            **{f"rmse_{approach}": each.rmse.get(approach) for approach in WITH_ERROR},
            "rmse_steady": {approach: each.rmse_steady.get(approach) for approach in WITH_ERROR},
            "motion_equality": equality(support.trials, each),
            **_headline(each),
            "approaches": {
                APPROACHES[approach]: {**_whole(effort), "spread": each.spread.get(approach)}
                for approach, effort in each.by.items()
            },
            "phases": [
                {
                    "phase": part.phase,
                    "duration_s": part.duration_s,
                    "approaches": {APPROACHES[approach]: _effort(effort) for approach, effort in part.by.items()},
                    "best": None if part.best is None else APPROACHES[part.best.approach],
                }
                for part in each.phases
            ],
            "null": {approach: each.null.get(approach) for approach in ("a", "b", "paired")},
            "masked_share": each.masked_share,
            "rest_share": each.rest_share,
            "rest_half_width": each.rest_half_width,
            "band_model": sentence(values) if (values := support.band_model.get(each.device)) else None,
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
    for approach in ("band_model", best_approach(joint)):
        if approach in joint.by and math.isfinite(joint.by[approach].peak.value):
            return abs(joint.by[approach].peak.value)
    return 0.0


def best_approach(joint: JointSupport) -> str:
    """Whose own null test says it is best."""
    return joint.best.approach if joint.best and joint.best.approach in joint.by else "b"


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
    """Peak, mean and integral of the whole motion, by the best approach; None where the data decide nothing."""
    approach = best_approach(joint)
    if not joint.decided or approach not in joint.by:
        return dict.fromkeys(QUANTITIES)
    effort = joint.by[approach]
    as_good = joint.best.as_good if joint.best else (approach,)
    said = {"approach": APPROACHES[approach], "as_good": [APPROACHES[name] for name in as_good if name in joint.by]}
    return {name: {**doubted(getattr(effort, name)), **said} for name in QUANTITIES}


def _effort(effort: Effort) -> dict[str, dict[str, Any]]:
    return {quantity: number(getattr(effort, quantity)) for quantity in QUANTITIES}


def _whole(effort: Effort) -> dict[str, dict[str, Any]]:
    return {quantity: doubted(getattr(effort, quantity)) for quantity in QUANTITIES}


def doubted(estimate: Estimate) -> dict[str, Any]:
    """With its 95 % interval, and what its doubt is made of."""
    ends = [estimate.value - Z95 * estimate.std, estimate.value + Z95 * estimate.std]
    return {**number(estimate), "interval_95": ends, "budget": budget(estimate.parts)}


def budget(parts: Mapping[str, float]) -> list[dict[str, Any]]:
    """The largest part first."""
    return [{"source": source, "std": std} for source, std in sorted(parts.items(), key=lambda part: -part[1])]


def number(estimate: Estimate) -> dict[str, Any]:
    return {"value": estimate.value, "std": estimate.std, "unit": estimate.unit}


def stiffness_entries(found: Sequence[StiffnessResult]) -> list[dict[str, Any]]:
    """`stiffness[]`: one entry per device, approach and band."""
    return [
        {
            "device": each.device,
            "approach": each.approach,
            "band": band.band,
            "group": band.group,
            "stiffness_n_per_m": number(band.stiffness),
            "natural_length_m": number(band.natural_length),
            "interval_95": {
                "stiffness_n_per_m": list(band.stiffness_interval),
                "natural_length_m": list(band.natural_length_interval),
            },
            "truth_n_per_m": band.true_stiffness,
            "error_percent": band.error_percent,
            "identifiable": bool(band.identifiable),
            "length_identifiable": bool(band.length_identifiable),
            "headline": each.approach == headline_approach(found, each.device, band.group),
            "note": band_note(band),
            "budget": [
                {
                    "source": part["source"],
                    "words": source_words(part["source"]),
                    "stiffness_std": part["std"],
                    "natural_length_std": band.natural_length.parts.get(part["source"]),
                    "advice": source_advice(part["source"]),
                }
                for part in budget(band.stiffness.parts)
            ],
        }
        for each in found
        for band in each.bands
    ]


def headline_approach(found: Sequence[StiffnessResult], device: str, group: str) -> str | None:
    """The approach that decides a group's stiffness with the smallest doubt for its size, what it finds on logs without
    the device in it; None where none decides it. Levers and gains are doubted in proportion: the smallest doubt in N/m
    would be that of the smallest stiffness."""
    decided = {
        each.approach: band.stiffness.std / abs(band.stiffness.value)
        for each in found
        for band in each.bands
        if (each.device, band.group) == (device, group) and each.approach != "prior" and band.identifiable
    }
    return min(decided, key=lambda approach: decided[approach]) if decided else None


def cross_checks(found: Sequence[StiffnessResult]) -> list[dict[str, Any]]:
    """`cross_checks[]`: one entry per device, approach, pair of parts and unit, the worst of several lengths; two
    approaches stand once."""
    worst = dict[tuple[object, ...], tuple[str, CrossCheck]]()
    for each in found:
        for one in each.cross_checks:
            approach = "" if one.check == "approaches" else each.approach
            key = (each.device, one.check, one.group, frozenset(one.between), one.unit, approach)
            if key not in worst or (not one.agrees, abs(one.z)) > (not worst[key][1].agrees, abs(worst[key][1].z)):
                worst[key] = each.approach, one
    return [
        {
            "device": key[0],
            "approach": approach,
            "check": one.check,
            "group": one.group,
            "between": list(one.between),
            "difference": one.difference,
            "std": one.std,
            "unit": one.unit,
            "z": one.z,
            "limit": one.limit,
            "small": one.small,
            "agrees": bool(one.agrees),
        }
        for key, (approach, one) in worst.items()
    ]


def stiffness_details(found: Sequence[StiffnessResult]) -> list[dict[str, Any]]:
    """`stiffness_details[]`: one entry per device and approach; rms [N·m] by joint."""
    return [
        {
            "device": each.device,
            "approach": each.approach,
            "parameters": list(each.parameters),
            "correlation": each.correlation,
            "rms": dict(each.rms),
            "samples": each.samples,
            "notes": [sentence(note) for note in each.notes],
        }
        for each in found
    ]


def stiffness_table(found: Sequence[StiffnessResult]) -> bytes:
    """stiffness.csv: one row per device, approach and band."""
    columns = (
        *("device", "approach", "band", "group", "stiffness_n_per_m", "stiffness_std", "stiffness_low"),
        *("stiffness_high", "natural_length_m", "natural_length_std", "natural_length_low", "natural_length_high"),
        *("truth_n_per_m", "error_percent", "identifiable", "length_identifiable", "note"),
    )
    rows = (
        [
            *(each.device, each.approach, band.band, band.group),
            *(band.stiffness.value, band.stiffness.std, *band.stiffness_interval),
            *(band.natural_length.value, band.natural_length.std, *band.natural_length_interval),
            *(band.true_stiffness, band.error_percent, bool(band.identifiable), bool(band.length_identifiable)),
            band_note(band),
        ]
        for each in found
        for band in each.bands
    )
    return csv_table(columns, rows)


Estimated = tuple[SupportResult, Sequence[StiffnessResult]]
TOLD = 2  # joints of a device and motion: those that the bands load most
AT_REST = 0.9  # of the samples: from here on there is an interval of the torque, and hardly a torque


def before_after(before: Consequences, after: Estimated) -> tuple[Consequence, ...]:
    """RMSE of B against the band model at the most loaded joints, and the stiffness of each group by each approach."""
    result: list[Consequence] = []
    joints, stiffness = after
    for device, motion in dict.fromkeys((one.device, one.motion) for one in joints.joints):
        here = [one for one in joints.joints if (one.device, one.motion) == (device, motion)]
        for one in sorted(here, key=lambda each: -_load(each))[:TOLD]:
            of = device, motion, one.joint
            if "b" in one.rmse and of in before.rmse and one.rest_share < AT_REST:
                errors = (Estimate(rmse, 0.0, one.unit) for rmse in (before.rmse[of], one.rmse["b"]))
                result.append(Consequence("rmse", of, *errors))
    for now in stiffness:
        earlier = before.stiffness.get((now.device, now.approach), {})
        for group, value in {band.group: band.stiffness for band in now.bands}.items():
            if group in earlier:
                of = (group, now.approach, now.device)
                result.append(Consequence("group_stiffness", of, earlier[group], value))
    return tuple(result)


def _load(joint: JointSupport) -> float:
    effort = joint.by.get("band_model")
    return abs(effort.peak.value) if effort else 0.0
