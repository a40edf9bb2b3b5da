"""What is declared because no log shows it, as columns of torque: of each log's motors and sensors, and of how a device
sits: where its via points are, and how it was put on each time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.device import Band
from exogauge.devices.routing import Routing
from exogauge.support.band_model import NEAR, SEARCHED
from exogauge.support.band_rows import WearLog, WearLogs, Wire
from exogauge.support.evidence import ALIKE, on_joints

Array = NDArray[np.float64]

VIA_POINTS, DONNING = "via_points", "donning"


@final
@dataclass(frozen=True)
class Inputs:
    """[N·m] of one standard deviation of each of K independent inputs, by the name of what is declared.

    own: by log, (n, D, K) of its n samples: another input in each log. common: (N, D, K): the same in all. constant:
    (W,) [m] of a band's length as via points alone leave it, the same in all postures: a natural length goes with it.
    """

    own: Sequence[Mapping[str, Array]]
    common: Mapping[str, Array]
    constant: Array

    def scores(self, logs: WearLogs, told: Array) -> dict[str, Array]:
        """Name -> (P, P) covariance of the score that the inputs make. told: (N, D, P) weighted slopes."""
        found: dict[str, Array] = {}
        for place, own in enumerate(self.own):
            here = told[logs.log == place]
            for name, each in own.items():
                moved = np.tensordot(here, each, axes=((0, 1), (0, 1)))
                found[name] = found.get(name, np.zeros((len(moved), len(moved)))) + moved @ moved.T
        for name, each in self.common.items():
            moved = np.tensordot(told, each, axes=((0, 1), (0, 1)))
            found[name] = found.get(name, 0.0) + moved @ moved.T
        return found


def inputs_of(logs: WearLogs, wires: Sequence[Wire], k: Array, l_0: Array) -> Inputs | None:
    """None where nothing is declared. wires: the declared bands first; k: (W,) [N/m], l_0: (W,) [m] of those."""
    own, alike = _of_the_session(logs)
    longer: list[list[Array]] = [[] for _ in logs.logs]
    points, constants = list[Array](), np.zeros(len(k))
    for b, (wire, stiffness, length) in enumerate(zip(wires, k, l_0, strict=False)):
        band = None if wire.course.routing is None else wire.course.routing.bands[wire.course.index]
        if band is None or not (band.donning_std or band.point_std):
            continue
        pull, taut = stiffness * wire.stretch(length), wire.taut(length)
        of_length = -wire.jacobian * (stiffness * taut)[:, None]
        for place in range(len(logs.logs)):
            if band.donning_std > 0.0:
                longer[place].append(band.donning_std * of_length[logs.log == place])
        if band.point_std > 0.0:
            moved = [_moved_points(wire, band, log, logs) for log in logs.logs]
            jacobian, lengths = (np.concatenate(each) for each in zip(*moved, strict=True))
            points.append(band.point_std * (of_length[:, :, None] * lengths[:, None] - jacobian * pull[:, None, None]))
            constants[b] = band.point_std * float(np.linalg.norm(taut @ lengths) / max(float(taut.sum()), 1e-300))
    for place, each in enumerate(longer):
        if each:
            own[place][DONNING] = np.stack(each, axis=2)
    if not points and not alike and not any(own):
        return None
    common = alike | ({VIA_POINTS: np.concatenate(points, axis=2)} if points else {})
    return Inputs(own, common, constants)


def _of_the_session(logs: WearLogs) -> tuple[list[dict[str, Array]], dict[str, Array]]:
    """What motors and sensors do: by log, its own part, and the part that all of these logs have in common."""
    own, alike = [dict[str, Array]() for _ in logs.logs], dict[str, Array]()
    for name in dict.fromkeys(name for log in logs.logs for name in log.own):
        most = max(log.own[name].shape[2] for log in logs.logs if name in log.own)
        of_logs = [_at_kept(log, name, (len(logs.joints), most)) for log in logs.logs]
        live = np.any([each.any(axis=(0, 1)) for each in of_logs], axis=0)
        common, _, what = name.rpartition(".")
        if common == ALIKE:
            alike[what] = np.concatenate([each[:, :, live] for each in of_logs])
            continue
        for of_log, each in zip(own, of_logs, strict=True):
            of_log[name] = each[:, :, live]
    return own, alike


def _at_kept(log: WearLog, name: str, shape: tuple[int, int]) -> Array:
    """(n, D, K) of one declared uncertainty; further joints, beside those that the device acts on, feel nothing."""
    found = np.zeros((len(log.kept), *shape))
    if name in log.own:
        own = _between(log.own[name], np.asarray(log.sloped, dtype=np.float64), log)
        found[:, : own.shape[1], : own.shape[2]] = own
    return found


def _nodes(log: WearLog, step: int) -> Array:
    """(m,) places among the kept samples: every n-th, and the last."""
    last = len(log.kept) - 1
    return np.unique(np.append(np.arange(0, last, step), last)).astype(np.float64)


def _between(values: Array | NDArray[np.float32], nodes: Array, log: WearLog) -> Array:
    """(n, D, K) at the kept samples, straight lines between the nodes. values: (m, D, K)."""
    m = len(nodes)
    at = np.interp(np.arange(len(log.kept)), nodes, np.arange(m))
    before = np.minimum(at.astype(np.intp), max(m - 2, 0))
    share = (at - before)[:, None, None]
    return np.asarray((1.0 - share) * values[before] + share * values[np.minimum(before + 1, m - 1)], dtype=np.float64)


def _moved_points(wire: Wire, band: Band, log: WearLog, logs: WearLogs) -> tuple[Array, Array]:
    """(n, D, 3 points) [1/rad] of the band's jacobian and (n, 3 points) of its length, per metre of each coordinate of
    each via point: smooth, where the band comes taut or not."""
    nodes = _nodes(log, max(1, len(logs.log) // SEARCHED))
    routing = wire.course.routing
    assert routing is not None
    moved = Routing(routing.tree, [band, *_moved(band)])
    geometry = moved.geometry(log.posture[log.kept[nodes.astype(np.intp)]])
    jacobian = on_joints(geometry.jacobian, moved, logs.joints).transpose(0, 2, 1)
    slope = (jacobian[:, :, 1:] - jacobian[:, :, :1]) / NEAR
    lengths = (geometry.length[:, None, 1:] - geometry.length[:, None, :1]) / NEAR
    return _between(slope, nodes, log), _between(lengths, nodes, log)[:, 0]


def _moved(band: Band) -> Iterator[Band]:
    """The band with each coordinate of each of its via points moved by a hundredth of a millimetre."""
    for number, point in enumerate(band.via_points):
        for axis in range(3):
            xyz = tuple(value + NEAR * (axis == k) for k, value in enumerate(point.xyz))
            points = list(band.via_points)
            points[number] = replace(point, xyz=(xyz[0], xyz[1], xyz[2]))
            yield replace(band, via_points=tuple(points))
