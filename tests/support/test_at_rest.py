"""Where friction holds a joint: what the data leave open, and what rule (9) of [Evaluator] makes of it."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from scipy.ndimage import binary_erosion

from exogauge.support.at_rest import (
    NEIGHBOURS,
    between_motions,
    bridged,
    doubt_at_rest,
    scatter_at_rest,
)
from exogauge.support.balance import balance
from exogauge.support.difference import difference
from exogauge.support.repeatability import held_friction
from exogauge.support.same_motion import Posture, match
from exogauge.support.settings import SupportSettings

RINGS = 0.1  # of a jump of friction, what a low-pass of this kind overshoots at most
RATE = 100.0
SETTLED = 20  # samples after which nothing of that is left


def anyhow(seed):
    """Friction at rest anywhere between its limits, another one in every hold of every joint."""
    return lambda t: np.random.default_rng([seed, round(100 * t)]).uniform(-1.0, 1.0, 6)


def deep(mask):
    """Samples at least SETTLED away from where it ends."""
    return binary_erosion(mask, np.ones((2 * SETTLED + 1, 1), dtype=bool))


@pytest.fixture(scope="module")
def runs(biped, suit, stoop):
    @functools.cache
    def record(worn, stuck):
        stuck_at = anyhow(stuck) if isinstance(stuck, int) else lambda t: np.full(6, stuck)
        recorded = biped.record(stoop(1), bands=suit.bands if worn else (), stuck=stuck_at)
        model = biped.known()
        return recorded, balance(model, model.prepare(recorded.log), np.array(biped.torso))

    return record


@pytest.mark.slow
@pytest.mark.parametrize("stuck", [11, 12, 1.0, -1.0])
def test_the_truth_lies_within_the_interval_at_rest_whatever_friction_does(biped, runs, low_passed, inner, stuck):
    recorded, own = runs(True, stuck)
    truth, most = low_passed(recorded.support)[:, biped.torso], biped.xi["tau_s"][biped.torso]
    outside = np.abs(own.torque - truth) - own.rest * most
    assert own.at_rest.mean(axis=0).min() > 0.3
    assert outside[inner][own.at_rest[inner]].max() < RINGS * 2.0 * most.max()
    quiet = deep(recorded.held[:, biped.torso])
    assert quiet.mean(axis=0).min() > 0.2
    assert own.at_rest[quiet].all()
    assert outside[inner][quiet[inner]].max() < 1e-3 * most.max()


def test_at_rest_the_balance_is_the_support_less_what_friction_holds(biped, runs, low_passed):
    for stuck in (1.0, -1.0, 0.3):
        recorded, own = runs(True, stuck)
        truth = low_passed(recorded.support)[:, biped.torso] - stuck * biped.xi["tau_s"][biped.torso]
        quiet = deep(recorded.held[:, biped.torso])
        quiet[: 2 * SETTLED] = quiet[-2 * SETTLED :] = False
        assert np.abs(own.torque - truth)[quiet].max() < 1e-3


def test_4_with_rule_9_at_rest_is_wrong_by_twice_the_static_friction_once_a_device_is_on(biped, runs, low_passed):
    """(8)-(9) take the sign of static friction from what the model cannot explain, and a device is just that."""
    most, holding = biped.xi["tau_s"][biped.torso], slice(330, 430)  # bent
    pitch = 1
    for worn, stuck, wrong in ((False, -1.0, 0.0), (False, 1.0, 0.0), (True, -1.0, 2.0), (True, 1.0, 0.0)):
        recorded, own = runs(worn, stuck)
        raw = own.torque[holding, pitch]
        printed = raw - np.sign(raw) * most[pitch]
        truth = low_passed(recorded.support)[holding, biped.torso[pitch]]
        assert np.abs(np.abs(printed - truth) - wrong * most[pitch]).max() < 1e-3
        assert np.all(truth < -2.0 * most[pitch]) or not worn
        assert np.abs(raw - truth).max() < most[pitch] + 1e-3  # ours: the interval about raw, never worse than this


def test_the_difference_of_two_runs_at_rest_may_be_wrong_by_both_frictions_and_says_so(biped, runs, low_passed, inner):
    names, most = ["torso_yaw", "torso_pitch"], biped.xi["tau_s"][biped.torso]
    (worn, this), (plain, other) = runs(True, -1.0), runs(False, 1.0)
    found = difference(this, other, match(Posture(worn.log, names), Posture(plain.log, names), SupportSettings()))
    error = np.abs(found.torque - low_passed(worn.support)[:, biped.torso])
    quiet = deep(worn.held[:, biped.torso])
    quiet[: 2 * SETTLED] = quiet[-2 * SETTLED :] = False
    np.testing.assert_allclose(error[quiet], np.broadcast_to(2.0 * most, error.shape)[quiet], rtol=2e-3)
    np.testing.assert_allclose(found.rest[quiet], 2.0, atol=1e-3)
    assert not found.compared[quiet].any()
    assert error[inner][found.compared[inner]].max() < 0.02


def test_the_interval_is_as_wide_as_the_friction_seen_at_rest_and_at_least_the_identified_one(biped, runs):
    model, most = biped.known(), biped.xi["tau_s"][biped.torso]
    np.testing.assert_allclose(held_friction(model, runs(False, 0.2)[1]), most)
    seen = held_friction(biped.known(tau_s=0.2 * biped.xi["tau_s"]), runs(False, 1.0)[1])
    assert np.all(seen >= most * (1 - 1e-3))
    assert np.all(seen <= most * (1 + 2.0 * RINGS))


def test_the_number_given_at_rest_comes_from_the_motions_on_both_sides(biped, runs, low_passed):
    """A hold in which only this joint's own bands could change: the number is right though friction is at its worst."""
    recorded, own = runs(True, -1.0)
    holding, pitch, most = slice(330, 430), 1, biped.xi["tau_s"][biped.torso]
    given = bridged(own.torque, own.steady, own.rest * most)[holding, pitch]
    truth = low_passed(recorded.support)[holding, biped.torso[pitch]]
    assert np.abs(given - truth).max() < 0.3 * most[pitch]
    assert np.abs(own.torque[holding, pitch] - truth).min() > 0.9 * most[pitch]


