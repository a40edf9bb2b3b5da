"""Supporting torque joint by joint over all trials: errors against the band model, peaks, means, phases, spread."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.model import RobotModel
from exogauge.support.best import Regime, best
from exogauge.support.effort import MEASURED, Runs, efforts, step
from exogauge.support.evidence import Background, Evidence
from exogauge.support.result import Best, Effort, JointSupport, PhaseEffort, Trial

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

APPROACHES = ("a", "b", "paired", "prior", "band_model")
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
    first, nulls = trials[0], background.repeats.by_approach
    runs = Runs(model, trials, evidences, shifts, background.repeats, joint)
    lines = [lines_of(trial, joint) for trial in trials]
    present = [name for name in APPROACHES if all(name in each for each in lines)]
    whole = [np.ones(len(trial.time), dtype=np.bool_) for trial in trials]
    phases = []
    for number, name in enumerate(first.phase_names):
        chosen = [trial.phase == number for trial in trials]
        have = [k for k, mask in enumerate(chosen) if mask.sum() > 1]
        if have:
            seconds = [float(np.sum(chosen[k])) * step(trials[k]) for k in have]
            by = efforts(runs, lines, chosen, present)
            regime = PHASE_REGIME.get(name, "steady")
            phases.append(PhaseEffort(name, float(np.mean(seconds)), by, _best(runs, by, regime)))
    means = {name: [float(np.nanmean(each[name])) for each in lines] for name in present}
    by = efforts(runs, lines, whole, present)
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


def _best(runs: Runs, by: Mapping[str, Effort], regime: Regime) -> Best | None:
    std = {name: by[name].mean.std for name in MEASURED if name in by}
    return best(runs.repeats.by_approach, std, runs.joint, regime, runs.model.criteria.support)


def _share(masks: Sequence[BoolArray]) -> float:
    return float(np.mean(np.concatenate(masks))) if masks else 0.0
