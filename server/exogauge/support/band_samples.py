"""The samples that a device is identified from, by approach, and how much each joint counts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.band_fit import BandFit, TorqueSamples
from exogauge.devices.result import Approach
from exogauge.identification.uncertainty import block_length
from exogauge.support.evidence import Evidence

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]


@final
@dataclass(frozen=True)
class BandSamples:
    """All kept samples of several logs, one after the other: (N, ...). used: (N, D) which count. log: (N,) place."""

    torque: Array
    used: BoolArray
    length: Array
    jacobian: Array
    log: IntArray
    rate_hz: tuple[float, ...]

    def weighted(self, sigma: Array) -> TorqueSamples:
        """sigma: (D,) [N·m]"""
        return TorqueSamples(self.torque, self.used / sigma**2, self.length, self.jacobian)

    def residual(self, fit: BandFit) -> Array:
        """(N, D) [N·m] what the bands leave unexplained, 0 where a sample does not count."""
        left = self.torque + np.einsum("nwd,nw->nd", self.jacobian, fit.tension)
        return np.where(self.used, left, 0.0)

    def rms(self, fit: BandFit) -> Array:
        """(D,) [N·m] of the residual."""
        return np.asarray(np.sqrt(np.sum(self.residual(fit) ** 2, axis=0) / np.maximum(self.used.sum(axis=0), 1)))

    def blocks(self, fit: BandFit) -> IntArray:
        """(N,) consecutive samples of a log that are long against the residual's memory share a number."""
        residual, numbers, start = self.residual(fit), np.zeros(len(self.log), dtype=np.intp), 0
        for place, rate in enumerate(self.rate_hz):
            own = np.flatnonzero(self.log == place)
            length = block_length(residual[own][:, self.used[own].any(axis=0)], rate)
            numbers[own] = start + np.arange(len(own)) // length
            start = int(numbers[own[-1]]) + 1
        return numbers


def band_samples(evidences: Sequence[Evidence], approach: Approach) -> BandSamples:
    """A counts where both runs move with the same friction, B and the prior where this run moves steadily."""
    torque, used = zip(*(_chosen(each, approach) for each in evidences), strict=True)
    return BandSamples(
        torque=np.concatenate(torque),
        used=np.concatenate(used),
        length=np.concatenate([each.length[each.kept] for each in evidences]),
        jacobian=np.concatenate([each.jacobian[each.kept] for each in evidences]),
        log=np.repeat(np.arange(len(evidences)), [len(each.kept) for each in evidences]),
        rate_hz=tuple((len(e.kept) - 1) / float(e.time[e.kept[-1]] - e.time[e.kept[0]]) for e in evidences),
    )


def counted(evidence: Evidence, approach: Approach) -> BoolArray:
    """(T, D) samples of a log that count."""
    if approach != "A":
        return evidence.steady
    assert evidence.a is not None
    return evidence.compared & np.isfinite(evidence.a)


def _chosen(evidence: Evidence, approach: Approach) -> tuple[Array, BoolArray]:
    used = counted(evidence, approach)[evidence.kept]
    torque = {"A": evidence.a, "B": evidence.b, "prior": evidence.a_priori}[approach]
    assert torque is not None
    return np.where(used, torque[evidence.kept], 0.0), used
