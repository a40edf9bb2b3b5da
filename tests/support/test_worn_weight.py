"""What the feet bear in logs with a device beyond those without is told: no band and no motor is in that balance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.support.test_zeros import STARTS, asked

from exogauge.remarks import About
from exogauge.robots.description import Declared
from exogauge.support.worn_weight import notes_on_weight


@pytest.mark.slow
@pytest.mark.parametrize("weight_n", [0.0, 40.0])
def test_a_load_that_logs_with_the_device_alone_carry_is_told_with_its_mass(biped, suit, recorded, weight_n):
    declared = Declared(ft_zero_force=2.0, ft_zero_moment=0.2)
    model = replace(biped, robot=replace(biped.robot, declared=declared)).known()
    clean = recorded(biped, suit, STARTS)
    plain, worn = asked(model.robot, clean, suit, np.zeros(12), weight_n)
    notes = notes_on_weight(model, plain, worn)
    assert [each.about for each in notes] == [About.WORN_WEIGHT] * (weight_n > 0.0)
    for note in notes:
        more, std = note.numbers
        assert more == pytest.approx(weight_n / 9.81, abs=2.0 * std)
        assert std < 0.5
        assert note.beside == (suit.name,)
