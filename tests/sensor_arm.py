"""An arm of four joints with force/torque sensors inside, moved by pinocchio, and by Newton and Euler link by link: no
code shared with what is tested.

Its bodies, friction and sensors' zeros are known and differ from what the URDF, that is the maker, says.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pinocchio as pin
import yaml

from exogauge.logs.model import Log
from exogauge.robots.description import Robot
from exogauge.studies.intake.robot_file import load_robot

RATE = 100.0  # [Hz]
JOINTS = ("j1", "j2", "j3", "j4")
AXES = ("0 0 1", "0 1 0", "1 0 0", "0 1 0")
COMPONENTS = ("fx", "fy", "fz", "mx", "my", "mz")
SENSOR_NOISE = np.array([0.1, 0.1, 0.1, 0.01, 0.01, 0.01])  # [N, N·m]
TORQUE_NOISE = 0.05  # [N·m]
FRICTION = {"k_d": np.array([0.8, 1.1, 0.4, 0.3]), "tau_c": np.array([1.2, 1.6, 0.7, 0.5])}
OFFSET = np.array([0.2, -0.3, 0.1, 0.15])
GRAVITY = np.array([0.0, 0.0, -9.81])
STATED = {  # mass [kg], centre of mass [m] of every link that weighs something
    "plate": (3.0, (0.02, 0.0, 0.05)),
    "l1": (4.0, (0.02, -0.03, 0.08)),
    "l2": (3.0, (0.03, 0.04, 0.14)),
    "l3": (2.0, (-0.02, 0.02, 0.11)),
    "l4": (1.2, (0.01, 0.02, 0.05)),
    "tool": (1.5, (0.03, -0.02, 0.08)),
    "camera": (0.2, (0.0, 0.02, 0.01)),
}
BEYOND = {"wrist_ft": ("tool", "camera"), "foot_ft": tuple(STATED)}

Reading = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""(t (T,), what the sensor should read (T, 6)) -> what it reads instead."""


@dataclass(frozen=True)
class Sensor:
    """sees: as in robot.yaml. zero: (6,) what it reads with nothing beyond it."""

    name: str
    frame: str
    sees: str
    zero: np.ndarray = field(default_factory=lambda: np.zeros(6))

    @property
    def sign(self) -> float:
        """Of the reading against the wrench that holds and moves what is beyond."""
        return -1.0 if self.sees in ("payload_on_sensor", "robot_on_world") else 1.0


def wrist(sees: str = "payload_on_sensor") -> Sensor:
    return Sensor("wrist", "wrist_ft", sees, np.array([0.7, -0.4, 1.1, 0.05, -0.08, 0.03]))


def _inertia(name: str, true: bool) -> pin.Inertia:
    mass, com = STATED[name]
    number = list(STATED).index(name)
    if true:
        mass, com = (
            mass * (1.12 - 0.05 * (number % 4)),
            np.array(com) + 0.006 * np.cos([number, number + 1, number + 3]),
        )
    size = np.array([0.08, 0.11, 0.15 + 0.01 * number])
    about_com = mass / 12.0 * np.diag(np.sum(size**2) - size**2) * (1.1 if true else 1.0)
    R = pin.rpy.rpyToMatrix(0.1 * number, -0.2, 0.15)
    return pin.Inertia(mass, np.array(com), R @ about_com @ R.T)


