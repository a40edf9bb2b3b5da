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
SHORTEST = 1e-3  # natural length [m]
STEPS = 40
SMALLEST_STEP = 1e-8  # in those units
SMALLEST_GAIN = 1e-13  # of the cost


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
    """Samples seen from the bands: e^T w e = yy + 2 T·v + T M T at every sample.

    length, v: (W, N), M: (W, W, N); time last, because every sum here runs over it.
    """

    def __init__(self, samples: TorqueSamples) -> None:
        J = np.ascontiguousarray(samples.jacobian.transpose(1, 2, 0))
        weight, bands = np.ascontiguousarray(samples.weight.T), len(J)
        self.length = np.ascontiguousarray(samples.length.T)
        self.M, self.v = np.empty((bands, bands, J.shape[2])), np.empty((bands, J.shape[2]))
        weighted_torque = np.ascontiguousarray(samples.torque.T) * weight
        for a in range(bands):
            np.einsum("dn,dn->n", J[a], weighted_torque, out=self.v[a])
            weighted = J[a] * weight
            for b in range(a, bands):
                np.einsum("dn,dn->n", weighted, J[b], out=self.M[a, b])
                self.M[b, a] = self.M[a, b]
        self.yy = float(np.sum(weighted_torque * samples.torque.T))

    @property
    def samples(self) -> int:
        return int(self.length.shape[1])

    def every(self, step: int) -> Reduced:
        """Each step-th sample, for a search."""
        few = object.__new__(Reduced)
        few.length, few.v, few.M = (np.ascontiguousarray(x[..., ::step]) for x in (self.length, self.v, self.M))
        few.yy = self.yy / step
        return few

    def force(self, tension: Array) -> Array:
        """(W, N) v + M T: half the slope of e^T w e with each band's tension (W, N)."""
        return np.asarray(self.v + np.einsum("abn,bn->an", self.M, tension))


@final
@dataclass(frozen=True)
class BandFit:
    """theta: (P,) in the order of `layout.names`. hessian: (P, P) Σ G^T w G. cost: weighted square sum.

    tension: (N, W) [N] at the solution.
    """

    layout: Layout
    theta: Array
    hessian: Array
    cost: float
    tension: Array
    reduced: Reduced

    def scores(self, block: IntArray) -> Array:
        """(blocks, P) sums of G^T w e over each block of samples. block: (N,) which samples share their errors."""
        stretch, taut = _stretch(self.layout, self.reduced.length, self.theta)
        force, k = self.reduced.force(self.tension.T), self.theta[self.layout.stiffness]
        total = np.zeros((int(block.max()) + 1, len(self.theta)))
        for band, (of_k, of_l) in enumerate(zip(self.layout.stiffness, self.layout.natural_length, strict=True)):
            np.add.at(total[:, of_k], block, -stretch[band] * force[band])
            np.add.at(total[:, of_l], block, k[band] * taut[band] * force[band])
        return total


