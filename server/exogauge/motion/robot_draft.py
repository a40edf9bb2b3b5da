"""What planning needs of a robot that no preset knows, by looking at its URDF: feet, arms, a posture on bent knees."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.optimize import least_squares

from exogauge.criteria.motion_draft import USUAL
from exogauge.errors import BadRobot, Fault
from exogauge.robots.moving.robot import MotionRobot, Shape
from exogauge.robots.moving.segments import LEFT
from exogauge.robots.moving.touching import Pairs
from exogauge.robots.urdf import model_text
from exogauge.studies.import_log.robot_draft import drafted, slips
from exogauge.studies.intake.mesh_files import mesh_opener
from exogauge.studies.intake.moving_robot import shapes_of

Array = NDArray[np.float64]
ELBOW = re.compile(r"elbow|(^|_)elb(_|\d|$)", re.I)
BODY = pin.FrameType.BODY
UPRIGHT = {"x": "0 -1.570796 0", "-x": "0 1.570796 0", "y": "1.570796 0 0", "-y": "-1.570796 0 0",
           "-z": "3.141593 0 0"}  # fmt: skip
"""rpy by which an axis becomes z."""


def draft_of(urdf: bytes, file: str, folder: Path) -> tuple[dict[str, Any], list[str]]:
    """robot.yaml as a tree of plain values, and what of it is to be looked at (`?`) or is lacking (`!`).

    folder: where meshes are looked for, and beside it. A robot without two feet is bolted down. Raises BadRobot.
    """
    content, _ = drafted(urdf, file, "torque")
    slipped = slips(urdf, file)
    feet = [sensor["frame"] for sensor in content.pop("ft_sensors", ()) if sensor["role"] == "contact"]
    if len(feet) != 2:
        content, told = _arm(urdf, content)
        return content, [*told, *slipped]
    look = _Look(urdf, folder, content["base_link"], feet)
    look.refuse_lying(file)
    faces = "along" if look.ahead > 0.0 else "against"
    told = [
        *slipped,
        f"# ? soles: {' and '.join(look.feet)}, left first; so it faces {faces} the x of {look.base_link}",
    ]
    soles = [(foot, look.outline(foot)) for foot in look.feet]
    parts, hands = look.arms(told)
    names = [name for name in look.model.names[2:] if not look.beyond(name, hands)]
    left_out = [name for name in look.model.names[2:] if name not in names]
    if left_out:
        told.append(f"# ? joints: without what lies beyond the hands ({', '.join(left_out[:6])}…), held at zero")
    content["joints"] = [{"name": name, "actuation": "none"} for name in names]
    if all(outline is not None for _, outline in soles):
        told.append("# ? soles: the lowest corners of the feet's collision shapes")
        content["soles"] = [{"link": foot, "outline": outline} for foot, outline in soles]
    else:
        told.append("# ! soles: the feet have no shape that can be read; measure their corners in the frame of "
                    f"{look.feet[0]}: soles: [{{link: {look.feet[0]}, outline: [[x, y, z], …]}}, …]")  # fmt: skip
    content["human_map"] = {"pelvis": content["base_link"], **parts}
    content["home"] = look.home(names, told)
    content["limits"] = {"acceleration": USUAL.acceleration, "jerk": USUAL.jerk}
    told.append("# ? limits: usual ones, not the maker's")
    return content, told


def _arm(urdf: bytes, content: dict[str, Any]) -> tuple[dict[str, Any], list[str]]:
    model = pin.buildModelFromXML(model_text(urdf))
    home = _within(model, [joint["name"] for joint in content["joints"]])
    content["home"] = {name: round(value, 3) for name, value in home.items() if value}
    content["limits"] = {"acceleration": USUAL.arm_acceleration}
    return content, [
        "# ? base: bolted down, as no two feet were found (last links of two legs, called sole, foot, ankle or ank): "
        "for `motion excite`. A robot that stands needs base, base_link, imu, soles, human_map: docs/motion.md",
        "# ? joints: torques are logged; of currents `actuation: current, prior: {k_T: …}`. Leave out what is still",
        "# ? home: joints at zero, or as near as they may be; put it where no link is near another or the floor",
        "# ? limits: usual ones, not the maker's",
    ]


def _within(model: pin.Model, names: Sequence[str]) -> dict[str, float]:
    """Zero, or as near to it as a joint may be, a little off its stop."""
    low, high, home = model.lowerPositionLimit, model.upperPositionLimit, {}
    for name in names:
        k = model.joints[model.getJointId(name)].idx_q
        inside = USUAL.off_stop * (high[k] - low[k])
        home[name] = float(np.clip(0.0, low[k] + inside, high[k] - inside)) if not low[k] < 0.0 < high[k] else 0.0
    return home


@final
class _Look:
    """The URDF's robot with all joints at zero, on a base of its own."""

    def __init__(self, urdf: bytes, folder: Path, base_link: str, feet: list[str]) -> None:
        self.model = pin.buildModelFromXML(model_text(urdf), pin.JointModelFreeFlyer())
        self.data = self.model.createData()
        self.zero = pin.neutral(self.model)
        pin.framesForwardKinematics(self.model, self.data, self.zero)
        self.base_link = base_link
        aside = {link: float(self.place(link).translation[1]) for link in feet}
        called = {link: bool(LEFT.search(link)) for link in feet}
        if len(set(called.values())) == 2:  # by name, as a root link may face backwards; else by where they are
            self.feet = sorted(feet, key=lambda link: not called[link])
        else:
            self.feet = sorted(feet, key=lambda link: -aside[link])
        self.ahead = 1.0 if aside[self.feet[0]] > aside[self.feet[1]] else -1.0  # along x of the root
        self.shapes, _ = shapes_of(urdf, {}, mesh_opener(folder, beside=True))

    def frame(self, link: str) -> pin.Frame:
        return self.model.frames[self.model.getFrameId(link, BODY)]

    def place(self, link: str) -> pin.SE3:
        return self.data.oMf[self.model.getFrameId(link, BODY)]

    def refuse_lying(self, file: str) -> None:
        """Raises BadRobot where both legs hang along another axis than z: gravity would pull along it."""
        hangs = [self.data.oMi[self.chain(self.frame(foot).parentJoint)[0]].translation - self.place(foot).translation
                 for foot in self.feet]  # fmt: skip
        along = np.mean([each / np.linalg.norm(each) for each in hangs], axis=0)
        k = int(np.abs(along).argmax())
        axis = ("-" if along[k] < 0.0 else "") + "xyz"[k]
        if axis == "z" or abs(along[k]) < USUAL.hangs:
            return
        raise BadRobot(Fault(
            f"with all joints at zero {axis} of {self.base_link} points up, and z has to", "not_upright",
            f'Put a link of its own above it: <link name="upright"/> <joint name="to_upright" type="fixed"><parent '
            f'link="upright"/><child link="{self.base_link}"/><origin rpy="{UPRIGHT[axis]}"/></joint>',
            file, column=self.base_link, value=axis,
        ))  # fmt: skip

    def chain(self, joint: int) -> list[int]:
        """Joints from the base to this one, the base's own left out."""
        return [k for k in self.model.supports[joint] if k > 1]

    def link(self, joint: int) -> str:
        """That the joint moves first."""
        return next(str(each.name) for each in self.model.frames if each.type == BODY and each.parentJoint == joint)

    def outline(self, foot: str) -> list[list[float]] | None:
        """The rectangle below the shapes of the foot's body, in the frame of its link, counter-clockwise from above."""
        of = self.frame(foot).parentJoint
        points = [self.place(shape.link).act(point) for shape in self.shapes if self.frame(shape.link).parentJoint == of
                  for point in corners(shape)]  # fmt: skip
        if not points:
            return None
        low = np.array([each for each in points if each[2] < min(p[2] for p in points) + USUAL.sole_m])
        (x0, y0, z), (x1, y1, _) = low.min(axis=0), low.max(axis=0)
        if min(x1 - x0, y1 - y0) < USUAL.least_sole_m:
            return None
        to_link = self.place(foot).inverse()
        around = ((x1, y1), (x0, y1), (x0, y0), (x1, y0))
        return [[round(float(each), 4) for each in to_link.act(np.array([x, y, z]))] for x, y in around]

    def arms(self, told: list[str]) -> tuple[dict[str, str], list[int]]:
        """Parts of the body that links stand for, and the joints of the hands."""
        legs = {k for foot in self.feet for k in self.chain(self.frame(foot).parentJoint)}
        ends = [k for k in range(2, self.model.njoints) if k not in legs and not list(self.model.children[k])]
        wide = USUAL.aside * abs(float(self.place(self.feet[0]).translation[1]))
        found = list[list[int]]()
        for sign in (self.ahead, -self.ahead):
            chains = [self.chain(k) for k in ends if sign * self.data.oMi[k].translation[1] > wide]
            chains = [each for each in chains if any(ELBOW.search(self.model.names[k]) for k in each)]
            shared = [column[0] for column in zip(*chains, strict=False) if len(set(column)) == 1]
            if not shared:
                told.append("# ! human_map: no arms were found (none has a joint called elbow); name `thorax`, "
                            "`l_upper_arm`, `l_forearm`, `l_hand` and those on the right")  # fmt: skip
                return {"thorax": self.base_link}, []
            found.append(shared)
        left, right = found
        trunk = [a for a, b in zip(left, right, strict=False) if a == b]
        parts = {"thorax": self.link(trunk[-1]) if trunk else self.base_link}
        for side, arm in zip("lr", found, strict=True):
            bends = [k for k in arm if ELBOW.search(self.model.names[k])]
            parts |= {f"{side}_upper_arm": self.link(arm[arm.index(bends[0]) - 1]), f"{side}_forearm":
                      self.link(bends[-1]), f"{side}_hand": self.link(arm[-1])}  # fmt: skip
        told.append("# ? human_map: by the joints called elbow, and where the two arms part")
        return parts, [left[-1], right[-1]]

    def beyond(self, name: str, hands: list[int]) -> bool:
        joint = self.model.getJointId(name)
        return any(hand in list(self.model.supports[joint]) and hand != joint for hand in hands)

    def home(self, names: list[str], told: list[str]) -> dict[str, float]:
        """Knees bent so far that the hips come down by a share of the leg, soles as flat as at zero; the rest at zero,
        or as near to it as it may be."""
        home = _within(self.model, names)
        bent = [self._bent(foot) for foot in self.feet]
        if lost := [foot for foot, found in zip(self.feet, bent, strict=True) if found is None]:
            told += [self._why(foot) for foot in lost]
        else:
            home |= {name: angle for found in bent if found is not None for name, angle in found.items()}
            told.append("# ? home: on bent knees")
        told.append("# ? home: arms at zero, or as near as they may be; put them beside the body where they stand out")
        return {name: round(value, 3) for name, value in home.items() if abs(value) > 1e-3}

    def _why(self, foot: str) -> str:
        """Which joints' limits keep the leg from bending, and what it takes of them."""
        limits, takes = self._limits(foot), self._bent(foot, free=True) or {}
        beyond = [f"{name} takes {takes[name]:.2f} rad, its limit is {low:.4g} to {high:.4g}"
                  for name, (low, high) in limits.items() if name in takes and not low <= takes[name] <= high
                  ]  # fmt: skip
        if not beyond:
            return (f"# ! home: within the joints' limits no knee goes ahead above a flat {foot}, z up; look at the "
                    "limits of the legs, and give their joints by hand")  # fmt: skip
        return (f"# ! home: no knee goes ahead above a flat {foot}: {'; '.join(beyond)}. Where that is not the "
                "joint's, correct its <limit> in the URDF, whose limits count; else give `home` by hand")  # fmt: skip

    def _limits(self, foot: str) -> dict[str, tuple[float, float]]:
        """Of the joints of its leg [rad]."""
        model, joints = self.model, self.chain(self.frame(foot).parentJoint)
        at = [model.joints[k].idx_q for k in joints]
        ends = zip(model.lowerPositionLimit[at].tolist(), model.upperPositionLimit[at].tolist(), strict=True)
        return dict(zip((str(model.names[k]) for k in joints), ends, strict=True))

    def _bent(self, foot: str, *, free: bool = False) -> dict[str, float] | None:
        """Of the two ways in which a leg bends, the one whose knee goes ahead. free: as if no joint had limits."""
        joints = self.chain(self.frame(foot).parentJoint)
        at = [self.model.joints[k].idx_q for k in joints]
        low, high = np.array(list(self._limits(foot).values())).T if not free else np.full((2, len(at)), np.pi)
        low = -high if free else low
        goal, hip = self.place(foot).copy(), self.data.oMi[joints[0]].translation.copy()
        leg = float(hip[2] - goal.translation[2])
        if leg < USUAL.hangs * np.linalg.norm(goal.translation - hip):
            return None  # z does not point up
        goal.translation = goal.translation + np.array([0.0, 0.0, USUAL.lower * leg])
        data, frame = self.model.createData(), self.model.getFrameId(foot, BODY)

        def posed(x: Array) -> pin.SE3:
            q = self.zero.copy()
            q[at] = x
            pin.forwardKinematics(self.model, data, q)
            return pin.updateFramePlacement(self.model, data, frame)

        def off(x: Array) -> Array:
            miss = goal.actInv(posed(x))
            return np.concatenate([miss.translation / leg, pin.log3(miss.rotation), USUAL.calm * x])

        best: tuple[float, Array] | None = None
        for start in (*np.eye(len(at)), *-np.eye(len(at))):
            x = np.clip(0.6 * start, low + 1e-3, high - 1e-3)
            found = least_squares(off, x, bounds=(low, high))
            if np.abs(off(found.x)[:6]).max() > USUAL.flat:
                continue
            posed(found.x)
            ahead = max(self.ahead * float(data.oMi[k].translation[0]) for k in joints)
            if best is None or ahead > best[0] + 1e-3:
                best = ahead, found.x
        if best is None or best[0] < max(self.ahead * hip[0], self.ahead * goal.translation[0]) + USUAL.flat:
            return None
        return {self.model.names[k]: float(v) for k, v in zip(joints, best[1], strict=True)}


