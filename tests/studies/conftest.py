"""A small floating robot on files, and an identification of it made by hand."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from exogauge.identification.result import ChannelFit, Channels, Identification, Parameter, Prediction
from exogauge.remarks import About, Remark
from exogauge.robots.description import Robot
from exogauge.studies.intake.open import needed_channels, open_study

JOINTS = ("torso_yaw", "torso_pitch", "r_elbow")


def _link(name: str, mass: float) -> str:
    return (
        f'<link name="{name}"><inertial><origin xyz="0.01 0 0.1"/><mass value="{mass}"/>'
        '<inertia ixx="0.05" ixy="0" ixz="0" iyy="0.06" iyz="0" izz="0.04"/></inertial></link>'
    )


def _joint(name: str, kind: str, parent: str, child: str, axis: str = "0 0 1") -> str:
    limit = '<limit lower="-1" upper="1" effort="50" velocity="5"/>' if kind == "revolute" else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0 0 0.2"/><axis xyz="{axis}"/>{limit}</joint>'
    )


URDF = (
    '<robot name="small">'
    + "".join(_link(name, mass) for name, mass in (("BODY", 8.0), ("chest_0", 2.0), ("chest_1", 10.0), ("r_arm", 3.0)))
    + '<link name="imu_link"/><link name="foot_sensor"/>'
    + _joint("torso_yaw", "revolute", "BODY", "chest_0")
    + _joint("torso_pitch", "revolute", "chest_0", "chest_1", "0 1 0")
    + _joint("r_elbow", "revolute", "chest_1", "r_arm", "0 1 0")
    + _joint("imu_joint", "fixed", "BODY", "imu_link")
    + _joint("foot_joint", "fixed", "BODY", "foot_sensor")
    + "</robot>"
)
ROBOT = """version: 1
urdf: robot.urdf
base: floating
base_link: BODY
imu: {frame: imu_link}
ft_sensors:
  - {name: foot, frame: foot_sensor, role: contact, sees: robot_on_world}
joints:
  - {name: torso_yaw, actuation: current, gear_ratio: 100, prior: {k_T: 5.0, tau_c: 1}, prior_std: {k_T: 1.0}}
  - {name: torso_pitch, actuation: current, gear_ratio: 45.0, prior: {k_T: 5.0, J_r: 0.3}}
  - {name: r_elbow, actuation: torque, gear_ratio: 32.0}
transmission:
  joints: [torso_pitch, r_elbow]
  matrix: [[45.0, 0.0], [32.0, 32.0]]
noise: {q: 1e-5, i: 0.02}
inertial_prior_std: {default: 0.25, chest_1: 0.1}
"""
STUDY = """version: 1
name: Small robot, synthetic
robot: robot.yaml
logs:
  - {file: logs/id_1.parquet, role: identification}
  - {file: logs/val_1.parquet, role: validation, motion: bend}
settings: {cutoff_hz: 10, prior_strength: 1}
"""


def write_log(path: Path, robot: Robot, samples: int = 400, drop: tuple[str, ...] = ()) -> None:
    """Standing still with a slow wave in every channel; not a physical motion."""
    t = np.arange(samples) / 200.0
    columns = {"t": t}
    for k, name in enumerate(needed_channels(robot)):
        columns[name] = 0.1 * np.sin(t + k) + (9.81 if name == "acc.z" else 0.0)
    path.parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(pa.table({name: column for name, column in columns.items() if name not in drop}), path)


@pytest.fixture(scope="session")
def pristine(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study folder with robot.yaml, robot.urdf, study.yaml and two logs; not to be changed."""
    root = tmp_path_factory.mktemp("pristine") / "study"
    (root / "logs").mkdir(parents=True)
    (root / "robot.urdf").write_text(URDF)
    (root / "robot.yaml").write_text(ROBOT)
    (root / "study.yaml").write_text(STUDY)
    for name in ("id_1", "val_1"):
        (root / "logs" / f"{name}.parquet").write_bytes(b"")
    with open_study(root) as study:
        for name in ("id_1", "val_1"):
            write_log(root / "logs" / f"{name}.parquet", study.robot)
    return root


@pytest.fixture
def folder(pristine: Path, tmp_path: Path) -> Path:
    """A copy of the pristine study, to be changed at will."""
    return Path(shutil.copytree(pristine, tmp_path / "study"))


