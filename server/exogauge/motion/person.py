"""What of a person's motion a robot can be asked for, in the body's own axes: x forward, y left, z up."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from exogauge.criteria.motion_fit import USUAL as FIT
from exogauge.criteria.motion_import import USUAL
from exogauge.errors import BadMotion, Fault
from exogauge.logs.findings import runs
from exogauge.motion.fit.result import HumanFit
from exogauge.motion.human import Contacts, HumanMotion, JointTree
from exogauge.motion.leaps import leaps_of
from exogauge.motion.sides import refuse_exchanged
from exogauge.robots.moving.segments import Segment

Array = NDArray[np.float64]
LIMBS: tuple[tuple[Segment, Segment], ...] = (
    ("l_upper_arm", "l_forearm"), ("l_forearm", "l_hand"), ("r_upper_arm", "r_forearm"), ("r_forearm", "r_hand"),
)  # fmt: skip
PARTS: tuple[Segment, ...] = ("pelvis", "thorax", "head")
BESIDE: tuple[tuple[Segment, Segment, int], ...] = (  # at rest the head lies above the chest, arms on its sides
    ("thorax", "head", 2), ("r_upper_arm", "l_upper_arm", 1),
)  # fmt: skip
CARRIED: Mapping[Segment, tuple[Segment, Segment, Segment]] = {  # on the left, on the right, above
    "pelvis": ("l_thigh", "r_thigh", "thorax"), "thorax": ("l_upper_arm", "r_upper_arm", "head"),
}  # fmt: skip


@final
@dataclass(frozen=True)
class Person:
    """time: (T,) [s]. pelvis: (T, 3) [m] and turn: (T, 3, 3), world from pelvis. trunk: (T, 3, 3), pelvis from thorax.
    limbs: unit vectors (T, 3) along a segment, seen from the thorax. hip_height: [m] of the hips over the ankles when
    upright. feet: where known, (T, 2, 3) [m] of the left and the right foot in the world. lost: where known, (T,) in
    which nothing is seen of pelvis or of thorax."""

    name: str
    time: Array
    pelvis: Array
    turn: Array
    trunk: Array
    limbs: Mapping[Segment, Array]
    hip_height: float
    contacts: Contacts | None = None
    told: Mapping[str, str] = field(default_factory=dict)
    feet: Array | None = None
    lost: NDArray[np.bool_] | None = None

    def cut(self, begin: float, end: float) -> Person:
        """From `begin` to `end` [s]."""
        kept = (self.time >= begin - 1e-9) & (self.time <= end + 1e-9)
        if kept.sum() < 2:
            span = f"between {begin:g} and {end:g} s" if np.isfinite(end) else f"from {begin:g} s on"
            raise BadMotion(Fault(f"nothing is left {span}", "empty_cut",
                                  f"The motion lasts {self.time[-1]:g} s", self.name))  # fmt: skip
        self._refuse_what_is_none(kept)
        contacts = self.contacts and Contacts(self.contacts.left[kept], self.contacts.right[kept])
        return replace(
            self, time=self.time[kept] - self.time[kept][0], pelvis=self.pelvis[kept], turn=self.turn[kept],
            trunk=self.trunk[kept], limbs={part: along[kept] for part, along in self.limbs.items()}, contacts=contacts,
            feet=None if self.feet is None else self.feet[kept],
            lost=None if self.lost is None else self.lost[kept],
        )  # fmt: skip

    def _refuse_what_is_none(self, kept: NDArray[np.bool_]) -> None:
        """Raises BadMotion where the person lies; where, of what is kept (T,), pelvis or chest leap from a frame to the
        next or are not seen for long."""
        upright = float(np.median(self.turn[:, 2, 2]))
        if upright < USUAL.level:
            detail = f"the pelvis lies: {np.degrees(np.arccos(upright)):.0f}° from upright in half of the frames"
            advice = "Say which axis points up (--up); what somebody does who lies is none for two feet"
            raise BadMotion(Fault(detail, "not_upright", advice, self.name, column="pelvis"))
        time = self.time[kept]
        rate = float((len(time) - 1) / (time[-1] - time[0]))
        reach = 0.5  # [m] a trunk's length: at its end a turn shows as a way
        ahead = self.pelvis + reach * self.turn[..., 0]
        chest = self.pelvis + reach * (self.turn @ self.trunk)[..., 2]
        points = np.stack([self.pelvis, ahead, chest], axis=1)[kept]
        for n, leap in sorted(leaps_of(points, rate, range(3)).items()):
            t = int(np.linalg.norm(leap, axis=1).argmax())
            detail = f"is {np.linalg.norm(leap[t]):.2g} m elsewhere from {time[t]:.2f} s to the next frame"
            raise BadMotion(Fault(detail, "leap", "Cut the motion there, or mend it where it was captured", self.name,
                                  column="chest" if n == 2 else "pelvis"))  # fmt: skip
        lost = np.zeros(len(time), dtype=bool) if self.lost is None else self.lost[kept]
        for start, length in zip(*runs(lost), strict=True):
            if length > FIT.guessed_s * rate:
                when = f"{time[start]:.2f} to {time[start + length - 1]:.2f} s"
                detail = f"nothing is seen of the pelvis or of the thorax {when}"
                raise BadMotion(Fault(detail, "gaps", "Cut the motion where both are seen", self.name))

    def slowed(self, factor: float) -> Person:
        """The same in `factor` times the time."""
        return replace(self, time=self.time * factor)

    def mirrored(self) -> Person:
        """Left and right exchanged."""
        flip = np.diag([1.0, -1.0, 1.0])
        other: dict[Segment, Segment] = {
            "l_upper_arm": "r_upper_arm", "r_upper_arm": "l_upper_arm", "l_forearm": "r_forearm",
            "r_forearm": "l_forearm",
        }  # fmt: skip
        limbs = {other[part]: along @ flip for part, along in self.limbs.items()}
        contacts = self.contacts and Contacts(self.contacts.right, self.contacts.left)
        return replace(
            self, pelvis=self.pelvis @ flip, turn=flip @ self.turn @ flip, trunk=flip @ self.trunk @ flip,
            limbs=limbs, contacts=contacts, feet=None if self.feet is None else self.feet[:, ::-1] @ flip,
        )  # fmt: skip

    def repeated(self, times: int, pause: float) -> Person:
        """One after the other; `pause` [s] leads from the end of one to the begin of the next."""
        period = self.time[-1] - self.time[0] + pause
        time = np.concatenate([self.time + k * period for k in range(times)])
        contacts = self.contacts and Contacts(np.tile(self.contacts.left, times), np.tile(self.contacts.right, times))
        return replace(
            self, time=time, pelvis=np.tile(self.pelvis, (times, 1)), turn=np.tile(self.turn, (times, 1, 1)),
            trunk=np.tile(self.trunk, (times, 1, 1)), contacts=contacts,
            feet=None if self.feet is None else np.tile(self.feet, (times, 1, 1)),
            limbs={part: np.tile(along, (times, 1)) for part, along in self.limbs.items()},
        )  # fmt: skip

    def trunk_share(self, share: float) -> Person:
        """The trunk's turn in the pelvis that many times as far."""
        turns = Rotation.from_matrix(self.trunk).as_rotvec()
        return replace(self, trunk=Rotation.from_rotvec(share * turns).as_matrix())

    def without(self, part: Literal["arms", "pelvis"]) -> Person:
        """Nothing asked of the arms; or a pelvis that stays as it is at first."""
        if part == "arms":
            return replace(self, limbs={})
        still = np.broadcast_to(self.pelvis[:1], self.pelvis.shape), np.broadcast_to(self.turn[:1], self.turn.shape)
        return replace(self, pelvis=still[0].copy(), turn=still[1].copy())


