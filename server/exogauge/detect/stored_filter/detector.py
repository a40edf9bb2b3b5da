"""Signals that were low-passed before they were stored: seen, at which cut-off, and what passing the model through the
same low-pass is worth.

A low-pass makes friction look soft where a joint turns round, as presliding does. Two things tell them apart. A stored
low-pass takes the sensors' noise along, so the spectrum ends (`logs.stored_band`). And it is one filter for all joints,
however fast they turn: the one through which the model explains the unfiltered measurement best.

What has its effect in some logs only may have nothing held out, or nothing that is fitted. Then these logs judge
themselves, and more is asked of them.

What a model lacks around the moments at which a joint turns round, over the time since the turn.

Before anything else is sought: what a log's own low-pass has done looks like several effects.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.detect.so_far import SoFar
from exogauge.detect.stored_filter.stored_pass import Band, beside_rest, stored_band
from exogauge.errors import NotIdentifiable
from exogauge.findings.basis import FloorOf, LowPassed
from exogauge.findings.result import Alternative, Evidence, Finding, HeldOut, Place
from exogauge.identification.model import RobotModel
from exogauge.identification.noise_bias import noise_behind_stored
from exogauge.identification.preparation import DRIVE
from exogauge.identification.result import Channels, Identification, Prediction
from exogauge.identification.settings import Recording
from exogauge.identification.validate import floors_of, rmse_in_steady_motion, unit_of
from exogauge.logs.model import Log
from exogauge.logs.stored_band import Edge, stored_edges
from exogauge.progress import Doing, Progress, unwatched
from exogauge.search.judge import refused

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

ALL = "all"


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
    progress: Progress = unwatched,
) -> BandLimited | None:
    """None where no log is band-limited, or where filtering alike does not surely make errors smaller.

    found: identification of `recordings` as they are. identify_anew: the same with other recordings.
    """
    criteria = found.model.criteria
    edges = stored_edges([each.log for each in recordings if each.log.stored is None])
    if not edges or not any(each.held_out for each in recordings):
        return None
    progress(0.0, Doing.LOOKING_FOR_STORED_FILTER)
    ended = [each for each in recordings if each.log.name in edges]
    seeking = [each.log for each in ended if not each.held_out] or [each.log for each in ended]
    names = _stored_alike(edges, [log.name for log in seeking], criteria.stored_filter.alike)
    seeking = [log for log in seeking if log.name in names]
    band = stored_band(found.model, seeking, float(np.median([edges[log.name].hz for log in seeking])))
    if band is None:
        return None
    band = replace(band, logs=names)
    limited = tuple(
        replace(each, log=replace(each.log, stored=band.stored)) if each.log.name in names else each
        for each in recordings
    )
    progress(0.5, Doing.IDENTIFYING_FILTERED_ALIKE)
    try:
        again = identify_anew(limited)
    except NotIdentifiable:  # behind so low a pass nothing is left that moves steadily
        return None
    judges = _judges(ended, names, seeking)
    free = {
        each.log.name: beside_rest(found.model.prepare(each.log), criteria.stored_filter)
        for each in ended
        if each.log.name in judges.logs
    }
    if not _surely_better(found, again, judges, free):
        return None
    finding = _finding(band, judges, found, again, limited, free)
    return BandLimited(band, finding, limited, again, _in_the_same_motion(found, again, limited))


@final
@dataclass(frozen=True)
class _Judges:
    """logs: whose error has to fall. themselves: no log was held out from the search for a band."""

    logs: tuple[str, ...]
    themselves: bool


def _stored_alike(edges: Mapping[str, Edge], among: Sequence[str], ratio: float) -> tuple[str, ...]:
    """Logs that end as those `among` do in the middle, within this ratio of their edges."""
    steep = sum(edges[name].steep for name in among) > 0.5 * len(among)
    middle = float(np.median([edges[name].hz for name in among if edges[name].steep is steep]))
    alike = [name for name, edge in edges.items() if edge.steep is steep and middle / ratio < edge.hz < middle * ratio]
    return tuple(alike)


def _judges(ended: Sequence[Recording], names: Sequence[str], seeking: Sequence[Log]) -> _Judges:
    """Held-out logs that the band was not sought in; else these that it was sought in."""
    sought = [log.name for log in seeking]
    out = [each.log.name for each in ended if each.held_out and each.log.name in names and each.log.name not in sought]
    return _Judges(tuple(out or sought), themselves=not out)


def _surely_better(
    before: Identification, after: Identification, judges: _Judges, free: Mapping[str, BoolArray]
) -> bool:
    """Whether the blocks of these logs gain: each joint counts by its share of its own error. Of logs that judge
    themselves every joint's blocks count by themselves, as joints turn at their own times, and rarely: few blocks hold
    most of it. free: log -> samples that count."""
    criteria, channels = before.model.criteria, [f"tau.{joint.name}" for joint in before.model.robot.joints]
    least, once = criteria.judging.least, criteria.judging.once
    gains = [
        _gains(one.time, (one.channels(), other.channels()), free[one.log], channels, criteria.judging.block_s)
        for one, other in zip(before.predictions, after.predictions, strict=True)
        if one.log in judges.logs
    ]
    gain = np.concatenate(gains, axis=1) if gains else np.zeros((0, 0))
    gain = gain[:, np.isfinite(gain).any(axis=0)][np.isfinite(gain).any(axis=1)]
    if gain.shape[1] < 2 or np.mean(np.nanmean(gain, axis=1) > least) < criteria.stored_filter.joints:
        return False
    parts, sure = np.nanmean(gain, axis=0), criteria.judging.sure
    if judges.themselves:
        most = np.median(np.nanmean(gain, axis=1)) > criteria.stored_filter.most
        parts, sure = gain[np.isfinite(gain)], sure if most else once
    return bool(parts.mean() > least and parts.mean() > sure * parts.std(ddof=1) / np.sqrt(len(parts)))


def _gains(
    time: Array, told: tuple[Channels, Channels], free: BoolArray, channels: Sequence[str], block_s: float
) -> Array:
    """(joints, blocks) by how much the mean square error falls, over that of the joint in the whole log; NaN where a
    joint rests. told: before and after. free: (T, joints) samples that count. channels: of all joints, of which some
    have no torque."""
    block = ((time - time[0]) / block_s).astype(np.intp)
    found = []
    for axis, channel in enumerate(channels):
        if channel not in told[0].measured:
            continue
        own = free[:, axis]
        errors = (each.measured[channel] - each.predicted[channel] for each in told)
        error, smaller = (np.where(own, each, 0.0) for each in errors)
        count = np.bincount(block, own)
        gain = np.bincount(block, error**2 - smaller**2) / np.maximum(count, 1.0)
        found.append(np.where(count > 0, gain, np.nan) * own.sum() / max(float(np.sum(error**2)), 1e-300))
    return np.array(found)


def _finding(
    band: Band,
    judges: _Judges,
    before: Identification,
    after: Identification,
    limited: Sequence[Recording],
    free: Mapping[str, BoolArray],
) -> Finding:
    held_out = _held_out(before, after, judges, free)
    where = ALL if len(band.logs) == len(limited) else ", ".join(band.logs)
    rate_hz = next(each.log.rate_hz for each in limited if each.log.name in band.logs)
    return Finding(
        rank=1,
        effect="band_limited_log",
        place=Place("log", where),
        parameters={"cutoff": band.cutoff},
        held_out=held_out,
        score=held_out.explained,
        basis=LowPassed(
            kind=band.stored.kind,
            order=band.stored.order,
            delay_s=band.stored.delay_s(rate_hz) if band.stored.late else None,
            judges=judges.logs if judges.themselves else (),
            floor=_floor_of(after.model, limited, held_out.channel),
        ),
        alternatives=tuple[Alternative, ...](),
        also_possible=tuple[Alternative, ...](),
        evidence=_evidence(held_out.channel, judges.logs, before, after, limited),
    )


def _held_out(before: Identification, after: Identification, judges: _Judges, free: Mapping[str, BoolArray]) -> HeldOut:
    """The joint torque that gains most in the logs that judge, at turns as well: it is there that a low-pass shows."""
    log = judges.logs[0] if judges.themselves and len(judges.logs) == 1 else ""
    found, errors = [], [_errors(each, free) for each in (before, after)]
    for joint in before.model.robot.joints:
        channel = f"tau.{joint.name}"
        floors = [fit.noise_floor for fit in after.validation if fit.log in judges.logs and fit.channel == channel]
        if floors:
            one, other = (each[channel] for each in errors)
            floor = float(np.sqrt(np.mean(np.square(floors))))
            found.append(HeldOut(channel, unit_of(channel, before.model.robot), one, other, floor, log))
    return max(found, key=lambda each: each.rmse_before / max(each.rmse_after, 1e-300))


def _errors(found: Identification, free: Mapping[str, BoolArray]) -> dict[str, float]:
    """Channel of a joint's torque -> RMSE over the samples that count."""
    errors: dict[str, list[Array]] = {}
    for each in (one for one in found.predictions if one.log in free):
        told = each.channels()
        for axis, joint in enumerate(found.model.robot.joints):
            channel = f"tau.{joint.name}"
            if channel in told.measured:
                error = (told.measured[channel] - told.predicted[channel])[free[each.log][:, axis]]
                errors.setdefault(channel, []).append(error)
    return {channel: float(np.sqrt(np.mean(np.concatenate(own) ** 2))) for channel, own in errors.items()}


