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

from exogauge.devices.routing import Routing
from exogauge.support.band_fit import best_start, starts
from exogauge.support.band_model import Belief, Setting, fit, shared
from exogauge.support.band_rows import WearLog, WearLogs, band_wires

Array = NDArray[np.float64]

TRUE = {"A": 200.0, "B": 150.0}  # [N/m]
NOISE = 0.3  # [N·m]
AGREEMENT = 1e-4  # of the larger: far within what noise leaves open


@final
@dataclass(frozen=True)
class FitSpeeds:
    """seconds: of CPU by way. difference: relative, of all parameters."""

    seconds: dict[str, float]
    difference: float


def measure(samples: int, repeats: int) -> FitSpeeds:
    given = problem(samples)
    a, b = ours(given), theirs(given)
    ways = {"exogauge": seconds_of(lambda: ours(given)), "scipy least_squares": seconds_of(lambda: theirs(given))}
    return FitSpeeds(in_turns(ways, repeats), float(np.max(np.abs(a - b) / np.abs(b))))


def problem(samples: int) -> Setting:
    """What linear bands on Talos pull over a random motion, with white noise."""
    made, rng = make("Talos", samples), np.random.default_rng(0)
    bands, routing, q = suit(), Routing(made.tree, suit()), made.motion.q
    geometry = routing.geometry(q)
    rest = np.quantile(geometry.length, 0.2, axis=0)
    tension = np.array([TRUE[band.group] for band in bands]) * np.maximum(geometry.length - rest, 0.0)
    torque = -np.einsum("nwd,nw->nd", geometry.jacobian, tension)
    noisy = torque + NOISE * rng.standard_normal(torque.shape)
    every, nothing = np.arange(len(q)), np.zeros(0, dtype=np.intp)
    log = WearLog(
        "worn",
        "any",
        np.asarray(0.01 * every, dtype=np.float64),
        q,
        every,
        noisy,
        np.ones(noisy.shape, dtype=bool),
        nothing,
        None,
    )
    logs = WearLogs([log], np.array(routing.columns), routing.joints)
    size = len(shared(bands).names)
    belief = Belief(np.zeros(size), np.zeros((size, size)))
    weight = np.full(noisy.shape, NOISE**-2)
    return Setting(logs, band_wires(logs, routing), weight, float(noisy.size), belief)


def ours(given: Setting) -> Array:
    return fit(given, best_start(given, starts(shared(suit()), given.wires, ()))).wear.springs


def theirs(given: Setting) -> Array:
    """The usual way, from a start that is near: residuals and Jacobian of every sample and joint."""
    plan, torque = shared(suit()), given.logs.torque
    J = np.stack([wire.jacobian for wire in given.wires], axis=1)
    length = np.stack([wire.length for wire in given.wires], axis=1)

    def residuals(theta: Array) -> Array:
        stretch = np.maximum(length - theta[plan.natural_length], 0.0)
        model = np.einsum("nwd,nw->nd", J, theta[plan.stiffness] * stretch)
        return np.asarray(((torque + model) / NOISE).ravel())

    def slopes(theta: Array) -> Array:
        stretch = np.maximum(length - theta[plan.natural_length], 0.0)
        out = np.zeros((*torque.shape, len(theta)))
        for w, (of_k, of_l) in enumerate(zip(plan.stiffness, plan.natural_length, strict=True)):
            out[:, :, of_k] += J[:, w] * stretch[:, w, None]
            out[:, :, of_l] -= J[:, w] * (theta[of_k] * (stretch[:, w] > 0.0))[:, None]
        return out.reshape(-1, len(theta)) / NOISE

    start = np.concatenate([[100.0, 100.0], length.min(axis=0) - 0.02])
    scale = np.array([100.0] * 2 + [0.05] * 4)
    return np.asarray(
        least_squares(residuals, start, slopes, method="trf", x_scale=scale, xtol=1e-12, ftol=1e-12, gtol=1e-12).x
    )
