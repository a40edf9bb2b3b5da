"""Whether a person's left is on the left: toes point ahead of hips whose left side is named, and all names agree."""

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


def sides_doubt(motion: HumanMotion) -> str | None:
    """Why left is not left: toes point behind the hips, as where the names of all are exchanged or one axis points the
    other way; or some names are exchanged against the others."""
    if _behind(motion):
        return f"{DOUBT}. {WHY}"
    crossed = _crossed(motion)
    return None if not crossed else (f"left lies to the right of {', of '.join(crossed)}, unlike the rest: left and "
                                     "right are exchanged in these names")  # fmt: skip


def _crossed(motion: HumanMotion) -> list[str]:
    """Pairs whose left one lies to the right, against what the others say, in nearly all frames."""
    pairs = _pairs_of_bones(motion.tree) if motion.tree is not None else _pairs_of_markers(motion.markers)
    way = {names: left - right for names, (left, right) in pairs.items()}
    for each in way.values():
        each[:, 2] = 0.0
        each[np.linalg.norm(each, axis=1) < USUAL.apart_m] = np.nan
        each /= np.linalg.norm(each, axis=1, keepdims=True)
    fewest = 3  # pairs, of which two outvote one
    if len(way) < fewest:
        return []
    all_ways = np.sum([np.nan_to_num(each) for each in way.values()], axis=0)
    found = []
    for names, own in way.items():
        known = np.isfinite(own[:, 0])
        others = all_ways[known] - own[known]
        size = np.linalg.norm(others, axis=1)
        against = np.sum(own[known] * others, axis=1) < -USUAL.level * size
        if known.any() and (against & (size > 1.0)).mean() > USUAL.crossed:
            found.append(names)
    return found


def _pairs_of_bones(tree: JointTree) -> dict[str, tuple[Array, Array]]:
    bone: dict[str, str] = {part: name for name, part in reversed(list(tree.segment.items()))}
    at, found = tree.position, dict[str, tuple[Array, Array]]()
    for part, name in bone.items():
        other = bone.get(f"r_{part[2:]}") if part.startswith("l_") and not part.endswith("hand") else None
        if other is not None:
            found[f"{name} and {other}"] = (at[:, tree.names.index(name)], at[:, tree.names.index(other)])
    return found


def _pairs_of_markers(markers: Markers | None) -> dict[str, tuple[Array, Array]]:
    """Those of known places that lie alike on both sides; hands cross, and are left out."""
    if markers is None:
        return {}
    left, right = dict[tuple[str, object], int](), dict[tuple[str, object], int]()
    for m, label in enumerate(markers.labels):
        part = markers.segment.get(label, "")
        place = place_of(label, part)
        if place is None or part.endswith(("hand", "forearm")):
            continue
        x, y, z = place[0]
        whole = part.removeprefix("l_").removeprefix("r_")
        on_left = y > 0.0 if part == whole else part.startswith("l_")
        if y or part != whole:
            side, inwards = (left, y) if on_left else (right, -y)
            side.setdefault((whole, (x, inwards, z)), m)
    at = markers.position
    return {f"{markers.labels[m]} and {markers.labels[right[key]]}": (at[:, m], at[:, right[key]])
            for key, m in left.items() if key in right}  # fmt: skip


def _behind(motion: HumanMotion) -> bool:
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
    if (doubt := sides_doubt(motion)) is not None:
        advice = "Correct the names, or export it again, right-handed"
        raise BadMotion(Fault(doubt, "mirrored", advice, motion.name))


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
