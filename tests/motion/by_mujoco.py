"""What MuJoCo says of a motion: its inverse dynamics of the URDF, and its own collisions of the URDF's shapes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Protocol
from xml.etree import ElementTree

import mujoco
import numpy as np
import pinocchio as pin
import yaml
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.strain import EVENLY
from exogauge.robots.moving.touching import FLOOR
from exogauge.synthetic.urdf import robot_urdf

Array = np.ndarray
AS_IT_IS = (  # links without mass, as those between two axes of a joint are, get next to none
    '<mujoco><compiler discardvisual="true" fusestatic="false" balanceinertia="false" boundmass="1e-9" '
    'boundinertia="1e-12"/></mujoco>'
)


class Motion(Protocol):
    """Of some seconds."""

    @property
    def duration(self) -> float:
        """[s]"""
        ...

    def at(self, time: Array) -> tuple[Array, ...]:
        """q (T, n) first."""
        ...


def spec_of(urdf: str, assets: Mapping[str, bytes] | None = None) -> mujoco.MjSpec:
    spec = mujoco.MjSpec.from_string(urdf.replace("</robot>", AS_IT_IS + "</robot>"), assets=dict(assets or {}))
    spec.worldbody.first_body().add_freejoint()
    return spec


def felt(folder: Path) -> tuple[str, dict[str, bytes]]:
    """The URDF of a folder with robot.yaml, its meshes beside it or below; shapes of robot.yaml in place of its own.

    Nothing that is only seen is left of it.
    """
    whole = yaml.safe_load((folder / "robot.yaml").read_text())
    root = ElementTree.fromstring((folder / whole["urdf"]).read_bytes())
    shapes, assets = whole.get("collision", {}).get("shapes", {}), dict[str, bytes]()
    for link in root.findall("link"):
        given = shapes.get(link.get("name"))
        for part in [*link.findall("visual"), *(link.findall("collision") if given is not None else [])]:
            link.remove(part)
        for each in given or []:
            collision = ElementTree.SubElement(link, "collision")
            along = {key: " ".join(map(str, each.get(key, (0.0, 0.0, 0.0)))) for key in ("xyz", "rpy")}
            ElementTree.SubElement(collision, "origin", along)
            ((kind, size),) = ((key, value) for key, value in each.items() if key not in along)
            said = {"box": lambda s: {"size": " ".join(map(str, s))}, "sphere": lambda s: {"radius": str(s)}}.get(
                kind, lambda s: {"radius": str(s[0]), "length": str(s[1])}
            )(size)
            ElementTree.SubElement(ElementTree.SubElement(collision, "geometry"), kind, said)
        for mesh in link.findall("collision/geometry/mesh"):
            name = Path(str(mesh.get("filename"))).name
            assets[name] = next(folder.rglob(name)).read_bytes()
            mesh.set("filename", name)
    return ElementTree.tostring(root, encoding="unicode"), assets


def bare(urdf: str) -> str:
    """Without any shape."""
    root = ElementTree.fromstring(urdf)
    for link in root.findall("link"):
        for part in link.findall("collision"):
            link.remove(part)
    return ElementTree.tostring(root, encoding="unicode")


def limits(urdf: str, joints: tuple[str, ...]) -> dict[str, Array]:
    """lower, upper [rad, m], velocity, effort of joints (J,), as the file says them."""
    root = ElementTree.fromstring(urdf)
    said = {each.get("name"): limit for each in root.findall("joint") if (limit := each.find("limit")) is not None}
    return {
        key: np.array([float(said[joint].get(key, "nan")) for joint in joints])
        for key in ("lower", "upper", "velocity", "effort")
    }


class ByMuJoCo:
    """Forces and torques of a trajectory by MuJoCo's inverse dynamics of the URDF, rates by its own differences.

    inside: (T - 2,) [m] of the centre of pressure; rubbed: (T - 2,) force along the floor over that on it; carried:
    (T - 2,) [N] on the floor. torque: (T - 2, J) as if nothing stood on the feet; evenly: (T - 2, J) where feet that
    stand share the load as evenly as they can. feet, turned: (T, F, 3) [m] and (T, F) [rad] against how they began.
    angle (T, J), speed (T - 2, J).

    stands: (T, F) which feet do; all where none is given.
    """

    def __init__(
        self, robot: MotionRobot, spline: Motion, rate: float, stands: Array | None = None, urdf: str | None = None
    ) -> None:
        time = np.arange(int(spline.duration * rate + 1e-6) + 1) / rate
        tight = 1e-4
        fine = [spline.at(np.clip(time + k * tight, 0.0, spline.duration))[0] for k in (-1, 0, 1)]
        model = self.model(urdf)
        self._look(model, robot, [self.qpos(model, robot, q) for q in fine], tight, stands)

    @classmethod
    def of_file(cls, robot: MotionRobot, file: Mapping[str, Array], urdf: str) -> ByMuJoCo:
        """Of an export for MuJoCo: nothing but its samples, rates from one to the next."""
        seen = cls.__new__(cls)
        model = cls.model(urdf)
        qpos = np.empty_like(file["qpos"])
        order = [model.joint(str(name)).qposadr[0] for name in file["joint_names"]]
        qpos = np.tile(mujoco.MjData(model).qpos, (len(file["qpos"]), 1))
        qpos[:, [*range(7), *order]] = file["qpos"]
        shifted = [np.roll(qpos, 1, axis=0), qpos, np.roll(qpos, -1, axis=0)]
        seen._look(model, robot, shifted, float(file["time"][1] - file["time"][0]), file["stands"].astype(bool))
        return seen

    @staticmethod
    def model(urdf: str | None) -> mujoco.MjModel:
        """Without anything that touches, rubs or is reflected."""
        model = spec_of(urdf or robot_urdf()).compile()
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        model.dof_damping[:] = model.dof_frictionloss[:] = model.dof_armature[:] = 0.0
        return model

    def _look(
        self, model: mujoco.MjModel, robot: MotionRobot, place: list[Array], tight: float, stands: Array | None
    ) -> None:
        """place: (T, nq) before, at and after every sample, `tight` [s] apart."""
        data, T = mujoco.MjData(model), len(place[1])
        order = [model.joint(name).dofadr[0] for name in robot.joints]
        self.evenly, self.speed = (np.empty((T - 2, len(order))) for _ in range(2))
        self.angle = place[1][:, [model.joint(name).qposadr[0] for name in robot.joints]]
        up = np.ones((T, 2), bool) if stands is None else stands
        bodies = [model.body(sole.link).id for sole in robot.soles]
        self.feet, feet = np.empty((T, 2, 3)), np.empty((T, 2, 3, 3))
        asked, trunk = np.empty((T - 2, model.nv)), np.empty((T - 2, 3, 3))
        for t in range(T):
            data.qpos[:] = place[1][t]
            mujoco.mj_kinematics(model, data)
            self.feet[t], feet[t] = data.xpos[bodies], data.xmat[bodies].reshape(-1, 3, 3)
            if not 0 < t < T - 1:
                continue
            before, after = np.empty(model.nv), np.empty(model.nv)
            mujoco.mj_differentiatePos(model, before, tight, place[0][t], place[1][t])
            mujoco.mj_differentiatePos(model, after, tight, place[1][t], place[2][t])
            data.qvel[:], data.qacc[:] = 0.5 * (before + after), (after - before) / tight
            mujoco.mj_inverse(model, data)
            asked[t - 1], trunk[t - 1] = data.qfrc_inverse, data.xmat[1].reshape(3, 3)
            self.speed[t - 1] = data.qvel[order]
            self.evenly[t - 1] = (asked[t - 1] - self._borne(model, data, bodies, up[t], asked[t - 1]))[order]
        self.torque = asked[:, order]
        turned = np.swapaxes(feet[:1], 2, 3) @ feet
        self.turned = Rotation.from_matrix(turned.reshape(-1, 3, 3)).magnitude().reshape(T, 2)
        each = [sole.outline @ feet[0, f].T + self.feet[0, f] for f, sole in enumerate(robot.soles)]
        floor, force = np.concatenate(each)[:, 2].mean(), asked[:, :3]
        moment = np.einsum("tij,tj->ti", trunk, asked[:, 3:6])
        moment += np.cross(place[1][1:-1, :3] - [0, 0, floor], force)
        cop = np.stack([-moment[:, 1], moment[:, 0]], axis=1) / force[:, 2:]
        self.rubbed, self.carried = np.hypot(force[:, 0], force[:, 1]) / force[:, 2], force[:, 2]
        self.inside = np.full(T - 2, np.nan)  # where no foot stands
        for which in ((True, True), (False, True), (True, False)):
            corners = np.concatenate([corners for corners, stands in zip(each, which, strict=True) if stands])
            hull, there = ConvexHull(corners[:, :2]).equations, (up[1:-1] == which).all(axis=1)
            self.inside[there] = -(cop[there] @ hull[:, :2].T + hull[:, 2]).max(axis=1)

    @staticmethod
    def _borne(model: mujoco.MjModel, data: mujoco.MjData, bodies: list[int], up: Array, asked: Array) -> Array:
        """(nv,) what the floor does for the motion by the feet that stand, each in the axes of its link."""
        rows = []
        for body in bodies:
            along, around = np.empty((3, model.nv)), np.empty((3, model.nv))
            mujoco.mj_jacBody(model, data, along, around, body)
            R = data.xmat[body].reshape(3, 3)
            rows += [R.T @ along, R.T @ around]
        J, D = np.concatenate(rows), np.tile(EVENLY, len(bodies)) * np.repeat(up, 6)
        driven = J[:, :6]
        return np.asarray(J.T @ (D * (driven @ np.linalg.solve(driven.T @ (D[:, None] * driven), asked[:6]))))

    @staticmethod
    def qpos(model: mujoco.MjModel, robot: MotionRobot, q: np.ndarray) -> np.ndarray:
        """(T, nq) of (T, n)."""
        out = np.tile(mujoco.MjData(model).qpos, (len(q), 1))
        out[:, :3], out[:, [4, 5, 6, 3]] = q[:, :3], Rotation.from_euler("ZXY", q[:, 3:6]).as_quat()
        out[:, [model.joint(name).qposadr[0] for name in robot.joints]] = q[:, 6:]
        return out


class Shapes:
    """The URDF as MuJoCo reads it, on a floor."""

    def __init__(self, robot: MotionRobot, urdf: str, assets: Mapping[str, bytes] | None = None) -> None:
        spec = spec_of(urdf, assets)
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[5.0, 5.0, 0.1])
        self.robot, self.model = robot, spec.compile()
        self.data = mujoco.MjData(self.model)
        bodies = [self.model.body(self.model.geom_bodyid[g]).name for g in range(self.model.ngeom)]
        self.link = [FLOOR if body == "world" else body for body in bodies]

    def stand(self, q: np.ndarray) -> None:
        turn = pin.Quaternion(pin.rpy.rotate("z", q[3]) @ pin.rpy.rotate("x", q[4]) @ pin.rpy.rotate("y", q[5]))
        self.data.qpos[:3], self.data.qpos[3:7] = q[:3], [turn.w, turn.x, turn.y, turn.z]
        for k, name in enumerate(self.robot.joints):
            self.data.qpos[self.model.joint(name).qposadr[0]] = q[6 + k]
        mujoco.mj_kinematics(self.model, self.data)

    def distance(self, one: str, other: str) -> float:
        geoms = (self.link.index(one), self.link.index(other))
        return float(mujoco.mj_geomDistance(self.model, self.data, *geoms, 10.0, None))

    def nearest(self, most: float, q: np.ndarray) -> dict[frozenset[str], float]:
        """[m] of pairs of links that MuJoCo's own collision detection finds nearer than `most`, parents and children
        aside."""
        self.model.geom_margin[:] = most
        found = dict[frozenset[str], float]()
        for posture in q:
            self.stand(posture)
            mujoco.mj_collision(self.model, self.data)
            for contact in self.data.contact[: self.data.ncon]:
                if contact.dist < most:
                    pair = frozenset(self.link[g] for g in contact.geom)
                    found[pair] = min(found.get(pair, most), float(contact.dist))
        return found

    def nearer_than(self, most: float, q: np.ndarray) -> set[frozenset[str]]:
        return set(self.nearest(most, q))
