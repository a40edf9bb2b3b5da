"""Bands whose lengths are polynomials of three angles, as a problem for the fit of the springs."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from exogauge.support.band_fit import best_start, starts
from exogauge.support.band_model import Belief, Fitted, Layout, Setting, fit
from exogauge.support.band_rows import WearLog, WearLogs


@dataclass(frozen=True)
class Motion:
    """angles: (N, 3) bend, twist, knee. W bands over D joints: polynomials of the angles, and their slopes, which is
    what a band over a back does, more or less."""

    angles: np.ndarray
    bands: int = 4
    joints: int = 3

    def only(self, bands: int, joints: int = 3) -> Motion:
        return replace(self, bands=bands, joints=joints)

    @property
    def length(self) -> np.ndarray:
        return np.stack([Way(band).length(self.angles) for band in range(self.bands)], axis=1)

    @property
    def jacobian(self) -> np.ndarray:
        return np.stack([Way(b).jacobian(self.angles, np.arange(self.joints)) for b in range(self.bands)], axis=1)


@dataclass(frozen=True)
class Way:
    """The course of one band."""

    band: int
    routing = None

    def length(self, angles: np.ndarray) -> np.ndarray:
        b, w, n = angles.T
        s = 1.0 - 2.0 * self.band
        if self.band < 2:
            return 0.6 + 0.1 * b + 0.02 * b**2 + s * 0.05 * w + s * 0.02 * b * w + 0.01 * w**2
        return 0.4 - 0.06 * b + 0.04 * w**2 if self.band == 2 else 0.3 + 0.05 * n + 0.01 * n**2 + 0.02 * b

    def jacobian(self, angles: np.ndarray, joints: np.ndarray) -> np.ndarray:
        b, w, n = angles.T
        s, zero = 1.0 - 2.0 * self.band, 0.0 * b
        if self.band < 2:
            slope = (0.1 + 0.04 * b + s * 0.02 * w, s * (0.05 + 0.02 * b) + 0.02 * w, zero)
        elif self.band == 2:
            slope = (-0.06 + zero, 0.08 * w, zero)
        else:
            slope = (0.02 + zero, zero, 0.05 + 0.02 * n)
        return np.stack(slope, axis=1)[:, joints]


@dataclass(frozen=True)
class TorqueSamples:
    motion: Motion
    torque: np.ndarray
    weight: np.ndarray

    @property
    def length(self) -> np.ndarray:
        return self.motion.length

    @property
    def jacobian(self) -> np.ndarray:
        return self.motion.jacobian


def setting(plan: Layout, samples: TorqueSamples, beliefs=()) -> Setting:
    """beliefs: (place, mean, std)"""
    angles, N = samples.motion.angles, len(samples.torque)
    log = WearLog("worn", "any", np.arange(N) * 0.04, angles, np.arange(N), samples.torque, samples.weight > 0.0,
                  np.zeros(0, dtype=int), None)  # fmt: skip
    logs = WearLogs([log], np.arange(samples.motion.joints), ["bend", "twist", "knee"][: samples.motion.joints])
    wires = tuple(logs.wire(Way(band)) for band in range(samples.motion.bands))
    mean, precision = np.zeros(len(plan.names)), np.zeros((len(plan.names),) * 2)
    for place, value, std in beliefs:
        mean[place], precision[place, place] = value, std**-2
    return Setting(logs, wires, np.array(samples.weight, dtype=float), float(N), Belief(mean, precision))


def fit_bands(plan: Layout, samples: TorqueSamples, beliefs=()) -> Fitted:
    given = setting(plan, samples, beliefs)
    return fit(given, best_start(given, starts(plan, given.wires, ())))