@pytest.fixture
def rewrite(folder: Path) -> Callable[[str, str, str], Path]:
    """rewrite(file, old, new): the study with one change in one file."""

    def change(name: str, old: str, new: str) -> Path:
        text = (folder / name).read_text()
        assert old in text
        (folder / name).write_text(text.replace(old, new, 1))
        return folder

    return change


@pytest.fixture
def log_writer() -> Callable[..., None]:
    return write_log


def predictions(samples: int = 4000) -> tuple[Prediction, ...]:
    """Two logs; the a-priori model is off by a factor and an offset, the identified one nearly right."""
    rng = np.random.default_rng(3)
    made = []
    for log, held_out in (("id_1", False), ("val_1", True)):
        t = np.arange(samples) / 200.0
        names = [f"base.{axis}" for axis in ("fx", "fy", "fz", "mx", "my", "mz")] + [f"tau.{name}" for name in JOINTS]
        units = {name: "N" if ".f" in name else "N·m" for name in names}
        truth = {
            name: (12 + 3 * k) * np.sin(0.6 * t + k) * np.sin(0.11 * t) + 3 * np.sin(2.1 * t)
            for k, name in enumerate(names)
        }
        measured = {name: values + 0.6 * rng.standard_normal(samples) for name, values in truth.items()}
        predicted = {name: 0.99 * values for name, values in truth.items()}
        prior = {name: 0.75 * values + 2.0 for name, values in truth.items()}
        channels = partial(Channels, measured, predicted, prior, {})
        made.append(Prediction(log, held_out, t, units, channels))
    return tuple(made)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


@pytest.fixture(scope="session")
def identification(pristine: Path) -> Identification:
    """Made by hand: numbers whose roundings, marks and names can be told apart."""
    with open_study(pristine) as study:
        tree = study.robot.tree
    made = predictions()
    fits = tuple(
        ChannelFit(
            channel,
            each.units[channel],
            each.log,
            each.held_out,
            _rms(told.measured[channel] - told.predicted_prior[channel]),
            _rms(told.measured[channel] - told.predicted[channel]),
            0.6,
        )
        for each, told in ((one, one.channels()) for one in made)
        for channel in told.measured
    )
    phi = tree.phi * 1.07
    symbols = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
    units = ("kg", *("kg·m",) * 3, *("kg·m²",) * 6)
    parameters = [
        Parameter(f"{symbols[k]}[{body}]", phi[n, k], 0.0312 * (k + 1), units[k], tree.phi[n, k], 0.25, body != "r_arm")
        for n, body in enumerate(tree.bodies)
        for k in range(10)
    ]
    parameters.append(
        Parameter("base[mx[chest_1]]", 0.1234, 0.0056, "kg·m", 0.1, 0.05, True, {"mx[chest_1]": 1.0, "m[r_arm]": -0.31})
    )
    values = {"k_T": 4.7312, "k_d": 1.9, "tau_c": 3.01, "tau_s": 3.8, "tau_o": -0.2, "J_r": 0.31}
    joint_units = {"k_T": "N·m/A", "k_d": "N·m·s/rad", "J_r": "kg·m²"}
    for name, value in values.items():
        for k, joint in enumerate(JOINTS):
            identifiable = not (name == "tau_s" and joint == "r_elbow")
            unit = joint_units.get(name, "N·m")
            parameters.append(Parameter(f"{name}[{joint}]", value + k, 0.0213, unit, value, 1.0, identifiable))
    return Identification(
        phi=phi,
        joint_values={name: np.full(3, value) for name, value in values.items()},
        parameters=tuple(parameters),
        unidentifiable=tuple(each.name for each in parameters if not each.identifiable),
        validation=fits,
        predictions=made,
        consistent_links=(True,) * len(tree.bodies),
        prior_strength=1.0,
        prior_curve=((0.01, 2.4), (0.1, 1.7), (1.0, 1.5), (10.0, 1.9), (100.0, 4.0)),
        condition=312.4,
        rank=31,
        samples=4000,
        cutoff_hz=10.0,
        velocity_threshold=np.array([0.01, 0.02, 0.03]),
        remarks=(Remark(About.STICKS_UNEQUALLY, ("r_elbow",)),),
        model=None,  # what is written and drawn needs no model
    )
