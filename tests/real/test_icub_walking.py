"""iCub walking: 12 s of joint positions, an IMU and the vertical force under each foot; no torques, no currents."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pinocchio as pin
import pytest
from tests.real.recordings.icub_walking import FILES, JOINTS, RECORDING, write

from exogauge.studies.evaluate import evaluate

pytestmark = pytest.mark.slow

GRAVITY = 9.81
STANDING = 100  # samples before the first step


@pytest.fixture(scope="module")
def folder(recording: Callable[..., Path]) -> Path:
    return recording(RECORDING, FILES)


def identification(folder: Path, base_link: str = "root_link", imu: str = "root_link_imu_frame") -> Mapping[str, Any]:
    """Evaluate the study, bodies possible; results.json's `identification`."""
    write(folder, base_link, imu)
    out = folder / f"results_{imu}"
    evaluate(folder / "study.yaml", out, lambda *_: None, {"consistency": "physical"})
    found: Mapping[str, Any] = json.loads((out / "results.json").read_text())["identification"]
    return found


def total_mass(found: Mapping[str, Any]) -> float:
    return sum(each["value"] for each in found["parameters"] if each["name"].startswith("m["))


def recorded(folder: Path, *names: str) -> list[np.ndarray]:
    """(T, components) of each variable."""
    with h5py.File(folder / "walking.mat") as file:
        return [np.asarray(file[name]).T for name in names]


def mass_by_the_feet(folder: Path) -> float:
    left, right = recorded(folder, "lfForceZ", "rfForceZ")
    return float((left + right).mean()) / GRAVITY


@pytest.fixture(scope="module")
def found(folder: Path) -> Mapping[str, Any]:
    return identification(folder)


def test_the_base_rows_weigh_the_robot_as_its_feet_do(folder: Path, found: Mapping[str, Any]) -> None:
    expected = mass_by_the_feet(folder)
    assert expected == pytest.approx(33.59, abs=0.01)
    assert total_mass(found) == pytest.approx(expected, rel=0.02)
    (mass,) = [each for each in found["parameters"] if each["name"] == "base[m[root_link]]"]
    assert mass["identifiable"]
    assert len(mass["combination"]) == 27
    assert abs(mass["value"] - expected) < 2.0 * mass["std"]


def test_no_joint_parameter_is_claimed_where_no_torque_is_logged(found: Mapping[str, Any]) -> None:
    assert not any(fit["channel"].startswith("tau.") for fit in found["validation"])
    of_joints = [each for joint in found["joints"] for name, each in joint.items() if name != "joint"]
    assert of_joints
    assert not any(each["identifiable"] for each in of_joints)


def test_every_body_that_is_found_is_possible(folder: Path, found: Mapping[str, Any]) -> None:
    assert all(found["consistent_links"].values())
    assert (folder / "results_root_link_imu_frame" / "identified.urdf").is_file()


def test_the_heads_imu_frame_gives_no_mass_at_all(folder: Path) -> None:
    assert abs(total_mass(identification(folder, "head", "imu_frame"))) < 5.0


def test_gravity_says_that_the_imu_is_the_root_links(folder: Path) -> None:
    angle = {name: gravity_angle(folder, name) for name in ("root_link_imu_frame", "imu_frame", "root_link", "head")}
    assert angle.pop("root_link_imu_frame") < 3.0
    assert min(angle.values()) > 90.0


def gravity_angle(folder: Path, frame: str) -> float:
    """[deg] between the accelerometer and the upward direction in a frame, standing; posture from motion capture."""
    q_log, acc, base = recorded(folder, "estimatorJointsPos", "imuAcc", "linkBaseRot")
    model = pin.buildModelFromUrdf(str(folder / "model.urdf"))
    data, q = model.createData(), pin.neutral(model)
    for name, value in zip(JOINTS, q_log[:STANDING].mean(axis=0), strict=True):
        q[model.joints[model.getJointId(name)].idx_q] = value
    pin.framesForwardKinematics(model, data, q)
    R_world_root = pin.rpy.rpyToMatrix(base[:STANDING].mean(axis=0))
    up = (R_world_root @ data.oMf[model.getFrameId(frame)].rotation).T @ [0.0, 0.0, 1.0]
    f = acc[:STANDING].mean(axis=0)
    return float(np.degrees(np.arccos(up @ f / np.linalg.norm(f))))
