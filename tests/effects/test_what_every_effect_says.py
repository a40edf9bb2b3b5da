"""What every effect that a model may lack says of itself, wherever it sits: coefficients, shapes, words."""

import itertools

import numpy as np
import pytest

from exogauge.effects.catalogue import (
    band_effects,
    base_effects,
    encoder_effects,
    link_effects,
    pair_effects,
    sensor_effects,
    shaped_effects,
    whole_sensor_effects,
)
from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import OWN_SIZES
from exogauge.studies.words.names import effect_words, parameter_words

PLACES = {
    "joint": shaped_effects(),
    "pair": pair_effects(),
    "encoder": encoder_effects(),
    "sensor": sensor_effects(),
    "whole_sensor": whole_sensor_effects(),
    "base": base_effects(),
    "link": link_effects(),
    "band": band_effects(),
}
UNITS = {
    "joint": {"N·m", "N·m/s", "N·m/rad", "N·m/rad³", "N·m·s/rad", "rad", "s", "s²", "1"},
    "pair": {"N·m", "N·m·s/rad", "kg·m²"},
    "encoder": {"rad"},
    "sensor": {"1", "reading", "reading/s", "reading/reading"},  # of the component that it sits on
    "whole_sensor": {"rad"},
    "base": {"rad", "s", "N·m"},
    "link": {"kg", "kg·m"},
    "band": {"N/m", "N/m²", "N·s/m", "m", "1"},
}
SHAPE_UNITS = {
    "joint": {"1", "s", "1/s", "Hz", "rad", "1/rev", "1/K", *OWN_SIZES},
    "pair": {"1", "s"},
    "encoder": set(),
    "sensor": {"1", "s"},
    "whole_sensor": set(),
    "base": set(),
    "link": {"1"},
    "band": {"s", "1", "m", "share", "travel"},
}
ERRS_BOTH_WAYS = ("encoder", "sensor", "whole_sensor", "base")
FINEST = {"torque_ripple": 40, "band_slip": 120, "backlash": 13}  # values of one shape: orders, moments, landings
FEW = 8

every_effect = pytest.mark.parametrize(
    ("place", "effect"),
    [
        pytest.param(place, each, id=f"{place}-{name}")
        for place, found in PLACES.items()
        for name, each in found.items()
    ],
)


@every_effect
def test_every_coefficient_has_a_name_a_unit_and_a_range_that_holds_zero(place, effect):
    assert len(effect.coefficients) > 0
    for quantity in effect.coefficients:
        assert isinstance(quantity, Quantity)
        assert quantity.name.isidentifier()
        assert quantity.unit in UNITS[place]
        assert quantity.low <= 0.0 < quantity.high
        assert quantity.low < 0.0 or place not in ERRS_BOTH_WAYS


@every_effect
def test_every_shape_has_a_grid_in_order_within_its_bounds(place, effect):
    for one in effect.shapes:
        assert one.name.isidentifier()
        assert one.unit in SHAPE_UNITS[place]
        if place == "band" and not one.grid:
            assert effect.law, "stated, not looked for"
            continue
        assert one.low <= one.grid[0]
        assert one.grid[-1] <= one.high
        assert all(before < after for before, after in itertools.pairwise(one.grid))
        if one.choice:
            assert np.all(np.mod(one.grid, 1.0) == 0.0)
        else:
            assert len(one.grid) <= FINEST.get(effect.name, FEW)


@every_effect
def test_a_user_is_told_in_sentences(place, effect):
    for text in (effect.sentence, effect.needs):
        assert text[0].isupper()
        assert text.endswith(".")
        assert text.count(".") == 1
        assert len(text.split()) >= 4


@every_effect
def test_every_number_and_the_effect_itself_have_words_of_their_own(place, effect):
    assert effect_words(effect.name) == effect.words
    for each in (*effect.coefficients, *effect.shapes):
        assert len(each.words.split()) >= 1
        assert "_" not in each.words
        assert parameter_words(effect.name, each.name)


def test_a_number_that_no_effect_has_gets_no_words():
    assert parameter_words("stribeck", "tau_p") == ""
    assert parameter_words("contact", "force") == ""
