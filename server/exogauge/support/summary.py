"""Supporting torque joint by joint over all trials: errors against the band model, peaks, means, phases, spread."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.result import Estimate
from exogauge.identification.model import RobotModel
from exogauge.support.best import Regime, best
from exogauge.support.evidence import Background, Evidence
from exogauge.support.peak import peak_places
from exogauge.support.repeatability import Null
from exogauge.support.result import Best, Effort, JointSupport, PhaseEffort, Trial

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

APPROACHES = ("a", "b", "paired", "prior", "band_model")
MEASURED = ("a", "b", "paired")  # those with a doubt
PHASE_REGIME: dict[str, Regime] = {"standing": "other", "holding": "other"}  # of the others: steady motion


def summarise_joint(
    model: RobotModel,
    trials: Sequence[Trial],
    evidences: Sequence[Evidence],
    background: Background,
    joint: int,
    shifts: Sequence[float],
) -> JointSupport:
    """One joint over the trials of one device and motion. joint: its place among the trials' joints. shifts: [s] time
    in each trial minus time in the first at the same posture."""
    first, repeats = trials[0], background.repeats
    found = {"a": repeats.a, "b": repeats.b, "paired": repeats.paired}
    nulls = {name: each for name, each in found.items() if each is not None}
    runs = _Runs(model, trials, evidences, shifts, nulls, joint)
    lines = [lines_of(trial, joint) for trial in trials]
    present = [name for name in APPROACHES if all(name in each for each in lines)]
    whole = [np.ones(len(trial.time), dtype=np.bool_) for trial in trials]
    phases = []
    for number, name in enumerate(first.phase_names):
        chosen = [trial.phase == number for trial in trials]
        have = [k for k, mask in enumerate(chosen) if mask.sum() > 1]
        if have:
            seconds = [float(np.sum(chosen[k])) * _step(trials[k]) for k in have]
            by = _efforts(runs, lines, chosen, present)
            regime = PHASE_REGIME.get(name, "steady")
            phases.append(PhaseEffort(name, float(np.mean(seconds)), by, _best(runs, by, regime)))
    means = {name: [float(np.nanmean(each[name])) for each in lines] for name in present}
    by = _efforts(runs, lines, whole, present)
    compared = [trial for trial in trials if trial.support_a is not None]
    return JointSupport(
        device=first.device,
        motion=first.motion,
        joint=first.joints[joint],
        logs=tuple(trial.log for trial in trials),
        references=tuple(trial.reference for trial in trials if trial.reference is not None),
        rmse=_rmse(trials, lines, whole),
        rmse_steady=_rmse(trials, lines, [_steady(trial, joint) for trial in trials]),
        by=by,
        best=_best(runs, by, "whole"),
        spread={name: float(np.std(values, ddof=1)) for name, values in means.items() if len(values) > 1},
        phases=tuple(phases),
        null={name: float(each.whole[joint]) for name, each in nulls.items()},
        slides=first.joints[joint] in model.robot.tree.sliding,
        equality=tuple(trial.equality[joint] for trial in compared),
        lag_s=tuple(trial.lag_s for trial in compared),
        masked_share=_share([~trial.compared[:, joint] for trial in compared]),
        rest_share=_share([trial.rest[:, joint] for trial in trials]),
        rest_half_width=float(background.held[joint]),
    )


def lines_of(trial: Trial, joint: int) -> dict[str, Array]:
    """Approach -> (T,) [N·m]."""
    lines = {"b": trial.support_b[:, joint], "prior": trial.support_prior[:, joint]}
    if trial.support_a is not None:
        lines["a"] = trial.support_a[:, joint]
    if trial.support_paired is not None:
        lines["paired"] = trial.support_paired[:, joint]
    if trial.band_model is not None:
        lines["band_model"] = trial.band_model[:, joint]
    return lines


def _steady(trial: Trial, joint: int) -> BoolArray:
    return trial.steady[:, joint] & (trial.compared[:, joint] if trial.support_a is not None else True)


def _rmse(
    trials: Sequence[Trial], lines: Sequence[Mapping[str, Array]], chosen: Sequence[BoolArray]
) -> dict[str, float]:
    """Approach -> RMSE against the band model, pooled over all trials' chosen samples."""
    result = {}
    for name in APPROACHES[:4]:
        if all(name in each and "band_model" in each for each in lines):
            errors = np.concatenate(
                [(each[name] - each["band_model"])[c] for each, c in zip(lines, chosen, strict=True)]
            )
            errors = errors[np.isfinite(errors)]
            if errors.size:
                result[name] = float(np.sqrt(np.mean(errors**2)))
    return result


