"""A link whose centre of mass or mass is stated wrongly, on an arm that pinocchio moves: what is told of all links."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from exogauge.detect.nominal.contradicted import contradicted
from exogauge.detect.nominal.let_go import let_go
from exogauge.identification.identify import identify
from exogauge.identification.settings import Settings
from exogauge.remarks import About
from exogauge.studies.words.remark_words import sentence

SETTINGS = Settings(cutoff_hz=8.0)
PARAMETERS = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")


@pytest.fixture(scope="module")
def recordings(study):
    return study(seconds=20.0)


@pytest.fixture(scope="module")
def told(weighed, recordings):
    """(what is stated of the link in the middle) -> identified, before and after numbers are let go."""

    def of(stated):
        robot = replace(weighed(), inertial_std={"": 0.01})
        phi = robot.tree.phi.copy()
        phi[1] = stated(pin.Inertia.FromDynamicParameters(phi[1])).toDynamicParameters()
        found = identify(replace(robot, tree=replace(robot.tree, phi=phi)), recordings, SETTINGS)
        return found, let_go(found, recordings, SETTINGS)

    return of


def off(found, robot):
    """Of every parameter of a link, how many standard deviations it is off."""
    true = {f"{name}[{link}]": value for link, own in zip(robot.tree.bodies, robot.tree.phi, strict=True)
            for name, value in zip(PARAMETERS, own, strict=True)}  # fmt: skip
    own = [each for each in found.parameters if each.name in true]
    assert len(own) == len(true)
    return np.array([(each.value - true[each.name]) / each.std for each in own])


@pytest.mark.parametrize("by", [(0.04, 0.0, 0.0), (0.0, -0.028, 0.028)])
def test_a_centre_stated_four_centimetres_off_is_believed_no_more(told, weighed, recordings, by):
    before, after = told(lambda own: pin.Inertia(own.mass, own.lever + np.array(by), own.inertia))
    robot = weighed()
    assert np.abs(off(before, robot)).max() > 4.0  # neighbours paid for it, and were as sure as ever
    assert np.abs(off(after, robot)).max() < 1.96
    (remark,) = [each for each in after.remarks if each.about == About.CENTRE_LET_GO]
    assert remark.names == (robot.tree.bodies[1],)
    assert remark.each[0][0] > 5.0
    fitted = [each.log for each in recordings if not each.held_out]
    named = contradicted(before.model, fitted).one_by_one
    assert {each.best.stated.index for each in named} <= {1}  # no other link's
    assert f"centre of mass of {remark.names[0]}" in sentence(remark)


def test_a_mass_stated_a_quarter_off_is_believed_no_more(told, weighed):
    before, after = told(lambda own: pin.Inertia(1.25 * own.mass, own.lever, 1.25 * own.inertia))
    robot = weighed()
    assert np.abs(off(before, robot)).max() > 4.0
    assert np.abs(off(after, robot)).max() < 1.96
    (remark,) = [each for each in after.remarks if each.about == About.MASS_LET_GO]
    assert remark.names == (robot.tree.bodies[1],)


def test_what_is_within_its_doubt_is_not_let_go(told):
    before, after = told(lambda own: pin.Inertia(1.01 * own.mass, own.lever + np.array([0.001, 0.0, 0.0]), own.inertia))
    assert after is before


def test_a_motor_that_gives_a_fifth_more_than_stated_is_believed_no_more(weighed, recordings):
    """Two motors are logged by their torque, which says how large all of it is; the third one by its current."""
    robot, k_T = weighed(("torque", "torque", "current")), 3.0
    logs = [replace(each, log=_by_current(each.log, 1.2 * k_T)) for each in recordings]
    found = identify(robot, logs, SETTINGS)
    after = let_go(found, logs, SETTINGS)
    (remark,) = [each for each in after.remarks if each.about == About.GAIN_LET_GO]
    assert remark.names == ("j3",)
    (gain,) = [each for each in after.parameters if each.name == "k_T[j3]"]
    assert abs(gain.value - 1.2 * k_T) < 1.96 * gain.std


def _by_current(log, k_T):
    channels = dict(log.channels)
    channels["i.j3"] = channels.pop("tau.j3") / k_T
    return replace(log, channels=channels)
