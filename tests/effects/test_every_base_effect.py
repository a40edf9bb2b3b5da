"""The contract that every effect of the base and its IMU keeps."""

import importlib
from dataclasses import fields, replace

import numpy as np
import pinocchio as pin
import pytest

from exogauge.effects.catalogue import all_effects, base_effects, sensor_effects, shaped_effects
from exogauge.effects.places import BaseSignals

WORDS = {"first moments", "zero", "leg encoders"}  # what else may stand in for one: no effects, but bodies and sensors
MOST_COLUMNS = 8  # each costs two passes over all rows
PARTS = ("acc", "gyro", "gyro_dot")
EFFECTS = dict(base_effects())

every_effect = pytest.mark.parametrize("effect", EFFECTS.values(), ids=list(EFFECTS))


def floating(samples=2000, seed=0):
    """A trunk that sways and turns."""
    rng = np.random.default_rng(seed)
    t = np.arange(samples) / 100.0
    omega, phase = 2.0 * np.pi * rng.uniform(0.1, 1.0, (4, 3)), rng.uniform(0.0, 6.0, (4, 3))
    angle = t[:, None, None] * omega + phase
    gyro = 0.3 * np.sum(np.sin(angle), axis=1)
    gyro_dot = 0.3 * np.sum(omega * np.cos(angle), axis=1)
    acc = np.array([0.0, 0.0, 9.81]) + 0.5 * np.sum(np.cos(angle + 1.0), axis=1)
    rates = [np.gradient(each, t, axis=0) for each in (acc, gyro, gyro_dot)]
    imu_at = np.array([0.1, -0.05, 0.2])
    return BaseSignals(t, acc, gyro, gyro_dot, *rates, True, 0.8 * np.sin(0.7 * t), imu_at, feet_feel=True)


def fixed(samples=2000):
    """A base that stands still, below joints that move."""
    t, zero = np.arange(samples) / 100.0, np.zeros((samples, 3))
    acc = np.tile([0.0, 0.0, 9.81], (samples, 1))
    return BaseSignals(t, acc, zero, zero, zero, zero, zero, False, 0.8 * np.sin(0.7 * t))


def cut(whole, part):
    constant = ("floating", "imu_at", "feet_feel", "turn")
    arrays = {f.name: getattr(whole, f.name)[part] for f in fields(whole) if f.name not in constant}
    return replace(whole, **arrays)


def own(effect):
    """Signals in which it may be looked for."""
    return next(each for each in (fixed(), floating()) if effect.applies(each))


def flat(change):
    parts = [getattr(change, part) for part in PARTS]
    first = change.first_torque
    return np.hstack([*parts, (np.zeros(len(parts[0])) if first is None else first)[:, None]])


@every_effect
@pytest.mark.parametrize("whole", [fixed(), floating()], ids=["fixed", "floating"])
def test_there_is_one_finite_change_for_each_coefficient(effect, whole):
    changes = effect.changes(whole, ())
    assert len(changes) == len(effect.coefficients)
    for change in changes:
        for part in PARTS:
            assert getattr(change, part).shape == (len(whole.time), 3)
        assert flat(change).dtype == np.float64
        assert np.isfinite(flat(change)).all()
        assert flat(change).any() or not effect.applies(whole)


@every_effect
@pytest.mark.parametrize("samples", [0, 1, 2, 5])
def test_a_log_of_a_few_samples_is_no_special_case(effect, samples):
    for whole in (fixed(), floating()):
        short = cut(whole, slice(300, 300 + samples))
        shown = False
        for change in effect.changes(short, ()):
            assert flat(change).shape == (samples, 10)
            shown |= bool(flat(change).any())
        assert effect.applies(short) is False or (shown and samples > 0)


@every_effect
def test_it_is_looked_for_on_one_sort_of_base_only(effect):
    """One IMU feels gravity wherever it is; what stands still has none that could be late."""
    assert effect.applies(fixed()) != effect.applies(floating())


@every_effect
def test_the_signals_stay_as_they_are(effect):
    whole, fresh = own(effect), own(effect)
    effect.changes(whole, ())
    for field in fields(whole):
        np.testing.assert_array_equal(getattr(whole, field.name), getattr(fresh, field.name))


@every_effect
def test_no_two_coefficients_do_the_same(effect):
    columns = np.stack([flat(change).ravel() for change in effect.changes(own(effect), ())])
    size = np.linalg.norm(columns, axis=1)
    alike = np.abs(columns @ columns.T) / np.outer(size, size)
    assert np.all(alike[~np.eye(len(alike), dtype=bool)] < 0.9)


@every_effect
def test_what_it_is_confused_with_and_plotted_over_is_known(effect):
    assert effect.confounds
    assert set(effect.confounds) <= WORDS | set(EFFECTS) | set(all_effects())
    assert effect.coordinate == "time"
    assert effect.place == "base"
    assert effect.shapes == ()


@pytest.mark.parametrize("file", EFFECTS)
def test_the_effect_is_found_under_the_name_of_its_file(file):
    assert importlib.import_module(f"exogauge.effects.{file}").EFFECT is EFFECTS[file]