def urdf(true: bool = False) -> str:
    """Stand, massless sensor, plate, four links, massless sensor, tool and a camera on it."""

    def link(name: str) -> str:
        if name not in STATED:
            return f'<link name="{name}"/>'
        own = _inertia(name, true)
        I, c = own.inertia, own.lever  # noqa: E741
        return (
            (
                f'<link name="{name}"><inertial><origin xyz="{c[0]!r} {c[1]!r} {c[2]!r}"/><mass value="{own.mass!r}"/>'
                f'<inertia ixx="{I[0, 0]!r}" ixy="{I[0, 1]!r}" ixz="{I[0, 2]!r}" iyy="{I[1, 1]!r}" iyz="{I[1, 2]!r}" '
                f'izz="{I[2, 2]!r}"/></inertial></link>'
            )
            .replace("np.float64(", "")
            .replace(")", "")
        )

    def joint(name: str, a: str, b: str, xyz: str, rpy: str, axis: str = "") -> str:
        limit = '<limit lower="-3" upper="3" effort="100" velocity="10"/>'
        return (
            f'<joint name="{name}" type="{"revolute" if axis else "fixed"}"><parent link="{a}"/><child link="{b}"/>'
            f'<origin xyz="{xyz}" rpy="{rpy}"/>{f"<axis xyz={chr(34)}{axis}{chr(34)}/>{limit}" if axis else ""}</joint>'
        )

    links = ["stand", "foot_ft", "plate", "l1", "l2", "l3", "l4", "wrist_ft", "tool", "camera"]
    joints = [
        joint("ground", "stand", "foot_ft", "0 0 0.1", "0 0 0.3"),
        joint("bolted", "foot_ft", "plate", "0 0 0.05", "0 0 0"),
        joint("j1", "plate", "l1", "0 0 0.1", "0 0 0", AXES[0]),
        joint("j2", "l1", "l2", "0.05 0 0.2", "0 0 0", AXES[1]),
        joint("j3", "l2", "l3", "0 0.03 0.3", "0.1 0 0", AXES[2]),
        joint("j4", "l3", "l4", "0.02 0 0.25", "0 0 0.2", AXES[3]),
        joint("flange", "l4", "wrist_ft", "0 0.01 0.09", "0.3 0 0.1"),
        joint("mount", "wrist_ft", "tool", "0 0 0.03", "0 0.2 0"),
        joint("clip", "tool", "camera", "0.05 0 0.06", "0 0 1.0"),
    ]
    return f'<robot name="arm">{"".join(map(link, links))}{"".join(joints)}</robot>'


def describe(folder: Path, sensors: Sequence[Sensor]) -> Robot:
    """The arm as its maker describes it, read from robot.yaml."""
    (folder / "robot.urdf").write_text(urdf(), encoding="utf-8")
    about = {
        "version": 1,
        "uncertainty": "none",
        "urdf": "robot.urdf",
        "base": "fixed",
        "base_link": "stand",
        "joints": [{"name": name, "actuation": "torque"} for name in JOINTS],
        "ft_sensors": [{"name": s.name, "frame": s.frame, "role": "cut", "sees": s.sees} for s in sensors],
        "inertial_prior_std": {"default": 0.3},
    }
    (folder / "robot.yaml").write_text(yaml.safe_dump(about), encoding="utf-8")
    return load_robot(folder)


def true_phi(tree_bodies: Sequence[str], apart: Sequence[str]) -> np.ndarray:
    """(N, 10) of the named bodies, each in the frame of the link that it is called after.

    apart: links at which a sensor cuts; what is rigidly beyond one is no part of the body before it.
    """
    model = pin.buildModelFromXML(urdf(true=True))
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    members = {"l4": ("l4", "tool", "camera"), "tool": ("tool", "camera"), "plate": ("plate",)}
    if "wrist_ft" in apart:
        members["l4"] = ("l4",)
    rows = []
    for body in tree_bodies:
        place = data.oMf[model.getFrameId(body)]
        parts = (
            place.actInv(data.oMf[model.getFrameId(link)]).act(_inertia(link, True))
            for link in members.get(body, (body,))
        )
        rows.append(np.sum([part.toDynamicParameters() for part in parts], axis=0))
    return np.array(rows)


