"""The bands of a device as a model: every spring, its declared law, and what was added to it; fitted to all samples.

    τ_td = -Σ_b J_tbd max(k_b x_tb + Σ_e c_e T_e,tb, 0),    x = max(l - l_0, 0)

over the effects e of the declared law and those that were added; what differs along a band pulls segment by segment.
Implements [Evaluator] (25), (26). Differs from print: the squared norm of the sum over all bands, not the sum of
unsquared norms of each (equations.md). Gauss-Newton steps, damped where they lead uphill. There is one such fit: the
table of stiffness and the search for effects of bands differ in what they believe and in which bands share a value.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.device import Band
from exogauge.effects.band import BandEffect
from exogauge.effects.band_laws import law_named
from exogauge.estimation.least_squares import bounded_least_squares
from exogauge.support.band_nuisances import Between, Nuisances
from exogauge.support.band_rows import WearLogs, Wire, stretches, taut

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]

STIFFNESS_DOUBT = 0.2  # of a stated stiffness, one standard deviation
LENGTH_DOUBT = 0.02  # of a stated natural length
ALIKE = 0.1  # of a group's stiffness: how much its bands may differ, one standard deviation
UNSTATED = 1.0  # of a value that nobody states: hardly believed at all
STEPS = 40
DAMPINGS = (0.0, *10.0 ** np.arange(-4.0, 5.0))  # of the curvature along each value
NEAR = 1e-5  # of a value: a step that shows a slope
SMALL = 1e-8  # relative change of the cost at which a search ends
SOFTEST, SHORTEST = 1e-3, 1e-3  # [N/m], [m]
EDGE = 1e-9  # relative distance at which a value lies on its bound
SCALE = {"stiffness": 100.0, "natural_length": 0.05}  # sizes that matter [N/m, m]: what makes values comparable
NULL = 1e-9  # share of the largest curvature below which the samples hold nothing of a direction
SEARCHED = 2000  # samples that a search from several starts uses, or a walk along a profile


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

    @property
    def searched(self) -> tuple[int, ...]:
        """Places of the shapes of which every value between their bounds is another law."""
        linear = {each.name for each in self.effect.coefficients}
        return tuple(k for k, one in enumerate(self.effect.shapes) if not one.of_two and one.name not in linear)

    def linear_about_itself(self) -> Added:
        """With the values about which the law is taken as linear at what the coefficients are."""
        found = {each.name: value for each, value in zip(self.effect.coefficients, self.coefficients, strict=True)}
        shape = (
            float(np.clip(found[one.name], one.low, one.high)) if one.name in found else value
            for one, value in zip(self.effect.shapes, self.shape, strict=True)
        )
        return replace(self, shape=tuple(shape))


@final
@dataclass(frozen=True)
class Layout:
    """Which band has which value. names: (S,) of the values; stiffness, natural_length: (W,) places of each band's."""

    names: tuple[str, ...]
    stiffness: IntArray
    natural_length: IntArray

    @property
    def scale(self) -> Array:
        """(S,)"""
        return np.array([SCALE[name.split("[")[0]] for name in self.names])


def shared(bands: Sequence[Band], tied: frozenset[str] = frozenset()) -> Layout:
    """One stiffness per group; one natural length per band, or per group where it is tied."""
    return _layout([band.group for band in bands], [band.group if band.group in tied else band.name for band in bands])


def each_its_own(bands: Sequence[Band]) -> Layout:
    return _layout([band.name for band in bands], [band.name for band in bands])


def _layout(stiffness: Sequence[str], length: Sequence[str]) -> Layout:
    k, l_0 = (list(dict.fromkeys(each)) for each in (stiffness, length))
    names = [f"stiffness[{name}]" for name in k] + [f"natural_length[{name}]" for name in l_0]
    return Layout(
        tuple(names),
        np.array([k.index(name) for name in stiffness], dtype=np.intp),
        np.array([len(k) + l_0.index(name) for name in length], dtype=np.intp),
    )


