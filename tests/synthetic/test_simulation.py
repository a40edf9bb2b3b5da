from __future__ import annotations

import mujoco
import numpy as np
import pytest
from tests.synthetic.balance import balance

from exogauge.synthetic.mjcf import TIME_STEP
from exogauge.synthetic.robot_facts import ANKLE_HEIGHT, FEET, JOINT_NAMES, SOLE_SIZE
from exogauge.synthetic.true_robot import TrueRobot, moving_bodies

pytestmark = pytest.mark.slow


def _values(robot: TrueRobot, kind: str) -> np.ndarray:
    return np.array([getattr(robot.joints[name], kind) for name in JOINT_NAMES])


def test_planned_feet_stay_where_they_stand(run, planner) -> None:
    data = mujoco.MjData(planner)
    feet = [planner.body(foot).id for foot in FEET]
    for k in range(0, len(run.plan.angles), 20):
        data.qpos[:3] = run.plan.base[k]
        mujoco.mju_mat2Quat(data.qpos[3:7], run.plan.R_base[k].ravel())
        data.qpos[7:] = run.plan.angles[k]
        mujoco.mj_kinematics(planner, data)
        np.testing.assert_allclose(data.xpos[feet], [[0, 0.11, ANKLE_HEIGHT], [0, -0.11, ANKLE_HEIGHT]], atol=1e-9)
        np.testing.assert_allclose(data.xmat[feet], np.tile(np.eye(3).ravel(), (2, 1)), atol=1e-9)


def test_both_soles_stay_flat_on_the_ground(run) -> None:
    vertical = run.recording.wrench[:, :, 2]
    assert vertical.min() > 30.0
    forward, sideways = -run.recording.wrench[:, :, 4] / vertical, run.recording.wrench[:, :, 3] / vertical
    assert np.abs(forward - 0.02).max() < SOLE_SIZE[0] / 2
    assert np.abs(sideways).max() < SOLE_SIZE[1] / 2


def test_standing_still_the_feet_carry_the_weight(run) -> None:
    still = run.recording.time < 0.6
    weight = 9.81 * sum(body.mass for body in moving_bodies(run.robot.masses).values())
    assert run.recording.wrench[still, :, 2].sum(axis=1).mean() == pytest.approx(weight, rel=2e-3)


def test_friction_slides_at_tau_c_and_holds_up_to_tau_s(run) -> None:
    plain = np.array([name != "l_knee_pitch" for name in JOINT_NAMES])
    friction, speed = run.recording.friction[:, plain], run.recording.dq[:, plain]
    tau_c, tau_s = _values(run.robot, "tau_c")[plain], _values(run.robot, "tau_s")[plain]
    assert np.all(np.abs(friction) <= tau_s * (1.0 + 1e-9))
    sliding = np.abs(speed) > 0.02
    expected = np.broadcast_to(tau_c, speed.shape) * np.sign(speed)
    np.testing.assert_allclose(friction[sliding], expected[sliding], rtol=1e-6)


def test_a_stuck_joint_does_not_creep(run) -> None:
    """Where friction is well inside its limits the joint stands."""
    stuck = np.abs(run.recording.friction) < 0.8 * _values(run.robot, "tau_c")
    assert np.median(np.abs(run.recording.dq[stuck])) < 1e-4


def test_a_stribeck_peak_acts_at_low_speed_only(run) -> None:
    j = JOINT_NAMES.index("l_knee_pitch")
    truth, speed, friction = run.robot.joints["l_knee_pitch"], run.recording.dq[:, j], run.recording.friction[:, j]
    fast = np.abs(speed) > 4 * truth.v_s
    np.testing.assert_allclose(np.abs(friction[fast]), truth.tau_c, rtol=1e-3)
    assert np.abs(friction).max() > truth.tau_c + 0.5 * truth.tau_b


@pytest.mark.parametrize("suit", [None, "normal", "modified"])
def test_true_parameters_explain_the_motion_through_another_dynamics_library(run, worn, suit: str | None) -> None:
    """Base: Y φ = Σ Kᵀ F. Joints: Y φ − F_j + k_d θ̇ + friction + J_r θ̈ = k_T i + tau_o + bands, to solver accuracy.

    A suit without mass is an internal force: the base's rows are the same with it.
    """
    run = worn["bend", suit] if suit else run
    recording, robot = run.recording, run.robot
    kinds = {kind: _values(robot, kind) for kind in ("k_T", "k_d", "tau_o", "J_r")}
    rows, base, joints = balance(recording, robot)
    dq, ddq = recording.dq[rows], recording.ddq[rows]
    resistance = kinds["k_d"] * (dq + ddq * TIME_STEP / 2) + recording.friction[rows] + kinds["J_r"] * ddq
    np.testing.assert_allclose(base, 0.0, atol=1e-3)
    drive = kinds["k_T"] * recording.current[rows] + kinds["tau_o"] + recording.band_torque[rows]
    np.testing.assert_allclose(joints + resistance, drive, atol=1e-3)