@final
@dataclass(frozen=True)
class _Runs:
    """All trials of one device and motion, and what every approach finds where there is nothing."""

    model: RobotModel
    trials: Sequence[Trial]
    evidences: Sequence[Evidence]
    shifts: Sequence[float]
    nulls: Mapping[str, Null]
    joint: int


def _best(runs: _Runs, by: Mapping[str, Effort], regime: Regime) -> Best | None:
    std = {name: by[name].mean.std for name in MEASURED if name in by}
    return best(runs.nulls, std, runs.joint, regime, runs.model.criteria.support)


def _efforts(
    runs: _Runs, lines: Sequence[Mapping[str, Array]], chosen: Sequence[BoolArray], present: Sequence[str]
) -> dict[str, Effort]:
    """Approach -> effort over the chosen samples: mean over the trials, and the doubt with their spread in it."""
    trials, result = runs.trials, {}
    unit = "N" if trials[0].joints[runs.joint] in runs.model.robot.tree.sliding else "N·m"
    units = (unit, unit, f"{unit}·s")
    for name in present:
        used = [mask & np.isfinite(own[name]) for own, mask in zip(lines, chosen, strict=True)]
        peaks = peak_places(
            [trial.time - trial.time[0] for trial in trials],
            runs.shifts,
            [own[name] for own in lines],
            [own.get("band_model") for own in lines],
            used,
            runs.model.criteria.support.peak_s,
        )
        each = [
            _effort(runs, k, name, own[name], mask, peak)
            for k, (own, mask, peak) in enumerate(zip(lines, used, peaks, strict=True))
            if peak is not None
        ]
        if each:
            result[name] = Effort(*(_pooled([one[k] for one in each], units[k]) for k in range(3)))
    return result


def _effort(
    runs: _Runs, k: int, name: str, line: Array, used: BoolArray, peak: tuple[int, float]
) -> tuple[tuple[float, float], tuple[float, float], tuple[float, float]]:
    """(value, std) of peak, mean, integral of trial k."""
    trial, joint = runs.trials[k], runs.joint
    seconds = float(used.sum()) * _step(trial)
    peak_std = mean_std = 0.0
    if name in MEASURED:
        std = {"a": trial.support_a_std, "b": trial.support_b_std, "paired": trial.support_paired_std}[name]
        assert std is not None
        own = std[used, joint]
        peak_std = float(std[peak[0], joint])
        shared = _parameter_std(runs.model, runs.evidences[k], name, used, joint)
        rest = trial.rest[used, joint]
        lasting = float(np.mean(np.where(rest, own, 0.0)))  # what friction hides at rest does not average out,
        if name in runs.nulls:  # nor what drifts
            lasting = max(lasting, float(runs.nulls[name].mean[joint]))
        moving = max(float(np.mean(np.where(rest, 0.0, own) ** 2)) - shared**2, 0.0)
        moving /= max(1.0, seconds / runs.model.criteria.support.memory_s)
        mean_std = float(np.sqrt(shared**2 + moving + lasting**2))
    mean = float(np.mean(line[used]))
    return (peak[1], peak_std), (mean, mean_std), (mean * seconds, mean_std * seconds)


def _parameter_std(model: RobotModel, evidence: Evidence, name: str, used: BoolArray, joint: int) -> float:
    """[N·m] doubt of the mean that comes from the robot's parameters and what is declared: they err alike at every
    sample."""
    slope, inputs = {
        "a": (evidence.slope_a, evidence.own_a),
        "b": (evidence.slope_b, evidence.own_b),
        "paired": (evidence.slope_paired, evidence.own_paired),
    }[name]
    assert slope is not None
    chosen = used[evidence.sloped]
    if not chosen.any():
        return 0.0
    S = slope[chosen, joint].mean(axis=0, dtype=np.float64)
    own = np.concatenate(
        [each[chosen, joint].mean(axis=0, dtype=np.float64) for each in inputs.values()] or [np.zeros(0)]
    )
    return float(np.sqrt(max(float(S @ model.doubt @ S), 0.0) + own @ own))


def _pooled(each: Sequence[tuple[float, float]], unit: str) -> Estimate:
    """Mean over trials; their own doubt is largely shared and stays, their spread averages out."""
    values, stds = np.array(each).T
    spread = float(np.var(values, ddof=1)) / len(values) if len(values) > 1 else 0.0
    return Estimate(float(values.mean()), float(np.sqrt(np.mean(stds**2) + spread)), unit)


def _share(masks: Sequence[BoolArray]) -> float:
    return float(np.mean(np.concatenate(masks))) if masks else 0.0


def _step(trial: Trial) -> float:
    return float((trial.time[-1] - trial.time[0]) / (len(trial.time) - 1))