@final
@dataclass(frozen=True)
class Wear:
    """springs: (S,) as `layout` says, of the declared bands, which are the first W wires. declared: what device.yaml
    states of their laws, which stays; added: what is fitted beside the springs."""

    layout: Layout
    springs: Array
    declared: tuple[Added, ...] = ()
    added: tuple[Added, ...] = ()

    @cached_property
    def k(self) -> Array:
        """(W,) [N/m]"""
        return np.asarray(self.springs[self.layout.stiffness])

    @cached_property
    def l_0(self) -> Array:
        """(W,) [m]"""
        return np.asarray(self.springs[self.layout.natural_length])

    @property
    def theta(self) -> Array:
        """(P,) springs, then the coefficients of what was added, in order."""
        return np.concatenate([self.springs, *(each.coefficients for each in self.added)])

    @property
    def effects(self) -> tuple[Added, ...]:
        return (*self.added, *self.declared)

    def at(self, theta: Array) -> Wear:
        added, start = list[Added](), len(self.springs)
        for each in self.added:
            added.append(replace(each, coefficients=theta[start : start + len(each.coefficients)]))
            start += len(each.coefficients)
        return replace(self, springs=theta[: len(self.springs)], added=tuple(added))

    def with_added(self, *more: Added) -> Wear:
        return replace(self, added=(*self.added, *more))

    def spring(self, wire: int) -> tuple[float, float]:
        """(k, l_0) of a declared band; of a further wire nothing is known."""
        return (float(self.k[wire]), float(self.l_0[wire])) if wire < len(self.k) else (0.0, 0.0)


def declared_laws(bands: Sequence[Band]) -> tuple[Added, ...]:
    """What device.yaml states beside the springs."""
    return tuple(
        Added(effect, wire, shape, np.array(coefficients))
        for wire, band in enumerate(bands)
        for effect, shape, coefficients in law_named(band.law).parts(band.law_values)
    )


@final
@dataclass(frozen=True)
class Belief:
    """What is believed of the springs: mean (S,), and precision (S, S), of the sums of squares that they cost."""

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
    independent errors; independent: how many those are. wires: the declared bands first. added: (N, D, m) [N·m] per
    standard deviation of what is declared and fitted beside the bands (`Nuisances`)."""

    logs: WearLogs
    wires: tuple[Wire, ...]
    weight: Array
    independent: float
    belief: Belief
    added: Between | None = None

    @cached_property
    def nuisances(self) -> Nuisances:
        return Nuisances(self.logs, self.weight, self.added)


def thinned(setting: Setting, most: int = SEARCHED) -> Setting:
    """On every n-th sample, as if nothing had been low-passed: to search on."""
    step = max(1, len(setting.weight) // most)
    logs = setting.logs.every(step)
    chosen = np.concatenate([np.arange(span.start, span.stop, step) for span in setting.logs.spans])
    wires = tuple(wire.every(logs, step) for wire in setting.wires)
    added = None if setting.added is None else setting.added.at(chosen)
    return replace(setting, logs=logs, wires=wires, weight=step * setting.weight[chosen], added=added)


@final
@dataclass(frozen=True)
class Fitted:
    """e: (N, D) [N·m] what the wear and what is beside it leave unexplained. A: (N, D, P) the wear's columns. hessian:
    (P, P) with beliefs, `Nuisances` integrated out. cost: weighted square sum with what is paid for leaving beliefs.
    told: what a fit from here begins with."""

    wear: Wear
    e: Array
    A: Array
    hessian: Array
    cost: float
    told: Told | None = None

    @property
    def null_directions(self) -> Array:
        """(n, S) unit directions, in values of comparable size, of which the springs' samples hold nothing."""
        scale = self.wear.layout.scale
        H = self.hessian[: len(scale), : len(scale)] * np.outer(scale, scale)
        curvature, vectors = np.linalg.eigh(H)
        return np.asarray(vectors[:, curvature <= NULL * max(float(curvature[-1]), 1e-300)].T)


@final
@dataclass(frozen=True)
class Reached:
    """e, cost: as `Fitted`."""

    wear: Wear
    e: Array
    cost: float


