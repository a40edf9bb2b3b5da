"""Peak, mean and integral of a supporting torque over repeated trials, and what their doubt is made of.

All three are means of the torque over some samples, so that every disturbance acts on them through the mean of its
slopes: what all logs share adds up, what is a log's own averages out, but for the share that is alike in a session.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.result import Estimate
from exogauge.identification.model import RobotModel
from exogauge.support.evidence import Evidence
from exogauge.support.inputs import variance_of_mean, weights_of_mean
from exogauge.support.peak import Moments, peak_places, same_moments
from exogauge.support.repeatability import Repeatability, beyond_chance
from exogauge.support.result import Effort, Trial

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

MEASURED = ("a", "b", "paired")  # those with a doubt
SCATTER, NULL_TEST, AT_REST = "scatter", "null_test", "at_rest"


@final
@dataclass(frozen=True)
class Runs:
    """All K trials of one device and motion at one joint. shifts: (K,) [s] time in each minus time in the first at the
    same posture. repeats: what every approach finds where there is nothing."""

    model: RobotModel
    trials: Sequence[Trial]
    evidences: Sequence[Evidence]
    shifts: Sequence[float]
    repeats: Repeatability
    joint: int

    @cached_property
    def times(self) -> list[Array]:
        """(T_k,) [s] from each start."""
        return [trial.time - trial.time[0] for trial in self.trials]

    @cached_property
    def moments(self) -> list[Moments]:
        return same_moments(self.times, self.shifts)


def efforts(
    runs: Runs, lines: Sequence[Mapping[str, Array]], chosen: Sequence[BoolArray], present: Sequence[str]
) -> dict[str, Effort]:
    """Approach -> effort over the chosen samples: mean over the trials, and the doubt with their spread in it."""
    trials, result = runs.trials, {}
    unit = "N" if trials[0].joints[runs.joint] in runs.model.robot.tree.sliding else "N·m"
    seconds = runs.model.criteria.support.peak_s
    for name in present:
        used = [mask & np.isfinite(own[name]) for own, mask in zip(lines, chosen, strict=True)]
        calm = _calm(runs, used)
        peaks = peak_places(
            runs.times,
            runs.moments,
            [own[name] for own in lines],
            [own.get("band_model") for own in lines],
            calm,
            seconds,
            _noise(runs, name),
        )
        have = [k for k, peak in enumerate(peaks) if peak is not None]
        if not have:
            continue
        means = [float(np.mean(lines[k][name][used[k]])) for k in have]
        tops = [(k, peaks[k]) for k in have]
        near = {k: _near(trials[k].time, top[0], seconds) & calm[k] for k, top in tops if top is not None}
        of_mean = _told(runs, name, {k: used[k] for k in have}, means, whole=True)
        of_peak = _told(runs, name, near, [top[1] for _, top in tops if top is not None], whole=False)
        lasting = float(np.mean([float(used[k].sum()) * step(trials[k]) for k in have]))
        integral = [mean * float(used[k].sum()) * step(trials[k]) for k, mean in zip(have, means, strict=True)]
        result[name] = Effort(
            _estimate(float(np.mean([top[1] for _, top in tops if top is not None])), of_peak, unit),
            _estimate(float(np.mean(means)), of_mean, unit),
            _estimate(
                float(np.mean(integral)), {source: lasting * std for source, std in of_mean.items()}, f"{unit}·s"
            ),
        )
    return result


def _calm(runs: Runs, used: Sequence[BoolArray]) -> list[BoolArray]:
    """(T_k,) of every run where it moves steadily or rests; all that is used where it never does. At starts and turns
    errors are rare and large, and the largest of them, alike in all runs, would be the peak."""
    j = runs.joint
    calm = [own & (each.steady[:, j] | each.rest[:, j]) for own, each in zip(used, runs.trials, strict=True)]
    return [some if some.any() else own for some, own in zip(calm, used, strict=True)]


def _noise(runs: Runs, name: str) -> list[Array] | None:
    """(T_k,) [N·m] of every run, by what the approach finds where there is nothing; None of what is not measured."""
    if name not in MEASURED:
        return None
    steady, other = (float(each[runs.joint]) for each in runs.repeats.spread(name))
    return [np.where(trial.steady[:, runs.joint], steady, other) for trial in runs.trials]


def step(trial: Trial) -> float:
    """[s] between samples."""
    return float((trial.time[-1] - trial.time[0]) / (len(trial.time) - 1))


def _estimate(value: float, parts: Mapping[str, float], unit: str) -> Estimate:
    """Nothing is told of the parts where trials scatter and nothing else is known."""
    told = parts if set(parts) - {SCATTER} else {}
    return Estimate(value, float(np.sqrt(sum(std**2 for std in parts.values()))), unit, told)


def _told(
    runs: Runs, name: str, windows: Mapping[int, BoolArray], values: Sequence[float], whole: bool
) -> dict[str, float]:
    """Source -> standard deviation [N·m] of the mean over trials of means over windows.

    windows: trial -> (T,) samples. values: [N·m] of each trial. whole: of a motion or phase, over which errors that
    last a second average out; a peak bears them all, as it does what the model lacks in just that posture.
    """
    K = len(values)
    scatter = float(np.var(values, ddof=1)) / K if K > 1 else 0.0
    if name not in MEASURED:
        return {SCATTER: float(np.sqrt(scatter))}
    seen = [(runs.evidences[k], window) for k, window in windows.items()]
    means = [(each.inputs(name).joint(runs.joint), weights_of_mean(each.sloped, window)) for each, window in seen]
    found = {source: float(np.sqrt(square)) for source, square in variance_of_mean(runs.model, means).items()}
    steady, other = (float(each[runs.joint]) for each in runs.repeats.spread(name))
    memory = runs.model.criteria.support.memory_s
    at_rest, nulls = list[float](), list[float]()
    for k, window in windows.items():
        moves, rests = (each[window, runs.joint] for each in (runs.trials[k].steady, runs.trials[k].rest))
        hidden = runs.evidences[k].at_rest(name)[window, runs.joint]
        noise = np.where(moves, steady, other) ** 2
        if not whole:
            at_rest.append(float(np.mean(hidden)))
            nulls.append(float(np.sqrt(np.mean(noise))))
            continue
        seconds = float(window.sum()) * step(runs.trials[k])
        scatter += float(np.mean(np.where(rests, 0.0, noise))) / max(1.0, seconds / memory) / K**2
        at_rest.append(float(np.mean(np.where(rests, np.hypot(hidden, other), hidden))))  # it does not average out
    if whole and name in runs.repeats.by_approach:  # nor does what drifts
        nulls.append(float(runs.repeats.by_approach[name].mean[runs.joint]))
    null = float(np.mean(nulls)) if nulls else 0.0
    if name == "b" and not whole:
        known = sum(std**2 for std in found.values())
        there = beyond_chance(_in_that_posture(runs, windows) ** 2, known, runs.model.criteria.support.equal)
        null = max(null, float(np.sqrt(there)))
    found |= {
        SCATTER: float(np.sqrt(scatter)),
        AT_REST: float(np.mean(at_rest)),
        NULL_TEST: null,
    }
    return {source: std for source, std in found.items() if std > 0.0}


def _in_that_posture(runs: Runs, windows: Mapping[int, BoolArray]) -> float:
    """[N·m] that B finds there without the device, on the average of the runs that have a partner; 0 without any."""
    found = list[float]()
    for k, window in windows.items():
        evidence = runs.evidences[k]
        if evidence.paired is not None:  # which is B less that
            without = (evidence.b - evidence.paired)[window, runs.joint]
            found += [float(np.mean(without))] if np.isfinite(without).all() else []
    return float(np.mean(found)) if found else 0.0


def _near(time: Array, top: int, seconds: float) -> BoolArray:
    """(T,) samples that the peak is a mean of."""
    return np.asarray(np.abs(time - time[top]) <= 0.5 * seconds)
