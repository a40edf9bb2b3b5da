"""Joints whose current and torque are not logged: the base rows alone identify, and nothing else is claimed."""

from dataclasses import replace

import pytest

from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings
from exogauge.logs.model import Log


@pytest.mark.parametrize("prior", ["per_parameter", "as_printed"])
def test_the_base_rows_alone_give_the_mass_and_claim_no_joint_parameter(make_truth, make_log, prior):
    truth = make_truth(floating=True, seed=3)
    logged = make_log(truth, 1, noise=1.0)
    log = Log("bare", logged.time, {k: v for k, v in logged.channels.items() if not k.startswith("i.")})
    joints = tuple(replace(joint, actuation="none", prior={}) for joint in truth.robot.joints)
    robot = replace(truth.robot, joints=joints)

    found = identify(robot, [Recording(log, False)], Settings(cutoff_hz=8.0, prior=prior))

    mass = truth.phi[:, 0].sum()
    assert found.phi[:, 0].sum() == pytest.approx(mass, rel=0.002)
    assert truth.robot.tree.mass != pytest.approx(mass, rel=0.01)
    assert {fit.channel for fit in found.validation} == {f"base.{kind}{axis}" for kind in "fm" for axis in "xyz"}
    named = {f"[{joint.name}]" for joint in joints}
    of_joints = [p for p in found.parameters if any(p.name.endswith(end) for end in named) and not p.combination]
    assert len(of_joints) == 18
    assert not any(p.identifiable for p in of_joints)
    assert all(p.value == p.prior for p in of_joints)