@final
class Told:
    """What the model says of samples with one choice of the values, however these count: fits of the same samples by
    other weights begin with it."""

    def __init__(self, logs: WearLogs, wires: tuple[Wire, ...], wear: Wear) -> None:
        self.logs, self.wires, self.wear = logs, wires, wear
        own_wires, whole = wires[: len(wear.k)], tensions(wires, wear)
        self._stretched = stretches(own_wires, wear.l_0)
        self._pulling = {place: [each > 0.0 for each in own] for place, own in whole.items()}
        self._own = dict[int, Array]()  # columns of an effect by its number
        e = logs.torque.copy()
        for wire, stretch, k in zip(own_wires, self._stretched.T, wear.k, strict=True):
            e += wire.jacobian * (k * stretch)[:, None]
        for place, tension in whole.items():
            e -= wires[place].beyond_spring(tension, *wear.spring(place))
        for number, each in enumerate(wear.effects):
            if each.effect.per_segment or each.wire not in whole:
                own = wires[each.wire].columns(each.effect, each.shape, *wear.spring(each.wire))
                e -= own @ each.coefficients
                self._own[number] = own
        self.e = np.asarray(e)
        """(N, D) [N·m] what is left of the torque"""

    @cached_property
    def columns(self) -> Array:
        """(N, D, P) slope of the model's torque with theta. That an effect moves with its own band's spring counts."""
        wear, W, layout = self.wear, len(self.wear.k), self.wear.layout
        springs, own_wires = np.zeros((*self.logs.torque.shape, len(wear.springs))), self.wires[: len(wear.k)]
        pulling_at_all = taut(own_wires, wear.l_0)
        for b, wire in enumerate(own_wires):
            springs[:, :, layout.stiffness[b]] -= wire.jacobian * self._stretched[:, b, None]
            springs[:, :, layout.natural_length[b]] += wire.jacobian * (wear.k[b] * pulling_at_all[:, b, None])
        more = []
        for number, each in enumerate(wear.effects):
            (k, l_0), wire, pulls = wear.spring(each.wire), self.wires[each.wire], self._pulling.get(each.wire)
            near = [(k + NEAR * k, l_0), (k, l_0 + NEAR * l_0)] if each.wire < W else []
            known = [self._own[number]] if number in self._own else []
            asked = near if known else [(k, l_0), *near]
            own, *changed = known + wire.columns_about(each.effect, each.shape, asked, pulls)
            if changed:
                stiffer, longer = changed
                springs[:, :, layout.stiffness[each.wire]] += (stiffer - own) @ each.coefficients / (NEAR * k)
                springs[:, :, layout.natural_length[each.wire]] += (longer - own) @ each.coefficients / (NEAR * l_0)
            if number < len(wear.added):
                more.append(own)
        return np.concatenate([springs, *more], axis=2)


Begin = Wear | Fitted | Told


def told(setting: Setting, begin: Begin) -> Told:
    """Anew, unless what is told already is of these samples and wires."""
    known = begin.told if isinstance(begin, Fitted) else begin
    if isinstance(known, Told) and known.logs is setting.logs and known.wires == setting.wires:
        return known
    return Told(setting.logs, setting.wires, begin if isinstance(begin, Wear) else begin.wear)


def fit(setting: Setting, begin: Begin, held: Mapping[int, float] | None = None) -> Fitted:
    """From there downhill. held: place in theta -> value at which it is kept."""
    return _with_slopes(setting, *_downhill(setting, begin, held or {}, SMALL))


def lowest(setting: Setting, begin: Begin, held: Mapping[int, float] | None = None, small: float = SMALL) -> Reached:
    """Where `fit` ends, without the slopes there. small: share of the cost that is not worth another step."""
    return _downhill(setting, begin, held or {}, small)[0]


def _downhill(setting: Setting, begin: Begin, held: Mapping[int, float], small: float) -> tuple[Reached, Told]:
    begin = told(setting, begin)
    wear, theta = begin.wear, begin.wear.theta.copy()
    for place, value in held.items():
        theta[place] = value
    low, high = _bounds(wear)
    free = np.array([p for p in range(len(theta)) if p not in held], dtype=np.intp)
    as_held = np.array_equal(theta, wear.theta)
    now, seen = _reached(setting, begin if as_held else told(setting, wear.at(theta)))
    for _ in range(STEPS):
        here, was = _with_slopes(setting, now, seen), now.wear.theta
        g = np.dot((setting.weight * here.e).ravel(), here.A.reshape(-1, len(was))) - _pulled(setting.belief, was)
        step = _steps(here.hessian, g, free, low - was, high - was)
        if g @ step(DAMPINGS[0]) <= small * max(now.cost, SMALL):  # what is to be gained
            break
        for damping in DAMPINGS:
            tried, seen_there = _reached(setting, told(setting, now.wear.at(np.clip(was + step(damping), low, high))))
            if tried.cost <= now.cost:
                break
        else:
            break
        gained, now, seen = now.cost - tried.cost, tried, seen_there
        if gained <= small * max(now.cost, SMALL):
            break
    return now, seen


