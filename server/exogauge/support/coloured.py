"""Errors that last: their autocovariance, and what they make of sums over a log."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len, rfft

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


def by_autocovariance(
    spans: Sequence[slice], counts: BoolArray, e: Array, weighted: Array, pooled: bool = False
) -> Array:
    """Σ gᵀ C g over logs and joints; g: (n, P) weighted slopes of a joint's torque, C: covariance of its errors, which
    counts by its spectrum once no end of a log meets the other. counts, e: (N, D), weighted: (N, D, P). pooled: errors
    are alike in all logs: in one alone those that last for seconds are few, and may be small by chance."""
    P = weighted.shape[2]
    total, felt = np.zeros((P, P)), np.flatnonzero(weighted.any(axis=(0, 2)))
    each = [(np.where(counts[span], e[span], 0.0)[:, felt].T, counts[span][:, felt].T) for span in spans]
    alike = _cut_off(*(np.sum(part, axis=0) for part in _lags_of_all(each))) if pooled and each else None
    for span, log in zip(spans, each, strict=True):
        c = _autocovariances(*log) if alike is None else alike
        for joint, own in enumerate(c):
            total += _through(own, weighted[span][:, felt[joint]])
    return 0.5 * (total + total.T)


def by_what_is_shared(
    groups: Sequence[Sequence[tuple[slice, int]]], counts: BoolArray, e: Array, weighted: Array
) -> Array:
    """The same of pairs of different logs, Σ gᵢᵀ C gⱼ, where the same log was taken off both: its errors are in both at
    the same moments of it. groups: spans of such logs, and the sample of their partner that each begins at."""
    P = weighted.shape[2]
    total = np.zeros((P, P))
    for group in groups:
        n = max(at + span.stop - span.start for span, at in group)
        for joint in np.flatnonzero(weighted.any(axis=(0, 2))):
            errors, used, g = np.zeros((len(group), n)), np.zeros((len(group), n)), np.zeros((len(group), n, P))
            for k, (span, at) in enumerate(group):
                place = slice(at, at + span.stop - span.start)
                used[k, place] = counts[span, joint]
                errors[k, place] = np.where(counts[span, joint], e[span, joint], 0.0)
                g[k, place] = weighted[span, joint]
            products, pairs = (_lagged(each.sum(axis=0)) - np.sum([_lagged(x) for x in each], axis=0)
                               for each in (errors, used))  # fmt: skip
            c = products / np.maximum(pairs, 1.0)
            c = c[: int(np.argmin(np.append(c, -1.0) > 0.0))]
            if len(c):
                total += _through(c, g.sum(axis=0)) - np.sum([_through(c, own) for own in g], axis=0)
    return 0.5 * (total + total.T)


def _through(c: Array, g: Array) -> Array:
    """(P, P) gᵀ C g. c: (lags,) of the errors; g: (n, P)."""
    length = next_fast_len(len(g) + len(c), real=True)
    waves = rfft(g, length, axis=0)
    both_ways = np.full(len(waves), 2.0 / length)
    both_ways[[0] if length % 2 else [0, -1]] = 1.0 / length
    spectrum = ((2.0 * rfft(c, length).real - c[0]) * both_ways)[:, None]
    return np.asarray(sum(np.dot(part.T, spectrum * part) for part in (waves.real, waves.imag)))


def _lagged(x: Array) -> Array:
    """(lags,) Σ x(t) x(t + lag), up to half of x (n,)."""
    n = len(x)
    return np.asarray(np.fft.irfft(np.abs(np.fft.rfft(x, 2 * n)) ** 2)[: max(n // 2, 1)])


def of_one_log(counts: BoolArray, e: Array, weighted: Array) -> Array:
    """The same of one log, and no less in any direction than errors that do not last make of it: a spectrum of an
    autocovariance that was cut off goes below zero, where such a sum would be known better than exactly."""
    square = np.sum(np.where(counts, e, 0.0) ** 2, axis=0) / np.maximum(counts.sum(axis=0), 1)
    alone = np.einsum("ndp,d,ndq->pq", weighted, square, weighted, optimize=True)
    return larger(by_autocovariance((slice(0, len(e)),), counts, e, weighted), alone)


def larger(first: Array, second: Array) -> Array:
    """(P, P) the first, and what the second has more of in any direction."""
    size = np.sqrt(np.maximum(np.diag(first) + np.diag(second), 1e-300))
    more, directions = np.linalg.eigh((second - first) / np.outer(size, size))
    return np.asarray(first + (directions * np.maximum(more, 0.0)) @ directions.T * np.outer(size, size))


def autocovariance(errors: Array, used: BoolArray) -> Array:
    """(lags,) about zero, up to half of the log or to where it is first not positive. errors: (n,), 0 where unused."""
    return _autocovariances(errors[None], used[None])[0]


def _autocovariances(errors: Array, used: BoolArray) -> list[Array]:
    """Of every row of errors and used, (D, n)."""
    products, pairs = (part[0] for part in _lags_of_all([(errors, used)]))
    return _cut_off(products, pairs)


def _lags_of_all(logs: Sequence[tuple[Array, BoolArray]]) -> tuple[Array, Array]:
    """(L, D, lags) sums of products of errors, and of pairs of samples, up to half of the longest log."""
    most = max(max(errors.shape[1] // 2, 1) for errors, _ in logs)
    found = np.zeros((2, len(logs), logs[0][0].shape[0], most))
    for k, log in enumerate(logs):
        n = log[0].shape[1]
        for kind, x in enumerate(log):
            found[kind, k, :, : max(n // 2, 1)] = np.fft.irfft(np.abs(np.fft.rfft(x, 2 * n)) ** 2)[:, : max(n // 2, 1)]
    return found[0], found[1]


def _cut_off(products: Array, pairs: Array) -> list[Array]:
    """Of every row of (D, lags), to where it is first not positive."""
    c: Array = products / np.maximum(pairs, 1.0)
    positive = np.cumprod(c > 0.0, axis=1)
    positive[:, 0] = 1
    return [own[: int(count)] for own, count in zip(c, positive.sum(axis=1), strict=True)]