def person_of(motion: HumanMotion) -> Person:
    """Of a skeleton. Raises BadMotion where it has no pelvis, thorax, thighs and feet."""
    tree = motion.tree
    if tree is None:
        raise _fault(motion, "joint angles alone have no skeleton", "no_skeleton",
                     "Give the markers or the skeleton that they are of; to markers a body is fitted")  # fmt: skip
    bones = bones_of(tree)
    needed: tuple[Segment, ...] = ("pelvis", "thorax", "l_thigh", "r_thigh", "l_foot", "r_foot")
    lost = [part for part in needed if part not in bones]
    if lost:
        raise _fault(
            motion,
            f"no bone stands for {', '.join(lost)}",
            "no_segment",
            "Say what its bones are called elsewhere (--name OWN=KNOWN): see `unknown`",
        )
    rest = tree.rest_position
    height = float(np.mean([_leg(rest, bones, side) for side in ("l", "r")]))
    axes = axes_of(motion, tree, bones)
    refuse_exchanged(motion)
    pelvis, thorax = (tree.rotation[:, bones[part]] @ axes[part] for part in PARTS[:2])
    limbs = {}
    for part, beyond in LIMBS:
        if part in bones and beyond in bones:
            along = tree.position[:, bones[beyond]] - tree.position[:, bones[part]]
            along = along / np.linalg.norm(along, axis=1, keepdims=True)
            limbs[part] = np.einsum("tji,tj->ti", thorax, along)
    return Person(
        motion.name, motion.time, tree.position[:, bones["pelvis"]], pelvis,
        np.einsum("tji,tjk->tik", pelvis, thorax), limbs, height, motion.contacts, motion.told,
        np.stack([tree.position[:, bones[part]] for part in ("l_foot", "r_foot")], axis=1),
    )  # fmt: skip


