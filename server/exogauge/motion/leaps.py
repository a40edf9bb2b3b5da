"""Points that are elsewhere from one frame to the next: labels exchanged for a while, markers that slipped, values that
were held, captures that were joined."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.motion_import import USUAL, MotionImport
from exogauge.logs.findings import runs

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
Stretch = tuple[int, int]
Leaps = dict[int, Array]


def sort_out(names: Sequence[str], position: Array, rate: float, segment: Mapping[str, str]) -> dict[str, str]:
    """What is told of markers `position` (T, N, 3) [m], NaN where not seen; it is changed: labels that were exchanged
    are put back, what is held or elsewhere is not seen. rate: [Hz]. segment: of a name, which part it is on; others
    are left alone."""
    told, parts = dict[str, str](), dict[str, list[int]]()
    for n, name in enumerate(names):
        if name in segment:
            parts.setdefault(segment[name], []).append(n)
    known = sorted(n for points in parts.values() for n in points)
    leaps = leaps_of(position, rate, known)
    if stays := held(position, list(parts.values()), leaps):
        told["held"] = _words(names, stays, rate)
        _lose(position, stays)
        leaps = leaps_of(position, rate, known)
    cuts = joined(position, leaps)
    if cuts:
        told["joined"] = (
            f"most markers are elsewhere from one frame to the next {_when([(t, t + 1) for t in cuts], rate)}"
        )
    for leap in leaps.values():
        leap[cuts] = 0.0
    if back := put_back(position, leaps) | neighbours_put_back(position, list(parts.values())):
        told["exchanged"] = "; ".join(f"{names[i]} and {names[j]} {_when(frames, rate)}: put back"
                                      for (i, j), frames in back.items())  # fmt: skip
    if away := aside(leaps):
        told["slips"] = _words(names, away, rate)
        _lose(position, away)
    trunk = [points for part, points in parts.items() if part in ("pelvis", "thorax")]
    if stray := strays(position, rate, trunk):
        told["strays"] = "; ".join(f"{names[n]} by {100.0 * by:.1f} cm at {(t + 1) / rate:.2f} s"
                                   for n, (t, by) in stray.items())  # fmt: skip
    return told


def leap_of_bones(names: Sequence[str], position: Array, rate: float) -> str | None:
    """Which bones (T, N, 3) leap, parents first, when, and by how much."""
    leaps = leaps_of(position, rate, range(len(names)))
    if not leaps:
        return None
    steps = np.flatnonzero(np.any([leap.any(axis=1) for leap in leaps.values()], axis=0))
    first = next(n for n in leaps if leaps[n][steps[0]].any())
    far = np.linalg.norm(leaps[first][steps[0]])
    more = f", and {len(steps) - 1} times more" if len(steps) > 1 else ""
    return f"{names[first]} is {far:.2g} m elsewhere from {steps[0] / rate:.2f} s to the next frame{more}"


def rate_doubt(trunk: Array, feet: Array, rate: float, criteria: MotionImport = USUAL) -> str | None:
    """Why `rate` [Hz] is none at which a person moved so. trunk, feet: (T, ., 3) [m] points of them."""
    low, high = criteria.usual_hz
    if not low <= rate <= high:
        return f"{rate:.4g} frames a second: neither cameras nor suits run so"
    h = max(1, round(criteria.fast_s * rate))
    fast = np.sum((trunk[2 * h :] - 2.0 * trunk[h:-h] + trunk[: -2 * h]) ** 2, axis=2) * (rate / h) ** 4
    known = np.isfinite(fast)
    rms = float(np.sqrt((np.where(known, fast, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)).max(initial=0.0)))
    if rms > criteria.fast_m_per_s2:
        return f"the trunk accelerates by {rms:.0f} m/s² (rms): nobody does at {rate:.4g} frames a second"
    slowest = _comes_back(trunk, feet, rate, criteria)
    if slowest is not None and slowest < criteria.slow_hz:
        return (f"the trunk moves as what comes back every {1.0 / slowest:.0f} s: who does not do so on purpose is ten "
                f"times as fast, and {rate:.4g} frames a second too few")  # fmt: skip
    return None


def _comes_back(trunk: Array, feet: Array, rate: float, criteria: MotionImport) -> float | None:
    """[Hz] at which the trunk moves over the feet: acceleration over speed, rms, over 2 π, over windows in which noise
    is little. None of who hardly moves, of a short capture, and where no feet are seen."""
    every = max(1, round(criteria.slow_s * rate / 10.0))
    trunk, feet, h = trunk[::every], feet[::every], round(criteria.slow_s * rate / every)
    seen = np.isfinite(feet[..., 0])
    if len(trunk) < 5 * h or not seen.any():
        return None
    count = seen.sum(axis=1)[:, None]
    ground = np.where(seen[..., None], feet, 0.0).sum(axis=1) / np.where(count, count, np.nan)
    way = trunk - ground[:, None]
    speed, bend = (way[2 * h :] - way[: -2 * h]) / 2.0, way[2 * h :] - 2.0 * way[h:-h] + way[: -2 * h]
    whole = np.isfinite(bend[..., 0]) & np.isfinite(speed[..., 0])
    ever = way[:, np.isfinite(way[..., 0]).any(axis=0)]
    if not whole.any() or (np.nanmax(ever, axis=0) - np.nanmin(ever, axis=0)).max() < criteria.moves_m:
        return None
    return float(np.sqrt(np.sum(bend[whole] ** 2) / np.sum(speed[whole] ** 2)) * rate / (2.0 * np.pi * h * every))


def leaps_of(position: Array, rate: float, points: Sequence[int], criteria: MotionImport = USUAL) -> Leaps:
    """Of those `points` of (T, N, 3) that leap, (T - 1, 3) [m]: by how much the way from each frame to the next differs
    from the ways beside it, where that is more than `farthest`, else 0.

    Beside it: the median, axis by axis, of two steps before and two after. A single step that is wrong does not move
    it, nor do both of a point that is elsewhere in one frame. Across a gap no step is looked at.
    """
    most, found = farthest(rate, criteria), Leaps()
    window, steps = np.arange(-2, 3), len(position) - 1
    far = _of_steps(position, lambda before, after: np.abs(after - before).max(axis=2, initial=0.0) > most / 2.0)
    for n in points:
        near = np.flatnonzero(far[:, n])
        at = near[:, None] + window
        inside = np.clip(at, 0, steps - 1)
        step = position[inside + 1, n] - position[inside, n]
        off = step[:, 2] - _median(np.where((at == inside)[..., None], step, np.nan))
        leapt = np.linalg.norm(off, axis=1) > most
        if leapt.any():
            found[n] = np.zeros((steps, 3))
            found[n][near[leapt]] = off[leapt]
    return found


def _of_steps(position: Array, test: Callable[[Array, Array], BoolArray]) -> BoolArray:
    """(T - 1, N) of what is seen in a frame and in the next, (., N, 3) each; some thousand at a time."""
    together = 4096  # frames: 5 MB of 50 markers, whatever the capture's length
    parts = range(0, len(position) - 1, together)
    return np.concatenate([test(position[k : k + together][: len(position) - 1 - k], position[k + 1 : k + 1 + together])
                           for k in parts])  # fmt: skip


def farthest(rate: float, criteria: MotionImport = USUAL) -> float:
    """[m] by which a step between two frames may differ from those beside it."""
    return criteria.leap_m + 0.5 * criteria.jerk_m_per_s3 / rate**3


def _median(values: Array) -> Array:
    """(C, 3) of (C, W, 3), over those of W that are finite."""
    ranked = np.sort(values, axis=1)  # NaN come last
    count = np.isfinite(ranked).sum(axis=1, keepdims=True)
    low, high = (np.take_along_axis(ranked, each, axis=1)[:, 0] for each in ((count - 1) // 2, count // 2))
    return np.asarray((low + high) / 2.0)


def joined(position: Array, leaps: Leaps, criteria: MotionImport = USUAL) -> list[int]:
    """Steps from t to t + 1 in which most of what is seen leaps: another take begins, or frames are lost."""
    if len(leaps) < 2:
        return []
    count = np.sum([leap.any(axis=1) for leap in leaps.values()], axis=0)
    return [int(t) for t in np.flatnonzero(count > 1)
            if count[t] > criteria.most_leap * np.isfinite(position[t : t + 2, :, 0]).all(axis=0).sum()]  # fmt: skip


def put_back(position: Array, leaps: Leaps) -> dict[tuple[int, int], list[Stretch]]:
    """Pairs of points that took each other's place, with the frames [begin, end) in which they had it: of those in
    which they stood one way and the other the fewer. `position` (T, N, 3) and `leaps` are changed."""
    at, found = dict[tuple[int, int], list[int]](), dict[tuple[int, int], list[Stretch]]()
    leapt: dict[int, BoolArray] = {n: np.asarray(leap.any(axis=1)) for n, leap in leaps.items()}
    for t in np.flatnonzero(np.sum(list(leapt.values()), axis=0) > 1) if leapt else ():
        points = np.array([n for n in leapt if leapt[n][t]])
        far = np.linalg.norm(position[t + 1, points][:, None] - position[t, points], axis=2)
        nearest = far.argmin(axis=1)  # to where each is now, who was there
        for i, j in enumerate(nearest):
            if i < j and nearest[j] == i:
                at.setdefault((int(points[i]), int(points[j])), []).append(int(t))
    for pair, steps in at.items():
        other = np.zeros(len(position), dtype=bool)
        for step in steps:
            other[step + 1 :] ^= True
            for n in pair:
                leaps[n][step] = 0.0
        if other.mean() > 0.5:
            other = ~other
        rows = np.flatnonzero(other)[:, None]
        position[rows, pair] = position[rows, pair[::-1]]
        found[pair] = _stretches(other)
    return found


def neighbours_put_back(
    position: Array, parts: Sequence[Sequence[int]], criteria: MotionImport = USUAL
) -> dict[tuple[int, int], list[Stretch]]:
    """As `put_back`, of pairs on one part of the body that are nearer to each other than a leap: the way from one to
    the other turns round from one frame to the next. parts: the points on each. `position` is changed."""
    found = dict[tuple[int, int], list[Stretch]]()
    some = position[:: max(1, len(position) // criteria.looked_at)]
    for i, j in ((i, j) for points in parts for k, i in enumerate(points) for j in points[k + 1 :]):
        with np.errstate(invalid="ignore"):
            if not (np.abs(some[:, j] - some[:, i]).max(axis=1) < criteria.leap_m).any():
                continue
            way = position[:, j] - position[:, i]
            steps = np.flatnonzero(np.einsum("ta,ta->t", way[1:], way[:-1]) < 0.0)
            turned, straight = (np.linalg.norm(way[steps + 1] + sign * way[steps], axis=1) for sign in (1.0, -1.0))
        steps = steps[(turned < criteria.lands * straight) & (straight > criteria.apart_least_m)]
        if not len(steps):
            continue
        other = np.zeros(len(position), dtype=bool)
        for step in steps:
            other[step + 1 :] ^= True
        if other.mean() > 0.5:
            other = ~other
        rows = np.flatnonzero(other)[:, None]
        position[rows, [i, j]] = position[rows, [j, i]]
        found[i, j] = _stretches(other)
    return found


def strays(
    position: Array, rate: float, parts: Sequence[Sequence[int]], criteria: MotionImport = USUAL
) -> dict[int, tuple[int, float]]:
    """Points that leap against the others on their part, less far than what is taken for a slip: the step and [m], of
    each the largest. parts: the points on each, of `position` (T, N, 3)."""
    found, finer = dict[int, tuple[int, float]](), replace(criteria, leap_m=criteria.strays_m)
    for points in parts:
        if len(points) < 3:
            continue
        own = position[:, points]
        beside = len(points) / (len(points) - 1.0) * (own - own.mean(axis=1, keepdims=True))  # from the others' middle
        leaps = leaps_of(beside, rate, range(len(points)), finer)
        far = {k: np.linalg.norm(leap, axis=1) for k, leap in leaps.items()}
        for k, by in far.items():
            t = int(by.argmax())
            if by[t] == max(each[t] for each in far.values()):
                found[points[k]] = t, float(by[t])
    return found


def aside(leaps: Leaps) -> dict[int, list[Stretch]]:
    """Frames [begin, end) in which points are that leapt away from where they are most of the time."""
    found = {}
    for n, leap in leaps.items():
        if leap.any():
            place = np.concatenate([np.zeros((1, 3)), np.cumsum(leap, axis=0)])
            off = np.linalg.norm(place - np.median(place, axis=0), axis=1)
            found[n] = _stretches(off > 0.5 * np.linalg.norm(leap, axis=1).max())
    return found


def held(
    position: Array, parts: Sequence[Sequence[int]], leaps: Leaps, criteria: MotionImport = USUAL
) -> dict[int, list[Stretch]]:  # fmt: skip
    """Frames [begin, end) in which a point keeps the very numbers of the frame before while the others of its part
    move, their leaps aside: a program wrote what it knew last. parts: the points on each part of the body, of
    `position` (T, N, 3)."""
    found = dict[int, list[Stretch]]()
    same = _of_steps(position, lambda before, after: np.asarray((before == after).all(axis=2)))
    for points in parts:
        for n in points:
            others = [k for k in points if k != n]
            for start, length in zip(*runs(same[:, n]), strict=True):
                if length < criteria.held_frames or not others:
                    continue
                moved = position[start : start + length + 1, others]
                for k, other in enumerate(others):
                    if other in leaps:
                        moved[1:, k] -= np.cumsum(leaps[other][start : start + length], axis=0)
                moved = moved[:, np.isfinite(moved).all(axis=(0, 2))]
                if moved.size and np.median(np.linalg.norm(np.ptp(moved, axis=0), axis=1)) > criteria.held_m:
                    found.setdefault(n, []).append((int(start + (start > 0)), int(start + length + 1)))
    return found


def _stretches(flags: BoolArray) -> list[Stretch]:
    return [(int(start), int(start + length)) for start, length in zip(*runs(flags), strict=True)]


def _lose(position: Array, frames: Mapping[int, Sequence[Stretch]]) -> None:
    for n, stretches in frames.items():
        for begin, end in stretches:
            position[begin:end, n] = np.nan


def _words(names: Sequence[str], frames: Mapping[int, Sequence[Stretch]], rate: float) -> str:
    return "; ".join(f"{names[n]} {_when(stretches, rate)}" for n, stretches in frames.items())


def _when(frames: Sequence[Stretch], rate: float) -> str:
    begin, end = frames[0]
    said = f"at {begin / rate:.2f} s" if end - begin == 1 else f"{begin / rate:.2f} to {(end - 1) / rate:.2f} s"
    return said if len(frames) == 1 else f"{said}, and {len(frames) - 1} times more"
