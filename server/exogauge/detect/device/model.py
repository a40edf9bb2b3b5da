"""The wear as a model: every band's spring, and what was added to it; fitted to all samples by Gauss-Newton steps.

    τ_td = -Σ_b J_tbd (k_b x_tb + declared law beyond its spring) + Σ_e c_e column_e,    x = max(l - l_0, 0)

What is stated of stiffness and natural length is believed within its doubt; bands of a group are nearly alike.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.detect.device.logs import WearLogs, Wire
from exogauge.devices.device import Band
from exogauge.effects.band import BandEffect, WireMotion
from exogauge.effects.band_laws import law_named
from exogauge.search.bounded import bounded_least_squares

Array = NDArray[np.float64]

STIFFNESS_DOUBT = 0.2  # of a stated stiffness, one standard deviation
LENGTH_DOUBT = 0.02  # of a stated natural length
ALIKE = 0.1  # of a group's stiffness: how much its bands may differ, one standard deviation
UNSTATED = 1.0  # of a value that nobody states: hardly believed at all
STEPS = 15
NEAR = 1e-5  # of a value: a step that shows a slope
SMALL = 1e-6  # relative change of the cost at which a search ends
SOFTEST, SHORTEST = 1e-3, 1e-3  # [N/m], [m]


@final
@dataclass(frozen=True)
class Added:
    """An effect on wire `wire` (place among the wires) at one shape. coefficients: (C,)."""

    effect: BandEffect
    wire: int
    shape: tuple[float, ...]
    coefficients: Array

    @property
    def key(self) -> tuple[str, int]:
        return self.effect.name, self.wire


@final
@dataclass(frozen=True)
class Wear:
    """k: (W,) [N/m], l_0: (W,) [m] of the declared bands, which are the first W wires."""

    k: Array
    l_0: Array
    added: tuple[Added, ...] = ()

    @property
    def theta(self) -> Array:
        """(P,) k, l_0, then the coefficients in order."""
        return np.concatenate([self.k, self.l_0, *(each.coefficients for each in self.added)])

    def at(self, theta: Array) -> Wear:
        W, added, start = len(self.k), list[Added](), 2 * len(self.k)
        for each in self.added:
            added.append(replace(each, coefficients=theta[start : start + len(each.coefficients)]))
            start += len(each.coefficients)
        return Wear(theta[:W], theta[W : 2 * W], tuple(added))

    def with_added(self, one: Added) -> Wear:
        return replace(self, added=(*self.added, one))

    def spring(self, wire: int) -> tuple[float, float]:
        """(k, l_0) of a declared band; of a further wire nothing is known."""
        return (float(self.k[wire]), float(self.l_0[wire])) if wire < len(self.k) else (0.0, 0.0)


@final
@dataclass(frozen=True)
class Belief:
    """What is believed of k and l_0: mean (2W,), and precision (2W, 2W), of the sums of squares that they cost."""

    mean: Array
    precision: Array


def believed(bands: Sequence[Band], start: Wear, travel: Array, free: frozenset[int] = frozenset()) -> Belief:
    """free: places among (k, l_0) of which nothing shall be believed, however stated. travel: (W,) [m]."""
    W = len(bands)
    mean = np.concatenate([
        [band.stiffness or k for band, k in zip(bands, start.k, strict=True)],
        [band.natural_length or l_0 for band, l_0 in zip(bands, start.l_0, strict=True)],
    ])  # fmt: skip
    doubt = np.concatenate([
        [STIFFNESS_DOUBT * band.stiffness if band.stiffness else UNSTATED * max(k, 1.0)
         for band, k in zip(bands, start.k, strict=True)],
        [LENGTH_DOUBT * band.natural_length if band.natural_length else UNSTATED * max(t, 0.01)
         for band, t in zip(bands, travel, strict=True)],
    ])  # fmt: skip
    wide = np.concatenate([UNSTATED * np.maximum(mean[:W], 1.0), UNSTATED * np.maximum(travel, 0.01)])
    let_go = np.isin(np.arange(2 * W), list(free))
    precision = np.diag(np.where(let_go, wide, doubt) ** -2.0)
    for group in dict.fromkeys(band.group for band in bands):
        own = [b for b, band in enumerate(bands) if band.group == group and b not in free]
        if len(own) > 1:
            apart = np.eye(len(own)) - 1.0 / len(own)
            precision[np.ix_(own, own)] += apart / (ALIKE * float(np.mean(mean[own]))) ** 2
    return Belief(mean, precision)


@final
@dataclass(frozen=True)
class Setting:
    """What a fit is made in. weight: (N, D) 1/(σ² memory) where a sample counts, so that square sums count in units of
    independent errors; independent: how many those are. wires: the declared bands first."""

    logs: WearLogs
    bands: tuple[Band, ...]
    wires: tuple[Wire, ...]
    weight: Array
    independent: float
    belief: Belief


@final
@dataclass(frozen=True)
class Fitted:
    """e: (N, D) [N·m] what the wear leaves unexplained. A: (N, D, P) its columns. hessian: (P, P) with beliefs. cost:
    weighted square sum with what is paid for leaving beliefs."""

    wear: Wear
    e: Array
    A: Array
    hessian: Array
    cost: float


def fit(setting: Setting, wear: Wear, held: Mapping[int, float] | None = None) -> Fitted:
    """From `wear` downhill. held: place in theta -> value at which it is kept."""
    held = held or {}
    theta = wear.theta.copy()
    for place, value in held.items():
        theta[place] = value
    low, high = _bounds(wear)
    free = np.array([p for p in range(len(theta)) if p not in held])
    now = _at(setting, wear.at(theta))
    for _ in range(STEPS):
        g = np.einsum("ndp,nd,nd->p", now.A, setting.weight, now.e) - _pulled(setting.belief, now.wear.theta)
        step = _step(now.hessian, g, free, low - now.wear.theta, high - now.wear.theta)
        for halving in 0.5 ** np.arange(8):
            tried = _at(setting, now.wear.at(np.clip(now.wear.theta + halving * step, low, high)))
            if tried.cost <= now.cost:
                break
        else:
            break
        gained, now = now.cost - tried.cost, tried
        if gained < SMALL * max(now.cost, 1.0):
            break
    return now


def residual(logs: WearLogs, bands: Sequence[Band], wires: Sequence[Wire], wear: Wear) -> Array:
    """(N, D) [N·m]"""
    e = logs.torque.copy()
    for b, (band, wire) in enumerate(zip(bands, wires, strict=False)):
        k, l_0 = wear.spring(b)
        e += wire.jacobian * (k * wire.stretch(l_0))[:, None]
        if band.law != "linear":
            e += _beyond_spring(band, wire, k, l_0)
    whole = tensions(wires, wear)
    for place, tension in whole.items():
        e -= wires[place].beyond_spring(tension, *wear.spring(place))
    for each in wear.added:
        if each.effect.per_segment or each.wire not in whole:
            k, l_0 = wear.spring(each.wire)
            e -= wires[each.wire].columns(each.effect, each.shape, k, l_0) @ each.coefficients
    return np.asarray(e)


def tensions(wires: Sequence[Wire], wear: Wear) -> Mapping[int, list[Array]]:
    """Declared band that a law was added to -> its tension by log, as the laws have it."""
    laws = [each for each in wear.added if not each.effect.per_segment and each.wire < len(wear.k)]
    return {
        wire: wires[wire].tension(
            [(each.effect, each.shape, each.coefficients) for each in laws if each.wire == wire], *wear.spring(wire)
        )
        for wire in dict.fromkeys(each.wire for each in laws)
    }


def columns(logs: WearLogs, wires: Sequence[Wire], wear: Wear) -> Array:
    """(N, D, P) slope of the model's torque with theta. That an effect moves with its own band's spring counts too."""
    W = len(wear.k)
    parts = np.zeros((*logs.torque.shape, 2 * W))
    for b in range(W):
        wire, l_0 = wires[b], float(wear.l_0[b])
        parts[:, :, b] = -wire.jacobian * wire.stretch(l_0)[:, None]
        parts[:, :, W + b] = wire.jacobian * (wear.k[b] * wire.taut(l_0))[:, None]
    more = []
    pulling = {place: [each > 0.0 for each in own] for place, own in tensions(wires, wear).items()}
    for each in wear.added:
        (k, l_0), wire, pulls = wear.spring(each.wire), wires[each.wire], pulling.get(each.wire)
        own = wire.columns(each.effect, each.shape, k, l_0, pulls)
        if each.wire < W:
            stiffer, longer = (
                wire.columns(each.effect, each.shape, k + dk, l_0 + dl, pulls)
                for dk, dl in ((NEAR * k, 0.0), (0.0, NEAR * l_0))
            )
            parts[:, :, each.wire] += (stiffer - own) @ each.coefficients / (NEAR * k)
            parts[:, :, W + each.wire] += (longer - own) @ each.coefficients / (NEAR * l_0)
        more.append(own)
    return np.concatenate([parts, *more], axis=2)


def _at(setting: Setting, wear: Wear) -> Fitted:
    e = residual(setting.logs, setting.bands, setting.wires, wear)
    A = columns(setting.logs, setting.wires, wear)
    flat = (A * np.sqrt(setting.weight)[:, :, None]).reshape(-1, A.shape[2])
    hessian, W2 = flat.T @ flat, len(setting.belief.mean)
    hessian[:W2, :W2] += setting.belief.precision
    off = wear.theta[:W2] - setting.belief.mean
    cost = float(np.sum(setting.weight * e**2) + off @ setting.belief.precision @ off)
    return Fitted(wear, e, A, hessian, cost)


def _pulled(belief: Belief, theta: Array) -> Array:
    """(P,) half the slope of what beliefs cost."""
    pulled, W2 = np.zeros(len(theta)), len(belief.mean)
    pulled[:W2] = belief.precision @ (theta[:W2] - belief.mean)
    return pulled


def _step(hessian: Array, g: Array, free: NDArray[np.intp], low: Array, high: Array) -> Array:
    """(P,) the least-squares step within bounds, 0 where held."""
    step = np.zeros(len(g))
    H = hessian[np.ix_(free, free)]
    size = np.sqrt(np.maximum(np.diag(H), 1e-300))
    H = H / np.outer(size, size) + 1e-12 * np.eye(len(H))
    target, lower, upper = g[free] / size, low[free] * size, high[free] * size
    step[free] = bounded_least_squares(H, target, np.minimum(lower, 0.0), np.maximum(upper, 1e-300)) / size
    return step


def _bounds(wear: Wear) -> tuple[Array, Array]:
    W = len(wear.k)
    quantities = [q for each in wear.added for q in each.effect.coefficients]
    low = np.concatenate([np.full(W, SOFTEST), np.full(W, SHORTEST), [q.low for q in quantities]])
    return low, np.concatenate([np.full(2 * W, np.inf), [q.high for q in quantities]])


def _beyond_spring(band: Band, wire: Wire, k: float, l_0: float) -> Array:
    """(N, D) [N·m] with the sign of the residual: what a declared law pulls beyond its spring."""
    law, parts = law_named(band.law), []
    for run in wire.runs:
        spring = k * np.maximum(run.length - l_0, 0.0)
        if law.per_segment:
            motion = WireMotion(run.log.time, run.length, run.rate, *(run.segments or (None, None)))
            pull = run.log.as_torque(law.tension(motion, k, l_0, band.law_values) - spring[:, None])
            parts.append(np.einsum("nsd,ns->nd", run.segment_jacobian, pull))
        else:
            motion = WireMotion(run.log.time, run.length, run.rate)
            pull = run.log.as_torque(law.tension(motion, k, l_0, band.law_values) - spring)
            parts.append(run.jacobian * pull[:, None])
    return np.concatenate(parts)
