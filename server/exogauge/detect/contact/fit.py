"""The push that explains a burst: at which link, when, how long, how strong; and what each other link explains."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from exogauge.criteria.detecting import Touching
from exogauge.detect.contact.rows import LogRows
from exogauge.detect.contact.scan import bump

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class LinkFit:
    """A force F and moment M (6,) about the middle of a body, base axes, at their largest. gain: by which the weighted
    square falls, less what the doubt of F and M takes. evidence: gain less what letting go six numbers is worth."""

    body: int
    wrench: Array
    gain: float
    evidence: float


@final
@dataclass(frozen=True)
class Push:
    """One burst explained. start [s of the log's own clock], duration [s], each with std. best: the likeliest link;
    links: of every body, likeliest first. force, force_std [N].

    share: of what stands above the usual around the burst, 0…1, that the force explains. by_kind: (K,) of the gain.
    seen: (K,) share of the burst's time in which there are such rows.
    time, weight, before, added: (m,), (m, K) around the burst: residuals, and what the push adds to them.
    """

    rows: LogRows
    start: float
    start_std: float
    duration: float
    duration_std: float
    force: float
    force_std: float
    best: LinkFit
    links: tuple[LinkFit, ...]
    share: float
    by_kind: Array
    seen: Array
    time: Array
    weight: Array
    before: Array
    added: Array

    @property
    def stop(self) -> float:
        return self.start + self.duration

    @property
    def kind(self) -> int:
        """Of the rows that gain most."""
        return int(np.argmax(self.by_kind))

    @property
    def alone(self) -> float:
        """Share of the gain in that kind, 0…1."""
        positive = np.maximum(self.by_kind, 0.0)
        return float(positive.max() / max(float(positive.sum()), 1e-300))


@final
@dataclass(frozen=True)
class Around:
    """The rows around one burst. C: (N, m, K, 6), w, e: (m, K)."""

    rows: LogRows
    time: Array
    C: Array
    w: Array
    e: Array
    reach: Array
    criteria: Touching


def explain(
    rows: LogRows,
    columns: Iterable[Array],
    reach: Array,
    middle: float,
    duration: float,
    criteria: Touching,
    body: int | None = None,
) -> Push:
    """columns: of `force_columns`; reach: (N,) [m] of `reaches`. middle, duration: where the search begins. body: the
    one that is pushed, None for the likeliest."""
    low_pass = rows.prepared.low_pass
    near = np.abs(rows.time - middle) < criteria.bounds_s[1] / 2.0 + 1.0 / low_pass.cutoff_hz
    around = np.stack([own[near] for own in columns])
    part = Around(rows, rows.time[near], around, rows.weight[near], rows.e[near], reach, criteria)
    power, known = 1.0, body
    for _ in range(2):
        likeliest = max(_links(part, _shape(part, middle, duration, power)), key=lambda each: each.evidence).body
        if known == likeliest and body is None:
            break
        known = likeliest if body is None else body
        tried = [_refined(part, known, middle, duration, power) for power in criteria.powers]
        middle, duration, power = max(tried, key=lambda each: each[1])[0]
    shape = _shape(part, middle, duration, power)
    links = tuple(sorted(_links(part, shape), key=lambda each: -each.evidence))
    best = links[0] if body is None else next(each for each in links if each.body == body)
    added = shape[:, None] * (part.C[best.body] @ best.wrench)
    inside = np.abs(part.time - middle) < 0.5 * duration + 0.5 / low_pass.cutoff_hz
    by_kind = np.sum((part.w * (part.e**2 - (part.e - added) ** 2))[inside], axis=0)
    usual = _usual_square(rows, part.w[inside])
    excess = max(float(np.sum((part.w * part.e**2)[inside])) - usual, 1e-300)
    force_std, middle_std, duration_std = _doubt(part, best, middle, duration, power)
    start_std = float(np.hypot(middle_std, 0.5 * duration_std))
    return Push(
        rows=rows,
        start=middle - 0.5 * duration,
        start_std=start_std,
        duration=duration,
        duration_std=duration_std,
        force=float(np.linalg.norm(best.wrench[:3])),
        force_std=force_std,
        best=best,
        links=links,
        share=float(np.clip(by_kind.sum() / excess, 0.0, 1.0)),
        by_kind=by_kind,
        seen=np.mean(part.w[inside] > 0.0, axis=0),
        time=part.time,
        weight=part.w,
        before=part.e,
        added=added,
    )


def _usual_square(rows: LogRows, w: Array) -> float:
    """Weighted square of what is usual: a row's is one over its memory."""
    whole, there = np.sum(rows.weight * rows.e**2, axis=0), np.sum(rows.weight > 0.0, axis=0)
    return float(np.sum(np.sum(w > 0.0, axis=0) * np.minimum(whole / np.maximum(there, 1), 1.0)))


def _shape(part: Around, middle: float, duration: float, power: float) -> Array:
    return bump(part.rows.prepared.low_pass, middle, duration, power, part.time)


def _links(part: Around, shape: Array) -> list[LinkFit]:
    return [_fit(part, body, shape) for body in range(len(part.C))]


def _fit(part: Around, body: int, shape: Array) -> LinkFit:
    """Force and moment of one body. A moment comes from a force that acts beside the middle: it stands across it, and
    is as large as the body reaches."""
    passes = 5  # of the moment's doubt, which depends on the force
    A = part.C[body] * shape[:, None, None]
    S = np.einsum("tki,tk,tkj->ij", A, part.w, A)
    g = np.einsum("tki,tk,tk->i", A, part.w, part.e)
    force, theta, doubt = np.zeros(3), np.zeros(6), np.eye(6)
    for _ in range(passes):
        doubt = _prior(force, float(part.reach[body]), part.criteria)
        theta = np.linalg.solve(S + np.linalg.inv(doubt), g)
        force = theta[:3]
    gain = float(g @ theta)
    half = np.linalg.cholesky(doubt)
    return LinkFit(body, theta, gain, gain - float(np.linalg.slogdet(np.eye(6) + half.T @ S @ half)[1]))


def _prior(force: Array, reach: float, criteria: Touching) -> Array:
    """(6, 6) what is believed of force and moment."""
    square = float(force @ force) + criteria.least_n**2
    doubt = np.zeros((6, 6))
    doubt[:3, :3] = criteria.usual_n**2 * np.eye(3)
    doubt[3:, 3:] = reach**2 * (square * np.eye(3) - np.outer(force, force))
    return doubt


def _refined(
    part: Around, body: int, middle: float, duration: float, power: float
) -> tuple[tuple[float, float, float], float]:
    """((middle, duration, power), gain) with which the body explains most."""

    trials = 60
    bounds = part.criteria.bounds_s

    def cost(values: Array) -> float:
        m, d = float(values[0]), float(np.clip(np.exp(values[1]), *bounds))
        return -_fit(part, body, _shape(part, m, d, power)).gain

    start = np.array([middle, np.log(duration)])
    simplex = start + np.array([[0.0, 0.0], [0.2 * duration, 0.0], [0.0, 0.4]])
    found = minimize(cost, start, method="Nelder-Mead", options={"maxfev": trials, "initial_simplex": simplex})
    m, d = float(found.x[0]), float(np.clip(np.exp(found.x[1]), *bounds))
    return (m, d, power), -float(found.fun)


def _doubt(part: Around, best: LinkFit, middle: float, duration: float, power: float) -> tuple[float, float, float]:
    """Standard deviations of the force's size [N], of its middle and its duration [s], everything let go together."""

    step_s = 0.01  # for the slopes with start and duration

    def added(m: float, d: float) -> Array:
        return np.asarray(_shape(part, m, d, power)[:, None] * (part.C[best.body] @ best.wrench))

    of_middle = (added(middle + step_s, duration) - added(middle - step_s, duration)) / (2.0 * step_s)
    of_duration = (added(middle, duration + step_s) - added(middle, duration - step_s)) / (2.0 * step_s)
    A = part.C[best.body] * _shape(part, middle, duration, power)[:, None, None]
    A = np.concatenate([A, of_middle[:, :, None], of_duration[:, :, None]], axis=2)
    S = np.einsum("tki,tk,tkj->ij", A, part.w, A)
    S[:6, :6] += np.linalg.inv(_prior(best.wrench[:3], float(part.reach[best.body]), part.criteria))
    covariance = np.linalg.pinv(S, hermitian=True)
    left = (part.e - added(middle, duration))[part.w > 0.0] ** 2
    more = max(float(np.sum(part.w[part.w > 0.0] * left)) / max(_usual_square(part.rows, part.w), 1e-300), 1.0)
    way = best.wrench[:3] / max(float(np.linalg.norm(best.wrench[:3])), 1e-300)
    variances = (way @ covariance[:3, :3] @ way, covariance[6, 6], covariance[7, 7])
    force, at, lasts = (float(np.sqrt(max(more * each, 0.0))) for each in variances)
    return force, at, lasts
