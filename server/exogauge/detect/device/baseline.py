"""Where the search for effects of bands begins: one wear's logs, its bands fitted, how far joints are believed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.detect.device.logs import Approach, Course, WearLog, WearLogs
from exogauge.detect.device.model import Fitted, Setting, Wear, believed, fit
from exogauge.detect.device.uncovered_joints import Beyond
from exogauge.devices.device import Device
from exogauge.devices.result import StiffnessResult
from exogauge.devices.routing import Routing
from exogauge.identification.model import RobotModel
from exogauge.logs.filtering import LowPass
from exogauge.support.band_doubt import autocovariance
from exogauge.support.evaluate import LEAST_SIGMA, Gathered
from exogauge.support.evidence import Evidence

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

DENSE = 12.0  # samples in a period of the cut-off: what rubs is followed from sample to sample
WEIGHINGS = 2  # of fitting and weighing the joints by what is left


@final
@dataclass(frozen=True)
class Ground:
    """One wear. floor: (D,) [N·m] what the approach finds in steady motion where there is nothing, and what doubt of
    the robot's parameters makes of it with the wear on: a motor gain that is 1 % off is 1 % of the support. sigma: (D,)
    of the weights, memory: (D,) samples that count as one. null: the logs without the wear as if it were on, for B."""

    device: Device
    approach: Approach
    model: RobotModel
    setting: Setting
    fitted: Fitted
    floor: Array
    sigma: Array
    memory: Array
    null: WearLogs | None

    @property
    def joints(self) -> tuple[str, ...]:
        return self.setting.logs.names


def lay_ground(
    model: RobotModel,
    gathered: Gathered,
    device: Device,
    stiffness: Sequence[StiffnessResult],
    beyond: Beyond | None = None,
) -> Ground | None:
    """None where no log with the device has a sample that counts. beyond: further joints to look at."""
    own = [each for each in gathered.evidences if each.worn.device.name == device.name]
    approach: Approach = "A" if all(each.a is not None and each.compared.any() for each in own) else "B"
    joints, names = gathered.joints, list(gathered.names)
    if beyond is not None:
        joints, names = np.concatenate([joints, beyond.joints]), [*names, *beyond.names]
    logs = WearLogs([_log(each, approach, beyond, model.cutoff_hz) for each in own], joints, names)
    if not logs.used.any():
        return None
    routing = Routing(model.robot.tree, device.bands)
    wires = tuple(logs.wire(Course("band", band.name, routing, b)) for b, band in enumerate(device.bands))
    start = _start(device, stiffness, approach)
    floor = _floor(gathered, own, approach)
    if beyond is not None:
        floor = np.concatenate([floor, beyond.floor_a if approach == "A" else beyond.floor_b])
    floor = np.hypot(floor, _of_the_robot(model, logs))
    travel = np.array([wire.travel for wire in wires])
    belief = believed(device.bands, start, travel)
    sigma, memory = np.maximum(floor, LEAST_SIGMA), np.ones(len(names))
    for _ in range(WEIGHINGS):
        weight, independent = weights(logs, sigma, memory)
        setting = Setting(logs, device.bands, wires, weight, independent, belief)
        fitted = fit(setting, start)
        sigma, memory = spread(logs, fitted.e, floor), memories(logs, fitted.e)
    null = _null_logs(gathered, own, beyond) if approach == "B" else None
    ground = Ground(device, approach, model, setting, fitted, floor, sigma, memory, null)
    return weighed(ground, fitted)


def whitened(ground: Ground) -> tuple[Setting, Fitted]:
    """As if every sample's error were its own: to choose by what is worth a closer look. What is missing has a memory
    of its own, which must not count against it."""
    weight, independent = weights(ground.setting.logs, ground.sigma, np.ones_like(ground.memory))
    setting = replace(ground.setting, weight=weight, independent=independent)
    return setting, fit(setting, ground.fitted.wear)


def weighed(ground: Ground, fitted: Fitted) -> Ground:
    """The same ground with every joint weighed by what a fit leaves on it, and fitted so."""
    logs = ground.setting.logs
    sigma, memory = spread(logs, fitted.e, ground.floor), memories(logs, fitted.e)
    weight, independent = weights(logs, sigma, memory)
    setting = replace(ground.setting, weight=weight, independent=independent)
    return replace(ground, setting=setting, fitted=fit(setting, fitted.wear), sigma=sigma, memory=memory)


def weights(logs: WearLogs, sigma: Array, memory: Array) -> tuple[Array, float]:
    """(N, D) 1/(σ² memory) of the samples that count, and how many independent errors they are."""
    return logs.used / (sigma**2 * memory), float(np.sum(logs.used / memory))


def memories(logs: WearLogs, e: Array) -> Array:
    """(D,) samples of a joint's residual that count as one: their integral correlation time, mean over the logs."""
    result = np.ones(e.shape[1])
    for joint in range(e.shape[1]):
        found = []
        for log in range(len(logs.logs)):
            own = (logs.log == log) & logs.used[:, joint]
            if own.sum() > 10:
                whole = logs.log == log
                c = autocovariance(np.where(own, e[:, joint], 0.0)[whole], own[whole])
                found.append((1.0 + 2.0 * float(np.sum(c[1:])) / max(float(c[0]), 1e-300), int(own.sum())))
        if found:
            value, count = np.array(found).T
            result[joint] = max(1.0, float(np.average(value, weights=count)))
    return result


def spread(logs: WearLogs, e: Array, floor: Array) -> Array:
    """(D,) [N·m] RMS of residuals e (N, D) where they count, at least the floor."""
    square = np.sum(np.where(logs.used, e, 0.0) ** 2, axis=0) / np.maximum(logs.used.sum(axis=0), 1)
    return np.asarray(np.maximum(np.sqrt(square), np.maximum(floor, LEAST_SIGMA)))


