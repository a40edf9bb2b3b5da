"""The contract that every effect of what an encoder reads keeps, and what its site makes of it."""

import numpy as np
import pytest

from exogauge.effects.catalogue import all_effects, encoder_effects, missing_effects
from exogauge.effects.places import EncoderSignals

EFFECTS = dict(encoder_effects())
WORDS = {"first moments"}
every_effect = pytest.mark.parametrize("effect", EFFECTS.values(), ids=list(EFFECTS))


def signals(samples=500):
    t = np.arange(samples) / 100.0
    return EncoderSignals(t, 1.4 * np.sin(0.7 * t))


@every_effect
@pytest.mark.parametrize("samples", [0, 1, 500])
def test_there_is_one_finite_error_for_each_coefficient(effect, samples):
    errors = effect.errors(signals(samples), ())
    assert errors.shape == (samples, len(effect.coefficients))
    assert errors.dtype == np.float64
    assert np.isfinite(errors).all()
    assert effect.applies(signals(500))
    assert not effect.applies(signals(0))


def test_a_zero_is_seen_in_one_sample_and_not_where_it_turns_the_whole_robot():
    zero, one = EFFECTS["encoder_zero"], signals(1)
    assert zero.applies(one)
    assert not zero.applies(EncoderSignals(one.time, one.position, first=True))


def test_an_eccentric_encoder_takes_a_quarter_of_a_turn_to_be_seen():
    t = np.arange(500) / 100.0
    assert not EFFECTS["encoder_eccentricity"].applies(EncoderSignals(t, 0.7 * np.sin(2.0 * t)))


@every_effect
def test_it_says_what_it_is_confused_with(effect):
    assert effect.place == "encoder"
    assert effect.shapes == ()
    assert effect.confounds
    known = {each.name for each in missing_effects()} | set(all_effects())
    assert set(effect.confounds) <= known | WORDS
    assert effect.coordinate in ("position", "time")
