"""By how much loads change with a joint's zero: where motors share joints, and feet bear the robot, too."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from tests.identification.conftest import chain_urdf

from exogauge.criteria.examining import Comparing
from exogauge.plausibility.expectation import Expected
from exogauge.plausibility.remedies import shifted
from exogauge.plausibility.snapshot import Snapshot
from exogauge.plausibility.zeros import _load_slopes
from exogauge.robots.description import Joint, Robot, WrenchSensor
from exogauge.robots.urdf import load_tree

JOINTS = ("j1", "j2", "j3", "j4")


def some_moments(count: int) -> Snapshot:
    rng, J = np.random.default_rng(1), len(JOINTS)

    def drawn(*shape: int) -> np.ndarray:
        return rng.normal(size=(count, *shape))

    return Snapshot(
        log="a", q=drawn(J), dq=drawn(J), ddq=drawn(J), way=np.ones((count, J)),
        ahead=np.ones((count, J)), held=np.zeros((count, J), dtype=bool),
        acc=drawn(3), gyro=drawn(3), gyro_dot=drawn(3), effort=drawn(J), late=drawn(J)[None], lags=np.zeros(1),
        late_imu=np.stack([drawn(3)] * 3)[None], wrenches=50.0 * drawn(1, 6), late_wrenches=drawn(1, 6)[None],
        alive=np.ones(J, dtype=bool), zeros=np.zeros(J),
        still=np.zeros(J, dtype=bool), rate_hz=100.0, recording="a", criteria=Comparing(),
    )  # fmt: skip


@pytest.mark.parametrize("coupled", [False, True])
def test_slopes_are_those_of_what_is_expected_of_each_axis(coupled: bool) -> None:
    tree = load_tree(chain_urdf(4), joints=list(JOINTS), base_link="base", floating=True, cut_frames=["link4"])
    C = np.eye(4) + (0.5 * np.eye(4, k=-1) if coupled else 0.0)
    foot = WrenchSensor("foot", "link4", "contact", 1.0)
    joints = tuple(Joint(name, "torque") for name in JOINTS)
    robot = Robot("chain", tree, joints, pin.SE3.Identity(), (foot,), C, inertial_std={"": 0.2})
    seen, h = some_moments(20), 1e-3
    found = _load_slopes(robot, Expected(robot, seen))
    for joint in range(len(JOINTS)):
        more, less = (Expected(robot, shifted(joint, step)(seen)).load for step in (h, -h))
        wanted = (more - less) / (2.0 * h)
        np.testing.assert_allclose(found[:, :, joint], wanted, atol=1e-3 * np.abs(wanted).max())
