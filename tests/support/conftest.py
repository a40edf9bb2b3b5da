"""A robot on two measured feet, moved and loaded by pinocchio alone: its logs share no code with what evaluates them.

Base and joints move as they are told. The feet share what the base rows ask for in any way they like, bands pull as
outside forces at their via points, and the motors give what is then missing, friction included.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import pairwise
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from scipy.signal import butter, lfilter, sosfiltfilt

from exogauge.criteria.criteria import Criteria
from exogauge.devices.device import Band, Device, ViaPoint
from exogauge.devices.routing import Geometry, Routing
from exogauge.effects.catalogue import choose
from exogauge.identification.equations import Equations
from exogauge.identification.model import RobotModel
from exogauge.identification.per_log import PerLog
from exogauge.identification.predict import Parameters
from exogauge.identification.result import Channels, Prediction
from exogauge.identification.settings import Settings
from exogauge.identification.turns import RestDetection
from exogauge.identification.type_b import TypeB
from exogauge.logs.model import Log
from exogauge.robots.description import Joint, Robot, WrenchSensor
from exogauge.robots.parameters import find_base_parameters
from exogauge.robots.row_blocks import RowBlocks
from exogauge.robots.urdf import load_tree
from exogauge.support.evidence import Evidence
from exogauge.support.inputs import Inputs
from exogauge.support.settings import WornLog

RATE = 100.0
CUTOFF = 20.0

# joint: parent, child, xyz, axis
JOINTS = {
    "l_hip": ("pelvis", "l_thigh", (0.0, 0.1, -0.05), (0, 1, 0)),
    "l_knee": ("l_thigh", "l_shank", (0.0, 0.02, -0.35), (0, 1, 0)),
    "r_hip": ("pelvis", "r_thigh", (0.0, -0.1, -0.05), (0, 1, 0)),
    "r_knee": ("r_thigh", "r_shank", (0.0, -0.02, -0.35), (0, 1, 0)),
    "torso_yaw": ("pelvis", "waist", (0.0, 0.0, 0.1), (0, 0, 1)),
    "torso_pitch": ("waist", "chest", (0.02, 0.0, 0.1), (0, 1, 0)),
}
ORDER = ("r_hip", "torso_pitch", "l_knee", "torso_yaw", "l_hip", "r_knee")  # in q, none where the tree has it
FEET = {"l_foot": "l_shank", "r_foot": "r_shank"}
BODIES = {"pelvis": (9, 0.3), "l_thigh": (4, 0.25), "l_shank": (3, 0.3), "r_thigh": (4, 0.25), "r_shank": (3, 0.3),
          "waist": (3, 0.15), "chest": (12, 0.4)}  # fmt: skip
TORSO = [ORDER.index("torso_yaw"), ORDER.index("torso_pitch")]
LEGS = [ORDER.index(name) for name in ("r_hip", "l_knee", "l_hip", "r_knee")]
XI = ("k_T", "k_d", "tau_c", "tau_s", "tau_o", "J_r")  # the effects' coefficients in the order of Settings().effects


def back_band(side: str, **values: float) -> Band:
    """From the shoulder over the back and the pelvis; sides cross the spine so that a twist lengthens one of them."""
    s = 1.0 if side == "left" else -1.0
    points = (("chest", -0.08, 0.12 * s, 0.3), ("chest", -0.12, 0.1 * s, 0.1), ("waist", -0.12, 0.04 * s, 0.0),
              ("pelvis", -0.12, -0.08 * s, 0.0), ("pelvis", -0.1, -0.12 * s, -0.08))  # fmt: skip
    return replace(Band(side, "back", tuple(ViaPoint(link, (x, y, z)) for link, x, y, z in points)), **values)


@pytest.fixture(scope="session")
def suit() -> Device:
    """Both sides alike but for their natural lengths; taut in part of a bend."""
    lengths = {"left": 0.67, "right": 0.68}
    return Device("suit", tuple(back_band(side, stiffness=1500.0, natural_length=lengths[side]) for side in lengths))


def urdf(joints: Mapping[str, tuple] = JOINTS) -> bytes:
    parts = []
    for link, (mass, size) in BODIES.items():
        Ixx, Iyy, Izz = (mass / 12 * (a**2 + b**2) for a, b in ((0.1, size), (0.12, size), (0.1, 0.12)))
        down = -0.4 * size if link[1] == "_" else 0.3 * size
        parts.append(
            f'<link name="{link}"><inertial><origin xyz="0.01 0.005 {down}"/><mass value="{mass}"/>'
            f'<inertia ixx="{Ixx}" ixy="0" ixz="0.001" iyy="{Iyy}" iyz="0" izz="{Izz}"/></inertial></link>'
        )
    for name, (parent, child, xyz, axis) in joints.items():
        parts.append(
            f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{xyz[0]} {xyz[1]} {xyz[2]}"/><axis xyz="{axis[0]} {axis[1]} {axis[2]}"/>'
            '<limit lower="-3" upper="3" velocity="10" effort="100"/></joint>'
        )
    for foot, shank in FEET.items():
        parts.append(
            f'<link name="{foot}"/><joint name="{foot}_mount" type="fixed"><parent link="{shank}"/>'
            f'<child link="{foot}"/><origin xyz="0.02 0 -0.34" rpy="0 0.2 0.1"/></joint>'
        )
    return f'<robot name="biped">{"".join(parts)}</robot>'.encode()


@dataclass(frozen=True)
class Course:
    """What base and joints do. time: (T,); q, dq, ddq: (T, J); angle, rate, turn: (T, 3) roll-pitch-yaw of the base and
    its derivatives; push: (T, 3) [m/s²] acceleration of the base in the world.
    """

    time: np.ndarray
    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray
    angle: np.ndarray
    rate: np.ndarray
    turn: np.ndarray
    push: np.ndarray


@dataclass(frozen=True)
class Recorded:
    """A log and what nobody measures. support: (T, J) [N·m] what the bands do to the joints, by the pulls at their via
    points; base: (T, 6) wrench that the feet give, in the base link. held: (T, J) bool, stuck by friction.
    """

    log: Log
    support: np.ndarray
    base: np.ndarray
    held: np.ndarray


@dataclass
class Biped:
    """phi: (N, 10) and xi: name -> (A,) are true; robot is described with the maker's other values."""

    robot: Robot
    phi: np.ndarray
    xi: dict[str, np.ndarray]
    model: pin.Model
    at: np.ndarray = field(init=False)  # place of each joint in pinocchio's velocities

    def __post_init__(self) -> None:
        self.at = np.array([self.model.joints[self.model.getJointId(name)].idx_v for name in ORDER])

    def record(
        self,
        course: Course,
        name: str = "log",
        bands: Sequence[Band] = (),
        share: Callable[[np.ndarray], np.ndarray] = lambda t: np.full(len(t), 0.5),
        against: Callable[[np.ndarray], np.ndarray] = lambda t: np.zeros((len(t), 6)),
        stuck: Callable[[np.ndarray], np.ndarray] = lambda t: np.zeros(len(ORDER)),
        extra: Callable[[np.ndarray], np.ndarray] = lambda dq: np.zeros_like(dq),
        noise: float = 0.0,
        seed: int = 0,
    ) -> Recorded:
        """Drive through a course. share: (T,) of the base wrench that the left foot carries; against: (T, 6) wrench,
        in the base link, that it gives beside it and the right foot takes back; stuck: (A,) friction of a held axis, by
        the start of the hold, as share of τ_s; extra: (T, A) friction that no model knows, of the velocities.
        """
        t, rng = course.time, np.random.default_rng(seed)
        data = self.model.createData()
        T = len(t)
        turned = [body_rates(*each) for each in zip(course.angle, course.rate, course.turn, strict=True)]
        R, w, wd = (np.array(each) for each in zip(*turned, strict=True))
        q, v, a = np.tile(pin.neutral(self.model), (T, 1)), *np.zeros((2, T, self.model.nv))
        q[:, 3:7], q[:, self.at + 1] = [pin.Quaternion(each).coeffs() for each in R], course.q
        v[:, 3:6], v[:, self.at] = w, course.dq
        a[:, :3], a[:, 3:6], a[:, self.at] = np.einsum("tji,tj->ti", R, course.push), wd, course.ddq
        pulls, frames = self.pulls(q, bands), [self.model.getFrameId(foot) for foot in FEET]
        needed, K = np.empty((T, self.model.nv)), np.empty((T, len(FEET), 6, self.model.nv))
        for k in range(T):
            needed[k] = pin.rnea(self.model, data, q[k], v[k], a[k])
            for foot, frame in enumerate(frames):
                K[k, foot] = pin.computeFrameJacobian(self.model, data, q[k], frame, pin.LOCAL)
        needed -= pulls
        base, support = needed[:, :6].copy(), pulls[:, self.at]
        carried = share(t)[:, None] * base + against(t)
        own = np.stack([carried, base - carried], axis=1)
        feet = np.linalg.solve(K[..., :6].swapaxes(2, 3), own[..., None])[..., 0]
        needed -= np.einsum("tfij,tfi->tj", K, feet)
        assert np.abs(needed[:, :6]).max() < 1e-8
        tau, r_imu, R_imu = needed[:, self.at], self.robot.T_base_imu.translation, self.robot.T_base_imu.rotation
        at_base = np.einsum("tji,tj->ti", R, course.push + np.array([0, 0, 9.81]))
        acc = (at_base + np.cross(wd, r_imu) + np.cross(w, np.cross(w, r_imu))) @ R_imu
        gyro = w @ R_imu
        drive, held = self.drive(course, tau, stuck, extra)
        channels = {f"q.{joint}": course.q[:, j] + noise * 1e-5 * rng.normal(size=T) for j, joint in enumerate(ORDER)}
        channels |= {f"i.{joint}": drive[:, j] + noise * 0.02 * rng.normal(size=T) for j, joint in enumerate(ORDER)}
        for i, axis in enumerate("xyz"):
            channels[f"acc.{axis}"] = acc[:, i] + noise * 0.02 * rng.normal(size=T)
            channels[f"gyro.{axis}"] = gyro[:, i] + noise * 0.001 * rng.normal(size=T)
            for foot, sensor in enumerate(FEET):
                channels[f"ft.{sensor}.f{axis}"] = feet[:, foot, i] + noise * 0.5 * rng.normal(size=T)
                channels[f"ft.{sensor}.m{axis}"] = feet[:, foot, 3 + i] + noise * 0.05 * rng.normal(size=T)
        return Recorded(Log(name, t, channels), support, base, held)

    def places(self, *joints: str) -> list[int]:
        return [ORDER.index(joint) for joint in joints]

    @property
    def torso(self) -> list[int]:
        return TORSO

    @property
    def legs(self) -> list[int]:
        return LEGS

    def pulls(self, q: np.ndarray, bands: Sequence[Band]) -> np.ndarray:
        """(T, nv) generalised force of linear bands: every segment draws its two ends together, virtual work by the
        Jacobians of the points. q: (T, nq)."""
        total, data = np.zeros((len(q), self.model.nv)), self.model.createData()
        frames = {via.link: self.model.getFrameId(via.link) for band in bands for via in band.via_points}
        place, turn, jacobian = (
            {link: np.empty((len(q), *size)) for link in frames} for size in ((3,), (3, 3), (6, self.model.nv))
        )
        for k in range(len(q) if frames else 0):
            pin.computeJointJacobians(self.model, data, q[k])
            pin.updateFramePlacements(self.model, data)
            for link, frame in frames.items():
                T = data.oMf[frame]
                place[link][k], turn[link][k] = T.translation, T.rotation
                jacobian[link][k] = pin.getFrameJacobian(self.model, data, frame, pin.LOCAL_WORLD_ALIGNED)
        for band in bands:
            arms = np.stack([turn[via.link] @ np.array(via.xyz) for via in band.via_points], axis=1)
            x = arms + np.stack([place[via.link] for via in band.via_points], axis=1)
            apart = np.diff(x, axis=1)
            length = np.linalg.norm(apart, axis=2, keepdims=True)
            tension = band.stiffness * np.maximum(length.sum(axis=1, keepdims=True) - band.natural_length, 0.0)
            pull, force = tension * apart / length, np.zeros_like(x)
            force[:, :-1] += pull
            force[:, 1:] -= pull
            wrench = np.concatenate([force, np.cross(arms, force)], axis=2)
            for point, via in enumerate(band.via_points):
                total += np.einsum("tij,ti->tj", jacobian[via.link], wrench[:, point])
        return total

    def drive(self, course: Course, tau: np.ndarray, stuck: Callable, extra: Callable) -> tuple[np.ndarray, np.ndarray]:
        """(T, A) currents, and which joints a held axis makes uncertain."""
        C = self.robot.axes_from_joints
        speed, surge, torque = course.dq @ C.T, course.ddq @ C.T, tau @ np.linalg.inv(C)
        friction, held = np.empty_like(speed), np.abs(speed) < 1e-12
        for axis in range(speed.shape[1]):
            edges = np.flatnonzero(np.diff(held[:, axis], prepend=False))
            holding = np.zeros(len(speed))
            for start, stop in zip(edges[::2], [*edges[1::2], len(speed)][: len(edges[::2])], strict=True):
                holding[start:stop] = stuck(course.time[start])[axis] * self.xi["tau_s"][axis]
            v = speed[:, axis]
            moving = self.xi["k_d"][axis] * v + self.xi["tau_c"][axis] * np.sign(v)
            friction[:, axis] = np.where(held[:, axis], holding, moving)
        friction += np.where(held, 0.0, extra(speed))
        current = (torque + friction + self.xi["J_r"] * surge - self.xi["tau_o"]) / self.xi["k_T"]
        return current, held @ (C != 0.0)

    def with_truth(self, phi: np.ndarray, xi: np.ndarray) -> Biped:
        """The same description over another truth. xi: (A, K)."""
        other = Biped(self.robot, phi, dict(zip(XI, xi.T, strict=True)), self.model.copy())
        load(other.model, self.robot, phi)
        return other

    def known(self, **wrong: np.ndarray) -> RobotModel:
        """A model that holds the true parameters, or wrong ones by the names in XI, without any doubt."""
        base = find_base_parameters(self.robot.tree)
        rows = RowBlocks(self.robot.tree, base, self.robot.axes_from_joints)
        equations = Equations(self.robot, rows, base, choose(Settings().effects))
        xi = np.column_stack([wrong.get(name, self.xi[name]) for name in XI])
        nothing = np.zeros((equations.size, equations.size))
        maker = np.column_stack([[joint.prior.get(name, 0.0) for joint in self.robot.joints] for name in XI])
        support_never_asks_for = {each.name: None for each in fields(RobotModel)} | {"inputs": TypeB()}
        known = {
            "equations": equations,
            "identified": Parameters(self.phi, xi),
            "a_priori": Parameters(self.robot.tree.phi, maker),
            "covariance": nothing,
            "a_priori_covariance": nothing,
            "at_rest": RestDetection(CUTOFF, np.full(len(ORDER), 2e-3), np.zeros(len(ORDER))),
            "cutoff_hz": CUTOFF,
            "prepared": PerLog(),
            "computed": PerLog(),
            "attached": PerLog(),
            "criteria": Criteria(),
        }
        return RobotModel(**(support_never_asks_for | known))


