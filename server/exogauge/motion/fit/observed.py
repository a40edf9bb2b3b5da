"""What a motion says of the body: points with their nominal places, and angles where a skeleton states them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from exogauge.criteria.motion_fit import MotionFit
from exogauge.errors import BadMotion, Fault
from exogauge.motion.fit.body import (
    FOREARM,
    HIP,
    NECK,
    OF_SEGMENT,
    PELVIS,
    SHANK,
    SHOULDER,
    THIGH,
    TRUNK,
    UPPER_ARM,
    HumanBody,
    scales_of,
)  # fmt: skip
from exogauge.motion.fit.kinematics import Points
from exogauge.motion.fit.places import place_of
from exogauge.motion.human import HumanMotion, JointTree
from exogauge.motion.person import axes_of, bones_of
from exogauge.robots.moving.segments import SEGMENTS, Segment

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
STATED = slice(3, 9)  # coordinates: how the pelvis turns in the world, and the thorax in the pelvis
HEAD = ("head_flexion", "head_bend", "head_rotation")


@final
@dataclass(frozen=True)
class Observed:
    """position: (T, M, 3) [m], NaN where not seen. offset_sd: (M,) [m] of a point beside its nominal place. known: (M,)
    has it a nominal place?

    mean, weight: (T, K) angles that are stated, and 1/variance of that; 0 where nothing is.
    """

    labels: tuple[str, ...]
    segment: tuple[Segment, ...]
    points: Points
    position: Array
    offset_sd: Array
    known: BoolArray
    mean: Array
    weight: Array

    def seen_of(self, part: Segment) -> NDArray[np.intp]:
        """(T,) points of known place that are seen on a part of the body."""
        on = np.array([each == part for each in self.segment]) & self.known
        return np.asarray(np.isfinite(self.position[:, on, 0]).sum(axis=1))

    def fixed(self, fewest: int) -> BoolArray:
        """(T,) how pelvis and thorax lie is seen, by `fewest` points of each, or stated."""
        stated = (self.weight[:, STATED] > 0.0).all(axis=1)
        return np.asarray(stated | ((self.seen_of("pelvis") >= fewest) & (self.seen_of("thorax") >= fewest)))

    def lost(self) -> BoolArray:
        """(T,) of pelvis or of thorax nothing is seen, nor stated."""
        return ~self.fixed(1)


def at_frames(observed: Observed, frames: slice | NDArray[np.intp]) -> Observed:
    """Some of its frames."""
    return replace(observed, position=observed.position[frames], mean=observed.mean[frames],
                   weight=observed.weight[frames])  # fmt: skip


def observe(motion: HumanMotion, body: HumanBody, criteria: MotionFit) -> Observed:
    """Raises BadMotion where pelvis or thorax cannot be known."""
    if motion.tree is not None:
        return _of_tree(motion, motion.tree, body, criteria)
    if motion.markers is None:
        raise _fault(motion, "the file holds angles and no points", "no_points", "Give the markers or the skeleton")
    markers = motion.markers
    seen = np.isfinite(markers.position[..., 0])
    kept = [m for m, label in enumerate(markers.labels) if label in markers.segment and seen[:, m].any()]
    segment = tuple(markers.segment[markers.labels[m]] for m in kept)
    found = [place_of(markers.labels[m], part) for m, part in zip(kept, segment, strict=True)]
    known = np.array([each is not None for each in found], dtype=bool)
    for part in ("pelvis", "thorax"):
        count = sum(each == part and bool(sure) for each, sure in zip(segment, known, strict=True))
        if count < criteria.fewest:
            advice = "Label them as Plug-in Gait, CMU, OpenCap or OptiTrack do"
            sites = {(x, abs(y), z) for on, each in zip(segment, found, strict=True) if on == part and each is not None
                     for x, y, z in (each[0],)}  # fmt: skip
            if sites == {HIP}:
                advice = "Centres of the hips do not say how it tilts: export markers, or those that Pose2Sim augments"
            raise _fault(motion, f"{count} markers of known place are seen on the {part}, {criteria.fewest} are needed",
                         "too_few_markers", advice, column=part)  # fmt: skip
        on = np.array([each == part for each in segment]) & known
        enough = seen[:, np.array(kept)[on]].sum(axis=1) >= criteria.fewest
        if enough.mean() < criteria.least_seen:
            raise _fault(motion, f"{criteria.fewest} markers of the {part} are seen in {100 * enough.mean():.3g} % of "
                         f"frames, {100 * criteria.least_seen:.3g} % are needed", "gaps",
                         "Close the gaps first: fill=True, or where it was captured", column=part)  # fmt: skip
    sd = [criteria.unknown_sd if each is None else criteria.landmark_sd if each[1] else criteria.loose_sd
          for each in found]  # fmt: skip
    nominal = [each[0] if each is not None else (0.0, 0.0, 0.0) for each in found]
    return _observed(body, [markers.labels[m] for m in kept], segment, nominal, markers.position[:, kept],
                     np.array(sd), known)  # fmt: skip


def standing(observed: Observed, body: HumanBody, criteria: MotionFit) -> Observed:
    """A static trial: its trunk is straight, which is the zero of the trunk's angles; legs and head are about so."""
    weight = observed.weight.copy()
    for k, name in enumerate(body.coordinates):
        if name in TRUNK:
            weight[:, k] = criteria.still_rad**-2
        elif name in HEAD or name in PELVIS[4:] or any(each in name for each in ("hip_flexion", "knee", "ankle")):
            weight[:, k] = criteria.tilt_rad**-2
    return Observed(observed.labels, observed.segment, observed.points, observed.position, observed.offset_sd,
                    observed.known, np.zeros_like(weight), weight)  # fmt: skip


