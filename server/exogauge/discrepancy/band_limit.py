"""Signals that were low-passed before they were stored: seen, at which cut-off, and what passing the model through the
same low-pass is worth.

A low-pass makes friction look soft where a joint turns round, as presliding does. Two things tell them apart. A stored
low-pass takes the sensors' noise along, so the spectrum ends (`logs.stored_band`). And it is one number for all joints,
however fast they turn: the cut-off at which the model, passed through it, explains the unfiltered measurement best.

What has its effect in some logs only may have nothing held out, or nothing that is fitted. Then these logs judge
themselves, and more is asked of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
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
from exogauge.identification.result import Identification, Prediction
from exogauge.identification.settings import Progress, Recording
from exogauge.identification.validate import floors_of, rmse_in_steady_motion
from exogauge.logs.model import Log
from exogauge.logs.stored_band import Edge, stored_edge

Array = NDArray[np.float64]

ABOVE = 4.0  # of the edge: the highest cut-off that is tried
LOWEST_HZ = 0.5  # of these: a gentle low-pass begins far below where its fall is seen
COARSE, FINE = 1.25, 9  # factor from one to the next, and how many between its neighbours then
NEAR = 1.2  # factor around the best coarse one in which the fine ones lie
BLOCK_S = 1.0
SURE = 3.0  # standard errors by which held-out blocks must gain
ONCE = 6.0  # standard errors asked of logs that judge themselves, by blocks of single joints
WORTH = 0.05  # of the mean square error
JOINTS = 0.75  # share of joints that must gain that much: every joint passes a stored low-pass, presliding is one's own
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
    """None where no log is band-limited, or where filtering alike does not surely make errors smaller.

    found: identification of `recordings` as they are. identify_anew: the same with other recordings.
    """
    found_edges = {each.log.name: stored_edge(each.log) for each in recordings if each.log.band_hz is None}
    edges = {name: edge for name, edge in found_edges.items() if edge}
    if not edges or not any(each.held_out for each in recordings):
        return None
    progress(0.0, "looking for the band in which the logs were stored")
    ended = [each for each in recordings if each.log.name in edges]
    seeking = [each.log for each in ended if not each.held_out] or [each.log for each in ended]
    names = _stored_alike(edges, [log.name for log in seeking])
    seeking = [log for log in seeking if log.name in names]
    band = stored_band(found.model, seeking, float(np.median([edges[log.name].hz for log in seeking])))
    if band is None:
        return None
    band = replace(band, logs=names)
    limited = tuple(
        replace(each, log=replace(each.log, band_hz=band.hz)) if each.log.name in names else each for each in recordings
    )
    progress(0.5, "identifying with both sides filtered alike")
    again = identify_anew(limited)
    judges = _judges(ended, names, seeking)
    if not _surely_better(found, again, judges):
        return None
    finding = _finding(band, judges, found, again, limited)
    return BandLimited(band, finding, limited, again, _in_the_same_motion(found, again, limited))


@final
@dataclass(frozen=True)
class _Judges:
    """logs: whose error has to fall. themselves: no log was held out from the search for a band."""

    logs: tuple[str, ...]
    themselves: bool

    @property
    def said(self) -> str:
        return f"error of {{}} in {', '.join(self.logs)}" if self.themselves else "held-out error of {}"


def _stored_alike(edges: Mapping[str, Edge], among: Sequence[str]) -> tuple[str, ...]:
    """Logs that end as those `among` do in the middle."""
    steep = sum(edges[name].steep for name in among) > 0.5 * len(among)
    middle = float(np.median([edges[name].hz for name in among if edges[name].steep is steep]))
    alike = [name for name, edge in edges.items() if edge.steep is steep and middle / ALIKE < edge.hz < middle * ALIKE]
    return tuple(alike)


def _judges(ended: Sequence[Recording], names: Sequence[str], seeking: Sequence[Log]) -> _Judges:
    """Held-out logs that the band was not sought in; else these that it was sought in."""
    sought = [log.name for log in seeking]
    out = [each.log.name for each in ended if each.held_out and each.log.name in names and each.log.name not in sought]
    return _Judges(tuple(out or sought), themselves=not out)


def stored_band(model: RobotModel, logs: Sequence[Log], edge_hz: float) -> Band | None:
    """The cut-off at which the model, one without added effects, explains the unfiltered logs best; None where the best
    is at an end of what is tried, so that no band explains them.

    Std: one block of a second left out at a time (jackknife).
    """
    steps = round(np.log(ABOVE * edge_hz / LOWEST_HZ) / np.log(COARSE))
    cutoffs = np.geomspace(LOWEST_HZ, ABOVE * edge_hz, max(steps, 3))
    best = int(np.argmin(_unexplained(_squares(model, logs, cutoffs))))
    if best in (0, len(cutoffs) - 1):
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


def _surely_better(before: Identification, after: Identification, judges: _Judges) -> bool:
    """Whether the blocks of these logs gain: each joint counts by its share of its own error. Of logs that judge
    themselves every joint's blocks count by themselves, as joints turn at their own times."""
    gains = [
        _gains(one, other)
        for one, other in zip(before.predictions, after.predictions, strict=True)
        if one.log in judges.logs
    ]
    gain = np.concatenate(gains, axis=1) if gains else np.zeros((0, 0))
    if gain.shape[1] < 2 or np.mean(gain.mean(axis=1) > WORTH) < JOINTS:
        return False
    parts, sure = (gain.ravel(), ONCE) if judges.themselves else (gain.mean(axis=0), SURE)
    return bool(parts.mean() > WORTH and parts.mean() > sure * parts.std(ddof=1) / np.sqrt(len(parts)))