def make_biped(coupled: bool) -> Biped:
    rng = np.random.default_rng(3)
    tree = load_tree(urdf(), joints=ORDER, base_link="pelvis", floating=True)
    J = len(ORDER)
    xi = {
        "k_T": rng.uniform(4, 8, J),
        "k_d": rng.uniform(0.5, 1.5, J),
        "tau_c": rng.uniform(1, 2, J),
        "tau_o": 0.4 * rng.normal(size=J),
        "J_r": rng.uniform(0.05, 0.3, J),
    }
    xi["tau_s"] = 1.4 * xi["tau_c"]
    C = np.eye(J)
    if coupled:  # both motors of the torso turn when it bends
        C[TORSO[0], TORSO[1]], C[TORSO[1], TORSO[0]] = 0.4, -0.3
    robot = Robot(
        "biped",
        tree,
        tuple(Joint(name, "current", prior={"k_T": 0.9 * k}) for name, k in zip(ORDER, xi["k_T"], strict=True)),
        pin.SE3(pin.utils.rotate("x", 0.4), np.array([0.03, -0.02, 0.05])),
        tuple(WrenchSensor(foot, foot, "contact", 1.0) for foot in FEET),
        C,
    )
    phi = tree.phi.copy()
    for body in range(len(phi)):  # heavier by a possible body, so that the maker's values are wrong
        extra = pin.Inertia.FromBox(float(rng.uniform(0.2, 0.8)), *rng.uniform(0.05, 0.2, 3))
        placed = pin.SE3(np.eye(3), 0.05 * rng.normal(size=3)).act(extra)
        phi[body] += placed.toDynamicParameters()
    model = pin.buildModelFromXML(urdf().decode(), pin.JointModelFreeFlyer())
    load(model, robot, phi)
    return Biped(robot, phi, xi, model)