def at(setting: Setting, there: Begin) -> Fitted:
    """Everything about one choice of the values."""
    return _with_slopes(setting, *_reached(setting, told(setting, there)))


def _reached(setting: Setting, seen: Told) -> tuple[Reached, Told]:
    off = seen.wear.springs - setting.belief.mean
    left, paid = setting.nuisances.beside(seen.e)
    squares = np.sum(setting.weight * left**2) + off @ setting.belief.precision @ off
    return Reached(seen.wear, left, float(squares + paid)), seen


def _with_slopes(setting: Setting, reached: Reached, seen: Told) -> Fitted:
    A = seen.columns
    hessian, S = setting.nuisances.information(A), len(reached.wear.springs)
    hessian[:S, :S] += setting.belief.precision
    return Fitted(reached.wear, reached.e, A, hessian, reached.cost, seen)


def residual(logs: WearLogs, wires: Sequence[Wire], wear: Wear) -> Array:
    """(N, D) [N·m]"""
    return Told(logs, tuple(wires), wear).e


def columns(logs: WearLogs, wires: Sequence[Wire], wear: Wear) -> Array:
    """(N, D, P) slope of the model's torque with theta."""
    return Told(logs, tuple(wires), wear).columns


def tensions(wires: Sequence[Wire], wear: Wear) -> Mapping[int, list[Array]]:
    """Declared band that has another law -> its tension by log, as the laws have it."""
    laws = [each for each in wear.effects if not each.effect.per_segment and each.wire < len(wear.k)]
    return {
        wire: wires[wire].tension(_laws(wear, wire), *wear.spring(wire))
        for wire in dict.fromkeys(each.wire for each in laws)
    }


def pulls(wires: Sequence[Wire], wear: Wear, place: int) -> tuple[Array, Array]:
    """(N,) each: [N] of a declared band, and [N/m] by which a longer way makes it larger; as the laws have it."""
    k, l_0 = wear.spring(place)
    return wires[place].pulls(_laws(wear, place), k, l_0, NEAR * l_0)


def _laws(wear: Wear, place: int) -> list[tuple[BandEffect, tuple[float, ...], Array]]:
    """Of a declared band, those that pull alike all along it."""
    own = [each for each in wear.effects if each.wire == place and not each.effect.per_segment]
    return [(each.effect, each.shape, each.coefficients) for each in own]


def _pulled(belief: Belief, theta: Array) -> Array:
    """(P,) half the slope of what beliefs cost."""
    pulled, S = np.zeros(len(theta)), len(belief.mean)
    pulled[:S] = belief.precision @ (theta[:S] - belief.mean)
    return pulled


def _steps(hessian: Array, g: Array, free: IntArray, low: Array, high: Array) -> Callable[[float], Array]:
    """damping -> (P,) the least-squares step within bounds, 0 where held or where nothing pulls."""
    free = free[np.diag(hessian)[free] > 0.0]
    H, eye = hessian[np.ix_(free, free)], np.eye(len(free))
    size = np.sqrt(np.diag(H))
    H, target = H / np.outer(size, size), g[free] / size
    lower, upper = np.minimum(low[free] * size, 0.0), np.maximum(high[free] * size, 1e-300)

    def step(damping: float) -> Array:
        found = np.zeros(len(g))
        if len(free):
            found[free] = bounded_least_squares(H + max(damping, 1e-12) * eye, target, lower, upper) / size
        return found

    return step


def at_bounds(wear: Wear) -> BoolArray:
    """(P,) which values lie where the search was not allowed to go on."""
    low, high = _bounds(wear)
    upper = np.isfinite(high) & (high - wear.theta <= EDGE * (1.0 + np.abs(high)))
    return np.asarray((wear.theta - low <= EDGE * (1.0 + np.abs(low))) | upper)


def _bounds(wear: Wear) -> tuple[Array, Array]:
    quantities = [q for each in wear.added for q in each.effect.coefficients]
    softest = np.zeros(len(wear.springs))
    softest[wear.layout.stiffness], softest[wear.layout.natural_length] = SOFTEST, SHORTEST
    low = np.concatenate([softest, [q.low for q in quantities]])
    return low, np.concatenate([np.full(len(softest), np.inf), [q.high for q in quantities]])
