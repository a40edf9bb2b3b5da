"""The robot as planning sees it: how its sensor moves by its joints, what its motors bear, what collides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final
from xml.etree.ElementTree import tostring

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.errors import BadStudy, Fault
from exogauge.payload.sensor_motion import Chain
from exogauge.robots.regressor import wrench_columns
from exogauge.robots.urdf import load_tree, model_text
from exogauge.robots.urdf_check import read_urdf

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]

CONTINUOUS = 2 * np.pi  # rad either way, of a joint without limits: cables do not bear more
FAR, TRIES, STEPS = 1e-9, 6, 60  # of inverse kinematics: rad that count as reached; starts; steps of each


@final
@dataclass(frozen=True)
class Component:
    """The payload as it is believed to be before it is identified: a box.

    mass [kg]; centre (3,) [m] of mass and of the box, size (3,) [m] of the box, in {S}.
    """

    mass: float
    centre: Array
    size: Array

    @property
    def inertia(self) -> pin.Inertia:
        body = pin.Inertia.FromBox(self.mass, *map(float, self.size))
        return pin.Inertia(self.mass, np.asarray(self.centre, np.float64), body.inertia)

    @property
    def phi(self) -> Array:
        """(10,) about the sensor's origin, in the order of `RigidTree.phi`."""
        return np.asarray(self.inertia.toDynamicParameters())


@final
@dataclass(frozen=True)
class Moving:
    """T samples, in {S}'s axes: state (T, 9) of [a - g, α, ω], torque (T, J) [N·m] with the payload, rotation R_BS.

    slopes: of the state (T, 9, n, 3), of the torque (T, J, n, 3), of the axes of R_BS (T, 3, 3, n) by the n chosen
    joints' q, q̇, q̈; None where they were not asked for. The last: entry [t, i, k, j], of the axis k.
    """

    rotation: Array
    state: Array
    torque: Array
    state_slopes: Array | None
    torque_slopes: Array | None
    axis_slopes: Array | None


