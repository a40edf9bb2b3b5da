"""The tree says what the URDF says, wherever it is rooted and cut."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from exogauge.errors import BadRobot
from exogauge.robots.urdf import load_tree

ODD_JOINTS = ("grip", "slide", "hip", "spin")


def test_talos_has_pinocchios_bodies_and_mass(robot):
    tree, model, _ = robot("talos")
    assert len(tree.bodies) == 33
    assert tree.mass == pytest.approx(pin.computeTotalMass(model), rel=1e-12)
    assert all(tree.parent[i] < i for i in range(33))


def test_phi_of_a_body_includes_the_links_welded_to_it(robot):
    tree, model, _ = robot("odd")
    expected = model.inertias[model.getJointId("spin")].toDynamicParameters()
    assert tree.phi[tree.bodies.index("arm")] == pytest.approx(expected, abs=1e-12)


def test_rooting_elsewhere_turns_the_joints_on_the_way_round(urdf_of):
    tree = load_tree(urdf_of("odd"), joints=ODD_JOINTS, base_link="tip", floating=True)
    assert tree.bodies[0] == "tip"
    assert set(tree.bodies) == {"tip", "finger", "rail", "trunk", "leg"}
    rail = tree.bodies.index("rail")
    assert tree.joints[tree.dof[rail]] == "spin"
    assert tree.axis[rail] == pytest.approx([-0.48, 0.6, -0.64])
    assert tree.mass == pytest.approx(12.2)
    assert tree.frames["arm"][0] == 0
    assert tree.frames["trunk"][0] == tree.bodies.index("trunk")


def test_limits_are_infinite_where_nothing_is_known(urdf_of):
    tree = load_tree(urdf_of("odd"), joints=ODD_JOINTS, base_link="trunk", floating=True)
    assert tree.lower.tolist() == [0.0, -1.0, -1.0, -np.inf]
    assert tree.effort_limit.tolist() == [1.0, 30.0, np.inf, np.inf]


def test_joints_off_the_list_are_held_and_named(urdf_of):
    tree = load_tree(urdf_of("odd"), joints=["slide"], base_link="trunk", floating=True)
    assert tree.locked == ("spin", "hip", "grip")
    assert tree.bodies == ("trunk", "rail")
    assert tree.mass == pytest.approx(12.2)


def test_what_hangs_beyond_a_contact_sensor_is_cut(urdf_of):
    tree = load_tree(urdf_of("odd"), joints=["slide", "spin"], base_link="trunk", floating=True, cut_frames=["arm"])
    assert tree.dropped == ("finger", "tip")
    assert tree.mass == pytest.approx(11.5)
    at_joint = load_tree(
        urdf_of("odd"), joints=["slide", "spin"], base_link="trunk", floating=True, cut_frames=["weld"]
    )
    assert at_joint.dropped == ("finger", "tip")
    assert "tip" in tree.frames


def test_a_leaf_sensor_cuts_nothing(urdf_of):
    tree = load_tree(urdf_of("talos"), joints=[], base_link="base_link", floating=True, cut_frames=["left_sole_link"])
    assert tree.dropped == ()


def test_a_joint_beyond_a_contact_sensor_is_refused(urdf_of):
    with pytest.raises(BadRobot, match="'grip' lies beyond"):
        load_tree(urdf_of("odd"), joints=ODD_JOINTS, base_link="trunk", floating=True, cut_frames=["arm"])
    with pytest.raises(BadRobot, match="lies beyond"):  # seen from the finger, the rest lies beyond
        load_tree(urdf_of("odd"), joints=ODD_JOINTS, base_link="finger", floating=True, cut_frames=["arm"])


def test_a_misspelt_name_gets_the_nearest_one(urdf_of):
    with pytest.raises(BadRobot) as caught:
        load_tree(urdf_of("odd"), joints=["slyde"], base_link="trnk", floating=True, cut_frames=["arn"])
    assert [fault.advice for fault in caught.value.faults] == [
        "Did you mean 'slide'?", "Did you mean 'trunk'?", "Did you mean 'arm'?",
    ]  # fmt: skip


def test_a_fixed_base_is_no_body_and_must_not_move(urdf_of):
    tree = load_tree(urdf_of("odd"), joints=["slide"], base_link="leg", floating=False)  # the hip is held
    assert tree.bodies == ("rail",)
    assert tree.parent.tolist() == [-1]
    assert tree.frames["leg"][0] == -1
    assert tree.frames["leg"][1].isIdentity()
    with pytest.raises(BadRobot, match="moves base_link"):
        load_tree(urdf_of("odd"), joints=ODD_JOINTS, base_link="tip", floating=False)


def test_a_mimic_joint_is_held_but_not_listed(urdf_of):
    joints = [f"panda_joint{i}" for i in range(1, 8)] + ["panda_finger_joint1"]
    tree = load_tree(urdf_of("panda"), joints=joints, base_link="panda_link0", floating=False)
    assert tree.locked == ("panda_finger_joint2",)
    with pytest.raises(BadRobot, match="mimics"):
        load_tree(urdf_of("panda"), joints=[*joints, "panda_finger_joint2"], base_link="panda_link0", floating=False)


def test_a_fixed_joint_cannot_be_listed(urdf_of):
    with pytest.raises(BadRobot, match="is fixed"):
        load_tree(urdf_of("odd"), joints=["weld"], base_link="trunk", floating=True)
