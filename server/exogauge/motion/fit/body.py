"""A human body of single joints: what turns about what, and how long each part is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.robots.moving.segments import Segment

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

SCALES = (
    "pelvis_width", "pelvis_height", "lumbar_depth", "trunk", "shoulder_width", "head", "upper_arm", "forearm", "hand",
    "thigh", "shank", "foot",
)  # fmt: skip
STATURE = 1.75  # m, of the body whose scales are all 1
THIGH, SHANK = 0.245 * STATURE, 0.246 * STATURE  # Drillis & Contini 1966, as in Winter 2009, figure 4.1
UPPER_ARM, FOREARM = 0.186 * STATURE, 0.146 * STATURE  # likewise
HIP_HEIGHT, SHOULDER_HEIGHT, NECK_HEIGHT = 0.530 * STATURE, 0.818 * STATURE, 0.8605 * STATURE  # neck: de Leva 1996
HIP, LUMBAR = (0.0, 0.0835, 0.0), (-0.030, 0.0, 0.1476)  # from the middle of the hips: Delp et al. 1990
SHOULDER_HALF = 0.17  # glenohumeral: Rajagopal et al. 2016
_TRUNK = HIP_HEIGHT + LUMBAR[2]
SHOULDER = (0.0, SHOULDER_HALF, SHOULDER_HEIGHT - _TRUNK)
NECK = (0.0, 0.0, NECK_HEIGHT - _TRUNK)
PELVIS = ("pelvis_tx", "pelvis_ty", "pelvis_tz", "pelvis_yaw", "pelvis_roll", "pelvis_pitch")
TRUNK = ("trunk_flexion", "trunk_bend", "trunk_rotation")
REACH: Mapping[str, tuple[float, float]] = {  # degrees, of joints that bear so much (AAOS, Joint Motion, 1965) and 25
    "hip_flexion": (-70.0, 160.0), "hip_abduction": (-70.0, 85.0), "hip_rotation": (-85.0, 85.0),  # to 40 more, as zero
    "knee_flexion": (-35.0, 165.0), "ankle_dorsiflexion": (-90.0, 60.0), "ankle_inversion": (-55.0, 75.0),  # is where
    "elbow_flexion": (-25.0, 175.0),  # markers sit
}  # fmt: skip
OF_SEGMENT: Mapping[str, tuple[str, str, str]] = {  # which scale stretches a part along its x, y, z
    "pelvis": ("pelvis_width", "pelvis_width", "pelvis_height"), "thorax": ("trunk", "shoulder_width", "trunk"),
    "head": ("head",) * 3, "upper_arm": ("upper_arm",) * 3, "forearm": ("forearm",) * 3, "hand": ("hand",) * 3,
    "thigh": ("thigh",) * 3, "shank": ("shank",) * 3, "foot": ("foot",) * 3,
}  # fmt: skip


@final
@dataclass(frozen=True)
class HumanBody:
    """K single joints, parents before children; at all zero it stands, arms hanging, thumbs ahead.

    World and every part then have x ahead, y left, z up. coordinates: (K,) names. parent: (K,), -1 the world.
    axis: (K, 3) in the parent. prismatic: (K,). offset: (K, 3) [m] of the joint in its parent where every scale is 1;
    stretch: (K, 3) which of SCALES stretches each. part: of a segment, the joint that carries it.

    Signs: flexion ahead (knee: heel to the back), bend to the right, trunk and head rotation to the left, abduction
    away from the middle, hip and shoulder rotation and pronation inwards, dorsiflexion, inversion, wrist flexion to
    the palm, deviation to the thumb are positive.
    """

    coordinates: tuple[str, ...]
    parent: Indices
    axis: Array
    prismatic: NDArray[np.bool_]
    offset: Array
    stretch: Indices
    part: Mapping[Segment, int]

    @cached_property
    def above(self) -> NDArray[np.bool_]:
        """(K, K): does joint k move what joint j carries? [j, k]"""
        moves = np.eye(len(self.parent), dtype=bool)
        for j, parent in enumerate(self.parent):
            if parent >= 0:
                moves[j] |= moves[parent]
        return moves

    @cached_property
    def axes(self) -> tuple[Indices, Array]:
        """(K,) which axis of its part a joint has, and (K,) ±1: which way."""
        along = np.abs(self.axis).argmax(axis=1)
        return along, self.axis[np.arange(len(along)), along]

    @cached_property
    def reach(self) -> Array:
        """(2, K) [rad or m] from where to where a joint may turn; infinite where nothing is said."""
        spans = [next((span for end, span in REACH.items() if name[2:] == end), (-np.inf, np.inf))
                 for name in self.coordinates]  # fmt: skip
        return np.asarray(np.radians(spans).T)

    def index(self, name: str) -> int:
        return self.coordinates.index(name)

    def model(self, scale: Array) -> pin.Model:
        """The same body in pinocchio, weightless; nq = nv = K, a frame per segment. scale: (S,) in the order SCALES."""
        model = pin.Model()
        model.name = "human"
        for k, name in enumerate(self.coordinates):
            kind = pin.JointModelPrismaticUnaligned if self.prismatic[k] else pin.JointModelRevoluteUnaligned
            place = pin.SE3(np.eye(3), self.offset[k] * scale[self.stretch[k]])
            model.addJoint(int(self.parent[k]) + 1, kind(self.axis[k]), place, name)
        for segment, joint in self.part.items():
            model.addFrame(pin.Frame(segment, joint + 1, 0, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
        return model


def human_body() -> HumanBody:
    """Pelvis (6), trunk (3), head (3), shoulders (3), elbows with pronation (2), wrists (2), hips (3), knees (1),
    ankles (2)."""
    x, y, z = np.eye(3)
    zero = (0.0, 0.0, 0.0)
    names: list[str] = []
    parent, axis, offset, stretch = [], [], [], []  # type: list[int], list[Array], list[tuple[float, float, float]], list[tuple[str, str, str]]
    part: dict[str, int] = {}

    def add(segment: str, on: str, place: tuple[float, float, float], *turns: tuple[str, Array]) -> None:
        for n, (name, about) in enumerate(turns):
            parent.append(part.get(on, -1) if n == 0 else len(names) - 1)
            names.append(name)
            axis.append(about)
            offset.append(place if n == 0 else zero)
            stretch.append(OF_SEGMENT[(on or "pelvis").removeprefix("l_").removeprefix("r_")])
        if segment == "thorax":
            stretch[-len(turns)] = ("lumbar_depth", *OF_SEGMENT["pelvis"][1:])
        part[segment] = len(names) - 1

    add("pelvis", "", zero, *zip(PELVIS, (x, y, z, z, x, y), strict=True))
    add("thorax", "pelvis", LUMBAR, *zip(TRUNK, (y, x, z), strict=True))
    add("head", "thorax", NECK, ("head_flexion", y), ("head_bend", x), ("head_rotation", z))
    for s, side in (("l", 1.0), ("r", -1.0)):
        mirror = np.array([1.0, side, 1.0])
        hip, shoulder = (tuple(float(each) for each in np.array(at) * mirror) for at in (HIP, SHOULDER))
        add(f"{s}_upper_arm", "thorax", shoulder, (f"{s}_shoulder_flexion", -y),  # type: ignore[arg-type]
            (f"{s}_shoulder_abduction", side * x), (f"{s}_shoulder_rotation", -side * z))  # fmt: skip
        add(f"{s}_forearm", f"{s}_upper_arm", (0.0, 0.0, -UPPER_ARM), (f"{s}_elbow_flexion", -y),
            (f"{s}_pronation", -side * z))  # fmt: skip
        add(f"{s}_hand", f"{s}_forearm", (0.0, 0.0, -FOREARM), (f"{s}_wrist_flexion", -side * x),
            (f"{s}_wrist_deviation", -y))  # fmt: skip
        add(f"{s}_thigh", "pelvis", hip, (f"{s}_hip_flexion", -y), (f"{s}_hip_abduction", side * x),  # type: ignore[arg-type]
            (f"{s}_hip_rotation", -side * z))  # fmt: skip
        add(f"{s}_shank", f"{s}_thigh", (0.0, 0.0, -THIGH), (f"{s}_knee_flexion", y))
        add(f"{s}_foot", f"{s}_shank", (0.0, 0.0, -SHANK), (f"{s}_ankle_dorsiflexion", -y),
            (f"{s}_ankle_inversion", -side * x))  # fmt: skip
    return HumanBody(
        tuple(names), np.array(parent, dtype=np.intp), np.array(axis), np.arange(len(names)) < 3, np.array(offset),
        np.array([scales_of(each) for each in stretch], dtype=np.intp), part,  # type: ignore[arg-type]
    )  # fmt: skip


def scales_of(names: tuple[str, str, str]) -> tuple[int, ...]:
    return tuple(SCALES.index(name) for name in names)