def _gains(before: Prediction, after: Prediction) -> Array:
    """(joints, blocks) by how much the mean square error falls, over that of the joint in the whole log."""
    block = ((before.time - before.time[0]) / BLOCK_S).astype(np.intp)
    found = []
    for channel in (name for name in before.measured if name.startswith("tau.")):
        error, smaller = (each.measured[channel] - each.predicted[channel] for each in (before, after))
        found.append(np.bincount(block, error**2 - smaller**2) / np.bincount(block) / np.mean(error**2))
    return np.array(found)


def _finding(
    band: Band, judges: _Judges, before: Identification, after: Identification, limited: Sequence[Recording]
) -> Finding:
    held_out = _held_out(before, after, judges)
    where = ALL if len(band.logs) == len(limited) else ", ".join(band.logs)
    sentence = (
        f"The signals were low-passed at {band.hz:.2f} ± {band.std:.2f} Hz before they were stored: the sensors' noise "
        f"fades above, and in every joint friction turns round as slowly as such a filter does. "
        f"With the model passed through the same low-pass the {judges.said.format(held_out.channel)}, turns included, "
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
        evidence=_evidence(held_out.channel, judges.logs, before, after, limited),
    )


def _held_out(before: Identification, after: Identification, judges: _Judges) -> HeldOut:
    """The joint torque that gains most, over all samples of the logs that judge: it is at turns that a low-pass
    shows."""
    best: tuple[float, HeldOut] = (-np.inf, HeldOut("", "", 0.0, 0.0, 0.0))
    log = judges.logs[0] if judges.themselves and len(judges.logs) == 1 else ""
    for joint in before.model.robot.joints:
        channel = f"tau.{joint.name}"
        pairs = [
            [fit for fit in each.validation if fit.log in judges.logs and fit.channel == channel]
            for each in (before, after)
        ]
        if not pairs[0]:
            continue
        one, other = (float(np.sqrt(np.mean([fit.rmse_identified**2 for fit in each]))) for each in pairs)
        floor = float(np.sqrt(np.mean([fit.noise_floor**2 for fit in pairs[1]])))
        gain = float(np.log(one / max(other, 1e-300)))
        if gain > best[0]:
            best = gain, HeldOut(channel, pairs[0][0].unit, one, other, floor, log)
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


def _evidence(
    channel: str, judging: Sequence[str], before: Identification, after: Identification, limited: Sequence[Recording]
) -> Evidence:
    axis = [f"tau.{joint.name}" for joint in before.model.robot.joints].index(channel)
    logs = {each.log.name: each.log for each in limited if each.log.name in judging}
    pairs = [
        (one, other, after.model.prepare(logs[one.log]).raw_direction[:, axis])
        for one, other in zip(before.predictions, after.predictions, strict=True)
        if one.log in logs
    ]
    return turn_evidence(channel, pairs)
