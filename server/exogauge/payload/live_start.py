"""What is known of a payload when its stream begins: what its postures say, then its excitation if it has one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import USUAL, Criteria
from exogauge.criteria.payload_dynamic import Moving
from exogauge.errors import BadStudy, Fault
from exogauge.payload.calibration import Calibration, uncalibrated
from exogauge.payload.contract import PayloadFile
from exogauge.payload.dynamics import DynamicSolution, Prior, static_prior
from exogauge.payload.evaluate import Evaluation, evaluate
from exogauge.payload.intake import Payload, Recording, Stream, open_payload
from exogauge.payload.live import Start
from exogauge.payload.live_track import Pose
from exogauge.payload.missing.words import name_of
from exogauge.payload.prepare import declared_of, std_of
from exogauge.payload.sensor_motion import Chain
from exogauge.payload.smoothing import likeliest, shown_std
from exogauge.payload.stages import prior_of, stated_sign
from exogauge.payload.statics import Holds

Array = NDArray[np.float64]

RELEASED = slice(10, 16)


def open_start(path: Path) -> tuple[PayloadFile, Start]:
    """path: payload.yaml, or its folder. Raises BadInput, NotIdentifiable."""
    payload = open_payload(path, roles=("postures", "excitation"))
    return payload.file, start_of(payload)


def start_of(payload: Payload, criteria: Criteria = USUAL) -> Start:
    """gravity, sign and prior by the recipe for logs; level, as stated and next to nothing without any."""
    pose, settings = payload.file.pose, payload.file.settings
    if payload.tree is None and pose.position is None:
        advice = "Send joint angles with a URDF, or name `pose.position`; an IMU is for logs."
        detail = "live, without joint angles or a position nothing says how the sensor accelerates"
        raise BadStudy(Fault(detail, "no_acceleration", advice, payload.name, None, "pose"))
    gravity, prior = np.array(payload.file.gravity), static_prior(None, criteria=criteria.payload_dynamic)
    believed, late, filtered = np.sqrt(np.diag(prior.covariance)), None, None
    calibration: Calibration = uncalibrated(declared_of(payload.file, criteria))
    in_doubt: tuple[str, ...] = ()
    memory, in_motion = 1.0, False
    zero: str = settings.zero
    if payload.recordings:
        found = evaluate(replace(payload, recordings=tuple(_identifying(payload))), criteria=criteria)
        late, filtered = _late(found)
        sign, stages = found.sign, found.stages
        zero = "drifted" if _of_zeros(found) else zero
        if late is None and found.rigid is not None and not found.missing.calibrated and not _of_zeros(found):
            # but for a delay, the sensor's calibration and a zero, what was named missing is not taken out live
            stages = found.rigid
        assert stages.calibration is not None
        assert stages.exact is not None
        calibration, stages, in_doubt = stages.calibration, stages.exact, _in_doubt(found)
        gravity = stages.gravity
        if stages.postures is not None:
            prior = prior_of(payload, stages.postures, criteria)
            believed[4:10] = np.sqrt(np.diag(prior.covariance)[4:10])
            memory = _memory(payload, stages.postures.holds, criteria)
        in_motion = stages.excitation is not None
        if stages.excitation is not None:
            prior = _after(stages.excitation.chosen, zero, criteria.payload_dynamic)
    else:
        sign = stated_sign(payload)
    return Start(
        pose_of(payload, criteria), gravity, sign, std_of(payload), prior, believed,
        settings.false_alarms_per_hour, criteria, late, filtered, calibration, memory, in_doubt, in_motion,
    )  # fmt: skip


def pose_of(payload: Payload, criteria: Criteria = USUAL) -> Pose:
    """Its channels, with the noise and the jerk that its logs show."""
    chain = None if payload.tree is None else Chain.of(payload.tree, payload.file.sensor.frame or "")
    return Pose(chain, *_channels(payload, criteria), _even_period(payload))


def _in_doubt(found: Evaluation) -> tuple[str, ...]:
    """What logs say is missing, and is not taken out live nor held by the doubt of the sensor's calibration."""
    missing = found.missing
    if missing.decision.verdict == "unexplained":
        return ("The logs leave something that nothing explains: what is told live does not hold.",)
    taken = {"gain", "crosstalk", "calibration", *(["delay"] if _late(found)[0] is not None else [])}
    taken |= {"zero_of_log", "zero_step"} if _of_zeros(found) else set()
    names = [name_of(each.effect, each.place) for each in missing.found if each.effect not in taken]
    if not names:
        return ()
    return (f"By the logs: {'; '.join(names)}. That is not taken out live: what is told does not hold.",)


