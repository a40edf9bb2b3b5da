"""What depends on the motor's torque sees what is left of it beside the wear: the wear bears the rest."""

from dataclasses import replace

import numpy as np
import pytest

from exogauge.effects.catalogue import shaped_effects
from exogauge.identification.model import AddedEffect, AxisSizes, Extension
from exogauge.identification.per_log import PerLog
from exogauge.identification.predict import Parameters
from exogauge.identification.sites import AxisSite
from exogauge.support.balance import balance, prepare_worn

POWER, LOSS, FULL = 3.0, 0.15, 15.0  # of the motor of one torso joint; its loss at FULL N·m


@pytest.fixture(scope="module")
def worn(biped, suit, wander):
    return biped.record(wander(1), bands=suit.bands)


@pytest.fixture
def saturating(biped):
    """(model that knows the loss, currents of a log as that motor needs them)."""
    axis, known = biped.torso[1], biped.known()
    sizes = AxisSizes(*(np.full(len(biped.robot.joints), size) for size in (1.0, FULL, 1.0, 1.0)))
    parent = replace(known, sizes=sizes, order={}, computed=PerLog())
    extension = Extension(parent, (AddedEffect(shaped_effects()["kt_saturation"], AxisSite(axis), (POWER,)),))
    own = Parameters(known.identified.phi, known.identified.xi, np.array([LOSS]))
    makers = Parameters(known.a_priori.phi, known.a_priori.xi, np.array([0.0]))
    equations = replace(known.equations, added=extension.columns)
    model = replace(parent, equations=equations, identified=own, a_priori=makers, extension=extension)
    channel, k_T = f"i.{biped.robot.joints[axis].name}", biped.xi["k_T"][axis]

    def needs_more(log):
        torque = k_T * log.channels[channel]
        lost = LOSS * torque * np.abs(torque / FULL) ** (POWER - 1.0)
        return replace(log, channels={**log.channels, channel: (torque + lost) / k_T})

    return model, needs_more


def test_the_support_is_exact_where_a_motor_saturates_under_what_is_left(biped, worn, saturating, low_passed, inner):
    model, needs_more = saturating
    log, truth = needs_more(worn.log), low_passed(worn.support)
    seeing, blind = (balance(model, each, np.arange(len(biped.robot.joints))) for each in
                     (prepare_worn(model, log), model.prepare(log)))  # fmt: skip
    joint = biped.torso[1]

    def error(found):
        return np.abs(np.where(found.steady, found.torque - truth, 0.0)[inner])[:, joint].max()

    assert error(blind) > 0.3
    assert error(seeing) < 0.1 * error(blind)


def test_without_added_effects_nothing_changes(biped, worn):
    log, model = worn.log, biped.known()
    np.testing.assert_array_equal(prepare_worn(model, log).drive, model.prepare(log).drive)
    assert prepare_worn(model, log).taken_off is None
