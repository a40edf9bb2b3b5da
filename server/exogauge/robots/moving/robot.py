"""The robot as a motion is planned for it: a flat coordinate space, what its feet stand on, and every bound."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, final

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.robots.joint_limits import JointLimits
from exogauge.robots.moving.segments import Segment
from exogauge.robots.urdf import model_text

Array = NDArray[np.float64]
BASE = ("base_x", "base_y", "base_z", "base_yaw", "base_roll", "base_pitch")


@final
@dataclass(frozen=True)
class Sole:
    """What a foot stands on. link: of the URDF. outline: (K, 3) [m] corners in the link's frame, counter-clockwise when
    seen from above."""

    link: str
    outline: Array

    @property
    def middle(self) -> Array:
        """(3,) [m] of the corners."""
        return np.asarray(self.outline.mean(axis=0), dtype=np.float64)

    @property
    def axes(self) -> Array:
        """(3, 3) in the link's frame: x along the first edge, z the normal upwards."""
        spokes = self.outline - self.middle
        z = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)
        z /= np.linalg.norm(z)
        x = self.outline[1] - self.outline[0]
        x = x - z * (x @ z)
        x /= np.linalg.norm(x)
        return np.stack([x, np.cross(z, x), z], axis=1)


@final
@dataclass(frozen=True)
class MotionRobot:
    """model: pinocchio; nq = nv = B + J, dq/dt = v (`flat_model`). joints: (J,) names, in the model's order.

    soles: those of the feet, left first where there are two. segments: part of the human body -> link that stands for
    it. home: (B + J,) posture in which motions begin and end, the soles on the floor. shapes: of links that must not
    touch; ignored: pairs of links that may; shapeless: links whose shape is in a file that cannot be read.
    """

    name: str
    model: pin.Model
    joints: tuple[str, ...]
    floating: bool
    limits: JointLimits
    soles: tuple[Sole, ...] = ()
    segments: Mapping[Segment, str] = field(default_factory=dict)
    home: Array | None = None
    shapes: tuple[Shape, ...] = ()
    ignored: tuple[tuple[str, str], ...] = ()
    shapeless: tuple[str, ...] = ()

    @property
    def base(self) -> int:
        """B: 6 or 0."""
        return 6 if self.floating else 0

    @property
    def jerk(self) -> Array:
        """(J,) bounds [rad/s³ or m/s³], inf where there is none."""
        return np.full(len(self.joints), np.inf) if self.limits.jerk is None else self.limits.jerk

    @cached_property
    def data(self) -> pin.Data:
        return self.model.createData()

    def frame(self, link: str) -> int:
        """Index of a link's frame in the model."""
        return frame_of(self.model, link)

    @cached_property
    def links(self) -> dict[str, int]:
        """Joints that move them, by name; the root first."""
        bodies = [each for each in self.model.frames if each.type == pin.FrameType.BODY]
        return {each.name.removeprefix(LINK): each.parentJoint for each in bodies}

    def leg(self, foot: int) -> NDArray[np.intp]:
        """Columns of `model`'s q that move the foot and not the base."""
        above = self.model.supports[self.model.frames[self.frame(self.soles[foot].link)].parentJoint]
        return np.array([joint - 1 for joint in above if joint > self.base], dtype=np.intp)

    @cached_property
    def mass(self) -> float:
        """[kg]"""
        return float(sum(inertia.mass for inertia in self.model.inertias))

    @cached_property
    def weight(self) -> float:
        """[N]"""
        return self.mass * float(np.linalg.norm(self.model.gravity.linear))

    @cached_property
    def torso(self) -> tuple[int, ...]:
        """Indices in `joints` of those between the pelvis and the thorax, from below."""
        return self.chain("pelvis", "thorax")

    def beyond(self, below: Segment) -> tuple[int, ...]:
        """Indices in `joints` of all that the link of `below` carries."""
        own = self.model.frames[self.frame(self.segments[below])].parentJoint
        return tuple(
            self.joints.index(self.model.names[k]) for k in range(self.base + 1, self.model.njoints)
            if own in list(self.model.supports[k]) and k != own
        )  # fmt: skip

    def chain(self, below: Segment, above: Segment) -> tuple[int, ...]:
        """Indices in `joints` of those that move `above` and not `below`."""
        model = self.model
        there = [model.frames[self.frame(self.segments[each])].parentJoint for each in (below, above)]
        moves = [list(model.supports[joint]) for joint in there]
        return tuple(
            self.joints.index(model.names[joint]) for joint in moves[1] if joint not in moves[0] and joint > self.base
        )