def test_what_shares_an_identifier_is_never_looked_for_on_the_same_base():
    for whole in (fixed(), floating()):
        applying = [effect.name for effect in EFFECTS.values() if effect.applies(whole)]
        assert len(set(applying)) == len(applying)
    assert [file for file, effect in EFFECTS.items() if effect.name != file] == ["imu_tilt"]


@every_effect
def test_where_it_does_not_apply_it_changes_nothing_or_is_told_by_another_name(effect):
    """Effects are collected by identifier: one that does not apply must not ride on one that does."""
    for whole in (fixed(), floating()):
        namesakes = [each for each in EFFECTS.values() if each is not effect and each.name == effect.name]
        if namesakes and not effect.applies(whole):
            assert not any(flat(change).any() for change in effect.changes(whole, ()))


def test_feet_that_do_not_feel_along_all_axes_show_no_tilt_of_an_imu():
    assert not EFFECTS["imu_tilt"].applies(replace(floating(), feet_feel=False))


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_tilted_imu_is_the_slope_of_turning_all_that_it_reads(axis):
    whole, step = floating(), 1e-6
    r = whole.imu_at

    def at_base(f, w, w_dot):
        return f - np.cross(w_dot, r) - np.cross(w, np.cross(w, r))

    f = 2.0 * whole.acc - at_base(whole.acc, whole.gyro, whole.gyro_dot)
    K = np.cross(np.eye(3), np.eye(3)[axis])
    turned = np.eye(3) + np.sin(step) * K + (1.0 - np.cos(step)) * K @ K
    assert turned @ np.eye(3)[(axis + 1) % 3] @ np.eye(3)[(axis + 2) % 3] > 0.0, "a turn to the right"
    (change,) = EFFECTS["imu_tilt"].changes(whole, ())[axis : axis + 1]
    read = [each @ turned.T for each in (f, whole.gyro, whole.gyro_dot)]
    np.testing.assert_allclose(change.acc, (at_base(*read) - whole.acc) / step, atol=1e-3)
    np.testing.assert_allclose(change.gyro, (read[1] - whole.gyro) / step, atol=1e-4)
    np.testing.assert_allclose(change.gyro_dot, (read[2] - whole.gyro_dot) / step, atol=1e-3)


def test_a_search_stays_affordable():
    assert sum(len(effect.coefficients) for effect in EFFECTS.values()) <= MOST_COLUMNS


def test_no_two_effects_bear_the_same_name():
    names = {effect.name for effect in EFFECTS.values()} | set(EFFECTS)
    assert not names & (set(shaped_effects()) | set(sensor_effects()) | set(all_effects()))


@pytest.mark.parametrize("axis", [0, 1])
def test_a_tilt_is_the_slope_of_a_rotation_at_zero(axis):
    whole, step = fixed(), 1e-6
    turned = np.eye(3)
    s, c = np.sin(step), np.cos(step)
    turned = np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) if axis == 0 else np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    slope = (whole.acc @ turned.T - whole.acc) / step
    np.testing.assert_allclose(EFFECTS["base_tilt"].changes(whole, ())[axis].acc, slope, atol=1e-4)


@pytest.mark.parametrize("turn", [[0.02, -0.03, 0.0], [0.15, 0.1, 0.0], [0.0, 0.0, 0.0]])
def test_a_tilt_that_was_found_leaves_gravity_its_size(turn):
    """Seen from the turn that it is, the change is the whole rotation."""
    turn, whole = np.array(turn), fixed()
    changes = EFFECTS["base_tilt"].changes(replace(whole, turn=turn), ())
    acc = whole.acc + sum(angle * each.acc for angle, each in zip(turn[:2], changes, strict=False))
    np.testing.assert_allclose(acc, whole.acc @ pin.exp3(turn).T, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(acc, axis=1), 9.81, atol=1e-12)


@pytest.mark.parametrize("turn", [[0.02, -0.03, 0.05], [-0.1, 0.15, 0.1]])
def test_an_imu_seen_from_its_turn_is_wholly_turned(turn):
    turn, whole = np.array(turn), replace(floating(), imu_at=np.zeros(3))
    changes = EFFECTS["imu_tilt"].changes(replace(whole, turn=turn), ())
    for part in ("gyro", "gyro_dot"):
        found = getattr(whole, part) + sum(
            angle * getattr(each, part) for angle, each in zip(turn, changes, strict=True)
        )
        np.testing.assert_allclose(found, getattr(whole, part) @ pin.exp3(turn).T, atol=1e-12)


def test_a_delay_is_made_good_by_the_rate_of_what_was_late():
    """What is logged is late; the true motion is the logged one plus delay times its rate."""
    t, delay = np.arange(0.0, 20.0, 0.01), 0.01
    true, late = (np.stack([np.sin(3.0 * (t - lag)), np.cos(2.0 * (t - lag)), 0.0 * t], axis=1) for lag in (0.0, delay))
    rate = np.gradient(late, t, axis=0)
    (change,) = EFFECTS["imu_delay"].changes(BaseSignals(t, late, late, late, rate, rate, rate, True, t), ())
    for part in PARTS:
        assert np.abs(late + delay * getattr(change, part) - true).max() < 0.05 * np.abs(late - true).max()
