"""Signals that were low-passed before they were stored: seen, at which cut-off, and what passing the model through the
same low-pass is worth.

A low-pass makes friction look soft where a joint turns round, as presliding does. Two things tell them apart. A stored
low-pass takes the sensors' noise along, so the spectrum ends (`logs.stored_band`). And it is one number for all joints,
however fast they turn: the cut-off at which the model, passed through it, explains the unfiltered measurement best.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.result import Estimate
from exogauge.discrepancy.band_floor import of_the_noise_floor
from exogauge.discrepancy.result import Alternative, Evidence, Finding, HeldOut, Place
from exogauge.discrepancy.turn_evidence import turn_evidence
from exogauge.identification.model import RobotModel
from exogauge.identification.quick_fit import quick_fit
from exogauge.identification.result import Identification
from exogauge.identification.settings import Progress, Recording
from exogauge.identification.validate import floors_of, rmse_in_steady_motion
from exogauge.logs.model import Log
from exogauge.logs.stored_band import stored_edge

Array = NDArray[np.float64]

BELOW, ABOVE = 0.35, 4.0  # of the edge: the cut-offs that are tried
COARSE, FINE = 12, 9  # how many
NEAR = 1.2  # factor around the best coarse one in which the fine ones lie
BLOCK_S = 1.0
SURE = 3.0  # standard errors by which held-out blocks must gain
WORTH = 0.05  # of the held-out mean square error
ALIKE = 1.5  # ratio of the edges of logs that were stored alike
ALL = "all"


@final
@dataclass(frozen=True)
class Band:
    """hz: cut-off of an order-4 `LowPass` (half of an amplitude is left), std: its doubt. logs: names of those stored
    with it."""

    hz: float
    std: float
    logs: tuple[str, ...]


@final
@dataclass(frozen=True)
class BandLimited:
    """recordings: the same, with the band where it was found. identification: with both sides filtered alike. before:
    the one without, its errors in steady motion taken where the new one moves steadily, to be compared."""

    band: Band
    finding: Finding
    recordings: tuple[Recording, ...]
    identification: Identification
    before: Identification


def band_limits(
    found: Identification,
    recordings: Sequence[Recording],
    identify_anew: Callable[[Sequence[Recording]], Identification],
    progress: Progress = lambda _fraction, _phrase: None,
) -> BandLimited | None:
    """None where no log is band-limited, or where filtering alike does not surely make held-out errors smaller.

    found: identification of `recordings` as they are. identify_anew: the same with other recordings.
    """
    edges = {each.log.name: stored_edge(each.log) for each in recordings if each.log.band_hz is None}
    seen = {name: edge.hz for name, edge in edges.items() if edge}
    fitted = [each.log for each in recordings if not each.held_out and each.log.name in seen]
    if not fitted or not any(each.held_out for each in recordings):
        return None
    progress(0.0, "looking for the band in which the logs were stored")
    middle = float(np.median([seen[log.name] for log in fitted]))
    names = tuple(name for name, hz in seen.items() if middle / ALIKE < hz < middle * ALIKE)
    band = stored_band(found.model, [log for log in fitted if log.name in names], middle)
    if band is None:
        return None
    band = replace(band, logs=names)
    limited = tuple(
        replace(each, log=replace(each.log, band_hz=band.hz)) if each.log.name in names else each for each in recordings
    )
    progress(0.5, "identifying with both sides filtered alike")
    again = identify_anew(limited)
    if not _surely_better(found, again, names):
        return None
    finding = _finding(band, len(recordings), found, again, limited)
    return BandLimited(band, finding, limited, again, _in_the_same_motion(found, again, limited))


def stored_band(model: RobotModel, logs: Sequence[Log], edge_hz: float) -> Band | None:
    """The cut-off at which the model, one without added effects, explains the unfiltered logs best; None where the best
    is at an end of what is tried, so that no band explains them.

    Std: one block of a second left out at a time (jackknife).
    """
    cutoffs = np.geomspace(BELOW * edge_hz, ABOVE * edge_hz, COARSE)
    best = int(np.argmin(_unexplained(_squares(model, logs, cutoffs))))
    if best in (0, COARSE - 1):
        return None
    cutoffs = np.geomspace(cutoffs[best] / NEAR, cutoffs[best] * NEAR, FINE)
    squares = _squares(model, logs, cutoffs)
    total = squares.sum(axis=2, keepdims=True)
    hz = _lowest(cutoffs, _unexplained(squares))
    without = np.array(
        [_lowest(cutoffs, _unexplained(total - squares[:, :, [block]])) for block in range(squares.shape[2])]
    )
    count = len(without)
    std = float(np.sqrt((count - 1) / count * np.sum((without - without.mean()) ** 2))) if count > 1 else float("inf")
    step = float(hz * np.log(cutoffs[1] / cutoffs[0]))
    return Band(hz, float(np.hypot(std, step / np.sqrt(12.0))), tuple(log.name for log in logs))


def _squares(model: RobotModel, logs: Sequence[Log], cutoffs: Array) -> Array:
    """(cut-offs, channels, blocks) sums of squared residuals over a second each."""
    blocks = [(np.arange(log.samples) / (BLOCK_S * log.rate_hz)).astype(np.intp) for log in logs]
    found = []
    for hz in cutoffs:
        fits = quick_fit(model.equations, [replace(log, band_hz=float(hz)) for log in logs], model.cutoff_hz)
        rows = [
            np.concatenate([np.bincount(at, fit.residual[c] ** 2) for fit, at in zip(fits, blocks, strict=True)])
            for c in fits[0].residual
            if c.startswith("tau.")
        ]
        found.append(rows)
    return np.array(found)


def _unexplained(squares: Array) -> Array:
    """(cut-offs,) mean over channels of the logarithm of what is left."""
    return np.asarray(np.log(np.maximum(squares.sum(axis=2), 1e-300)).mean(axis=1))


def _lowest(cutoffs: Array, score: Array) -> float:
    """Where a parabola through the best three has its lowest point."""
    middle = int(np.clip(np.argmin(score), 1, len(cutoffs) - 2))
    x, y = np.log(cutoffs[middle - 1 : middle + 2]), score[middle - 1 : middle + 2]
    a, b, _ = np.polyfit(x - x[1], y, 2)
    at = -b / (2.0 * a) if a > 0.0 else 0.0
    return float(np.exp(x[1] + np.clip(at, x[0] - x[1], x[2] - x[1])))


def _surely_better(before: Identification, after: Identification, logs: Sequence[str]) -> bool:
    """Whether the blocks of the held-out logs gain: each channel counts by its share of its own error."""
    gains: list[Array] = []
    for one, other in zip(before.predictions, after.predictions, strict=True):
        if not one.held_out or one.log not in logs:
            continue
        block = ((one.time - one.time[0]) / BLOCK_S).astype(np.intp)
        parts = []
        for channel in (name for name in one.measured if name.startswith("tau.")):
            error, smaller = (each.measured[channel] - each.predicted[channel] for each in (one, other))
            parts.append(np.bincount(block, error**2 - smaller**2) / np.bincount(block) / np.mean(error**2))
        gains.append(np.mean(parts, axis=0))
    gain = np.concatenate(gains) if gains else np.zeros(0)
    if len(gain) < 2:
        return False
    return bool(gain.mean() > WORTH and gain.mean() > SURE * gain.std(ddof=1) / np.sqrt(len(gain)))


def _finding(
    band: Band, recordings: int, before: Identification, after: Identification, limited: Sequence[Recording]
) -> Finding:
    held_out = _held_out(before, after, band.logs)
    where = ALL if len(band.logs) == recordings else ", ".join(band.logs)
    sentence = (
        f"The signals were low-passed at {band.hz:.2f} ± {band.std:.2f} Hz before they were stored: nothing is left "
        f"above, not even the sensors' noise, and in every joint friction turns round as slowly as such a filter does. "
        f"With the model passed through the same low-pass the held-out error of {held_out.channel}, turns included, "
        f"falls from {held_out.rmse_before:.2g} to {held_out.rmse_after:.2g} {held_out.unit} RMSE. "
        f"{of_the_noise_floor(before.model.robot, limited, held_out.channel)}"
    )
    return Finding(
        rank=1,
        effect="band_limited_log",
        place=Place("log", where),
        parameters={"cutoff": Estimate(band.hz, band.std, "Hz")},
        held_out=held_out,
        score=held_out.explained,
        sentence=sentence,
        alternatives=tuple[Alternative, ...](),
        also_possible=tuple[Alternative, ...](),
        motion="",
        evidence=_evidence(held_out.channel, before, after, limited),
    )


def _held_out(before: Identification, after: Identification, logs: Sequence[str]) -> HeldOut:
    """The joint torque that gains most, over all samples of the held-out logs: it is at turns that a low-pass shows."""
    best: tuple[float, HeldOut] = (-np.inf, HeldOut("", "", 0.0, 0.0, 0.0))
    for joint in before.model.robot.joints:
        channel = f"tau.{joint.name}"
        pairs = [
            [fit for fit in each.validation if fit.held_out and fit.log in logs and fit.channel == channel]
            for each in (before, after)
        ]
        if not pairs[0]:
            continue
        one, other = (float(np.sqrt(np.mean([fit.rmse_identified**2 for fit in each]))) for each in pairs)
        floor = float(np.sqrt(np.mean([fit.noise_floor**2 for fit in pairs[1]])))
        gain = float(np.log(one / max(other, 1e-300)))
        if gain > best[0]:
            best = gain, HeldOut(channel, pairs[0][0].unit, one, other, floor)
    return best[1]


def _in_the_same_motion(before: Identification, after: Identification, limited: Sequence[Recording]) -> Identification:
    logs, model = {each.log.name: each.log for each in limited}, before.model
    floors, moving = floors_of(after.validation), dict[tuple[str, str], float | None]()
    for one in before.predictions:
        prepared = after.model.prepare(logs[one.log])
        own = {channel: floors[one.log, channel] for channel in one.predicted}
        left = rmse_in_steady_motion(model.equations, prepared, one.measured, one.predicted, model.identified, own)
        moving |= {(one.log, channel): rmse for channel, rmse in left.items()}
    fits = [
        replace(fit, rmse_moving=moving[fit.log, fit.channel], noise_floor=floors[fit.log, fit.channel].whole)
        for fit in before.validation
    ]
    return replace(before, validation=tuple(fits))


def _evidence(channel: str, before: Identification, after: Identification, limited: Sequence[Recording]) -> Evidence:
    axis = [f"tau.{joint.name}" for joint in before.model.robot.joints].index(channel)
    logs = {each.log.name: each.log for each in limited if each.held_out}
    pairs = [
        (one, other, after.model.prepare(logs[one.log]).raw_direction[:, axis])
        for one, other in zip(before.predictions, after.predictions, strict=True)
        if one.log in logs
    ]
    return turn_evidence(channel, pairs)
