"""Stiffness and natural length of two pairs of bands from 10^5 samples, against scipy's least squares."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from tests.bench.bands import suit
from tests.bench.problems import make
from tests.bench.timing import in_turns, seconds_of

from exogauge.devices.band_fit import BandFit, Reduced, TorqueSamples, fit_bands, layout
from exogauge.devices.routing import Routing

Array = NDArray[np.float64]

TRUE = {"A": 200.0, "B": 150.0}  # [N/m]
NOISE = 0.3  # [N·m]
AGREEMENT = 1e-6  # of the larger


@final
@dataclass(frozen=True)
class FitSpeeds:
    """seconds: of CPU by way. difference: relative, of all parameters."""

    seconds: dict[str, float]
    difference: float


def measure(samples: int, repeats: int) -> FitSpeeds:
    seen = torques(samples)
    ours = seconds_of(lambda: fit(seen))
    theirs = seconds_of(lambda: scipy_fit(seen))
    a, b = fit(seen).theta, scipy_fit(seen)
    seconds = in_turns({"exogauge": ours, "scipy least_squares": theirs}, repeats)
    return FitSpeeds(seconds, float(np.max(np.abs(a - b) / np.abs(b))))


def torques(samples: int) -> TorqueSamples:
    """What linear bands on Talos pull over a random motion, with white noise."""
    problem, rng = make("Talos", samples), np.random.default_rng(0)
    geometry = Routing(problem.tree, suit()).geometry(problem.motion.q)
    bands, plan = suit(), layout(suit())
    rest = np.quantile(geometry.length, 0.2, axis=0)
    tension = np.array([TRUE[band.group] for band in bands]) * np.maximum(geometry.length - rest, 0.0)
    torque = -np.einsum("nwd,nw->nd", geometry.jacobian, tension)
    assert len(plan.names) == 6
    noisy = torque + NOISE * rng.standard_normal(torque.shape)
    return TorqueSamples(noisy, np.full(torque.shape, NOISE**-2), geometry.length, geometry.jacobian)


def fit(seen: TorqueSamples) -> BandFit:
    return fit_bands(layout(suit()), Reduced(seen))


def scipy_fit(seen: TorqueSamples) -> Array:
    """The usual way, from a start that is near: residuals and Jacobian of every sample and joint."""
    plan = layout(suit())
    J, size = seen.jacobian, seen.torque.shape

    def residuals(theta: Array) -> Array:
        stretch = np.maximum(seen.length - theta[plan.natural_length], 0.0)
        model = np.einsum("nwd,nw->nd", J, theta[plan.stiffness] * stretch)
        return np.asarray(((seen.torque + model) / NOISE).ravel())

    def slopes(theta: Array) -> Array:
        stretch = np.maximum(seen.length - theta[plan.natural_length], 0.0)
        out = np.zeros((*size, len(theta)))
        for w, (of_k, of_l) in enumerate(zip(plan.stiffness, plan.natural_length, strict=True)):
            out[:, :, of_k] += J[:, w] * stretch[:, w, None]
            out[:, :, of_l] -= J[:, w] * (theta[of_k] * (stretch[:, w] > 0.0))[:, None]
        return out.reshape(-1, len(theta)) / NOISE

    start = np.concatenate([[100.0, 100.0], seen.length.min(axis=0) - 0.02])
    scale = np.array([100.0] * 2 + [0.05] * 4)
    return np.asarray(
        least_squares(residuals, start, slopes, method="trf", x_scale=scale, xtol=1e-12, ftol=1e-12, gtol=1e-12).x
    )