def _of_tree(motion: HumanMotion, tree: JointTree, body: HumanBody, criteria: MotionFit) -> Observed:
    """Joint centres as points; pelvis, trunk and head turn as their bones do against the rest posture."""
    bone = bones_of(tree)
    lost = [part for part in ("pelvis", "thorax", "l_thigh", "r_thigh") if part not in bone]
    if lost:
        raise _fault(motion, f"the skeleton has no bone known as {', '.join(lost)}", "no_such_bone",
                     "Name its bones as Acclaim, iClone or Mixamo do", column=lost[0])  # fmt: skip
    labels: list[str] = []
    segment: list[Segment] = []
    nominal, where, sd = [], [], []  # type: list[tuple[float, float, float]], list[Array], list[float]

    def add(label: str, on: Segment, place: tuple[float, float, float], at: Array, spread: float) -> None:
        labels.append(label)
        segment.append(on)
        nominal.append(place)
        where.append(at)
        sd.append(spread)

    tight, loose = criteria.joint_sd, criteria.loose_sd
    for s, side in (("l", 1.0), ("r", -1.0)):
        hip, shoulder = ((x, side * y, z) for x, y, z in (HIP, SHOULDER))
        centres: list[tuple[str, str, str, tuple[float, float, float], float]] = [
            ("hip", "pelvis", f"{s}_thigh", hip, tight), ("knee", f"{s}_thigh", f"{s}_shank", (0, 0, -THIGH), tight),
            ("ankle", f"{s}_shank", f"{s}_foot", (0, 0, -SHANK), tight),
            ("shoulder", "thorax", f"{s}_upper_arm", shoulder, loose),
            ("elbow", f"{s}_upper_arm", f"{s}_forearm", (0, 0, -UPPER_ARM), tight),
            ("wrist", f"{s}_forearm", f"{s}_hand", (0, 0, -FOREARM), tight),
        ]  # fmt: skip
        for name, on, below, place, spread in centres:
            if below in bone:
                add(f"{s}_{name}", on, place, tree.position[:, bone[below]], spread)  # type: ignore[arg-type]
        for part, place in ((f"{s}_foot", (0.14, 0.0, -0.04)), (f"{s}_hand", (0.0, 0.0, -0.09))):
            if part in bone:
                add(f"{part}_end", part, place, tree.end[:, bone[part]], loose)
    if "head" in bone:
        add("neck", "thorax", NECK, tree.position[:, bone["head"]], loose)
    observed = _observed(body, labels, tuple(segment), nominal, np.stack(where, axis=1), np.array(sd),
                         np.ones(len(labels), dtype=bool))  # fmt: skip
    mean, weight = observed.mean, observed.weight
    turned = {part: tree.rotation[:, bone[part]] @ own for part, own in axes_of(motion, tree, bone).items()}
    stated = [(PELVIS[3:], "ZXY", turned["pelvis"]), (TRUNK, "YXZ", _inverse(turned["pelvis"]) @ turned["thorax"])]
    if "head" in turned:
        stated.append((HEAD, "YXZ", _inverse(turned["thorax"]) @ turned["head"]))
    for names, order, rotation in stated:
        at = [body.index(name) for name in names]
        mean[:, at] = continuous(Rotation.from_matrix(rotation).as_euler(order))  # type: ignore[call-overload]
        weight[:, at] = criteria.bone_rad**-2
    return observed


def continuous(angles: Array) -> Array:
    """(T, 3) angles about three different axes; of the two that mean the same rotation the one nearer to the frame
    before, without jumps of whole turns. The first frame takes the one whose middle angle is below 90°."""
    out = angles.copy()
    before = np.zeros(3)
    for t, (a, b, c) in enumerate(angles):
        both = np.array([[a, b, c], [a + np.pi, np.pi - b, c + np.pi]])
        both += 2 * np.pi * np.round((before - both) / (2 * np.pi))
        far = np.abs(both[:, 1]) if t == 0 else np.sum((both - before) ** 2, axis=1)
        before = out[t] = both[int(far.argmin())]
    return out


def untracked(observed: Observed) -> list[Segment]:
    """Parts of the body without a point."""
    return [part for part in SEGMENTS if part not in observed.segment]


def _observed(
    body: HumanBody, labels: list[str], segment: tuple[Segment, ...], nominal: list[tuple[float, float, float]],
    position: Array, sd: Array, known: BoolArray,
) -> Observed:  # fmt: skip
    joint = np.array([body.part[part] for part in segment], dtype=np.intp)
    stretch = np.array([scales_of(OF_SEGMENT[part.removeprefix("l_").removeprefix("r_")]) for part in segment])
    empty = np.zeros((len(position), len(body.coordinates)))
    return Observed(tuple(labels), segment, Points(joint, np.array(nominal), stretch), position, sd, known, empty,
                    empty.copy())  # fmt: skip


def _inverse(rotation: Array) -> Array:
    return np.swapaxes(rotation, 1, 2)


def _fault(motion: HumanMotion, detail: str, rule: str, advice: str, column: str | None = None) -> BadMotion:
    return BadMotion(Fault(detail, rule, advice, motion.name, column=column))
