"""Stiffness and natural length from torques: against truths, finite differences, closed forms and scipy's solver."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares
from tests.band_problem import Motion, TorqueSamples, Way, fit_bands, setting

from exogauge.devices.device import Band, ViaPoint
from exogauge.effects.catalogue import band_effects
from exogauge.logs.filtering import LowPass
from exogauge.support.band_model import Fitted, Layout, Wear, at, columns, fit, residual, shared
from exogauge.support.band_rows import WearLogs

NOWHERE = (ViaPoint("chest", (0.0, 0.0, 0.0)), ViaPoint("pelvis", (0.0, 0.0, 0.0)))
SIDES = (Band("left", "back", NOWHERE), Band("right", "back", NOWHERE))
SUIT = (*SIDES, Band("front", "belt", NOWHERE), Band("knee", "leg", NOWHERE))


def tension_of(found: Fitted, samples: TorqueSamples) -> np.ndarray:
    return tension(samples.motion, found.wear.k, found.wear.l_0)


def moved(samples=500, twist=0.5, seed=0) -> Motion:
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 20.0, samples)
    b = 0.5 - 0.5 * np.cos(0.7 * t + rng.uniform(0, 6)) + 0.05 * np.sin(3.1 * t)
    w = twist * np.sin(0.9 * t + rng.uniform(0, 6))
    n = 0.8 * np.sin(0.5 * t + rng.uniform(0, 6))
    return Motion(np.column_stack([b, w, n]))


def shares(motion: Motion, *taut_from: float) -> np.ndarray:
    """Natural lengths at which bands come taut at these shares of their travel."""
    low, high = motion.length.min(axis=0), motion.length.max(axis=0)
    return low + np.array(taut_from) * (high - low)


def tension(motion: Motion, k, l_0) -> np.ndarray:
    return np.asarray(k * np.maximum(motion.length - l_0, 0.0))


def pulled(motion: Motion, k, l_0, noise=0.0, seed=1) -> TorqueSamples:
    """τ = -Σ J^T T, with noise of the standard deviations that it is weighted by."""
    torque = -np.einsum("nwd,nw->nd", motion.jacobian, tension(motion, k, l_0))
    sigma = np.array([0.3, 0.2, 0.1])[: torque.shape[1]]
    torque = torque + noise * sigma * np.random.default_rng(seed).normal(size=torque.shape)
    return TorqueSamples(motion, torque, np.broadcast_to(sigma**-2, torque.shape))


def square_sum(samples: TorqueSamples, k, l_0) -> float:
    """(26), plainly."""
    T = k * np.maximum(samples.length - l_0, 0.0)
    left = samples.torque + np.einsum("nwd,nw->nd", samples.jacobian, T)
    return float(np.sum(samples.weight * left**2))


def test_bands_of_a_group_share_their_stiffness_and_tied_ones_their_length():
    plan = shared(SUIT)
    assert plan.names == ("stiffness[back]", "stiffness[belt]", "stiffness[leg]", "natural_length[left]",
                          "natural_length[right]", "natural_length[front]", "natural_length[knee]")  # fmt: skip
    assert [plan.names[i] for i in plan.stiffness] == [f"stiffness[{band.group}]" for band in SUIT]
    assert [plan.names[i] for i in plan.natural_length] == [f"natural_length[{band.name}]" for band in SUIT]
    tied = shared(SUIT, frozenset({"back"}))
    assert tied.names[3:] == ("natural_length[back]", "natural_length[front]", "natural_length[knee]")
    assert tied.natural_length.tolist() == [3, 3, 4, 5]


def test_columns_are_the_slope_of_what_the_bands_give():
    """By differences of the residual, of stiffness and of natural length, tied or not."""
    plan, motion = shared(SUIT, frozenset({"back"})), moved()
    theta = np.array([200.0, 300.0, 400.0, *shares(motion, 0.2, 0.2, 0.4, 0.5)[1:]])
    given, step = setting(plan, pulled(motion, 200.0, shares(motion, 0.1, 0.1, 0.1, 0.1))), 1e-6
    A = columns(given.logs, given.wires, Wear(plan, theta))
    kink = (np.abs(motion.length - theta[plan.natural_length]) < 2 * step).any(axis=1)
    for i in range(len(theta)):
        ahead, behind = theta.copy(), theta.copy()
        ahead[i] += step
        behind[i] -= step
        left = [residual(given.logs, given.wires, Wear(plan, each)) for each in (ahead, behind)]
        slope = (left[1] - left[0]) / (2 * step)
        assert np.abs(A[:, :, i] - slope)[~kink].max() < 1e-5


def test_cost_and_hessian_are_those_of_the_plain_square_sum():
    plan, motion = shared(SUIT), moved(200)
    samples = pulled(motion, [200, 200, 300, 400], shares(motion, 0.1, 0.3, 0.2, 0.5), noise=1.0)
    found = fit_bands(plan, samples)
    assert found.cost == pytest.approx(square_sum(samples, found.wear.k, found.wear.l_0), rel=1e-10)
    left = samples.torque + np.einsum("nwd,nw->nd", motion.jacobian, tension_of(found, samples))
    np.testing.assert_allclose(found.e, left, atol=1e-12)
    G = np.einsum("ndp,nd,ndq->pq", found.A, samples.weight, found.A)
    np.testing.assert_allclose(found.hessian, G, rtol=1e-9, atol=1e-12 * np.abs(G).max())


@pytest.mark.parametrize("taut_from", [(-0.3, -0.2, -0.5, -0.1), (0.1, 0.4, 0.2, 0.5), (0.5, 0.1, 0.7, 0.3)])
def test_stiffness_and_natural_length_come_back(taut_from):
    """Bands taut throughout, and bands that come taut part-way."""
    plan, motion = shared(SUIT), moved()
    l_0 = shares(motion, *taut_from)
    theta = fit_bands(plan, pulled(motion, [180.0, 180.0, 700.0, 90.0], l_0)).wear.theta
    np.testing.assert_allclose(theta, [180.0, 700.0, 90.0, *l_0], rtol=1e-6)


def test_a_tied_group_has_one_length():
    plan, motion = shared(SUIT, frozenset({"back"})), moved()
    l_0 = shares(motion, 0.3, 0.3, 0.2, 0.4)
    l_0[1] = l_0[0]
    theta = fit_bands(plan, pulled(motion, [180.0, 180.0, 700.0, 90.0], l_0)).wear.theta
    np.testing.assert_allclose(theta, [180.0, 700.0, 90.0, l_0[0], l_0[2], l_0[3]], rtol=1e-6)


@pytest.mark.parametrize("seed", range(40))
def test_no_search_ends_with_all_bands_slack_or_above_the_truth(seed):
    """From barely stretched to slack for nine tenths of the travel, soft to stiff, with noise and without."""
    rng = np.random.default_rng(seed)
    plan, motion = shared(SIDES), moved(600, twist=rng.uniform(0.1, 0.6), seed=seed).only(2)
    l_0, k = shares(motion, *rng.uniform(-0.4, 0.9, 2)), float(np.exp(rng.uniform(np.log(30), np.log(3000))))
    samples = pulled(motion, k, l_0, noise=rng.choice([0.0, 0.1, 1.0]), seed=seed)
    found = fit_bands(plan, samples)
    assert tension_of(found, samples).any()
    assert found.cost <= square_sum(samples, k, l_0) * (1 + 1e-6) + 1e-6


@pytest.mark.parametrize("seed", range(5))
def test_bands_that_are_slack_for_four_fifths_of_the_time_are_found(seed):
    plan, motion = shared(SIDES), moved(seed=seed).only(2)
    l_0 = np.quantile(motion.length, 0.8, axis=0)
    found = fit_bands(plan, pulled(motion, 250.0, l_0))
    assert (motion.length > found.wear.l_0).mean() == pytest.approx(0.2, abs=0.01)
    np.testing.assert_allclose(found.wear.theta, [250.0, *l_0], rtol=1e-6)


@pytest.mark.parametrize("share", [0.0, 0.5, 0.99, 1.0, 1.3])
def test_a_search_that_is_begun_anywhere_for_one_parameter_finds_the_others(share):
    """Also where that one band is slack throughout: the other one's torque is still explained as well as can be."""
    plan, motion = shared((SIDES[0], replace(SIDES[1], group="other"))), moved().only(2)
    l_0 = shares(motion, 0.2, 0.3)
    samples = pulled(motion, np.array([250.0, 400.0]), l_0, noise=1.0)
    found = fit_bands(plan, samples)
    held = float(shares(motion, share, share)[0])
    given = setting(plan, samples)
    cost = fit(given, found.wear, {2: held}).cost
    ours = by_scipy(samples, plan, found.wear.theta, held=(2, held))
    assert cost == pytest.approx(ours.fun @ ours.fun, rel=1e-6)
    assert cost >= found.cost