def arms_aside(robot: MotionRobot, clearance_m: float) -> dict[str, float]:
    """Of one shoulder joint each, the smallest angle that takes forearms and hands off all that is not their arm: what
    is nearer than `clearance_m` at home is never looked at. Nothing where they are off it, or no angle does."""
    found, home = dict[str, float](), robot.home
    assert home is not None
    for side in ("l", "r"):
        upper, fore = (robot.segments.get(f"{side}_{part}") for part in ("upper_arm", "forearm"))  # type: ignore[call-overload]
        if upper is None or fore is None:
            continue
        own, beyond = (_carried(robot, link) for link in (upper, fore))

        def close(q: Array, own: set[str] = own, beyond: set[str] = beyond) -> bool:
            pairs = Pairs(replace(robot, home=q), clearance_m).left_out
            return any((a in beyond) != (b in beyond) and not {a, b} <= own for a, b in pairs)

        shoulder = robot.chain("thorax", f"{side}_upper_arm")  # type: ignore[arg-type]
        tries = [(k, sign * angle) for angle in USUAL.aside_rad for k in shoulder for sign in (1.0, -1.0)]
        for k, angle in tries if close(home) else ():
            q = home.copy()
            q[robot.base + k] += angle
            if robot.limits.lower[k] <= q[robot.base + k] <= robot.limits.upper[k] and not close(q):
                found[robot.joints[k]] = round(float(q[robot.base + k]), 3)
                break
    return found


def _carried(robot: MotionRobot, link: str) -> set[str]:
    """Links that the joint of this one moves."""
    joint = robot.links[link]
    return {name for name, moved in robot.links.items() if joint in list(robot.model.supports[moved])}


def corners(shape: Shape) -> list[Array]:
    """Points that span it, in its link's frame; of what is round its ends alone."""
    if shape.kind == "hull":
        points = shape.points
    elif shape.kind == "box":
        points = np.array(np.meshgrid(*[[-0.5 * edge, 0.5 * edge] for edge in shape.size])).reshape(3, -1).T
    else:
        half = 0.5 * shape.size[1] if len(shape.size) > 1 else 0.0
        around = shape.size[0] * np.array([*np.eye(3), *-np.eye(3)])
        points = np.concatenate([around + np.array([0.0, 0.0, end]) for end in {half, -half}])
    return [shape.at.act(point) for point in points]