LINK = "link "  # before the names of links in a model: pinocchio takes none that is also a joint's, or `base`


def frame_of(model: pin.Model, link: str) -> int:
    """Index of a link's frame in a `flat_model`."""
    return int(model.getFrameId(LINK + link, pin.FrameType.BODY))


def flat_model(urdf: bytes, joints: Sequence[str], floating: bool) -> pin.Model:
    """The URDF's robot with the joints held at zero that are not named, on a base of six single joints. A joint without
    ends has an angle as any other.

    x, y, z, then turns about z (yaw), x (roll) and y (pitch): the axes of each are constant, so derivatives are exact,
    coordinates add up, and only a robot that lies on its side (roll 90°) is singular.
    """
    whole = pin.buildModelFromXML(model_text(urdf))
    for each in whole.frames:
        if each.type == pin.FrameType.BODY:
            each.name = LINK + each.name
    held = [k for k in range(1, whole.njoints) if whole.names[k] not in joints]
    model = pin.buildReducedModel(whole, held, pin.neutral(whole)) if held else whole
    if not floating:
        return model
    base = pin.Model()
    base.name = model.name
    last = 0
    kinds = (
        pin.JointModelPX(), pin.JointModelPY(), pin.JointModelPZ(),
        pin.JointModelRZ(), pin.JointModelRX(), pin.JointModelRY(),
    )  # fmt: skip
    for kind, name in zip(kinds, BASE, strict=True):
        last = base.addJoint(last, kind, pin.SE3.Identity(), name)
    frame = base.addFrame(pin.Frame("base", last, 0, pin.SE3.Identity(), pin.FrameType.OP_FRAME))
    return pin.appendModel(base, model, frame, pin.SE3.Identity())


Kind = Literal["box", "sphere", "cylinder", "capsule", "hull"]


@final
@dataclass(frozen=True)
class Shape:
    """link: of the URDF. at: in its frame. size [m]: edges of a box, radius of a sphere, radius and length of a
    cylinder or of a capsule without its caps, both along z. points: (K, 3) [m] corners of a hull; mesh: (V, 3) [m]
    corners and (F, 3) triangles of what it spans, where it does."""

    link: str
    kind: Kind
    size: tuple[float, ...] = ()
    at: pin.SE3 = field(default_factory=pin.SE3.Identity)
    points: Array = field(default_factory=lambda: np.zeros((0, 3)))
    mesh: tuple[Array, NDArray[np.intp]] | None = None

    def solid(self) -> coal.CollisionGeometry:
        """As coal knows it."""
        if self.kind == "box":
            return coal.Box(*self.size)
        if self.kind == "sphere":
            return coal.Sphere(*self.size)
        if self.kind == "cylinder":
            return coal.Cylinder(*self.size)
        if self.kind == "capsule":
            return coal.Capsule(*self.size)
        corners = coal.StdVec_Vec3s()
        corners.extend([np.array(point) for point in self.points])
        return coal.ConvexBase.convexHull(corners, False, "")

    def surface(self) -> coal.CollisionGeometry:
        """Of the mesh that a hull spans, with its hollows; else what `solid` is."""
        if self.mesh is None:
            return self.solid()
        points, triangles = self.mesh
        made = coal.BVHModelOBBRSS()
        made.beginModel(len(triangles), len(points))
        made.addVertices(points)
        made.addTriangles(triangles)
        made.endModel()
        return made