def fit_bands(layout: Layout, reduced: Reduced, beliefs: Sequence[Belief] = ()) -> BandFit:
    """The best of several starts, refined on all samples. Stiffness is not negative, natural length positive."""
    few = reduced.every(max(1, reduced.samples // SEARCHED))
    found = [_descend(layout, few, start, beliefs) for start in _starts(layout, few)]
    best = min(found, key=lambda each: each[1])[0]
    theta, cost = _descend(layout, reduced, best, beliefs)
    return at(layout, reduced, theta, beliefs, cost)


def at(layout: Layout, reduced: Reduced, theta: Array, beliefs: Sequence[Belief] = (), cost: float = np.nan) -> BandFit:
    """Everything about one choice of the parameters."""
    state = _State(layout, reduced, theta)
    hessian, _ = _normal(state, beliefs)
    return BandFit(layout, theta, hessian, cost, state.tension.T, reduced)


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


def _stretch(layout: Layout, length: Array, theta: Array) -> tuple[Array, Array]:
    """(W, N) how far each band is stretched [m], and 1 where it is taut. length: (W, N)."""
    stretch = length - theta[layout.natural_length][:, None]
    taut = (stretch > 0.0).astype(np.float64)
    stretch *= taut
    return stretch, taut


@final
class _State:
    """The bands at one choice of the parameters."""

    def __init__(self, layout: Layout, reduced: Reduced, theta: Array) -> None:
        self.layout, self.reduced, self.theta = layout, reduced, theta
        self.stretch, self.taut = _stretch(layout, reduced.length, theta)
        self.tension = theta[layout.stiffness][:, None] * self.stretch
        self.force = reduced.force(self.tension)

    def cost(self, beliefs: Sequence[Belief]) -> float:
        quadratic = float(np.einsum("wn,wn->", self.tension, self.force + self.reduced.v))
        believed = sum(float((self.theta[b.index] - b.mean) / b.std) ** 2 for b in beliefs)
        return self.reduced.yy + quadratic + believed


def _starts(layout: Layout, reduced: Reduced) -> list[Array]:
    """Bands that come taut at a share of their travel, with the stiffness that then fits best."""
    shortest, longest = reduced.length.min(axis=1), reduced.length.max(axis=1)
    starts = []
    for share in STARTS:
        begin = shortest - 0.02 if share == 0.0 else shortest + share * (longest - shortest)
        theta = np.zeros(len(layout.names))
        for band, index in enumerate(layout.natural_length):
            theta[index] = max(begin[band], SHORTEST)
        own = np.unique(layout.stiffness)
        hessian, gradient = _normal(_State(layout, reduced, theta), ())
        k = np.linalg.lstsq(hessian[np.ix_(own, own)], -gradient[own], rcond=NULL)[0]
        theta[own] = np.where(k > 1.0, k, SCALE["stiffness"])
        starts.append(theta)
    return starts


def _descend(
    layout: Layout, reduced: Reduced, theta: Array, beliefs: Sequence[Belief], held: int | None = None
) -> tuple[Array, float]:
    """Levenberg-Marquardt in scaled parameters; a direction without information is left where it is."""
    scale, free = layout.scale, np.array([i for i in range(len(layout.names)) if i != held])
    state = _State(layout, reduced, theta)
    cost, damping = state.cost(beliefs), 1e-9
    for _ in range(STEPS):
        hessian, gradient = _normal(state, beliefs)
        H = (hessian * np.outer(scale, scale))[np.ix_(free, free)]
        g = (gradient * scale)[free]
        size = max(float(np.trace(H)), 1e-300)
        while damping < 1e6:
            step = np.zeros(len(theta))
            step[free] = -np.linalg.lstsq(H + damping * size * np.eye(len(H)), g, rcond=NULL)[0] * scale[free]
            tried = _State(layout, reduced, _allowed(layout, state.theta + step))
            new_cost = tried.cost(beliefs)
            if new_cost <= cost:
                break
            damping *= 10.0
        else:
            break
        moved, gained = float(np.max(np.abs((tried.theta - state.theta) / scale))), cost - new_cost
        state, cost, damping = tried, new_cost, max(damping / 30.0, 1e-15)
        if moved < SMALLEST_STEP or gained < SMALLEST_GAIN * abs(cost):
            break
    return state.theta, cost


def _allowed(layout: Layout, theta: Array) -> Array:
    limited = theta.copy()
    limited[layout.stiffness] = np.maximum(limited[layout.stiffness], 0.0)
    limited[layout.natural_length] = np.maximum(limited[layout.natural_length], SHORTEST)
    return limited


def _normal(state: _State, beliefs: Sequence[Belief]) -> tuple[Array, Array]:
    """(P, P) half the Gauss-Newton Hessian of the cost, and (P,) half its gradient; analytic, band by band."""
    layout, M = state.layout, state.reduced.M
    k, bands = state.theta[layout.stiffness], len(M)
    hessian, gradient = np.zeros((len(state.theta),) * 2), np.zeros(len(state.theta))
    for a in range(bands):
        of_k, of_l = layout.stiffness[a], layout.natural_length[a]
        gradient[of_k] += state.stretch[a] @ state.force[a]
        gradient[of_l] -= k[a] * (state.taut[a] @ state.force[a])
        for b in range(bands):
            pulled, held = M[a, b] * state.stretch[b], M[a, b] * state.taut[b]
            hessian[of_k, layout.stiffness[b]] += state.stretch[a] @ pulled
            hessian[of_k, layout.natural_length[b]] -= k[b] * (state.stretch[a] @ held)
            hessian[of_l, layout.stiffness[b]] -= k[a] * (state.taut[a] @ pulled)
            hessian[of_l, layout.natural_length[b]] += k[a] * k[b] * (state.taut[a] @ held)
    for belief in beliefs:
        hessian[belief.index, belief.index] += belief.std**-2
        gradient[belief.index] += (state.theta[belief.index] - belief.mean) / belief.std**2
    return hessian, gradient