def _in_the_same_motion(before: Identification, after: Identification, limited: Sequence[Recording]) -> Identification:
    logs, model = {each.log.name: each.log for each in limited}, before.model
    floors, moving = floors_of(after.validation), dict[tuple[str, str], float | None]()
    for one in before.predictions:
        prepared, told = after.model.prepare(logs[one.log]), one.channels()
        own = {channel: floors[one.log, channel] for channel in told.predicted}
        left = rmse_in_steady_motion(model.equations, prepared, told.measured, told.predicted, model.identified, own)
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

    def lacked(by: Prediction) -> Array:
        told = by.channels()
        return np.asarray(told.predicted[channel] - told.measured[channel])

    pairs = [
        (one.time, lacked(one), lacked(other), after.model.prepare(logs[one.log]).raw_direction[:, axis])
        for one, other in zip(before.predictions, after.predictions, strict=True)
        if one.log in logs
    ]
    return turn_evidence(pairs)


def _floor_of(model: RobotModel, limited: Sequence[Recording], channel: str) -> FloorOf:
    """What the noise floor stands for: in these logs themselves little noise is left to be seen."""
    if any(each.log.stored is None for each in limited):
        return "other_logs"
    joint = next(each for each in model.robot.joints if channel == f"tau.{each.name}")
    drive = DRIVE[joint.actuation]
    if model.robot.noise.get(drive, 0.0) > 0.0:
        return "stated"
    behind = (noise_behind_stored(model.robot, model.prepare(each.log)) for each in limited)
    return "seen" if all(each[f"{drive}.{joint.name}"] is not None for each in behind) else "rounding"


