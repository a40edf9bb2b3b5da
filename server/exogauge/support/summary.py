"""Supporting torque joint by joint over all trials: errors against the band model, peaks, means, phases, spread."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from exogauge.devices.result import Estimate
from exogauge.identification.model import RobotModel
from exogauge.support.evidence import Background, Evidence
from exogauge.support.result import Effort, JointSupport, PhaseEffort, Trial

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

APPROACHES = ("a", "b", "prior", "band_model")
PEAK_S = 0.2  # over which a peak is a mean: the largest of many noisy samples is too large
MEMORY_S = 1.0  # how long an error that is not the robot's parameters' lasts: means over less do not average it out


def summarise_joint(
    model: RobotModel, trials: Sequence[Trial], evidences: Sequence[Evidence], background: Background, joint: int
) -> JointSupport:
    """One joint over the trials of one device and motion. joint: its place among the trials' joints."""
    first, repeats = trials[0], background.repeats
    lines = [lines_of(trial, joint) for trial in trials]
    present = [name for name in APPROACHES if all(name in each for each in lines)]
    whole = [np.ones(len(trial.time), dtype=np.bool_) for trial in trials]
    phases = []
    for number, name in enumerate(first.phase_names):
        chosen = [trial.phase == number for trial in trials]
        have = [k for k, mask in enumerate(chosen) if mask.sum() > 1]
        if have:
            seconds = [float(np.sum(chosen[k])) * _step(trials[k]) for k in have]
            phases.append(
                PhaseEffort(
                    name, float(np.mean(seconds)), _efforts(model, trials, evidences, lines, chosen, joint, present)
                )
            )
    means = {name: [float(np.nanmean(each[name])) for each in lines] for name in present}
    null = {"b": float(repeats.by_model[joint])}
    if repeats.between_runs is not None:
        null["a"] = float(repeats.between_runs[joint])
    compared = [trial for trial in trials if trial.support_a is not None]
    return JointSupport(
        device=first.device,
        motion=first.motion,
        joint=first.joints[joint],
        logs=tuple(trial.log for trial in trials),
        references=tuple(trial.reference for trial in trials if trial.reference is not None),
        rmse=_rmse(trials, lines, whole),
        rmse_steady=_rmse(trials, lines, [_steady(trial, joint) for trial in trials]),
        by=_efforts(model, trials, evidences, lines, whole, joint, present),
        spread={name: float(np.std(values, ddof=1)) for name, values in means.items() if len(values) > 1},
        phases=tuple(phases),
        null=null,
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
    for name in APPROACHES[:3]:
        if all(name in each and "band_model" in each for each in lines):
            errors = np.concatenate(
                [(each[name] - each["band_model"])[c] for each, c in zip(lines, chosen, strict=True)]
            )
            errors = errors[np.isfinite(errors)]
            if errors.size:
                result[name] = float(np.sqrt(np.mean(errors**2)))
    return result


def _efforts(
    model: RobotModel,
    trials: Sequence[Trial],
    evidences: Sequence[Evidence],
    lines: Sequence[Mapping[str, Array]],
    chosen: Sequence[BoolArray],
    joint: int,
    present: Sequence[str],
) -> dict[str, Effort]:
    """Approach -> effort over the chosen samples: mean over the trials, and the doubt with their spread in it."""
    result = {}
    for name in present:
        each = []
        for trial, evidence, own, mask in zip(trials, evidences, lines, chosen, strict=True):
            used = mask & np.isfinite(own[name])
            if used.any():
                each.append(_effort(model, trial, evidence, name, own[name], used, joint))
        if each:
            unit = "N" if trials[0].joints[joint] in model.robot.tree.sliding else "N·m"
            units = (unit, unit, f"{unit}·s")
            result[name] = Effort(*(_pooled([one[k] for one in each], units[k]) for k in range(3)))
    return result


def _effort(
    model: RobotModel, trial: Trial, evidence: Evidence, name: str, line: Array, used: BoolArray, joint: int
) -> tuple[tuple[float, float], tuple[float, float], tuple[float, float]]:
    """(value, std) of peak, mean, integral of one trial."""
    values = line[used]
    smooth = uniform_filter1d(values, max(1, round(PEAK_S / _step(trial))), mode="nearest")
    top = int(np.argmax(np.abs(smooth)))
    seconds = float(used.sum()) * _step(trial)
    peak_std = mean_std = 0.0
    if name in ("a", "b"):
        std = trial.support_a_std if name == "a" else trial.support_b_std
        assert std is not None
        own = std[used, joint]
        peak_std = float(own[top])
        shared = _parameter_std(model, evidence, name, used, joint)
        rest = trial.rest[used, joint]
        held = float(np.mean(np.where(rest, own, 0.0)))  # what friction hides at rest does not average out
        moving = max(float(np.mean(np.where(rest, 0.0, own) ** 2)) - shared**2, 0.0) / max(1.0, seconds / MEMORY_S)
        mean_std = float(np.sqrt(shared**2 + moving + held**2))
    mean = float(np.mean(values))
    return (float(smooth[top]), peak_std), (mean, mean_std), (mean * seconds, mean_std * seconds)


def _parameter_std(model: RobotModel, evidence: Evidence, name: str, used: BoolArray, joint: int) -> float:
    """[N·m] doubt of the mean that comes from the robot's parameters: they err alike at every sample."""
    slope = evidence.slope_a if name == "a" else evidence.slope_b
    assert slope is not None
    chosen = used[evidence.sloped]
    if not chosen.any():
        return 0.0
    S = slope[chosen, joint].mean(axis=0, dtype=np.float64)
    return float(np.sqrt(max(float(S @ model.covariance @ S), 0.0)))


def _pooled(each: Sequence[tuple[float, float]], unit: str) -> Estimate:
    """Mean over trials; their own doubt is largely shared and stays, their spread averages out."""
    values, stds = np.array(each).T
    spread = float(np.var(values, ddof=1)) / len(values) if len(values) > 1 else 0.0
    return Estimate(float(values.mean()), float(np.sqrt(np.mean(stds**2) + spread)), unit)


def _share(masks: Sequence[BoolArray]) -> float:
    return float(np.mean(np.concatenate(masks))) if masks else 0.0


def _step(trial: Trial) -> float:
    return float((trial.time[-1] - trial.time[0]) / (len(trial.time) - 1))
