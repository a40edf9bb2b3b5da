"""What the feet weigh, against the maker's masses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings
from exogauge.remarks import About
from exogauge.robots.description import Declared

GAIN = 0.01


@pytest.fixture(scope="module")
def weighed(biped, wander):
    """By how much the feet read too much -> what is found."""
    robot = replace(biped.robot, declared=Declared(ft_gain_common=GAIN))
    log = biped.record(wander(1), "log", noise=1.0).log

    def weighed(share):
        feet = {name: (1.0 + share) * each for name, each in log.channels.items() if name.startswith("ft.")}
        spoilt = replace(log, channels={**log.channels, **feet})
        return identify(robot, [Recording(spoilt, held_out=False)], Settings(cutoff_hz=20.0, consistency="free"))

    return weighed


@pytest.fixture(scope="module")
def found(weighed):
    return weighed(0.0)


def test_the_feet_weigh_the_robot_and_their_gain_is_in_the_doubt(biped, found):
    truth = biped.phi.ravel()[::10].sum()
    assert found.total_mass.found == pytest.approx(truth, rel=0.01)
    assert found.total_mass.std >= 0.9 * GAIN * truth
    assert found.total_mass.agrees
    assert About.FEET_AGAINST_MASS not in [each.about for each in found.remarks]


def test_feet_that_read_far_too_much_disagree_with_the_makers_masses_and_are_named(found, weighed):
    mass = found.total_mass
    far = 1.5 * mass.limit * np.hypot(mass.std, mass.stated_std) / mass.found
    spoilt = weighed(far)
    assert not spoilt.total_mass.agrees
    (remark,) = [each for each in spoilt.remarks if each.about == About.FEET_AGAINST_MASS]
    assert remark.numbers[0] == pytest.approx((1.0 + far) * mass.found, rel=0.02)
