"""Where the search for effects of bands begins: one wear's logs, its bands fitted, how far joints are believed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.detect.device.uncovered_joints import Beyond
from exogauge.devices.device import Device
from exogauge.devices.result import Approach, StiffnessResult
from exogauge.devices.routing import Routing
from exogauge.identification.model import RobotModel
from exogauge.support.band_fit import USUAL_STIFFNESS, BandFit, null_test
from exogauge.support.band_model import Fitted, Setting, Wear, believed, declared_laws, each_its_own, fit
from exogauge.support.band_rows import WearLogs, band_wires
from exogauge.support.band_weights import LEAST_SIGMA, memories, spread, weights
from exogauge.support.evaluate import Gathered
from exogauge.support.evidence import Evidence
from exogauge.support.rows_of_approach import rows_with, rows_without

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


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

    def unit(self, joint: int) -> str:
        """Of the torque on it."""
        return "N" if self.joints[joint] in self.model.robot.tree.sliding else "N·m"

    @property
    def fit(self) -> BandFit:
        null = null_test(self.null, self.setting, self.fitted, 1.0 / (self.sigma**2 * self.memory))
        return BandFit(self.model.doubt, null, self.setting, self.fitted)

    def deviations(self, fitted: Fitted) -> Array:
        """(P,) standard deviations."""
        return np.sqrt(np.maximum(np.diag(self.fit.covariance(fitted)), 0.0))


def lay_ground(
    model: RobotModel,
    gathered: Gathered,
    device: Device,
    stiffness: Sequence[StiffnessResult],
    beyond: Beyond | None = None,
) -> Ground | None:
    """None where no log with the device has a sample that counts. beyond: further joints to look at."""
    weighings = 2  # of fitting and weighing the joints by what is left
    own = [each for each in gathered.evidences if each.worn.device.name == device.name]
    approach: Approach = "A" if all(each.a is not None and each.compared.any() for each in own) else "B"
    joints, names = gathered.joints, list(gathered.names)
    if beyond is not None:
        joints, names = np.concatenate([joints, beyond.joints]), [*names, *beyond.names]
    beside = None if beyond is None else beyond.a if approach == "A" else beyond.b
    zero = model.robot.torque_zero[joints]
    logs = rows_with(own, approach, joints, names, model.cutoff_hz, beside, zero)
    if not logs.used.any():
        return None
    wires = band_wires(logs, Routing(model.robot.tree, device.bands))
    start = _start(device, stiffness, approach)
    floor = _floor(gathered, own, approach)
    if beyond is not None:
        floor = np.concatenate([floor, beyond.floor_a if approach == "A" else beyond.floor_b])
    floor = np.hypot(floor, _of_the_robot(model, logs))
    travel = np.array([wire.travel for wire in wires])
    belief = believed(device.bands, start, travel)
    sigma, memory = np.maximum(floor, LEAST_SIGMA), np.ones(len(names))
    for _ in range(weighings):
        weight, independent = weights(logs, sigma, memory)
        setting = Setting(logs, wires, weight, independent, belief)
        fitted = fit(setting, start)
        sigma, memory = spread(logs, fitted.e, floor), memories(logs, fitted.e)
    without = None if beyond is None else beyond.null
    null = rows_without(gathered.nothings, own, "B", joints, names, without, zero) if approach == "B" else None
    ground = Ground(device, approach, model, setting, fitted, floor, sigma, memory, null)
    return weighed(ground, fitted)


def whitened(ground: Ground) -> tuple[Setting, Fitted]:
    """As if every sample's error were its own: to choose by what is worth a closer look. What is missing has a memory
    of its own, which must not count against it."""
    weight, independent = weights(ground.setting.logs, ground.sigma, np.ones_like(ground.memory))
    setting = replace(ground.setting, weight=weight, independent=independent)
    return setting, fit(setting, ground.fitted)


def weighed(ground: Ground, fitted: Fitted) -> Ground:
    """The same ground with every joint weighed by what a fit leaves on it, and fitted so."""
    logs = ground.setting.logs
    sigma, memory = spread(logs, fitted.e, ground.floor), memories(logs, fitted.e)
    weight, independent = weights(logs, sigma, memory)
    setting = replace(ground.setting, weight=weight, independent=independent)
    return replace(ground, setting=setting, fitted=fit(setting, fitted), sigma=sigma, memory=memory)


def _floor(gathered: Gathered, own: Sequence[Evidence], approach: Approach) -> Array:
    """(D,) [N·m] over those motions of these logs in which the joint moves steadily. Of a motion that was recorded
    once, A's is what the model and that one run say; those that were repeated, in which the joint may hardly move, do
    not make it less."""
    repeats = [gathered.backgrounds[motion].repeats for motion in dict.fromkeys(each.worn.motion for each in own)]
    if approach == "B":
        return _rms_of_seen([each.b.steady for each in repeats])
    runs = [each.between_runs_steady for each in repeats]
    once = [each.between_runs_steady for each in repeats if each.a is None]
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
            variance = np.einsum("ndp,pq,ndq->nd", own, model.doubt, own, optimize=True)
            variance += sum(np.sum(each.astype(np.float64) ** 2, axis=2) for each in log.inputs)
            square[: own.shape[1]] += np.sum(np.where(used, variance, 0.0), axis=0)
            count[: own.shape[1]] += used.sum(axis=0)
    return np.asarray(np.sqrt(np.maximum(square, 0.0) / np.maximum(count, 1.0)))


def _start(device: Device, stiffness: Sequence[StiffnessResult], approach: Approach) -> Wear:
    """As identified by the approach; as stated where the data did not decide."""
    result = next(each for each in stiffness if each.device == device.name and each.approach == approach)
    k, l_0 = list[float](), list[float]()
    for band, found in zip(device.bands, result.bands, strict=True):
        k.append(_believable(found.stiffness.value, found.identifiable, band.stiffness, USUAL_STIFFNESS))
        length = found.natural_length.value
        l_0.append(_believable(length, found.length_identifiable, band.natural_length, found.longest))
    return Wear(each_its_own(device.bands), np.array(k + l_0), declared_laws(device.bands))


def _believable(value: float, decided: bool, stated: float | None, otherwise: float) -> float:
    if stated and not decided:
        return stated
    return max(value, 1e-3) if np.isfinite(value) else otherwise
