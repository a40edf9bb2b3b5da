"""What a recording's motion asks of base and joints, by another dynamics library than the one that made it."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from exogauge.synthetic.inertia import PHI_NAMES
from exogauge.synthetic.robot_facts import FEET, JOINT_NAMES
from exogauge.synthetic.simulation import Recording
from exogauge.synthetic.true_robot import TrueRobot, truth_record
from exogauge.synthetic.urdf import robot_urdf

EVERY = 50  # samples


def balance(recording: Recording, robot: TrueRobot) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows looked at, base (N, 6) Y φ − Σ Kᵀ F, joints (N, J) Y φ − F_j in the order of `JOINT_NAMES`."""
    truth = truth_record(robot, [])["parameters"]
    model = pin.buildModelFromXML(robot_urdf(), pin.JointModelFreeFlyer())
    assert tuple(sorted(model.names[2:])) == tuple(sorted(JOINT_NAMES))
    order = [JOINT_NAMES.index(name) for name in model.names[2:]]
    phi = np.concatenate([[truth[f"{name}[{body}]"] for name in PHI_NAMES] for body in _moved_links(model)])
    model.gravity = pin.Motion.Zero()
    data, imu = model.createData(), model.frames[model.getFrameId("imu_link")].placement
    R, r = imu.rotation, imu.translation
    rows = np.arange(0, len(recording.time), EVERY)
    out = np.zeros((len(rows), 6 + len(order)))
    for k, t in enumerate(rows):
        q, dq, ddq = recording.q[t, order], recording.dq[t, order], recording.ddq[t, order]
        w, alpha = R @ recording.gyro[t], recording.gyro_dot[t]
        f = R @ recording.acc[t] - np.cross(alpha, r) - np.cross(w, np.cross(w, r))
        configuration = np.r_[np.zeros(6), 1.0, q]
        Y = pin.computeJointTorqueRegressor(model, data, configuration, np.r_[0, 0, 0, w, dq], np.r_[f, alpha, ddq])
        F = sum(
            pin.computeFrameJacobian(model, data, configuration, model.getFrameId(f"{foot}_sensor"), pin.LOCAL).T
            @ wrench
            for foot, wrench in zip(FEET, recording.wrench[t], strict=True)
        )
        asked = Y @ phi - F
        out[k, :6], out[k, 6 + np.array(order)] = asked[:6], asked[6:]
    return rows, out[:, :6], out[:, 6:]


def _moved_links(model: pin.Model) -> list[str]:
    """Name of the link that each joint moves: the frame that lies on it."""
    names = []
    for joint in range(1, model.njoints):
        on_joint = (f for f in model.frames if f.type == pin.BODY and f.parentJoint == joint)
        names.append(next(f.name for f in on_joint if f.placement.isIdentity(1e-12)))
    return names
