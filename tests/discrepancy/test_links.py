"""A load fixed to a link is absorbed by its free inertia; what gives it away is the distance from what was believed."""

import numpy as np
import pinocchio as pin
import pytest

from exogauge.detect.nominal.contradicted import contradicted
from exogauge.detect.nominal.detector import name_contradiction
from exogauge.identification.identify import identify
from exogauge.identification.settings import Settings
from exogauge.robots.ends import carries_nothing
from exogauge.robots.urdf import load_tree

pytestmark = pytest.mark.slow

SETTINGS = Settings(cutoff_hz=8.0)
CENTRE = np.array([0.03, -0.02, 0.05])


def loaded(conftest_urdf, mass, body, centre=CENTRE):
    """Torque that a point mass on a body asks of the motors, by pinocchio with it minus without it."""
    with_it, without = (pin.buildModelFromXML(conftest_urdf) for _ in range(2))
    with_it.inertias[body] = with_it.inertias[body] + pin.Inertia(mass, centre, np.zeros((3, 3)))

    def torque(motion):
        a = np.gradient(motion.v, motion.t, axis=0)
        rows = list(zip(motion.q, motion.v, a, strict=True))
        one, other = (np.array([pin.rnea(m, m.createData(), *row) for row in rows]) for m in (with_it, without))
        return one - other

    return torque


def test_a_load_at_the_last_link_is_named_with_its_mass_and_place(study, search, arm_urdf):
    found = search(study(loaded(arm_urdf, 4.0, 3))).discrepancy
    assert found.verdict == "effects"
    (finding,) = [each for each in found.findings if each.place.kind == "link"]
    assert (finding.effect, finding.place.name) == ("payload", "lj3")
    mass = finding.parameters["mass"]
    # the true arm is heavier than its maker says, by 0.3 kg at this link, before anything is fixed to it
    assert abs(mass.value - 4.3) < 3.0 * mass.std + 0.3
    assert finding.parameters["mass"].unit == "kg"
    assert finding.held_out.rmse_after < finding.held_out.rmse_before


def link_findings(robot, recordings):
    found = identify(robot, recordings, SETTINGS)
    odd = contradicted(found.model, [each.log for each in recordings if not each.held_out])
    return [name_contradiction(rank, found, recordings, SETTINGS, each) for rank, each in enumerate(odd.one_by_one, 1)]


def test_a_load_at_the_last_link_could_be_a_heavier_link(study, weighed, arm_urdf):
    (finding,) = link_findings(weighed(), study(loaded(arm_urdf, 1.0, 3)))
    assert (finding.effect, finding.place.name) == ("payload", "lj3")
    assert ("link_mass", "lj3") in {(each.effect, each.place.name) for each in finding.also_possible}
    assert len(finding.also_possible) <= 2


def test_with_the_makers_value_alone_put_back_the_error_is_what_the_load_asks_for(study, weighed, arm_urdf):
    hidden = loaded(arm_urdf, 1.0, 3)
    recordings = study(hidden)
    (finding,) = link_findings(weighed(), recordings)
    held = finding.held_out
    assert held.rmse_after < 0.1 * held.rmse_before
    asked = pin.buildModelFromXML(arm_urdf)
    log = next(each.log for each in recordings if each.held_out)
    joints = ["j1", "j2", "j3"]
    q = np.column_stack([log.channels[f"q.{name}"] for name in joints])
    lever = []
    for row in q:  # gravity alone: the motion is slow
        data = asked.createData()
        with_it = pin.Model(asked)
        with_it.inertias[3] = with_it.inertias[3] + pin.Inertia(1.0, CENTRE, np.zeros((3, 3)))
        lever.append(pin.computeGeneralizedGravity(with_it, with_it.createData(), row)
                     - pin.computeGeneralizedGravity(asked, data, row))  # fmt: skip
    static = np.sqrt(np.mean(np.array(lever) ** 2, axis=0))[joints.index(held.channel.removeprefix("tau."))]
    assert 0.5 * static < held.rmse_before < 2.0 * static


def test_a_link_that_carries_others_has_a_wrong_mass_and_no_payload(study, weighed, arm_urdf):
    (finding,) = link_findings(weighed(), study(loaded(arm_urdf, 2.0, 2, np.array([0.1, -0.05, 0.15]))))
    assert (finding.effect, finding.place.name) == ("link_mass", "lj2")
    assert finding.parameters["mass"].value > 0.0


def test_a_last_link_that_is_too_light_has_a_wrong_mass(study, weighed, arm_urdf):
    lighter = loaded(arm_urdf, 1.0, 3)
    (finding,) = link_findings(weighed(), study(lambda motion: -lighter(motion)))
    assert (finding.effect, finding.place.name) == ("link_mass", "lj3")
    mass = finding.parameters["mass"]
    assert abs(mass.value + 1.0) < 3.0 * mass.std


def test_behind_a_wrist_sensor_the_tool_carries_the_payload_and_the_flange_does_not(arm_urdf):
    tool = (
        '<link name="tool"><inertial><mass value="0.2"/><inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" '
        'izz="1e-4"/></inertial></link><joint name="wrist" type="fixed"><parent link="lj3"/><child link="tool"/>'
        "</joint></robot>"
    )
    text, joints = arm_urdf.replace("</robot>", tool).encode(), ["j1", "j2", "j3"]
    apart = load_tree(text, joints=joints, base_link="base", floating=False, carrying=("wrist",))
    assert {name: carries_nothing(apart, k) for k, name in enumerate(apart.bodies)} == {
        **dict.fromkeys(("lj1", "lj2", "lj3"), False),
        "tool": True,
    }
    together = load_tree(text, joints=joints, base_link="base", floating=False)
    assert [carries_nothing(together, k) for k in range(3)] == [False, False, True]


def test_inertias_within_what_the_maker_doubts_are_no_finding(study, identified):
    recordings = study()
    assert (
        contradicted(identified(recordings).model, [each.log for each in recordings if not each.held_out]).one_by_one
        == []
    )


def test_a_link_that_never_turns_is_never_claimed(study, identified):
    recordings = study(still=0)
    model = identified(recordings).model
    found = contradicted(model, [each.log for each in recordings if not each.held_out]).one_by_one
    assert "lj1" not in {model.robot.tree.bodies[each.best.stated.index] for each in found if each.best.of_link}
