"""Where a marker was not seen: short gaps by a spline, longer ones by the rigid segment. What was filled is marked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from exogauge.criteria.motion_import import USUAL, MotionImport
from exogauge.logs.findings import runs
from exogauge.motion.human import HumanMotion, Markers

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
FEWEST = 3  # points that say how a rigid body lies


def fill_gaps(motion: HumanMotion, criteria: MotionImport = USUAL) -> HumanMotion:
    """The motion with its gaps closed as far as they can be; `told["filled"]` says how. Nothing measured is changed."""
    if motion.markers is None:
        return motion
    markers = motion.markers
    position, seen = markers.position.copy(), np.isfinite(markers.position[..., 0])
    for m in range(len(markers.labels)):
        _spline(motion.time, position[:, m], seen[:, m], criteria)
    by_spline = np.isfinite(position[..., 0]) & ~seen
    sound = position.copy()  # a rigid fill rests on what was seen or splined, not on another rigid fill
    for m, others in enumerate(_others(markers)):
        if len(others) >= FEWEST:
            _rigid(position[:, m], sound[:, m], sound[:, others], criteria.rigid_m)
    filled = np.isfinite(position[..., 0]) & ~seen
    shares = [100.0 * part.mean() for part in (by_spline, filled & ~by_spline, ~seen & ~filled)]
    said = "{:.2g} % of samples by splines, {:.2g} % by rigid segments; {:.2g} % stay gaps".format(*shares)
    whole = replace(markers, position=position, filled=markers.filled | filled)
    return replace(motion, markers=whole, told={**motion.told, "filled": said})


def _spline(time: Array, place: Array, seen: BoolArray, criteria: MotionImport) -> None:
    """place: (T, 3), written to. Gaps at either end have nothing beyond them, and stay."""
    for start, length in zip(*runs(~seen), strict=True):
        stop = start + length
        before = np.flatnonzero(seen[:start])[-criteria.beside :]
        after = stop + np.flatnonzero(seen[stop:])[: criteria.beside]
        if min(len(before), len(after)) < 2 or time[stop] - time[start - 1] > criteria.spline_s:
            continue
        known = np.concatenate([before, after])
        place[start:stop] = CubicSpline(time[known], place[known])(time[start:stop])


def _others(markers: Markers) -> list[list[int]]:
    """Of every marker, those on the same part of the body."""
    part = [markers.segment.get(label) for label in markers.labels]
    return [[k for k, each in enumerate(part) if each is not None and each == own and k != m]
            for m, own in enumerate(part)]  # fmt: skip


def _rigid(place: Array, seen: Array, others: Array, most: float) -> None:
    """place: (T, 3), written to where `seen` (T, 3) is NaN; others: (T, K, 3).

    Carried from the nearest frames before and after in which it was seen, each by how near it is.
    """
    there, known = np.isfinite(seen[:, 0]), np.isfinite(others[..., 0])
    for start, length in zip(*runs(~there), strict=True):
        stop = start + length
        ends = [t for t in (start - 1, stop) if 0 <= t < len(place)]
        for t in range(start, stop):
            said = [(abs(t - end), _carried(seen[end], others[end], others[t], known[end] & known[t], most))
                    for end in ends]  # fmt: skip
            found = [(1.0 / far, where) for far, where in said if where is not None]
            if found:
                place[t] = sum(weight * where for weight, where in found) / sum(weight for weight, _ in found)


def _carried(point: Array, then: Array, now: Array, both: BoolArray, most: float) -> Array | None:
    """Where a body's point is now, by the body's other points then and now; None where those do not say.

    Least-squares rotation by singular values (Kabsch, Acta Cryst. A32, 1976). Points on a line leave it open.
    """
    if both.sum() < FEWEST:
        return None
    a, b = then[both].mean(axis=0), now[both].mean(axis=0)
    U, size, Vt = np.linalg.svd((then[both] - a).T @ (now[both] - b))
    if size[1] < most**2:
        return None
    R = Vt.T @ np.diag([1.0, 1.0, np.sign(np.linalg.det(Vt.T @ U.T))]) @ U.T
    missed = now[both] - b - (then[both] - a) @ R.T
    if np.sqrt(np.mean(np.sum(missed**2, axis=1))) > most:
        return None
    carried: Array = b + R @ (point - a)
    return carried
