"""Supporting torque on joints that no declared band crosses: where one that nobody declared may pull."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.model import RobotModel
from exogauge.identification.preparation import Prepared
from exogauge.robots.tree import IntArray
from exogauge.support.balance import Balance, balance, prepare_worn
from exogauge.support.difference import difference
from exogauge.support.evaluate import Gathered
from exogauge.support.evidence import Evidence
from exogauge.support.repeatability import Plain, repeatability
from exogauge.support.same_motion import Posture
from exogauge.support.settings import PlainLog, SupportSettings

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@final
@dataclass(frozen=True)
class Beyond:
    """joints: (D,) columns of q, names: theirs. a, b: log with the wear -> (n, D) [N·m] at its kept samples and where
    it counts; a holds only logs that were compared. null: motion -> the same of its logs without the wear, in order.
    floor_a, floor_b: (D,) [N·m] what is found where there is nothing."""

    joints: IntArray
    names: tuple[str, ...]
    a: Mapping[str, tuple[Array, BoolArray]]
    b: Mapping[str, tuple[Array, BoolArray]]
    null: Mapping[str, Sequence[tuple[Array, BoolArray]]]
    floor_a: Array
    floor_b: Array


def look_beyond(
    model: RobotModel, gathered: Gathered, plain: Sequence[PlainLog], settings: SupportSettings
) -> Beyond | None:
    """None where the motions with the wear move no other joint whose torque is logged."""
    moved = np.max([np.ptp(each.posture, axis=0) for each in gathered.evidences], axis=0)
    logged = np.array([joint.actuation != "none" for joint in model.robot.joints])
    joints = np.setdiff1d(np.flatnonzero(logged & (moved > model.criteria.device.joint_moves)), gathered.joints)
    if not len(joints):
        return None
    a, b = dict[str, tuple[Array, BoolArray]](), dict[str, tuple[Array, BoolArray]]()
    null, floors = dict[str, Sequence[tuple[Array, BoolArray]]](), list[tuple[Array, Array]]()
    for motion in dict.fromkeys(each.worn.motion for each in gathered.evidences):
        own = [each for each in gathered.evidences if each.worn.motion == motion]
        chosen = [each for each in plain if each.motion == motion] or [each for each in plain if each.held_out] or plain
        plains = [
            Plain(_thin(model, model.prepare(each.log), joints), Posture(each.log, gathered.names), each.motion)
            for each in chosen
        ]
        repeats = repeatability(plains, np.zeros(len(joints)), settings)
        floors.append((repeats.between_runs_steady, repeats.b.steady))
        null[motion] = [_kept(each.balance, each.balance.torque, each.balance.steady) for each in plains]
        for each in own:
            _look(model, each, plains, joints, a, b)
    floor_a, floor_b = (np.max([pair[k] for pair in floors], axis=0) for k in (0, 1))
    names = tuple(model.robot.joints[j].name for j in joints)
    return Beyond(joints, names, a, b, null, floor_a, floor_b)


def _look(
    model: RobotModel,
    evidence: Evidence,
    plains: Sequence[Plain],
    joints: IntArray,
    a: dict[str, tuple[Array, BoolArray]],
    b: dict[str, tuple[Array, BoolArray]],
) -> None:
    own = _thin(model, prepare_worn(model, evidence.worn.log), joints)
    name = evidence.worn.log.name
    b[name] = _kept(own, own.torque, own.steady)
    reference = next((each for each in plains if each.name == evidence.reference), None)
    if reference is not None and evidence.found is not None:
        since = own.time - own.time[0] + evidence.found.lag_s
        clock = reference.balance.time - reference.balance.time[0]
        inside = np.flatnonzero((since >= 0.0) & (since <= clock[-1]))
        first, last = (int(inside[0]), int(inside[-1]) + 1) if inside.size else (0, 0)
        apart = difference(own, reference.balance, replace(evidence.found, first=first, last=last))
        used = apart.compared & np.isfinite(apart.torque)
        a[name] = _kept(own, np.where(used, apart.torque, 0.0), used)


def _thin(model: RobotModel, prepared: Prepared, joints: IntArray) -> Balance:
    """The balance of a log at about 40 Hz, the kept samples among them."""
    rate_hz = 40.0  # at which a log is looked at: supporting torques are low-passed
    kept = prepared.kept
    every = int(kept[1] - kept[0]) if len(kept) > 1 else 1
    steps = [n for n in range(1, every + 1) if every % n == 0]
    step = min(steps, key=lambda n: abs(n - prepared.log.rate_hz / rate_hz))
    samples = np.arange(int(kept[0]) % step, prepared.log.samples, step)
    changed: dict[str, object] = {
        each.name: value[samples]
        for each in fields(prepared)
        if isinstance(value := getattr(prepared, each.name), np.ndarray) and len(value) == prepared.log.samples
    }
    changed["motion"] = prepared.motion.rows(samples)
    changed["log"] = replace(prepared.log, time=prepared.log.time[samples], channels={})
    changed["kept"] = np.searchsorted(samples, kept)
    return balance(model, replace(prepared, **changed), joints)  # type: ignore[arg-type]


def _kept(own: Balance, torque: Array, used: BoolArray) -> tuple[Array, BoolArray]:
    kept = own.prepared.kept
    return np.where(used, torque, 0.0)[kept], used[kept]