def _log(evidence: Evidence, approach: Approach, beyond: Beyond | None, cutoff_hz: float) -> WearLog:
    log, kept = evidence.worn.log, evidence.kept
    dense, step = _dense(kept, log.samples, log.rate_hz / (DENSE * cutoff_hz))
    torque, used = evidence.b, evidence.steady
    if approach == "A":
        assert evidence.a is not None
        torque, used = evidence.a, evidence.compared & np.isfinite(evidence.a)
    pair = np.where(used, torque, 0.0)[kept], used[kept]
    if beyond is not None:
        pair = _beside(pair, (beyond.a if approach == "A" else beyond.b)[evidence.worn.log.name])
    return WearLog(
        name=log.name,
        motion=evidence.worn.motion,
        time=evidence.time[dense] - evidence.time[0],
        posture=evidence.posture[dense],
        kept=np.searchsorted(dense, kept),
        torque=pair[0],
        used=pair[1],
        sloped=np.searchsorted(kept, evidence.sloped),
        slope=evidence.slope_a if approach == "A" else evidence.slope_b,
        low_pass=LowPass(cutoff_hz, log.rate_hz / step, stored=log.stored),
    )


def _dense(kept: NDArray[np.intp], samples: int, most: float) -> tuple[NDArray[np.intp], int]:
    """Every n-th sample, the kept ones among them; and n, at most `most`."""
    apart = int(np.gcd.reduce(np.diff(kept))) if len(kept) > 1 else 1
    step = max(n for n in range(1, apart + 1) if apart % n == 0 and n <= max(most, 1.0))
    first = int(kept[0]) % step if len(kept) else 0
    return np.arange(first, samples, step), step


def _beside(own: tuple[Array, BoolArray], more: tuple[Array, BoolArray]) -> tuple[Array, BoolArray]:
    return np.hstack([own[0], more[0]]), np.hstack([own[1], more[1]])


def _null_logs(gathered: Gathered, own: Sequence[Evidence], beyond: Beyond | None) -> WearLogs:
    motions = {each.worn.motion for each in own}
    logs, places = list[WearLog](), dict[str, int]()
    for each in gathered.nothings:
        place = places[each.motion] = places.get(each.motion, -1) + 1
        if each.motion in motions:
            pair = np.where(each.steady, each.b, 0.0), each.steady
            if beyond is not None:
                pair = _beside(pair, beyond.null[each.motion][place])
            nothing = np.zeros(0, dtype=np.intp)
            time, kept = each.time - each.time[0], np.arange(len(each.time))
            logs.append(WearLog("", each.motion, time, each.posture, kept, pair[0], pair[1], nothing, None))
    joints, names = gathered.joints, list(gathered.names)
    if beyond is not None:
        joints, names = np.concatenate([joints, beyond.joints]), [*names, *beyond.names]
    return WearLogs(logs, joints, names, share=len(own) / max(len(logs), 1))


def _floor(gathered: Gathered, own: Sequence[Evidence], approach: Approach) -> Array:
    """(D,) [N·m] over those motions of these logs in which the joint moves steadily. Of a motion that was recorded
    once, A's is what the model and that one run say; those that were repeated, in which the joint may hardly move, do
    not make it less."""
    repeats = [gathered.backgrounds[motion].repeats for motion in dict.fromkeys(each.worn.motion for each in own)]
    if approach == "B":
        return _rms_of_seen([each.by_model_steady for each in repeats])
    runs = [np.sqrt(2.0) * each.by_model_steady if each.between_runs_steady is None else each.between_runs_steady
            for each in repeats]  # fmt: skip
    once = [one for one, each in zip(runs, repeats, strict=True) if each.between_runs_steady is None]
    return np.maximum(_rms_of_seen(runs), _rms_of_seen(once)) if once else _rms_of_seen(runs)


def _rms_of_seen(floors: Sequence[Array]) -> Array:
    """(D,) 0: not seen."""
    seen = np.sum([each > 0.0 for each in floors], axis=0)
    return np.asarray(np.sqrt(np.sum(np.square(floors), axis=0) / np.maximum(seen, 1)))


def _of_the_robot(model: RobotModel, logs: WearLogs) -> Array:
    """(D,) [N·m] RMS that the doubt of the robot's parameters makes of the torque, where its slopes are known."""
    square, count = np.zeros(len(logs.names)), np.zeros(len(logs.names))
    for log in logs.logs:
        if log.slope is not None:
            own = log.slope.astype(np.float64)
            used = log.used[log.sloped, : own.shape[1]]
            variance = np.einsum("ndp,pq,ndq->nd", own, model.covariance, own, optimize=True)
            square[: own.shape[1]] += np.sum(np.where(used, variance, 0.0), axis=0)
            count[: own.shape[1]] += used.sum(axis=0)
    return np.asarray(np.sqrt(np.maximum(square, 0.0) / np.maximum(count, 1.0)))


def _start(device: Device, stiffness: Sequence[StiffnessResult], approach: Approach) -> Wear:
    """As identified by the approach; as stated where the data did not decide."""
    result = next(each for each in stiffness if each.device == device.name and each.approach == approach)
    k, l_0 = [], []
    for band, found in zip(device.bands, result.bands, strict=True):
        use_stated = band.stiffness is not None and not found.identifiable
        k.append(band.stiffness if use_stated and band.stiffness else max(found.stiffness.value, 1.0))
        use_stated = band.natural_length is not None and not found.length_identifiable
        l_0.append(band.natural_length if use_stated and band.natural_length else found.natural_length.value)
    return Wear(np.array(k), np.array(l_0))