def _of_zeros(found: Evaluation) -> bool:
    """Whether logs say that the zero is another one now and then, and that nothing else is missing: a stream then
    begins with none."""
    names = [each.effect for each in found.missing.found]
    return found.missing.in_the_model and all(name.startswith("zero") for name in names)


Pair = tuple[float, float] | None


def _late(found: Evaluation) -> tuple[Pair, Pair]:
    """[s] by which wrenches are late, and its std, where logs say that, and that nothing else is missing; [s²] variance
    of the response of what delays them, and its std."""
    named = {each.effect: each.parameters for each in found.missing.found}
    if not found.missing.in_the_model or set(named) != {"delay"}:
        return None, None
    delay, variance = named["delay"]  # [ms], [ms²]
    return (1e-3 * delay.value, 1e-3 * delay.std), (1e-6 * variance.value, 1e-6 * variance.std)


def _memory(payload: Payload, holds: Holds, criteria: Criteria) -> float:
    """Samples at rest that count as one, where that is surely more than one: halves of postures differ so."""
    logs = [each for each in payload.of("postures") if not each.each_row]
    if holds.unrest is None or holds.noise is None or holds.spans is None or not logs or not holds.noise.all():
        return 1.0
    period = float(np.median(np.diff(logs[0].wrench.time)))
    count = float(np.median(np.diff(holds.spans, axis=1))) / period + 1.0
    found = float(np.mean(count * (holds.unrest / holds.noise) ** 2))
    chance = criteria.payload_static.unrest_stds * np.sqrt(2.0 / (6.0 * len(holds)))
    return found if found > 1.0 + chance else 1.0


def _identifying(payload: Payload) -> list[Recording]:
    return [*payload.of("postures"), *payload.of("excitation")]


def _after(found: DynamicSolution, zero: str, criteria: Moving) -> Prior:
    """What the excitation left known; a zero that drifts is then another one again."""
    covariance, lean = found.covariance.copy(), found.lean.copy()
    if zero == "drifted":
        covariance[RELEASED], covariance[:, RELEASED] = 0.0, 0.0
        covariance[RELEASED, RELEASED] = criteria.released**2 * np.eye(6)
        lean[RELEASED] = 0.0
    return Prior(found.value, covariance, lean)


def _channels(payload: Payload, criteria: Criteria) -> tuple[Array, Array]:
    """(K,) std and jerk density of the channels of a pose."""
    file = payload.file
    logs = [each for each in (*payload.of("excitation"), *payload.of("postures")) if not each.each_row]
    angles = len(file.pose.joints or ()) or 9
    stated = file.settings.jerk_density
    stds, turned = _shown([each.pose for each in logs], angles, file.pose.noise_rad, criteria)
    if payload.tree is not None:
        return stds, turned if stated is None else np.full(angles, stated)
    positions = [each.position for each in logs if each.position is not None]
    std_moved, moved = _shown(positions, 3, file.pose.noise_m, criteria)
    std = np.concatenate([np.full(9, stds.max()), std_moved])
    return std, np.concatenate([np.full(9, turned.max()), np.full(3, stated or moved.max())])


def _even_period(payload: Payload) -> float | None:
    """Of logs whose stamps jittered though samples were taken evenly."""
    steps = [np.median(np.diff(each.pose.time)) for each in payload.recordings if each.evened > 0.0]
    return float(np.median(steps)) if steps else None


def _shown(streams: Sequence[Stream], channels: int, std: float, criteria: Criteria) -> tuple[Array, Array]:
    """(K,) noise and jerk density of each, in the first log that moves it; as stated and the largest of all where none
    does."""
    stds, found = np.full(channels, std), np.zeros(channels)
    for each in streams:
        inside = each.time <= each.time[0] + criteria.payload_live.judged_s
        time, values = each.time[inside], each.values[inside]
        period = float(np.median(np.diff(time)))
        step = np.concatenate([[1.0], np.diff(time)]) / period
        for k in np.flatnonzero(found == 0.0):
            from_first = values[:, k] - values[0, k]
            if np.ptp(from_first) >= criteria.payload_dynamic.still_noises * std:
                stds[k] = shown_std(from_first, step, std, criteria.payload_dynamic)
                found[k] = likeliest(np.ascontiguousarray(from_first / stds[k]), step) * stds[k] ** 2 / period**5
    return stds, np.where(found > 0.0, found, found.max() or criteria.payload_live.density)