@final
class Arm:
    """A robot on a fixed base that carries the component, of which `moved` joints move and the others stay at home."""

    def __init__(
        self, urdf: bytes, joints: Sequence[str], base_link: str, frame: str, gravity: Array, component: Component,
        moved: Sequence[str], home: Array, *, folder: Path | None = None, file: str = "robot.urdf",
    ) -> None:  # fmt: skip
        """joints: all J, in the order of q; other movable ones stay at zero. home: (J,) [rad]. gravity: (3,) in {B}.

        folder: of the meshes. Raises BadStudy, BadRobot.
        """
        full = pin.buildModelFromXML(model_text(urdf, file))
        shapes = _shapes(full, tostring(read_urdf(urdf, file), encoding="unicode"), folder, file)
        locked = [full.getJointId(name) for name in full.names[1:] if name not in joints]
        model, shapes = pin.buildReducedModel(full, shapes, locked, pin.neutral(full))
        self.joints, self.frame = tuple(joints), _frame(model, frame)
        self.order = np.array([model.joints[model.getJointId(name)].idx_v for name in joints], dtype=np.intp)
        self.moved: IntArray = np.array([self.joints.index(name) for name in moved], dtype=np.intp)
        self.home, self.component = np.array(home, np.float64), component
        data = model.createData()
        pin.framesForwardKinematics(model, data, pin.neutral(model))
        self.R_base: Array = data.oMf[_frame(model, base_link)].rotation.copy()
        self.gravity: Array = np.asarray(gravity, np.float64)
        tree = load_tree(urdf, joints=joints, base_link=base_link, floating=False, file=file)
        self.chain = Chain.of(tree, frame)
        model.gravity.linear = self.R_base @ self.gravity
        at = model.frames[self.frame]
        model.inertias[at.parentJoint] += at.placement.act(component.inertia)
        self.model, self.data = model, data
        box = pin.GeometryObject(
            "payload", at.parentJoint, at.placement * pin.SE3(np.eye(3), np.asarray(component.centre, np.float64)),
            coal.Box(*map(float, component.size)),
        )  # fmt: skip
        shapes.addGeometryObject(box)
        shapes.addAllCollisionPairs()
        for pair in list(shapes.collisionPairs):
            a, b = (shapes.geometryObjects[k].parentJoint for k in (pair.first, pair.second))
            if a == b or model.parents[a] == b or model.parents[b] == a:
                shapes.removeCollisionPair(pair)  # what is joined touches
        self.shapes, self.contact = shapes, pin.GeometryData(shapes)

    def posture(self, angles: Array) -> Array:
        """(..., J) [rad] from the chosen joints' (..., n)."""
        q = np.broadcast_to(self.home, (*angles.shape[:-1], len(self.joints))).copy()
        q[..., self.moved] = angles
        return q

    def rotations(self, angles: Array) -> Array:
        """(T, 3, 3) R_BS at the chosen joints' angles (T, n)."""
        return self.chain.rotations(self.posture(angles))

    def moving(self, q: Array, dq: Array, ddq: Array, *, slopes: bool = False) -> Moving:
        """q, dq, ddq: (T, n) of the chosen joints."""
        moved, model, data = self.moved, self.model, self.data
        states = np.zeros((3, len(q), len(self.joints)))
        states[0], states[1][:, moved], states[2][:, moved] = self.posture(q), dq, ddq
        rotation, state, by_joint = self.chain.kinematics(states, self.gravity)
        torque, by_torque = np.empty(states.shape[1:]), None
        if slopes:
            by_torque = np.empty((len(q), 3, len(self.joints), len(self.joints)))
        for t, (at, rate, acceleration) in enumerate(zip(*self._inner(states), strict=True)):
            if by_torque is None:
                torque[t] = pin.rnea(model, data, at, rate, acceleration)
            else:
                by_torque[t] = pin.computeRNEADerivatives(model, data, at, rate, acceleration)
                torque[t] = data.tau
        torque = torque[:, self.order]
        if by_torque is None:
            return Moving(rotation, state, torque, None, None, None)
        by_torque = by_torque[:, :, self.order[:, None], self.order[moved]].transpose(0, 2, 3, 1)
        by_state = by_joint[:, moved].swapaxes(1, 2)
        turns = rotation @ by_state[:, 6:, :, 1]
        by_axis = np.cross(turns[:, :, None], rotation[:, :, :, None], axis=1)
        return Moving(rotation, state, torque, by_state, by_torque, by_axis)

    def wrench(self, moving: Moving, sign: int) -> Array:
        """(T, 6) [N, N·m] s A Φ of the component."""
        b, alpha, omega = moving.state[:, :3], moving.state[:, 3:6], moving.state[:, 6:]
        return np.asarray(sign * wrench_columns(b, alpha, omega) @ self.component.phi)

    def touching(self, angles: Array) -> list[tuple[str, str]]:
        """Names of what touches what it is not joined to, two by two. angles: (n,)."""
        (q,) = self._inner(self.posture(angles)[None])
        pin.computeCollisions(self.model, self.data, self.shapes, self.contact, q, False)
        pairs = zip(self.shapes.collisionPairs, self.contact.collisionResults, strict=True)
        return [
            (self.shapes.geometryObjects[pair.first].name, self.shapes.geometryObjects[pair.second].name)
            for pair, found in pairs if found.isCollision()
        ]  # fmt: skip

    def collides(self, angles: Array) -> NDArray[np.bool_]:
        """(T,) whether the robot, or the payload's box, touches what it is not joined to. angles: (T, n)."""
        return np.array(
            [
                pin.computeCollisions(self.model, self.data, self.shapes, self.contact, q, True)
                for q in self._inner(self.posture(angles))
            ],
            dtype=bool,
        )

    @property
    def pairs(self) -> int:
        """Pairs of shapes that are tried for collisions."""
        return len(self.shapes.collisionPairs)

    def reach(self, rotation: Array, lower: Array, upper: Array) -> Array | None:
        """(n,) angles within [lower, upper] (n,) that turn {S} to R_BS (3, 3): of those found, nearest home; or None.

        Newton's steps with damping, from home and five places beside it.
        """
        rng, home = np.random.default_rng(0), self.home[self.moved]
        wanted, best = self.R_base @ rotation, None
        at = self.order[self.moved]
        for start in [home, *rng.uniform(lower, upper, (TRIES - 1, len(home)))]:
            angles = start.copy()
            for _ in range(STEPS):
                pin.computeJointJacobians(self.model, self.data, self._inner(self.posture(angles[None]))[0])
                R = pin.updateFramePlacement(self.model, self.data, self.frame).rotation
                error = pin.log3(R.T @ wanted)
                if np.linalg.norm(error) < FAR:
                    break
                J = pin.getFrameJacobian(self.model, self.data, self.frame, pin.LOCAL)[3:, at]
                damping = min(1e-2, float(error @ error))
                angles = angles + J.T @ np.linalg.solve(J @ J.T + damping * np.eye(3), error)
            angles = home + np.remainder(angles - home + np.pi, 2 * np.pi) - np.pi
            reached = np.linalg.norm(error) < FAR and (angles >= lower).all() and (angles <= upper).all()
            if reached and (best is None or np.abs(angles - home).max() < np.abs(best - home).max()):
                best = angles
        return best

    def _inner(self, q: Array) -> Array:
        """From our order of the joints to the model's."""
        out = np.empty_like(q)
        out[..., self.order] = q
        return out


def _shapes(model: pin.Model, text: str, folder: Path | None, file: str) -> pin.GeometryModel:
    places = [str(folder), str(folder.parent)] if folder else []
    try:
        return pin.buildGeomFromUrdfString(model, text, pin.GeometryType.COLLISION, package_dirs=places)
    except (ValueError, RuntimeError) as problem:
        advice = "Put the collision meshes beside the URDF, or take their <collision> out of it."
        raise BadStudy(
            Fault(f"a collision shape cannot be read: {str(problem)[:200]}", "no_mesh", advice, file)
        ) from None


def _frame(model: pin.Model, name: str) -> int:
    return int(
        model.getFrameId(name, pin.FrameType.BODY)
        if model.existFrame(name, pin.FrameType.BODY)
        else model.getFrameId(name)
    )
