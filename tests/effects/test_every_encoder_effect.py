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
    return EncoderSignals(t, 0.8 * np.sin(0.7 * t))


@every_effect
@pytest.mark.parametrize("samples", [0, 1, 500])
def test_there_is_one_finite_error_for_each_coefficient(effect, samples):
    errors = effect.errors(signals(samples), ())
    assert errors.shape == (samples, len(effect.coefficients))
    assert errors.dtype == np.float64
    assert np.isfinite(errors).all()
    assert effect.applies(signals(samples)) is bool(samples)


@every_effect
def test_it_says_what_it_is_confused_with(effect):
    assert effect.place == "encoder"
    assert effect.shapes == ()
    assert effect.confounds
    known = {each.name for each in missing_effects()} | set(all_effects())
    assert set(effect.confounds) <= known | WORDS
    assert effect.coordinate in ("position", "time")