def load(model: pin.Model, robot: Robot, phi: np.ndarray) -> None:
    """Give the bodies of a model their true parameters. phi: (N, 10) in the order of the tree's bodies."""
    for body, one in zip(robot.tree.bodies, phi, strict=True):
        place = model.frames[model.getFrameId(body)].parentJoint
        model.inertias[place] = pin.Inertia.FromDynamicParameters(one)


@pytest.fixture(scope="session")
def biped() -> Biped:
    return make_biped(coupled=False)


@pytest.fixture(scope="session", params=["own motors", "coupled motors"])
def any_biped(request: pytest.FixtureRequest) -> Biped:
    return make_biped(coupled=request.param == "coupled motors")


def body_rates(angle: np.ndarray, rate: np.ndarray, turn: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rotation Rz Ry Rx (world from base), angular velocity and acceleration in the base."""
    x, y, _ = angle
    sx, cx, sy, cy = np.sin(x), np.cos(x), np.sin(y), np.cos(y)
    dx, dy, _ = rate
    E = np.array([[1, 0, -sy], [0, cx, cy * sx], [0, -sx, cy * cx]])
    dE = np.array([
        [0, 0, -cy * dy],
        [0, -sx * dx, -sy * dy * sx + cy * cx * dx],
        [0, -cx * dx, -sy * dy * cx - cy * sx * dx],
    ])  # fmt: skip
    return pin.rpy.rpyToMatrix(*angle), E @ rate, E @ turn + dE @ rate


def waves(rng: np.random.Generator, t: np.ndarray, width: int, size: float, fastest: float = 0.6) -> list[np.ndarray]:
    """(T, width) position, rate and acceleration of a smooth motion without rests."""
    omega = 2 * np.pi * rng.uniform(0.15, fastest, (4, width))
    amplitude, phase = size * rng.uniform(0.2, 0.5, (4, width)), rng.uniform(0, 2 * np.pi, (4, width))
    angle = t[:, None, None] * omega + phase
    return [
        np.sum(amplitude * np.sin(angle), axis=1),
        np.sum(amplitude * omega * np.cos(angle), axis=1),
        -np.sum(amplitude * omega**2 * np.sin(angle), axis=1),
    ]


def wander(seed: int, seconds: float = 8.0, base_seed: int | None = None, begin: float = 0.0) -> Course:
    """All joints and the base move all the time. base_seed: another base motion under the same joint motion; begin: [s]
    into the motion at which the log begins."""
    t = begin + np.arange(0.0, seconds, 1.0 / RATE)
    rng = np.random.default_rng(seed)
    q, dq, ddq = waves(rng, t, len(ORDER), 0.35)
    rng = np.random.default_rng(1000 + (seed if base_seed is None else base_seed))
    return Course(t - begin, q, dq, ddq, *waves(rng, t, 3, 0.15), waves(rng, t, 3, 0.1)[2])


def ramps(t: np.ndarray, corners: Sequence[tuple[float, float]]) -> np.ndarray:
    """(3, T) position, rate, acceleration: polynomials of 7th degree between corners (time, value), still at each."""
    out = np.full((3, len(t)), 0.0)
    out[0] = corners[0][1]
    for (t_0, x_0), (t_1, x_1) in pairwise(corners):
        s, span = np.clip((t - t_0) / (t_1 - t_0), 0.0, 1.0), t_1 - t_0
        begun = t >= t_0
        inside = begun & (t < t_1)
        out[0][begun] = (x_0 + (x_1 - x_0) * (35 * s**4 - 84 * s**5 + 70 * s**6 - 20 * s**7))[begun]
        out[1][inside] = ((x_1 - x_0) * (140 * s**3 - 420 * s**4 + 420 * s**5 - 140 * s**6) / span)[inside]
        out[2][inside] = ((x_1 - x_0) * (420 * s**2 - 1680 * s**3 + 2100 * s**4 - 840 * s**5) / span**2)[inside]
        out[1:, t >= t_1] = 0.0
    return out


def stoop(seed: int = 0, depth: float = 0.8, turn: float = 0.3) -> Course:
    """Bend, hold, rise, then twist to both sides, with the torso still in between; the legs yield, the base sways."""
    t = np.arange(0.0, 14.0, 1.0 / RATE)
    q, dq, ddq = np.zeros((3, len(t), len(ORDER)))
    bend = [(1, 0), (3, depth), (4.5, depth), (6.5, 0), (14, 0)]
    twist = [(1.2, 0), (2.8, 0.3 * turn), (4.7, 0.3 * turn), (6.3, 0), (7.5, 0), (9, turn), (9.5, turn), (12, -turn),
             (12.5, -turn), (13.5, 0)]  # fmt: skip
    for joint, corners in ((TORSO[1], bend), (TORSO[0], twist)):
        q[:, joint], dq[:, joint], ddq[:, joint] = ramps(t, corners)
    rng = np.random.default_rng(seed)
    q[:, LEGS], dq[:, LEGS], ddq[:, LEGS] = waves(rng, t, 4, 0.1)
    return Course(t, q, dq, ddq, *waves(rng, t, 3, 0.05), waves(rng, t, 3, 0.03)[2])


@pytest.fixture(scope="session", name="wander")
def _wander() -> Callable[..., Course]:
    return wander


@pytest.fixture(scope="session", name="stoop")
def _stoop() -> Callable[..., Course]:
    return stoop


@pytest.fixture(scope="session", name="ramps")
def _ramps() -> Callable[..., np.ndarray]:
    return ramps


@pytest.fixture(scope="session")
def low_passed() -> Callable[[np.ndarray], np.ndarray]:
    """(T, ...) as everything that is compared went through the same filter, here scipy's."""
    sections = butter(4, CUTOFF, fs=RATE, output="sos")
    return lambda values: sosfiltfilt(sections, values, axis=0)


@pytest.fixture(scope="session")
def inner() -> slice:
    """Samples that no filter's end touches."""
    return slice(round(RATE), -round(RATE))


@pytest.fixture(scope="session")
def make_evidence(biped: Biped) -> Callable[..., Evidence]:
    """What a log with a device says, with its true torque as that of all approaches, errors on top, and no doubt that
    comes from the robot. noise: [N·m] std of errors that last 0.2 s; gain: on all torques; unused: joints left out.
    """

    size = biped.known().equations.size
    clean = dict[tuple[int, int], tuple[Any, ...]]()  # hundreds of draws are of a few courses

    def without_errors(device: Device, course: Course) -> tuple[Routing, Geometry, np.ndarray]:
        routing = Routing(biped.robot.tree, device.bands)
        geometry = routing.geometry(course.q)
        pull = [
            b.stiffness * np.maximum(x - b.natural_length, 0)
            for b, x in zip(device.bands, geometry.length.T, strict=True)
        ]
        sections = butter(4, CUTOFF, fs=RATE, output="sos")
        tension = np.maximum(sosfiltfilt(sections, pull, axis=1), 0.0)  # what the torque has passed, scipy's
        return routing, geometry, -np.einsum("twd,wt->td", geometry.jacobian, tension)

    def make(
        device: Device, course: Course, noise: float = 0.0, gain: float = 1.0, seed: int = 0, unused: Sequence[str] = ()
    ) -> Evidence:
        key = id(device), id(course)
        if key not in clean:
            clean[key] = device, course, *without_errors(device, course)  # held with them: an id is not given again
        *_, routing, geometry, torque = clean[key]
        torque = gain * (torque + noise * lasting(np.random.default_rng(seed), torque.shape, 0.2))
        nothing, always = np.zeros_like(torque), np.ones(torque.shape, dtype=bool)
        used = always & ~np.isin(routing.joints, list(unused))
        kept = np.arange(0, len(torque), 2)
        slope = np.zeros((len(kept[::20]), torque.shape[1], size), dtype=np.float32)
        return Evidence(
            worn=WornLog(Log("worn", course.time, {}), "motion", device), reference="plain", found=None,
            time=course.time, q=course.q[:, routing.columns], posture=course.q, main=0,
            phase=np.zeros(len(torque), dtype=np.intp), a=torque, b=torque, a_priori=torque, std_a=nothing,
            std_b=nothing, half_a=nothing, half_b=nothing, low_b=torque, compared=used, steady=used, rest=~always,
            length=geometry.length, kept=kept, sloped=kept[::20], inputs_b=Inputs(slope), inputs_a=Inputs(slope),
            prediction=Prediction("worn", True, course.time, {}, lambda: Channels({}, {}, {}, {})),
        )  # fmt: skip

    return make


def lasting(rng: np.random.Generator, shape: tuple[int, int], seconds: float) -> np.ndarray:
    """(T, D) of unit variance, with a memory of that length."""
    rho = np.exp(-1.0 / (seconds * RATE))
    white = rng.normal(size=shape)
    white[0] /= np.sqrt(1.0 - rho**2)
    return np.asarray(lfilter([np.sqrt(1.0 - rho**2)], [1.0, -rho], white, axis=0))


@pytest.fixture(scope="session")
def recorded() -> Callable[[Biped, Device, Iterable[str]], dict[str, Log]]:
    """A stoop again and again, by name; the suit is on where the name says `worn`. No two runs stand on their feet
    alike; sensors have noise."""

    def recorded(biped: Biped, suit: Device, names: Iterable[str]) -> dict[str, Log]:
        return {
            name: biped.record(
                stoop(k), name, suit.bands if "worn" in name else (), share=lambda t, k=k: 0.5 + 0.3 * np.sin(t + k),
                noise=1.0, seed=k,
            ).log
            for k, name in enumerate(names)
        }  # fmt: skip

    return recorded
