"""A recorded motion and a device on it, kept so that another device of the same motion is answered in milliseconds.

What costs time is where the bands run: their lengths and Jacobians. They depend on the via points alone, so they are
measured once per routing and kept; other stiffnesses, natural lengths and laws need none of it anew.

A force-length test of the bare band as a straight line: stiffness, natural length and how well they are known.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.supporting import DEVICES
from exogauge.devices.device import Band, BenchTest, Device, ViaPoint
from exogauge.devices.routing import Routing
from exogauge.effects.band import WireMotion
from exogauge.effects.band_laws import check_values
from exogauge.robots.tree import IntArray, RigidTree

Array = NDArray[np.float64]

KEPT_BYTES = 64 << 20


@final
@dataclass(frozen=True)
class Wire:
    """One routing over T samples; D joints that it passes, C slopes per sample: one, or one per segment.

    columns: (D,) into q. motion: lengths and, where asked for, segments. slopes: (C, D, T) [m/rad or 1].
    """

    columns: IntArray
    motion: WireMotion
    slopes: Array

    @property
    def nbytes(self) -> int:
        segments = (self.motion.segment_length, self.motion.wrap)
        return self.slopes.nbytes + 16 * len(self.motion.time) + sum(0 if x is None else x.nbytes for x in segments)


@final
@dataclass(frozen=True)
class BandPull:
    """What one band does. length: (T,) [m]. tension: (T,) [N], the largest along the band. torque: (D, T) [N·m or N]
    on the joints `columns` (D,), positive along them."""

    columns: IntArray
    length: Array
    tension: Array
    torque: Array


@final
class Bench:
    """q: (T, J) [rad or m] of the tree's joints, low-passed where a law takes rates. time: (T,) [s], rising.

    kept_bytes: of routings that are not the device's own. Threads may share it.
    """

    def __init__(self, tree: RigidTree, device: Device, q: Array, time: Array, kept_bytes: int = KEPT_BYTES) -> None:
        self.tree, self.device, self.q, self.time = tree, device, np.ascontiguousarray(q), time
        self._kept_bytes = kept_bytes
        self._own = {_routing_of(band) for band in device.bands}
        self._wires: OrderedDict[tuple[object, ...], Wire] = OrderedDict()
        self._lock = threading.Lock()
        for band in device.bands:
            self.wire(band)

    def pull(self, band: Band) -> BandPull:
        """τ = J^T f with f = -T. Raises ValueError where the band's stiffness or natural length is not known.

        Implements [Evaluator] (21) for one band.
        """
        if band.stiffness is None or band.natural_length is None:
            raise ValueError(f"band {band.name!r} lacks a value")
        wire, law = self.wire(band), check_values(band.law, band.law_values)
        tension = law.tension(wire.motion, band.stiffness, band.natural_length, band.law_values)
        if not law.per_segment:
            return BandPull(wire.columns, wire.motion.length, tension, -wire.slopes[0] * tension)
        torque = -np.einsum("sdt,ts->dt", wire.slopes, tension)
        return BandPull(wire.columns, wire.motion.length, tension.max(axis=1), torque)

    def wire(self, band: Band) -> Wire:
        """Where the band runs, measured when it is first asked for."""
        key = _routing_of(band)
        with self._lock:
            if (kept := self._wires.get(key)) is not None:
                self._wires.move_to_end(key)
                return kept
        wire = self._measured(band)
        with self._lock:
            self._wires[key] = wire
            self._forget()
        return wire

    @property
    def nbytes(self) -> int:
        """Memory that it takes, or may come to take."""
        with self._lock:
            own = sum(wire.nbytes for key, wire in self._wires.items() if key in self._own)
        return self.q.nbytes + self.time.nbytes + own + self._kept_bytes

    def _measured(self, band: Band) -> Wire:
        routing = Routing(self.tree, [band])
        if not check_values(band.law, band.law_values).per_segment:
            geometry = routing.geometry(self.q)
            length = geometry.length[:, 0]
            return Wire(routing.columns, self._motion(length), geometry.jacobian[:, 0].T[None])
        segments = routing.segments(self.q, 0)
        motion = self._motion(routing.lengths(self.q)[:, 0])
        motion = replace(motion, segment_length=segments.length, wrap=segments.wrap)
        return Wire(routing.columns, motion, segments.jacobian.transpose(1, 2, 0))

    def _motion(self, length: Array) -> WireMotion:
        rate = np.gradient(length, self.time) if len(self.time) > 1 else np.zeros_like(length)
        return WireMotion(self.time, length, rate)

    def _forget(self) -> None:
        """The routings that were asked for least recently, until the rest fits; the device's own stay."""
        others = [key for key in self._wires if key not in self._own]
        taken = sum(self._wires[key].nbytes for key in others)
        for key in others[:-1]:
            if taken <= self._kept_bytes:
                return
            taken -= self._wires.pop(key).nbytes


def _routing_of(band: Band) -> tuple[tuple[ViaPoint, ...], bool]:
    """What tells routings apart: the via points, and whether single segments are asked for."""
    return band.via_points, check_values(band.law, band.law_values).per_segment


def wire_bytes(tree: RigidTree, band: Band, samples: int) -> int:
    """Memory that a band's routing takes, known before it is measured."""
    per_segment = check_values(band.law, band.law_values).per_segment
    return 8 * samples * len(Routing(tree, [band]).columns) * (len(band.via_points) - 1 if per_segment else 1)


def complete(bands: Sequence[Band]) -> tuple[Band, ...]:
    """Those whose stiffness and natural length are known."""
    return tuple(band for band in bands if band.stiffness is not None and band.natural_length is not None)


@final
@dataclass(frozen=True)
class BenchLine:
    """force = stiffness (length - natural_length) where taut [N/m, m]; std of both."""

    stiffness: float
    natural_length: float
    stiffness_std: float
    natural_length_std: float


def bench_line(test: BenchTest) -> BenchLine:
    """Least squares over the taut part.

    Implements the fit behind [Evaluator] Figure 5. Raises ValueError with fewer than two taut points.
    """
    length, force = np.array(test.length), np.array(test.force)
    taut = force > DEVICES.slack * force.max(initial=0.0)
    if taut.sum() < 2 or np.ptp(length[taut]) <= 0.0:
        raise ValueError("a bench test needs two or more lengths at which the band pulls")
    A = np.column_stack([length[taut], -np.ones(int(taut.sum()))])
    (k, c), *_ = np.linalg.lstsq(A, force[taut], rcond=None)
    spare = max(1, len(A) - 2)
    noise = float(np.sum((force[taut] - A @ [k, c]) ** 2)) / spare
    covariance = noise * np.linalg.inv(A.T @ A)
    slope = np.array([-c / k**2, 1.0 / k])  # of l0 = c / k
    return BenchLine(
        float(k),
        float(c / k),
        float(max(np.sqrt(covariance[0, 0]), DEVICES.bench * k)),
        float(max(np.sqrt(slope @ covariance @ slope), DEVICES.bench * np.ptp(length))),
    )