def random_case(seed):
    rng = np.random.default_rng(seed)
    torque = np.cumsum(rng.normal(size=(300, 3)), axis=0)
    edges = np.sort(rng.choice(np.arange(5, 295), 8, replace=False))
    steady = (np.searchsorted(edges, np.arange(300)) % 2 == seed % 2)[:, None] & np.array([True, True, False])
    return torque, steady, np.where(steady, 0.0, rng.uniform(0.0, 6.0, (300, 3)))


@pytest.mark.parametrize("seed", range(6))
def test_bridged_stays_in_the_interval_and_leaves_steady_motion_alone(seed):
    torque, steady, half = random_case(seed)
    given = bridged(torque, steady, half)
    assert np.all(np.abs(given - torque) <= half + 1e-12)
    np.testing.assert_array_equal(given[steady], torque[steady])
    np.testing.assert_array_equal(given[:, 2], torque[:, 2])  # never moves: the middle


def test_bridged_is_the_line_where_friction_allows_it():
    steady = np.zeros((100, 1), dtype=bool)
    steady[:20] = steady[60:80] = True
    torque = np.where(steady, np.where(np.arange(100) < 50, 2.0, 6.0)[:, None], 3.0)
    given = bridged(torque, steady, np.where(steady, 0.0, 10.0))[:, 0]
    np.testing.assert_allclose(given[19:61], np.interp(np.arange(19, 61), [19, 60], [2.0, 6.0]))
    np.testing.assert_allclose(given[80:], 6.0)  # nothing comes after
    narrow = bridged(torque, steady, np.where(steady, 0.0, 0.5))[:, 0]
    np.testing.assert_allclose(narrow[25:55], np.clip(given[25:55], 2.5, 3.5))


def test_the_line_goes_through_the_mean_of_a_few_steady_samples():
    steady = np.zeros(60, dtype=bool)
    steady[10:30] = steady[40:43] = True
    torque = np.random.default_rng(0).normal(size=60)
    line = between_motions(torque, steady)
    left, right = torque[30 - NEIGHBOURS : 30].mean(), torque[40:43].mean()
    np.testing.assert_allclose(line[29:41], np.linspace(left, right, 12))
    assert between_motions(torque, np.zeros(60, dtype=bool)) is None


def test_scatter_at_rest_is_the_rms_about_the_line_and_unknown_without_motion():
    steady = np.ones((200, 2), dtype=bool)
    steady[50:150] = steady[:, 1] = False
    half = np.where(steady, 0.0, 1.5)
    off = np.where(np.arange(200) % 2, 0.8, -0.6)
    torque = np.where(steady, 4.0, 4.0 + off[:, None])
    scatter = scatter_at_rest(torque, steady, half)
    assert scatter[0] == pytest.approx(np.sqrt(0.5))
    assert np.isnan(scatter[1])


def test_the_line_is_believed_as_far_as_the_band_kept_its_length():
    """Joint 0 moves, holds, moves, and its torque is 5 N·m per metre; in the hold joint 1 swings and takes band 0 with
    it; band 1 is its own. Joint 2 never moves."""
    t = np.arange(300)
    steady = np.ones((300, 3), dtype=bool)
    steady[100:200, 0] = steady[:, 2] = False
    own, swing = np.clip(t, 0, 100) + np.clip(t - 200, 0, 100), 60.0 * np.sin(np.pi * (t - 120) / 60.0)
    swing = np.where((t > 120) & (t < 180), swing, 0.0)
    length = 0.6 + 1e-3 * np.column_stack([own + swing, own])
    torque, half = np.outer(5.0 * length[:, 0], [1.0, 1.0, 1.0]), np.full((300, 3), 0.4)
    acts = np.array([[True, True, False], [True, False, True]])
    found = doubt_at_rest(torque, steady, half, length, acts)
    line = 5e-3 * np.abs(swing)  # what the pull changed by beside the line
    held = np.arange(300)[:, None].repeat(3, axis=1)[:, 0]
    inside = (held >= 100) & (held < 200)
    np.testing.assert_allclose(found[inside, 0], np.minimum(line[inside], 0.4 / np.sqrt(3.0)), atol=0.02)
    assert not found[steady[:, 0], 0].any()
    assert not found[:, 1].any()
    np.testing.assert_allclose(found[:, 2], 0.4 / np.sqrt(3.0))
