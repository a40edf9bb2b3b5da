"""The contract that every effect of a sensor with all its components keeps."""

import importlib
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from tests.effects.test_every_sensor_effect import signals

from exogauge.effects.catalogue import sensor_effects, shaped_effects, whole_sensor_effects

EFFECTS = dict(whole_sensor_effects())
every_effect = pytest.mark.parametrize("effect", EFFECTS.values(), ids=list(EFFECTS))


def standing(contacts=2):
    return replace(signals(component=-1), contacts=contacts)


@every_effect
def test_columns_are_one_per_coefficient_with_six_components(effect):
    columns = effect.columns(standing(), ())
    assert columns.shape == (3000, len(effect.coefficients), 6)
    assert np.isfinite(columns).all()
    assert np.any(columns != 0.0, axis=(0, 2)).all()


@every_effect
def test_it_is_looked_for_where_its_twin_is_not_the_base(effect):
    assert effect.applies(standing())
    assert not effect.applies(standing(contacts=0)), "inside the robot"
    assert not effect.applies(standing(contacts=1)), "one sensor alone turns as the base's IMU does"


@every_effect
def test_the_effect_is_found_under_the_name_of_its_file(effect):
    assert importlib.import_module(f"exogauge.effects.{effect.name}").EFFECT is effect
    assert effect.place == "whole_sensor"
    assert not set(EFFECTS) & (set(sensor_effects()) | set(shaped_effects()))


def test_a_tilt_is_the_slope_of_a_rotation():
    whole, step = standing(), 1e-5
    columns = EFFECTS["ft_tilt"].columns(whole, ())
    for axis in range(3):
        R = pin.exp3(step * np.eye(3)[axis])
        read = np.hstack([whole.expected[:, :3] @ R.T, whole.expected[:, 3:] @ R.T])
        np.testing.assert_allclose((read - whole.expected) / step, columns[:, axis], atol=1e-3)