def turn_evidence(pairs: Sequence[tuple[Array, Array, Array, NDArray[np.int8]]]) -> Evidence:
    """Mean residuals counted along the motion after the turn. pairs: of each log (T,) time, what the model before and
    after lacks, and the sign of the velocity.

    Signs: torque that the joint gets and the model lacks, as in `evidence`.
    """
    bins = 25
    window_s = 0.6  # to both sides of a turn
    at, lacks = [], []
    for times, before, after, direction in pairs:
        turns = np.flatnonzero(direction[1:] * direction[:-1] < 0.0) + 1
        step = float(np.median(np.diff(times)))
        reach = round(window_s / step)
        residuals = np.stack([before, after])
        for turn in turns:
            near = np.arange(max(int(turn) - reach, 0), min(int(turn) + reach + 1, len(direction)))
            at.append((near - turn) * step)
            lacks.append(residuals[:, near] * direction[turn])
    if not at:
        return Evidence("time_since_turn", "s", *([np.zeros(0)] * 5))
    time, (one, other) = np.concatenate(at), np.concatenate(lacks, axis=1)
    place = np.clip(((time + window_s) / (2.0 * window_s) * bins).astype(np.intp), 0, bins - 1)
    count = np.bincount(place, minlength=bins)
    full = count > 1

    def mean(values: Array) -> Array:
        return np.asarray(np.bincount(place, values, minlength=bins)[full] / count[full])

    spread = np.sqrt(np.maximum(mean(one**2) - mean(one) ** 2, 0.0) / count[full])
    return Evidence("time_since_turn", "s", mean(time), mean(one), mean(other), spread, mean(one) - mean(other))


def stored_filter(so_far: SoFar) -> SoFar:
    """With both sides filtered alike from here on."""
    limited = band_limits(so_far.current, so_far.recordings, so_far.identified, so_far.question.progress)
    if limited is None or refused(limited.finding, so_far.criteria.judging):
        return so_far
    models, recordings = (limited.before, limited.identification), limited.recordings
    return replace(so_far, recordings=recordings, whole=recordings, models=models).having([limited.finding])
