"""Whether the device was on where study.yaml says so: the torque that the robot's model misses in a log, held against
how the device's bands would pull there.

    level = Σ s b / Σ s²,    likeness = Σ s b / √(Σ s² Σ b²)

s: (n, D) torque of the bands as described, up to one factor; b: (n, D) what the model leaves, in steady motion. Levels
are compared within a motion: the bands of one device pull alike in all logs that it was on in, and not at all in the
others, if the robot was identified without it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.supporting import Supporting
from exogauge.devices.device import Device
from exogauge.devices.routing import Routing
from exogauge.identification.model import RobotModel
from exogauge.remarks import About, Remark
from exogauge.support.evidence import Evidence
from exogauge.support.repeatability import Plain

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@final
@dataclass(frozen=True)
class Missed:
    """Of one log: (n, J) posture, (n, D) torque that the model misses [N·m], and where it counts."""

    log: str
    posture: Array
    torque: Array
    counts: BoolArray


@final
@dataclass(frozen=True)
class Level:
    """In units of the bands as described."""

    log: str
    level: float
    likeness: float


def notes_on_labels(
    model: RobotModel, names: Sequence[str], evidences: Sequence[Evidence], plains: Sequence[Plain], motion: str
) -> list[Remark]:
    """Of one motion. names: of the D joints."""
    bare = [_of_plain(each) for each in plains if each.motion == motion]
    found = list[Remark]()
    for device in {each.worn.device.name: each.worn.device for each in evidences}.values():
        worn = [_of_evidence(each) for each in evidences if each.worn.device.name == device.name]
        levels = _levels(model, device, names, [*worn, *bare])
        found += said(levels[: len(worn)], levels[len(worn) :], device.name, model.criteria.support)
    return found


def said(worn: Sequence[Level], bare: Sequence[Level], device: str, criteria: Supporting) -> list[Remark]:
    """worn, bare: logs of one motion, by what study.yaml says of them."""
    most = max((abs(each.level) for each in (*worn, *bare)), default=0.0)
    if not worn or not bare or most <= 0.0:
        return []

    def pulls(each: Level, sign: float) -> bool:
        return sign * each.level > criteria.label_pulls * most and sign * each.likeness > criteria.label_likeness

    on, off = (
        [each.log for each in bare if pulls(each, 1.0)],
        [each.log for each in worn if _none(each, most, criteria)],
    )
    if on and off:
        return [Remark(About.LABELS_EXCHANGED, (*off, *on), beside=(device,))]
    if on:
        return [Remark(About.DEVICE_ON, tuple(on), beside=(device,))]
    if all(pulls(each, -1.0) for each in bare):
        return [Remark(About.DEVICE_ON_WHERE_FITTED, tuple(each.log for each in bare), beside=(device,))]
    if off and len(off) < len(worn):
        return [Remark(About.DEVICE_OFF, tuple(off), beside=(device,))]
    return []


def _none(each: Level, most: float, criteria: Supporting) -> bool:
    return abs(each.level) < criteria.label_none * most


def _of_evidence(each: Evidence) -> Missed:
    kept = each.kept
    return Missed(each.worn.log.name, each.posture[kept], each.b[kept], each.steady[kept])


def _of_plain(each: Plain) -> Missed:
    own, kept = each.balance, each.balance.prepared.kept
    return Missed(each.name, own.prepared.motion.q[kept], own.torque[kept], own.steady[kept])


def _levels(model: RobotModel, device: Device, names: Sequence[str], logs: Sequence[Missed]) -> list[Level]:
    routing = Routing(model.robot.tree, device.bands)
    geometries = [routing.geometry(each.posture) for each in logs]
    lengths = np.concatenate([each.length for each in geometries])
    shortest, longest = lengths.min(axis=0), lengths.max(axis=0)
    stated = [band.natural_length for band in device.bands]
    begins = [
        low if natural is None or not low < natural < high else natural
        for natural, low, high in zip(stated, shortest, longest, strict=True)
    ]
    sizes = [band.stiffness for band in device.bands]
    stiffness = np.ones(len(sizes)) if None in sizes else np.array(sizes, dtype=np.float64)
    columns, found = [names.index(name) for name in routing.joints], list[Level]()
    for each, geometry in zip(logs, geometries, strict=True):
        tension = stiffness * np.maximum(geometry.length - np.array(begins), 0.0)
        s = np.zeros(each.torque.shape)
        s[:, columns] = -np.einsum("nw,nwd->nd", tension, geometry.jacobian)
        counts = each.counts & np.isfinite(each.torque)
        s, b = s[counts], each.torque[counts]
        both = float(s @ s), float(b @ b)
        if min(both) > 0.0:
            found.append(Level(each.log, float(s @ b) / both[0], float(s @ b) / float(np.sqrt(both[0] * both[1]))))
        else:
            found.append(Level(each.log, 0.0, 0.0))
    return found
