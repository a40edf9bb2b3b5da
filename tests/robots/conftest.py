"""Robots for the tests: makers' URDFs, and a small one with odd axes and a sliding joint."""

from __future__ import annotations

import sysconfig
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from exogauge.robots.motion import Motion
from exogauge.robots.tree import RigidTree
from exogauge.robots.urdf import load_tree

MAKERS = {
    "talos": ("talos_data/robots/talos_reduced.urdf", "base_link", True),
    "ur10": ("ur_description/urdf/ur10_robot.urdf", "base_link", False),
    "ur5": ("ur_description/urdf/ur5_robot.urdf", "base_link", False),
    "panda": ("panda_description/urdf/panda.urdf", "panda_link0", False),
}

BODY = '<inertial><origin xyz="{} {} {}" rpy="0.3 0.2 -0.4"/><mass value="{}"/><inertia ixx="0.3" ixy="0.01" ixz="-0.02" iyy="0.25" iyz="0.03" izz="0.2"/></inertial>'  # noqa: E501
ODD = f"""<robot name="odd">
<link name="trunk">{BODY.format(0.1, 0.2, 0.3, 5)}</link><link name="rail">{BODY.format(0.3, -0.2, 0.1, 2)}</link>
<link name="arm">{BODY.format(0, 0.1, 0.2, 1.5)}</link><link name="tip">{BODY.format(0.2, 0, 0.1, 0.5)}</link>
<link name="leg">{BODY.format(0.1, 0.1, -0.2, 3)}</link><link name="finger">{BODY.format(0.1, 0, 0, 0.2)}</link>
<joint name="slide" type="prismatic"><parent link="trunk"/><child link="rail"/><origin xyz="0.1 0.2 0.3"
 rpy="0.1 -0.7 0.4"/><axis xyz="0.6 0 0.8"/><limit lower="-1" upper="2" effort="30" velocity="4"/></joint>
<joint name="spin" type="continuous"><parent link="rail"/><child link="arm"/><origin xyz="0.3 -0.1 0.2"
 rpy="1 0.2 0.3"/><axis xyz="0.48 -0.6 0.64"/></joint>
<joint name="weld" type="fixed"><parent link="arm"/><child link="tip"/><origin xyz="0 0 0.4" rpy="0.5 0 0"/></joint>
<joint name="hip" type="revolute"><parent link="trunk"/><child link="leg"/><origin xyz="-0.2 0 -0.3" rpy="0 0.3 0"/>
 <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="0" velocity="0"/></joint>
<joint name="grip" type="revolute"><parent link="tip"/><child link="finger"/><origin xyz="0 0.1 0.1" rpy="0 0 1"/>
 <axis xyz="0 0 1"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint></robot>"""


@pytest.fixture(scope="session")
def urdf_of():
    """Bytes of a robot's URDF by name."""
    folder = Path(sysconfig.get_path("purelib")) / "cmeel.prefix/share/example-robot-data/robots"

    def read(name: str) -> bytes:
        return ODD.encode() if name.startswith("odd") else (folder / MAKERS[name][0]).read_bytes()

    return read


@pytest.fixture(scope="session")
def robot(urdf_of):
    """name -> (tree, pinocchio model of the same bodies, rows of q in that model for each of the tree's joints)."""

    def load(name: str) -> tuple[RigidTree, pin.Model, list[int]]:
        floating = name in ("talos", "odd")
        base = "trunk" if name.startswith("odd") else MAKERS[name][1]
        xml = urdf_of(name).decode().replace('"continuous"', '"revolute"')
        xml = xml.replace('0.48 -0.6 0.64"/></joint>', '0.48 -0.6 0.64"/><limit effort="1" velocity="1"/></joint>')
        model = pin.buildModelFromXML(xml, pin.JointModelFreeFlyer()) if floating else pin.buildModelFromXML(xml)
        joints = [joint for joint in model.names if joint not in ("universe", "root_joint", "panda_finger_joint2")]
        if "panda_finger_joint2" in model.names:  # it mimics finger 1: held at zero
            held = [model.getJointId("panda_finger_joint2")]
            model = pin.buildReducedModel(model, held, pin.neutral(model))
        model.gravity = pin.Motion.Zero()
        model.armature[:] = 0.0
        rng = np.random.default_rng(3)
        joints = [joints[i] for i in rng.permutation(len(joints))]
        tree = load_tree(urdf_of(name), joints=joints, base_link=base, floating=floating)
        return tree, model, [model.joints[model.getJointId(joint)].idx_v for joint in joints]

    return load


@pytest.fixture(scope="session")
def random_motion():
    """tree, samples -> a motion with every velocity and acceleration of order one."""

    def draw(tree: RigidTree, samples: int, seed: int = 0) -> Motion:
        rng = np.random.default_rng(seed)
        q, dq, ddq = (rng.normal(size=(samples, len(tree.joints))) for _ in range(3))
        moving = 1.0 if tree.floating else 0.0
        acc = rng.normal(size=(samples, 3)) * 5 * moving + np.array([0.0, 0.0, 9.81])
        gyro, gyro_dot = (rng.normal(size=(samples, 3)) * moving for _ in range(2))
        return Motion(q, dq, ddq, acc, gyro, gyro_dot)

    return draw
