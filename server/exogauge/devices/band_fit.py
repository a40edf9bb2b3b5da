"""Stiffness and natural length of the bands from a supporting torque: weighted least squares over all samples.

    min Σ_t Σ_d w_td (τ_td + Σ_b J_tbd T_tb)²,     T_tb = k_g(b) (l_tb - l0_b) where the band is taut, else 0

Implements [Evaluator] (26). Differs from print: the squared norm of the sum over all bands, not the sum of unsquared
norms of each (equations.md). Samples are first brought from joints to bands (W x W numbers each), so that a step costs
nothing of the number of joints; the Jacobian is analytic. The search begins with every band taut at every sample, and
again with bands that come taut part-way, because with all bands slack the Jacobian is exactly zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.device import Band

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]

SCALE = {"stiffness": 100.0, "natural_length": 0.05}  # sizes that matter [N/m, m]: what makes parameters comparable
NULL = 1e-9  # share of the largest curvature below which the data hold nothing of a direction
STARTS = (0.0, 0.3, 0.6)  # share of a band's travel at which it comes taut, where the search begins
SEARCHED = 2000  # samples that the search from several starts uses; the best start is refined on all
STEPS = 30
SMALLEST_STEP = 1e-7  # in those units


@final
@dataclass(frozen=True)
class TorqueSamples:
    """N samples of all logs, D joints, W bands.

    torque: (N, D) [N·m] estimated support. weight: (N, D) 1/variance, 0 where a sample is not used.
    length: (N, W) [m]. jacobian: (N, W, D) [m/rad] ∂l/∂θ.
    """

    torque: Array
    weight: Array
    length: Array
    jacobian: Array


@final
@dataclass(frozen=True)
class Belief:
    """What is known of parameter `index` before the data: mean and standard deviation."""

    index: int
    mean: float
    std: float


@final
@dataclass(frozen=True)
class Layout:
    """Which parameter is which. stiffness: (W,) index of each band's k; natural_length: (W,) of its l0."""

    names: tuple[str, ...]
    stiffness: IntArray
    natural_length: IntArray

    @property
    def scale(self) -> Array:
        return np.array([SCALE[name.split("[")[0]] for name in self.names])


def layout(bands: Sequence[Band], tied: frozenset[str] = frozenset()) -> Layout:
    """One stiffness per group; one natural length per band, or per group where it is tied."""
    groups = list(dict.fromkeys(band.group for band in bands))
    lengths = list(dict.fromkeys(band.group if band.group in tied else band.name for band in bands))
    names = [f"stiffness[{group}]" for group in groups] + [f"natural_length[{name}]" for name in lengths]
    own = [lengths.index(band.group if band.group in tied else band.name) for band in bands]
    return Layout(
        tuple(names),
        np.array([groups.index(band.group) for band in bands]),
        len(groups) + np.array(own),
    )


@final
class Reduced:
    """Samples seen from the bands: e^T w e = yy + 2 T·v + T M T at every sample. v: (N, W), M: (N, W, W)."""

    def __init__(self, samples: TorqueSamples) -> None:
        J = samples.jacobian
        weighted = J * samples.weight[:, None, :]
        self.M = weighted @ np.swapaxes(J, 1, 2)
        self.v = (weighted @ samples.torque[:, :, None])[:, :, 0]
        self.yy = float(np.sum(samples.weight * samples.torque**2))
        self.length = samples.length

    def every(self, step: int) -> Reduced:
        """Each step-th sample, for a search."""
        few = object.__new__(Reduced)
        few.M, few.v, few.length = self.M[::step], self.v[::step], self.length[::step]
        few.yy = self.yy / step
        return few


@final
@dataclass(frozen=True)
class BandFit:
    """theta: (P,) in the order of `layout.names`. hessian: (P, P) Σ G^T w G. cost: weighted square sum.

    pull: (N, W, P) ∂T/∂θ [N per unit] at the solution.
    """

    layout: Layout
    theta: Array
    hessian: Array
    cost: float
    tension: Array
    pull: Array
    reduced: Reduced

    def scores(self, block: IntArray) -> Array:
        """(blocks, P) sums of G^T w e over each block of samples. block: (N,) which samples share their errors."""
        residual = self.reduced.v + (self.reduced.M @ self.tension[:, :, None])[:, :, 0]
        each = -np.einsum("nwp,nw->np", self.pull, residual)
        total = np.zeros((int(block.max()) + 1, each.shape[1]))
        np.add.at(total, block, each)
        return total


