"""No name without an error that falls, or for what may as well be nothing; and a leg carries no payload."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from exogauge.criteria.judging import Judging
from exogauge.devices.result import Estimate
from exogauge.effects.catalogue import shaped_effects
from exogauge.findings.as_told import as_drawn
from exogauge.findings.basis import OfRobot
from exogauge.findings.result import Evidence, Finding, HeldOut, Place
from exogauge.findings.verdict import Why
from exogauge.identification.model import AddedEffect
from exogauge.identification.sites import AxisSite
from exogauge.robots.description import Joint, Robot, WrenchSensor
from exogauge.robots.ends import carries_nothing, takes_payload
from exogauge.robots.urdf import load_tree
from exogauge.search.finding import objection
from exogauge.search.judge import refused, told
from exogauge.studies.words.reason_sentences import objection_words

JUDGING = Judging()


def finding(effect: str, before: float, after: float, **parameters: tuple[float, float]) -> Finding:
    return Finding(
        1, effect, Place("joint", "j1"), {name: Estimate(*pair, "") for name, pair in parameters.items()},
        HeldOut("tau.j1", "N·m", before, after, 0.1), 0.5, OfRobot(shaped_effects()["stribeck"]), (), (),
        Evidence("", "", *([np.zeros(0)] * 5)),
    )  # fmt: skip


@pytest.mark.parametrize(("before", "after"), [(461.0, 515.0), (0.716, 0.716), (2.0, float("nan"))])
def test_nothing_is_named_whose_held_out_error_does_not_fall(before: float, after: float) -> None:
    named, others = told([finding("kt_gain", before, after, gain=(2.0, 0.01), ratio=(1.2, 0.01))], JUDGING)
    assert named == ()
    (other,) = others
    assert other.objection.why is Why.NOT_FALLING
    assert (other.objection.value, other.objection.beside) == pytest.approx((before, after), nan_ok=True)


def test_what_stands_at_its_noise_is_given_no_name_however_surely_it_falls() -> None:
    """A differentiated encoder's own error at 125 Hz looked like a spring: from 0.97 noise floors to 0.71."""
    assert objection(finding("elasticity", 0.2, 0.15), 0.08, 0.03, JUDGING) is None
    why = objection(finding("elasticity", 0.097, 0.071), 0.08, 0.03, JUDGING)
    assert why is not None
    assert objection_words(why) == "the error is no more than the noise floor without it"


def test_a_load_that_may_as_well_weigh_nothing_is_not_named() -> None:
    light = refused(finding("payload", 2.0, 1.0, mass=(0.0, 0.3), x=(0.1, 0.01)), JUDGING)
    assert light is not None
    assert light.sizes == {"mass": Estimate(0.0, 0.3, "")}
    assert refused(finding("payload", 2.0, 1.0, mass=(0.7, 0.3), x=(0.0, 0.01)), JUDGING) is None


def test_a_gain_is_news_by_its_distance_from_what_is_stated() -> None:
    assert refused(finding("kt_gain", 2.0, 1.0, gain=(5.0, 0.1), stated=(4.9, 0.1), ratio=(1.02, 0.02)), JUDGING)
    assert refused(finding("kt_gain", 2.0, 1.0, gain=(6.0, 0.1), stated=(4.9, 0.1), ratio=(1.2, 0.02)), JUDGING) is None


def test_a_base_that_leans_by_nothing_is_no_name_for_a_pull_at_its_first_joint() -> None:
    """A spring there that the catalogue does not have left 0.99 N·m with the cosine of the angle."""
    pull, none = {"first_sin": (-0.15, 0.036), "first_cos": (0.99, 0.072)}, (2.5e-5, 2.3e-5)
    upright = refused(finding("base_tilt", 2.0, 1.0, about_x=none, about_y=none, **pull), JUDGING)
    assert upright is not None
    assert set(upright.sizes) == {"about_x", "about_y"}
    assert refused(finding("base_tilt", 2.0, 1.0, about_x=none, about_y=(2e-3, 2e-5), **pull), JUDGING) is None


def test_one_part_of_a_wave_may_be_zero_and_not_both() -> None:
    assert refused(finding("torque_ripple", 2.0, 1.0, sine=(0.5, 0.1), cosine=(0.0, 0.1)), JUDGING) is None
    nothing = refused(finding("asym_viscous", 2.0, 1.0, d_a=(0.01, 0.1)), JUDGING)
    assert nothing is not None
    assert objection_words(nothing) == "its size may as well be none (d_a 0.01 ±\u00a00.1)"


def test_a_curve_whose_size_and_shape_trade_against_each_other_is_told_as_drawn() -> None:
    """Its error falls, so it is there; 7.5 ± 6.2 N·m is no number."""
    open_shape = finding("stribeck", 2.0, 1.0, tau_b=(7.5, 6.2), v_s=(0.004, 0.006))
    assert refused(open_shape, JUDGING) is None
    inside = AddedEffect(shaped_effects()["stribeck"], AxisSite(0), (0.1, 2.0))
    told_so = as_drawn(open_shape, inside, JUDGING)
    assert not told_so.parameters
    assert told_so.as_drawn == ("tau_b", "v_s")
    known = finding("stribeck", 2.0, 1.0, tau_b=(1.5, 0.1), v_s=(0.04, 0.001))
    assert as_drawn(known, inside, JUDGING) is known


@pytest.mark.parametrize(("shape", "ended"), [((0.1, 2.5), "delta"), ((0.1, 0.5), "delta"), ((1.0, 2.0), "v_s")])
def test_a_shape_at_the_end_of_its_range_is_no_number(shape: tuple[float, float], ended: str) -> None:
    named = finding("stribeck", 2.0, 1.0, tau_b=(2.4, 0.2), v_s=(0.09, 0.002), delta=(2.5, 0.1))
    told = as_drawn(named, AddedEffect(shaped_effects()["stribeck"], AxisSite(0), shape), JUDGING)
    assert told.as_drawn == (ended,)
    assert set(told.parameters) == {"tau_b", "v_s", "delta"} - {ended}


LEG = """<robot name="walker">
<link name="trunk"><inertial><mass value="20"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
{limbs}</robot>"""
LIMB = """<link name="{0}"><inertial><origin xyz="0 0 -0.2"/><mass value="3"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.01"/></inertial></link>
<joint name="j_{0}" type="revolute"><parent link="trunk"/><child link="{0}"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" velocity="9" effort="99"/></joint>
<link name="end_{0}"/><joint name="at_{0}" type="fixed"><parent link="{0}"/><child link="end_{0}"/></joint>"""


def test_a_shank_above_the_sensor_it_stands_on_takes_no_payload_and_an_arm_does() -> None:
    text = LEG.format(limbs=LIMB.format("shank") + LIMB.format("arm")).encode()
    names = ("j_shank", "j_arm")
    tree = load_tree(text, joints=list(names), base_link="trunk", floating=True)
    joints = tuple(Joint(name, "torque") for name in names)
    foot = WrenchSensor("foot", "end_shank", "contact", 1.0)
    robot = Robot("walker", tree, joints, pin.SE3.Identity(), (foot,), np.eye(2))
    ends = {name: takes_payload(robot, body) for body, name in enumerate(tree.bodies)}
    assert ends == {"trunk": False, "shank": False, "arm": True}
    assert carries_nothing(tree, tree.bodies.index("shank")), "without the sensor it looks like a hand"
    assert takes_payload(replace(robot, sensors=()), tree.bodies.index("shank"))
