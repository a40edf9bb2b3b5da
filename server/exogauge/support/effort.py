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

from exogauge.criteria.identifying import DECLARED
from exogauge.devices.result import Estimate
from exogauge.identification.model import RobotModel
from exogauge.support.evidence import Evidence
from exogauge.support.peak import Moments, peak_places, same_moments
from exogauge.support.repeatability import Repeatability
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
        peaks = peak_places(
            runs.times,
            runs.moments,
            [own[name] for own in lines],
            [own.get("band_model") for own in lines],
            used,
            seconds,
        )
        have = [k for k, peak in enumerate(peaks) if peak is not None]
        if not have:
            continue
        means = [float(np.mean(lines[k][name][used[k]])) for k in have]
        tops = [(k, peaks[k]) for k in have]
        near = {k: _near(trials[k].time, top[0], seconds) & used[k] for k, top in tops if top is not None}
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
    last a second average out; a peak bears them all, as it does what the model lacks in just that posture: it is
    looked for where most is found, and what is found where there is nothing may be most there.
    """
    K = len(values)
    scatter = float(np.var(values, ddof=1)) / K if K > 1 else 0.0
    if name not in MEASURED:
        return {SCATTER: float(np.sqrt(scatter))}
    found = {source: float(np.sqrt(square)) for source, square in _of_inputs(runs, name, windows).items()}
    steady, other = (float(each[runs.joint]) for each in runs.repeats.spread(name))
    memory = runs.model.criteria.support.memory_s
    highest = float(runs.repeats.peak_b[runs.joint]) if name == "b" else 0.0
    at_rest, nulls = list[float](), list[float]()
    for k, window in windows.items():
        moves, rests = (each[window, runs.joint] for each in (runs.trials[k].steady, runs.trials[k].rest))
        hidden = runs.evidences[k].doubted(name, runs.joint).at_rest[window]
        noise = np.where(moves, steady, other) ** 2
        if not whole:
            at_rest.append(float(np.mean(hidden)))
            nulls.append(max(float(np.sqrt(np.mean(noise))), highest))
            continue
        seconds = float(window.sum()) * step(runs.trials[k])
        scatter += float(np.mean(np.where(rests, 0.0, noise))) / max(1.0, seconds / memory) / K**2
        at_rest.append(float(np.mean(np.where(rests, np.hypot(hidden, other), hidden))))  # it does not average out
    if whole and name in runs.repeats.by_approach:  # nor does what drifts
        nulls.append(float(runs.repeats.by_approach[name].mean[runs.joint]))
    found |= {
        SCATTER: float(np.sqrt(scatter)),
        AT_REST: float(np.mean(at_rest)),
        NULL_TEST: float(np.mean(nulls)) if nulls else 0.0,
    }
    return {source: std for source, std in found.items() if std > 0.0}


def _of_inputs(runs: Runs, name: str, windows: Mapping[int, BoolArray]) -> dict[str, float]:
    """Source -> variance [N²·m²] from the robot's parameters and what is declared. They err alike at every sample."""
    K, alike = len(windows), DECLARED.alike
    shared, own, session = list[Array](), list[Mapping[str, Array]](), list[Mapping[str, Array]]()
    for k, window in windows.items():
        evidence = runs.evidences[k]
        doubted, weights = evidence.doubted(name, runs.joint), _weights(evidence, window)
        shared.append(weights @ doubted.slope)
        own.append({each: weights @ inputs for each, inputs in doubted.own.items()})
        session.append({each: weights @ inputs for each, inputs in doubted.session.items()})
    S = np.mean(shared, axis=0)
    found = {source: max(float(S @ C @ S), 0.0) for source, C in runs.model.doubt_by_source.items()}
    for source in own[0]:
        each = np.array([inputs[source] for inputs in own])
        square = alike * np.sum(np.mean(each, axis=0) ** 2) + (1.0 - alike) * np.sum(each**2) / K**2
        found[source] = found.get(source, 0.0) + float(square)
    for source in session[0]:
        together = np.mean([inputs[source] for inputs in session], axis=0)
        found[source] = found.get(source, 0.0) + float(np.sum(together**2))
    return found


def _weights(evidence: Evidence, window: BoolArray) -> Array:
    """(n,) how much each of `Evidence.sloped` counts in a mean over a window, with straight lines between them."""
    place = np.interp(np.flatnonzero(window), evidence.sloped, np.arange(len(evidence.sloped)))
    before = np.floor(place).astype(np.intp)
    after, share = np.minimum(before + 1, len(evidence.sloped) - 1), place - before
    weights = np.zeros(len(evidence.sloped))
    np.add.at(weights, before, (1.0 - share) / len(place))
    np.add.at(weights, after, share / len(place))
    return weights


def _near(time: Array, top: int, seconds: float) -> BoolArray:
    """(T,) samples that the peak is a mean of."""
    return np.asarray(np.abs(time - time[top]) <= 0.5 * seconds)