def fit_bands(layout: Layout, reduced: Reduced, beliefs: Sequence[Belief] = ()) -> BandFit:
    """The best of several starts, refined on all samples. Stiffness is not negative, natural length positive."""
    few = reduced.every(max(1, len(reduced.v) // SEARCHED))
    found = [_descend(layout, few, start, beliefs) for start in _starts(layout, few)]
    best = min(found, key=lambda each: each[1])[0]
    theta, cost = _descend(layout, reduced, best, beliefs)
    return at(layout, reduced, theta, beliefs, cost)


def at(layout: Layout, reduced: Reduced, theta: Array, beliefs: Sequence[Belief] = (), cost: float = np.nan) -> BandFit:
    """Everything about one choice of the parameters."""
    tension, pull = tension_and_pull(layout, reduced.length, theta)
    hessian, _ = _normal(reduced, tension, pull, theta, beliefs)
    return BandFit(layout, theta, hessian, cost, tension, pull, reduced)


def refit_with_held(fit: BandFit, index: int, value: float, beliefs: Sequence[Belief] = ()) -> float:
    """Smallest cost with one parameter held at a value: a point of the profile likelihood."""
    start = fit.theta.copy()
    start[index] = value
    return _descend(fit.layout, fit.reduced, start, beliefs, held=index)[1]


def tension_and_pull(layout: Layout, length: Array, theta: Array) -> tuple[Array, Array]:
    """(N, W) tension of the linear law [N] and its analytic slope ∂T/∂θ (N, W, P)."""
    k, l_0 = theta[layout.stiffness], theta[layout.natural_length]
    stretch = np.maximum(length - l_0, 0.0)
    pull = np.zeros((*length.shape, len(theta)))
    for band, (of_k, of_l) in enumerate(zip(layout.stiffness, layout.natural_length, strict=True)):
        pull[:, band, of_k] = stretch[:, band]
        pull[:, band, of_l] = np.where(stretch[:, band] > 0.0, -k[band], 0.0)
    return k * stretch, pull


def null_directions(fit: BandFit) -> Array:
    """(n, P) unit directions in scaled parameters of which the data hold nothing."""
    scale = fit.layout.scale
    curvature, vectors = np.linalg.eigh(fit.hessian * np.outer(scale, scale))
    return np.asarray(vectors[:, curvature <= NULL * max(float(curvature[-1]), 1e-300)].T)


def _starts(layout: Layout, reduced: Reduced) -> list[Array]:
    """Bands that come taut at a share of their travel, with the stiffness that then fits best."""
    shortest, longest = reduced.length.min(axis=0), reduced.length.max(axis=0)
    starts = []
    for share in STARTS:
        begin = shortest - 0.02 if share == 0.0 else shortest + share * (longest - shortest)
        theta = np.full(len(layout.names), SCALE["stiffness"])
        for band, index in enumerate(layout.natural_length):
            theta[index] = max(begin[band], 1e-3)
        tension, pull = tension_and_pull(layout, reduced.length, theta)
        own = np.unique(layout.stiffness)
        hessian, gradient = _normal(reduced, np.zeros_like(tension), pull, theta, ())
        k = np.linalg.lstsq(hessian[np.ix_(own, own)], -gradient[own], rcond=NULL)[0]
        theta[own] = np.where(k > 1.0, k, SCALE["stiffness"])
        starts.append(theta)
    return starts


def _descend(
    layout: Layout, reduced: Reduced, theta: Array, beliefs: Sequence[Belief], held: int | None = None
) -> tuple[Array, float]:
    """Levenberg-Marquardt in scaled parameters; a direction without information is left where it is."""
    scale, free = layout.scale, np.array([i for i in range(len(layout.names)) if i != held])
    tension, pull = tension_and_pull(layout, reduced.length, theta)
    cost, damping = _cost(reduced, tension, theta, beliefs), 1e-6
    for _ in range(STEPS):
        hessian, gradient = _normal(reduced, tension, pull, theta, beliefs)
        H = (hessian * np.outer(scale, scale))[np.ix_(free, free)]
        g = (gradient * scale)[free]
        size = max(float(np.trace(H)), 1e-300)
        while damping < 1e6:
            step = np.zeros(len(theta))
            step[free] = -np.linalg.lstsq(H + damping * size * np.eye(len(H)), g, rcond=NULL)[0] * scale[free]
            tried = _allowed(layout, theta + step)
            new_tension, new_pull = tension_and_pull(layout, reduced.length, tried)
            new_cost = _cost(reduced, new_tension, tried, beliefs)
            if new_cost <= cost:
                break
            damping *= 10.0
        else:
            break
        moved = float(np.max(np.abs((tried - theta) / scale)))
        theta, cost, tension, pull, damping = tried, new_cost, new_tension, new_pull, max(damping / 30.0, 1e-15)
        if moved < SMALLEST_STEP:
            break
    return theta, cost


def _allowed(layout: Layout, theta: Array) -> Array:
    limited = theta.copy()
    limited[layout.stiffness] = np.maximum(limited[layout.stiffness], 0.0)
    limited[layout.natural_length] = np.maximum(limited[layout.natural_length], 1e-3)
    return limited


def _cost(reduced: Reduced, tension: Array, theta: Array, beliefs: Sequence[Belief]) -> float:
    quadratic = np.einsum("nw,nw->", tension, (reduced.M @ tension[:, :, None])[:, :, 0] + 2.0 * reduced.v)
    return float(reduced.yy + quadratic + sum(((theta[b.index] - b.mean) / b.std) ** 2 for b in beliefs))


def _normal(
    reduced: Reduced, tension: Array, pull: Array, theta: Array, beliefs: Sequence[Belief]
) -> tuple[Array, Array]:
    """(P, P) half the Gauss-Newton Hessian of the cost, and (P,) half its gradient."""
    parameters = pull.shape[2]
    flat = pull.reshape(-1, parameters)
    hessian = flat.T @ (reduced.M @ pull).reshape(-1, parameters)
    residual = reduced.v + (reduced.M @ tension[:, :, None])[:, :, 0]
    gradient = flat.T @ residual.ravel()
    for belief in beliefs:
        hessian[belief.index, belief.index] += belief.std**-2
        gradient[belief.index] += (theta[belief.index] - belief.mean) / belief.std**2
    return hessian, gradient
