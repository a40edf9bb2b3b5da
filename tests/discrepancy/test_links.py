"""A load fixed to a link is absorbed by its free inertia; what gives it away is the distance from what was believed."""

import numpy as np
import pinocchio as pin

from exogauge.discrepancy.links import odd_links

CENTRE = np.array([0.03, -0.02, 0.05])


def loaded(conftest_urdf, mass, body):
    """Torque that a point mass on a body asks of the motors, by pinocchio with it minus without it."""
    with_it, without = (pin.buildModelFromXML(conftest_urdf) for _ in range(2))
    with_it.inertias[body] = with_it.inertias[body] + pin.Inertia(mass, CENTRE, np.zeros((3, 3)))

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


def test_inertias_within_what_the_maker_doubts_are_no_finding(study, identified):
    recordings = study()
    assert odd_links(identified(recordings).model, [each.log for each in recordings if not each.held_out]) == []


def test_a_link_that_never_turns_is_never_claimed(study, identified):
    recordings = study(still=0)
    model = identified(recordings).model
    found = odd_links(model, [each.log for each in recordings if not each.held_out])
    assert "lj1" not in {model.robot.tree.bodies[each.best.body] for each in found}
