"""Whether a person's left is on the left: toes point ahead of hips whose left side is named."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.motion_import import USUAL
from exogauge.errors import BadMotion, Fault
from exogauge.motion.fit.places import place_of
from exogauge.motion.human import HumanMotion, JointTree, Markers

Array = NDArray[np.float64]
UP = np.array([0.0, 0.0, 1.0])
DOUBT = "toes point behind the hips"
WHY = "Left and right are exchanged in the names, or one axis of the file points the other way"


def exchanged(motion: HumanMotion) -> bool:
    """Whether toes point behind the hips, as where left and right are exchanged or one axis points the other way."""
    seen = _tree(motion.tree) if motion.tree is not None else None
    left, ways = seen or (_markers(motion.markers) if motion.markers is not None else (np.zeros((1, 3)), []))
    behind = [share for ahead in ways if (share := _ahead(left, ahead)) is not None]
    return bool(behind) and max(behind) < -USUAL.level


def _ahead(left: Array, along: Array) -> float | None:
    """Cosine between a way along (T, 3) and what is ahead of (T, 3) to the left; None where neither is seen."""
    meant = np.cross(left, UP)
    size = np.linalg.norm(meant, axis=1) * np.hypot(along[:, 0], along[:, 1])
    known = np.isfinite(size) & (size > 0.0)
    return float(np.median(np.sum(meant * along, axis=1)[known] / size[known])) if known.any() else None


def refuse_exchanged(motion: HumanMotion) -> None:
    """Raises BadMotion."""
    if exchanged(motion):
        raise BadMotion(Fault(DOUBT, "mirrored", f"{WHY}: export it again, right-handed", motion.name))


def _tree(tree: JointTree) -> tuple[Array, list[Array]]:
    """(T, 3) from the right hip to the left one, and along both feet."""
    bone = {part: tree.names.index(name) for name, part in reversed(list(tree.segment.items()))}
    if not {"l_thigh", "r_thigh", "l_foot", "r_foot"} <= set(bone):
        return np.zeros((1, 3)), []
    along = np.mean([_to_toes(tree, bone[foot]) for foot in ("l_foot", "r_foot")], axis=0)
    return tree.position[:, bone["l_thigh"]] - tree.position[:, bone["r_thigh"]], [along]


def _to_toes(tree: JointTree, foot: int) -> Array:
    """(T, 3), level, from the ankle to what of the foot lies farthest from it: some have bones of the heel too."""
    own = [foot]
    for k in range(foot + 1, len(tree.names)):
        if tree.parent[k] in own:
            own.append(k)
    ends = np.concatenate([tree.position[:, own], tree.end[:, own]], axis=1)
    level = (ends - tree.position[:, [foot]]) * (1.0 - UP)
    far = np.median(np.linalg.norm(level, axis=2), axis=0)
    return level[:, int(far.argmax())] if far.max() > USUAL.least_foot_m else np.full(level[:, 0].shape, np.nan)


def _markers(markers: Markers) -> tuple[Array, list[Array]]:
    """(T, 3) to the left through the pelvis, and ahead through pelvis and feet, by where names sit on a body."""
    left, ways = np.zeros((len(markers.position), 3)), []
    for part in ("pelvis", "l_foot", "r_foot"):
        on = [(m, found[0]) for m, label in enumerate(markers.labels) if markers.segment.get(label) == part
              and (found := place_of(label, part)) is not None and found[1]]  # fmt: skip
        if len(on) < 2:
            continue
        slopes = _slopes(markers.position[:, [m for m, _ in on]], np.array([where[:2] for _, where in on]))
        ways.append(slopes[..., 0])
        if part == "pelvis":
            left = slopes[..., 1]
    return left, ways


def _slopes(place: Array, nominal: Array) -> Array:
    """(T, 3, 2): where points (T, M, 3) lie that are far along each of two axes (M, 2); gaps left out."""
    there = np.isfinite(place)
    count = np.maximum(there.sum(axis=1, keepdims=True), 1)
    here = np.where(there, place, 0.0)
    named = np.where(there[..., :1], nominal, 0.0)
    off = np.where(there, here - here.sum(axis=1, keepdims=True) / count, 0.0)
    return np.asarray(np.einsum("tma,tmb->tab", off, named))
