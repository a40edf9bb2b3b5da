"""Wrenches carried along their own bodies do what they do in the whole tree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exogauge.identification.contacts import ContactPaths
from exogauge.robots.description import Joint, Robot, WrenchSensor
from exogauge.robots.regressor import contact_effect
from exogauge.robots.urdf import load_tree

BODY = '<inertial><origin xyz="0.1 0 0"/><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'  # noqa: E501
URDF = f"""<robot name="odd"><link name="trunk">{BODY}</link><link name="rail">{BODY}</link>
<link name="arm">{BODY}</link><link name="leg">{BODY}</link><link name="sole">{BODY}</link>
<joint name="slide" type="prismatic"><parent link="trunk"/><child link="rail"/><origin xyz="0.1 0.2 0.3"
 rpy="0.1 -0.7 0.4"/><axis xyz="0.6 0 0.8"/><limit lower="-1" upper="2" effort="30" velocity="4"/></joint>
<joint name="spin" type="revolute"><parent link="rail"/><child link="arm"/><origin xyz="0.3 -0.1 0.2"
 rpy="1 0.2 0.3"/><axis xyz="0.48 -0.6 0.64"/><limit lower="-1" upper="2" effort="30" velocity="4"/></joint>
<joint name="hip" type="revolute"><parent link="trunk"/><child link="leg"/><origin xyz="-0.2 0 -0.3" rpy="0 0.3 0"/>
 <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="weld" type="fixed"><parent link="leg"/><child link="sole"/>
 <origin xyz="0.1 0 -0.4" rpy="0.2 0 0.5"/></joint>
</robot>"""


@pytest.mark.parametrize(("base", "floating"), [("trunk", True), ("trunk", False), ("arm", True)])
def test_a_wrench_does_the_same_on_its_path_as_in_the_whole_tree(base, floating):
    names = ("spin", "hip", "slide")
    tree = load_tree(URDF.encode(), joints=names, base_link=base, floating=floating)
    frames = ("sole", "rail", "arm", "trunk")
    sensors = tuple(WrenchSensor(frame, frame, "contact", 1.0) for frame in frames)
    C = np.array([[1.0, 0.0, 0.3], [0.0, 1.0, 0.0], [0.2, 0.0, 1.0]])
    robot = Robot("odd", tree, tuple(Joint(n, "torque") for n in names), None, sensors, C)
    rng = np.random.default_rng(0)
    q, wrenches = rng.normal(size=(9, 3)), rng.normal(size=(9, len(frames), 6))
    expected = sum(contact_effect(tree, q, frame, wrenches[:, k]) for k, frame in enumerate(frames))
    expected[:, -3:] = expected[:, -3:] @ np.linalg.inv(C)
    assert np.abs(ContactPaths(robot).effect(q, wrenches) - expected).max() < 1e-12
    for sensor in range(len(frames)):
        parts = np.zeros_like(wrenches)
        parts[:, sensor] = wrenches[:, sensor]
        by_component = ContactPaths(robot).of_components(q, sensor)
        summed = np.einsum("tcr,tc->tr", by_component, wrenches[:, sensor])
        assert np.abs(summed - ContactPaths(robot).effect(q, parts)).max() < 1e-12
    without = replace(robot, sensors=())
    assert not ContactPaths(without).effect(q, wrenches[:, :0]).any()