def motion(seed: int, seconds: float) -> tuple[np.ndarray, ...]:
    """t, q, v, a: six waves per joint, fast and slow, through postures of all sorts; from rest to rest."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, 1.0 / RATE)
    omega = 2.0 * np.pi * rng.uniform(0.05, 0.6, size=(6, 4))
    size, phase = rng.uniform(0.2, 0.5, size=(6, 4)), rng.uniform(0.0, 6.28, size=(6, 4))
    ramp = np.clip(np.minimum(t, t[-1] - t) / 1.5, 0.0, 1.0)
    side = np.where(t < 0.5 * seconds, 1.0, -1.0)
    speed, surge = ramp**3 * (10.0 - 15.0 * ramp + 6.0 * ramp**2), side * 20.0 * (ramp * (1.0 - ramp)) ** 2
    clock = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1])) / RATE])
    angle = clock[:, None, None] * omega + phase
    rate = np.sum(size * omega * np.cos(angle), axis=1)
    bend = -np.sum(size * omega**2 * np.sin(angle), axis=1)
    return (
        t,
        np.sum(size * np.sin(angle), axis=1),
        rate * speed[:, None],
        bend * speed[:, None] ** 2 + rate * surge[:, None],
    )


def holding_wrench(frame: str, q: np.ndarray, v: np.ndarray, a: np.ndarray, gravity: np.ndarray) -> np.ndarray:
    """(T, 6) force and moment, in the sensor's frame, that hold and move the links beyond it."""
    model = pin.buildModelFromXML(urdf(true=True))
    data = model.createData()
    links = [(model.getFrameId(link), _inertia(link, True)) for link in BEYOND[frame]]
    at, readings = model.getFrameId(frame), np.empty((len(q), 6))
    for k in range(len(q)):
        pin.forwardKinematics(model, data, q[k], v[k], a[k])
        pin.updateFramePlacements(model, data)
        total = pin.Force.Zero()
        for number, inertia in links:
            place, twist = data.oMf[number], pin.getFrameVelocity(model, data, number)
            spatial = pin.getFrameAcceleration(model, data, number)
            spatial.linear = spatial.linear - place.rotation.T @ gravity
            total = total + place.act(inertia * spatial + twist.cross(inertia * twist))
        readings[k] = data.oMf[at].actInv(total).vector
    return readings


def record(
    seed: int,
    sensors: Sequence[Sensor],
    seconds: float = 20.0,
    gravity: np.ndarray = GRAVITY,
    spoiled: Mapping[str, Reading] | None = None,
    noise: float = 1.0,
    noise_seed: int | None = None,
) -> Log:
    """A log of the true arm. gravity: (3,) [m/s²] in the base's frame. spoiled: what a sensor makes of its reading."""
    t, q, v, a = motion(seed, seconds)
    rng = np.random.default_rng(seed + 1000 if noise_seed is None else noise_seed)
    model = pin.buildModelFromXML(urdf(true=True))
    model.gravity.linear = gravity
    data = model.createData()
    load = np.array([pin.rnea(model, data, *row) for row in zip(q, v, a, strict=True)])
    tau = load + FRICTION["k_d"] * v + FRICTION["tau_c"] * np.sign(v) - OFFSET
    tau = tau + noise * TORQUE_NOISE * rng.normal(size=q.shape)
    channels = {}
    for sensor in sensors:
        reading = sensor.sign * holding_wrench(sensor.frame, q, v, a, gravity)
        if spoiled and sensor.name in spoiled:
            reading = spoiled[sensor.name](t, reading)
        reading = reading + sensor.zero + noise * SENSOR_NOISE * rng.normal(size=reading.shape)
        channels |= {f"ft.{sensor.name}.{axis}": reading[:, k] for k, axis in enumerate(COMPONENTS)}
    measured = q + noise * 1e-5 * rng.normal(size=q.shape)
    channels |= {f"q.{name}": measured[:, j] for j, name in enumerate(JOINTS)}
    channels |= {f"tau.{name}": tau[:, j] for j, name in enumerate(JOINTS)}
    return Log(f"log{seed}", t, channels)


def truth(robot: Robot, sensors: Sequence[Sensor]) -> dict[str, float]:
    """`m[tool]`, `k_d[j1]`, `zero.fx[wrist]` … -> what the logs were made with."""
    phi = true_phi(robot.tree.bodies, [sensor.frame for sensor in sensors])
    names = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
    known = {f"{n}[{body}]": float(phi[i, k]) for i, body in enumerate(robot.tree.bodies) for k, n in enumerate(names)}
    known |= {f"zero.{axis}[{s.name}]": float(s.zero[k]) for s in sensors for k, axis in enumerate(COMPONENTS)}
    for name, values in (FRICTION | {"tau_o": OFFSET}).items():
        known |= {f"{name}[{joint}]": float(value) for joint, value in zip(JOINTS, values, strict=True)}
    return known