def axes_of(motion: HumanMotion, tree: JointTree, bones: Mapping[Segment, int]) -> dict[Segment, Array]:
    """(3, 3) ahead, left and up of the body in the own axes of pelvis, thorax and head, as the rest posture has them.
    Where that lies, up is along the trunk, if the motion itself stands so; where it is no posture, as where each bone's
    x runs along it, they are by what the bones carry. Raises BadMotion."""
    rest, up = tree.rest_position, np.array([0.0, 0.0, 1.0])
    left, trunk = rest[bones["l_thigh"]] - rest[bones["r_thigh"]], rest[bones["thorax"]] - rest[bones["pelvis"]]
    left, trunk = left / np.linalg.norm(left), trunk / np.linalg.norm(trunk)
    if np.hypot(left[0], left[1]) < USUAL.level or trunk[2] < USUAL.level:
        turned = tree.rotation[:, bones["pelvis"]] @ tree.rest_rotation[bones["pelvis"]].T
        stands = np.median(turned @ trunk, axis=0)[2] > USUAL.level > abs(np.median(turned @ left, axis=0)[2])
        if abs(left @ trunk) > USUAL.level or not stands:
            return _by_children(motion, tree, bones)
        up = trunk - (trunk @ left) * left
    axes = _frame(left, up)
    for part, to, axis in BESIDE:
        if part in bones and to in bones:
            way = rest[bones[to]] - rest[bones[part]]
            if way @ axes[:, axis] < USUAL.level * np.linalg.norm(way):
                return _by_children(motion, tree, bones)
    return {part: tree.rest_rotation[bones[part]].T @ axes for part in PARTS if part in bones}


def _by_children(motion: HumanMotion, tree: JointTree, bones: Mapping[Segment, int]) -> dict[Segment, Array]:
    """Of pelvis and thorax, where no rest posture says it: left between the bones that lead to both limbs, up to the
    bone that leads to what is above. Raises BadMotion where there are none, or where the pelvis then is not upright."""
    found = dict[Segment, Array]()
    for part, carried in CARRIED.items():
        at = bones[part]
        led = [_towards(tree, at, bones.get(to)) for to in carried]
        if None not in led:
            to_l, to_r, up = ((tree.rest_position[k] - tree.rest_position[at]) @ tree.rest_rotation[at] for k in led)
            left = to_l - to_r
            if abs(left @ up) < USUAL.level * np.linalg.norm(left) * np.linalg.norm(up):
                found[part] = _frame(left, up)
    if len(found) < 2 or np.median((tree.rotation[:, bones["pelvis"]] @ found["pelvis"])[:, 2, 2]) < USUAL.level:
        raise _fault(motion, "the hips are not side by side below the chest, at rest or later", "not_upright",
                     "Say which axis points up (--up), or export it with a rest pose that stands")  # fmt: skip
    return found


def _towards(tree: JointTree, at: int, bone: int | None) -> int | None:
    """The bone next to `at` on the way to `bone`."""
    while bone is not None and bone >= 0 and tree.parent[bone] != at:
        bone = int(tree.parent[bone])
    return None if bone is None or bone < 0 else bone


def _frame(left: Array, up: Array) -> Array:
    """(3, 3) ahead, left, up; what of left lies along up does not count."""
    left = left - (left @ up) * up / (up @ up)
    left, up = left / np.linalg.norm(left), up / np.linalg.norm(up)
    return np.stack([np.cross(left, up), left, up], axis=1)


def person_of_fit(fit: HumanFit, contacts: Contacts | None = None) -> Person:
    """Of a body that was fitted to markers."""
    turn, thorax, place = fit.rotation["pelvis"], fit.rotation["thorax"], fit.position
    limbs = {}
    for part, beyond in LIMBS:
        along = place[beyond] - place[part]
        limbs[part] = np.einsum("tji,tj->ti", thorax, along / np.linalg.norm(along, axis=1, keepdims=True))
    bones = (("l_thigh", "l_shank"), ("l_shank", "l_foot"))
    leg = sum((float(np.linalg.norm(place[b][0] - place[a][0])) for a, b in bones), 0.0)  # type: ignore[index]
    trunk = np.einsum("tji,tjk->tik", turn, thorax)
    return Person(fit.name, fit.time, place["pelvis"], turn, trunk, limbs, leg, contacts, fit.told,
                  np.stack([place["l_foot"], place["r_foot"]], axis=1), fit.lost)  # fmt: skip


def bones_of(tree: JointTree) -> dict[Segment, int]:
    """Of every part of the body, the bone nearest to the root."""
    found: dict[Segment, int] = {}
    for k, name in enumerate(tree.names):
        part = tree.segment.get(name)
        if part is not None:
            found.setdefault(part, k)
    return found


def _leg(rest: Array, bones: Mapping[Segment, int], side: Literal["l", "r"]) -> float:
    """[m] from hip to ankle along the bones: at rest some files spread the legs, some fold them up."""
    parts: tuple[Segment, ...] = ("l_thigh", "l_shank", "l_foot") if side == "l" else ("r_thigh", "r_shank", "r_foot")
    joints = [rest[bones[part]] for part in parts if part in bones]
    return float(sum(np.linalg.norm(b - a) for a, b in pairwise(joints)))


def _fault(motion: HumanMotion, detail: str, rule: str, advice: str) -> BadMotion:
    return BadMotion(Fault(detail, rule, advice, motion.name))
