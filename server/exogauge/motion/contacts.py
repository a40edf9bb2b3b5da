"""When each foot stands: a point of it is low and slow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.motion_import import USUAL, MotionImport
from exogauge.logs.findings import runs
from exogauge.motion.human import Contacts, HumanMotion

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


def with_contacts(motion: HumanMotion, criteria: MotionImport = USUAL) -> HumanMotion:
    """The motion with `contacts`, where points of both feet are known; else as it was."""
    left, right = _points(motion, "l_foot"), _points(motion, "r_foot")
    if left is None or right is None:
        return motion
    feet = [_stands(each, motion.rate, criteria) for each in (left, right)]
    return replace(motion, contacts=Contacts(*feet))


def _points(motion: HumanMotion, part: str) -> Array | None:
    """(T, K, 3) [m] of a foot."""
    if motion.markers is not None:
        markers = motion.markers
        kept = [k for k, label in enumerate(markers.labels) if markers.segment.get(label) == part]
        return markers.position[:, kept] if kept else None
    if motion.tree is not None:
        tree = motion.tree
        kept = [k for k, name in enumerate(tree.names) if tree.segment.get(name) == part]
        return np.concatenate([tree.position[:, kept], tree.end[:, kept]], axis=1) if kept else None
    return None


def _stands(points: Array, rate: float, criteria: MotionImport) -> BoolArray:
    """(T,); what is shorter than `shortest_step_s` is neither a step nor a stand. Unseen points say nothing."""
    half = max(1, round(0.5 * criteria.smooth_s * rate))
    at = np.arange(len(points))
    after, before = np.minimum(at + half, len(points) - 1), np.maximum(at - half, 0)
    speed = np.linalg.norm(points[after] - points[before], axis=2) * (rate / (after - before))[:, None]
    seen = np.isfinite(points[..., 2])
    lowest = np.array(
        [np.percentile(z[ok], 5) if ok.any() else np.inf for z, ok in zip(points[..., 2].T, seen.T, strict=True)]
    )
    with np.errstate(invalid="ignore"):
        stands: BoolArray = ((points[..., 2] - lowest < criteria.low_m) & (speed < criteria.slow_m_per_s)).any(axis=1)
    unknown = ~np.isfinite(speed).any(axis=1)
    for start, length in zip(*runs(unknown), strict=True):  # as before the foot was lost
        stands[start : start + length] = stands[start - 1] if start else False
    for value in (True, False):
        for start, length in zip(*runs(stands == value), strict=True):
            if start > 0 and start + length < len(stands) and length < criteria.shortest_step_s * rate:
                stands[start : start + length] = not value
    return stands