def by_scipy(samples: TorqueSamples, plan: Layout, start, beliefs=(), held=None):
    """The same minimum by a solver of others, from residuals and with its own numerical slopes."""
    free = [i for i in range(len(start)) if held is None or i != held[0]]

    def residual(x):
        theta = np.array(start, dtype=float)
        theta[free] = x * plan.scale[free]
        if held is not None:
            theta[held[0]] = held[1]
        T = theta[plan.stiffness] * np.maximum(samples.length - theta[plan.natural_length], 0.0)
        left = samples.torque + np.einsum("nwd,nw->nd", samples.jacobian, T)
        more = [(theta[place] - mean) / std for place, mean, std in beliefs]
        return np.concatenate([(np.sqrt(samples.weight) * left).ravel(), more])

    return least_squares(residual, np.asarray(start)[free] / plan.scale[free], xtol=1e-14, ftol=1e-14, gtol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_scipys_solver_finds_the_same_minimum(seed):
    plan, motion = shared(SUIT), moved(300, seed=seed)
    l_0 = shares(motion, 0.1, 0.3, 0.2, 0.4)
    samples = pulled(motion, [200, 200, 300, 400], l_0, noise=1.0, seed=seed)
    beliefs = [(1, 320.0, 15.0), (5, float(l_0[2]) + 0.01, 0.01)]
    found = fit_bands(plan, samples, beliefs)
    other = by_scipy(samples, plan, [200.0, 300.0, 400.0, *l_0], beliefs)
    std = np.sqrt(np.diag(np.linalg.inv(found.hessian)))
    assert abs(found.cost - other.fun @ other.fun) < 1e-2  # where a sample comes taut the cost has a small kink
    assert np.abs((found.wear.theta - other.x * plan.scale) / std).max() < 0.05


def test_weights_count_by_sample_and_joint():
    """Torque of a joint without weight is not looked at; a sample that is not used may hold anything."""
    plan, motion = shared(SIDES), moved().only(2)
    l_0 = shares(motion, 0.1, 0.3)
    good = pulled(motion, 250.0, l_0)
    wrong, weight = good.torque.copy(), np.array(good.weight)
    wrong[:, 1], weight[:, 1] = 99.0, 0.0
    wrong[100:200], weight[100:200] = -50.0, 0.0
    theta = fit_bands(plan, TorqueSamples(motion, wrong, weight)).wear.theta
    np.testing.assert_allclose(theta, [250.0, *l_0], rtol=1e-6)


def test_torque_five_percent_too_small_makes_stiffness_five_percent_too_small_and_leaves_lengths():
    plan, motion = shared(SUIT), moved()
    samples = pulled(motion, [200, 200, 300, 400], shares(motion, 0.1, 0.3, 0.2, 0.4), noise=1.0)
    theta, less = (fit_bands(plan, replace(samples, torque=gain * samples.torque)).wear.theta for gain in (1.0, 0.95))
    np.testing.assert_allclose(less[:3], 0.95 * theta[:3], rtol=1e-5)
    np.testing.assert_allclose(less[3:], theta[3:], rtol=1e-6)


def test_no_band_pushes():
    """Torque of the wrong sign is left unexplained rather than given to a negative stiffness."""
    plan, motion = shared(SIDES), moved().only(2)
    samples = pulled(motion, 250.0, shares(motion, 0.1, 0.3))
    found = fit_bands(plan, replace(samples, torque=-samples.torque))
    assert found.wear.theta[0] >= 0.0
    assert found.cost == pytest.approx(np.sum(samples.weight * samples.torque**2), rel=1e-6)


def test_26_as_printed_leaves_each_band_the_torque_of_all_of_them():
    """The sum over bands of norms asks every single band for the whole torque; its minimum is elsewhere."""
    motion = moved().only(2)
    l_0 = shares(motion, 0.1, 0.3)
    samples = pulled(motion, 250.0, l_0)

    def printed(k):
        T = k * np.maximum(motion.length - l_0, 0.0)
        left = samples.torque[:, None] + motion.jacobian * T[:, :, None]
        return float(np.linalg.norm(left, axis=2).sum())

    trial = np.linspace(100.0, 600.0, 101)
    best = trial[np.argmin([printed(k) for k in trial])]
    assert best > 1.15 * 250.0
    assert square_sum(samples, 250.0, l_0) < 1e-20
    assert fit_bands(shared(SIDES), samples).wear.k[0] == pytest.approx(250.0, rel=1e-6)


def test_a_belief_counts_by_its_inverse_variance():
    """All else known, stiffness is linear: the estimate is the weighted mean of the data's and the belief's."""
    plan, motion = shared((SIDES[0],)), moved().only(1)
    l_0 = float(shares(motion, 0.2)[0])
    samples = pulled(motion, 250.0, l_0, noise=3.0)
    known = (1, l_0, 1e-6)
    g = -motion.jacobian[:, 0] * np.maximum(motion.length - l_0, 0.0)
    information = float(np.sum(samples.weight * g**2))
    alone = float(np.sum(samples.weight * g * samples.torque)) / information
    for std in (0.3, 3.0, 30.0, 3000.0):
        expected = (information * alone + 300.0 / std**2) / (information + std**-2)
        found = fit_bands(plan, samples, [known, (0, 300.0, std)])
        assert found.wear.theta[0] == pytest.approx(expected, rel=1e-5)
        assert found.hessian[0, 0] == pytest.approx(information + std**-2, rel=1e-6)


def test_a_belief_decides_what_the_data_do_not_hold():
    """A band that these motions never stretch keeps what the bench said of it."""
    plan, motion = shared(SUIT), moved()
    l_0 = shares(motion, 0.1, 0.3, 1.5, 0.4)
    samples = pulled(motion, [200, 200, 300, 400], l_0)
    beliefs = [(1, 310.0, 20.0), (5, float(l_0[2]), 0.002)]
    theta = fit_bands(plan, samples, beliefs).wear.theta
    np.testing.assert_allclose(theta, [200.0, 310.0, 400.0, *l_0], rtol=1e-3)


def test_bending_and_the_torque_of_the_bend_alone_cannot_tell_left_from_right():
    plan, motion = shared(SIDES), moved(twist=0.0).only(2, joints=1)
    found = fit_bands(plan, pulled(motion, 250.0, shares(motion, 0.3, 0.3)))
    (direction,) = found.null_directions
    np.testing.assert_allclose(np.abs(direction), [0.0, np.sqrt(0.5), np.sqrt(0.5)], atol=1e-6)
    assert direction[1] == pytest.approx(-direction[2])
    twisted = moved(twist=0.3).only(2, joints=1)
    assert len(fit_bands(plan, pulled(twisted, 250.0, shares(twisted, 0.3, 0.3))).null_directions) == 0


def test_long_logs_are_searched_coarsely_and_fitted_on_every_sample():
    plan, motion = shared(SIDES), moved(9001).only(2)
    samples = pulled(motion, 250.0, shares(motion, 0.2, 0.5), noise=1.0)
    found = fit_bands(plan, samples)
    other = by_scipy(samples, plan, found.wear.theta)
    assert abs(found.cost - other.fun @ other.fun) < 1e-2


def test_everything_about_one_choice_is_said_without_a_search():
    plan, motion = shared(SIDES), moved(50).only(2)
    samples, theta = pulled(motion, 250.0, shares(motion, 0.2, 0.5)), np.array([100.0, *shares(motion, 0.1, 0.1)])
    found = at(setting(plan, samples), Wear(plan, theta))
    np.testing.assert_array_equal(found.wear.theta, theta)
    assert found.cost == pytest.approx(square_sum(samples, 100.0, theta[1:]), rel=1e-10)


def test_columns_of_shapes_side_by_side_are_those_of_each_alone():
    worn = setting(shared(SUIT), pulled(moved(), np.full(4, 200.0), np.full(4, 0.3))).logs.logs[0]
    N = len(worn.time)
    few = replace(worn, kept=np.arange(20, N - 20, 3), low_pass=LowPass(4.0, 25.0), torque=worn.torque[20 : N - 20 : 3],
                  used=worn.used[20 : N - 20 : 3])  # fmt: skip
    wire = WearLogs([few, worn], np.arange(3), ("bend", "twist", "knee")).wire(Way(0))
    pulls = [run.length > 0.58 for run in wire.runs]
    for effect in (each for each in band_effects().values() if each.sort == "law" and not each.per_segment):
        shapes = list(itertools.product(*(one.grid for one in effect.shapes)))
        for given in (None, pulls):
            together = wire.columns_of_all(effect, shapes, 200.0, 0.55, given)
            for shape, found in zip(shapes, together, strict=True):
                np.testing.assert_array_equal(found, wire.columns(effect, shape, 200.0, 0.55, given))
