"""Intervals of bands: symmetric and by profile, against closed forms and scipy's refits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares
from tests.band_problem import Motion, TorqueSamples, fit_bands, setting
from tests.draws import drawn, met_in

from exogauge.criteria.criterion import Z95
from exogauge.devices.device import Band, ViaPoint
from exogauge.support.band_fit import BandFit, downhill, starts
from exogauge.support.band_interval import Profiles
from exogauge.support.band_model import at, shared
from exogauge.support.band_model import fit as lowered
from exogauge.support.band_rows import WearLogs

NOWHERE = (ViaPoint("chest", (0.0, 0.0, 0.0)), ViaPoint("pelvis", (0.0, 0.0, 0.0)))
PLAN = shared((Band("back", "back", NOWHERE),))
STIFFNESS, LENGTH = 0, 1


def bending(samples=400, noise=0.5, taut_from=0.62, k=250.0, seed=0) -> TorqueSamples:
    """One band over one joint. noise: [N·m] white, and the torque is weighted by it."""
    t = np.linspace(0.0, 20.0, samples)
    b = 0.5 - 0.5 * np.cos(0.7 * t) + 0.05 * np.sin(3.1 * t)
    motion = Motion(np.column_stack([b, 0.0 * t, 0.0 * t]), bands=1, joints=1)
    torque = -motion.jacobian[:, 0] * k * np.maximum(motion.length - taut_from, 0.0)
    torque = torque + noise * np.random.default_rng(seed).normal(size=(samples, 1))
    return TorqueSamples(motion, torque, np.full((samples, 1), noise**-2))


def residual(samples: TorqueSamples, k, l_0) -> np.ndarray:
    T = k * np.maximum(samples.length[:, 0] - l_0, 0.0)
    return np.asarray(np.sqrt(samples.weight[:, 0]) * (samples.torque[:, 0] + samples.jacobian[:, 0, 0] * T))


def found_in(samples: TorqueSamples, beliefs=()):
    return setting(PLAN, samples, beliefs), fit_bands(PLAN, samples, beliefs)


def profiles(given, fit, covariance) -> Profiles:
    return Profiles(BandFit(np.zeros((0, 0)), None, given, fit), covariance, np.zeros(len(covariance)))


def curved(fit) -> np.ndarray:
    return np.asarray(np.linalg.inv(fit.hessian))


@pytest.mark.parametrize("samples", [400, 9001])
@pytest.mark.parametrize("coloured", [1.0, 6.0])
def test_both_kinds_agree_where_the_cost_is_a_parabola(samples, coloured):
    """With the natural length known, torque is linear in stiffness. coloured: the variance over the curvature's."""
    beliefs = [(LENGTH, 0.62, 1e-6)]
    given, fit = found_in(bending(samples), beliefs)
    covariance = coloured * curved(fit)
    std, value = np.sqrt(covariance[STIFFNESS, STIFFNESS]), fit.wear.theta[STIFFNESS]
    by_profile = profiles(given, fit, covariance).interval(STIFFNESS, 0.0)
    np.testing.assert_allclose(by_profile, [value - Z95 * std, value + Z95 * std], atol=0.01 * std)
    assert profiles(given, fit, covariance).interval(STIFFNESS, 1e9) == (value - Z95 * std, value + Z95 * std)


@pytest.mark.parametrize("index", [STIFFNESS, LENGTH])
def test_ends_of_a_profile_are_where_the_best_of_the_rest_costs_the_quantile_squared_more(index):
    samples = bending(noise=3.0)
    given, fit = found_in(samples)
    ends = profiles(given, fit, curved(fit)).interval(index, 0.0)
    other, start = 1 - index, fit.wear.theta

    def best(value):
        def left(x):
            return residual(samples, *((value, x[0]) if index == STIFFNESS else (x[0], value)))

        found = [least_squares(left, [start[other] * factor], x_scale=[start[other]], xtol=1e-14, ftol=1e-14)
                 for factor in (1.0, 0.97, 1.03, 2.0)]  # fmt: skip
        return min(2.0 * each.cost for each in found)

    lowest = float(np.sum(residual(samples, *start) ** 2))
    assert ends[0] < fit.wear.theta[index] < ends[1]
    for end in ends:
        assert best(end) - lowest == pytest.approx(Z95**2, rel=0.03)
    half = Z95 * np.sqrt(curved(fit)[index, index])
    symmetric = fit.wear.theta[index] + np.array([-half, half])
    assert np.abs(ends - symmetric).max() > 0.05 * half  # here the two kinds do differ


def test_two_ways_that_suit_alike_are_in_one_interval():
    """Two postures, and a pull that grows faster than its stretch: a soft spring that is always taut suits nearly as
    well as a hard one that is taut in one of them only, and nothing between suits at all."""
    t, noise = np.linspace(0.0, 20.0, 400), 0.8
    b = np.where(t < 10.0, 0.15, 0.95) + 0.12 * np.sin(2.1 * t)
    motion = Motion(np.column_stack([b, 0.0 * t, 0.0 * t]), bands=1, joints=1)
    pull = 80.0 * np.maximum(motion.length - 0.59, 0.0) + 250.0 * np.maximum(motion.length - 0.68, 0.0)
    samples = TorqueSamples(motion, -motion.jacobian[:, 0] * pull, np.full((len(t), 1), noise**-2))

    every, taut_from = np.linspace(50.0, 600.0, 551), np.linspace(0.5, 0.725, 1000)
    unit = -motion.jacobian[:, 0] * np.maximum(motion.length - taut_from, 0.0) / noise  # (N, lengths)
    measured = samples.torque[:, 0] / noise
    squares = measured @ measured - 2.0 * every[:, None] * (measured @ unit) + every[:, None] ** 2 * np.sum(unit**2, 0)
    cost = squares.min(axis=1)
    told = cost - cost.min() <= Z95**2
    assert np.sum(np.diff(told.astype(int)) == 1) == 2  # two parts, by trying every pair of values

    given, fit = found_in(samples)
    low, high = profiles(given, fit, curved(fit)).interval(STIFFNESS, 0.0)
    np.testing.assert_allclose([low, high], [every[told].min(), every[told].max()], atol=3.0)


def test_little_doubt_against_the_value_is_stated_symmetrically():
    given, fit = found_in(bending(noise=0.02))
    covariance = curved(fit)
    std = np.sqrt(np.diag(covariance))
    for index, size in ((STIFFNESS, fit.wear.theta[STIFFNESS]), (LENGTH, 0.1)):
        assert std[index] < 0.05 * size
        low, high = profiles(given, fit, covariance).interval(index, size)
        assert (low + high) / 2 == pytest.approx(fit.wear.theta[index], rel=1e-12)
        assert high - low == pytest.approx(2 * Z95 * std[index])


def test_what_the_data_do_not_hold_may_be_anything():
    given, fit = found_in(bending())
    assert profiles(given, fit, np.diag([np.inf, 1e-6])).interval(STIFFNESS, fit.wear.theta[STIFFNESS]) == (0.0, np.inf)


def test_an_end_that_no_data_hold_is_open():
    """Noise as large as the pull: any stiffness, if only the band comes taut late enough; and none at all."""
    given, fit = found_in(bending(noise=12.0, samples=200))
    low, high = profiles(given, fit, curved(fit)).interval(STIFFNESS, fit.wear.theta[STIFFNESS])
    assert low == 0.0
    assert np.isinf(high)
    assert profiles(given, fit, curved(fit)).interval(LENGTH, 0.1)[0] == 0.0


def test_the_interval_of_a_believed_parameter_narrows_as_the_closed_form_says():
    samples = bending(noise=2.0)
    for std in (5.0, 50.0):
        beliefs = [(STIFFNESS, 260.0, std), (LENGTH, 0.62, 1e-6)]
        given, fit = found_in(samples, beliefs)
        g = samples.jacobian[:, 0, 0] * np.maximum(samples.length[:, 0] - 0.62, 0.0)
        own = 1.0 / np.sqrt(np.sum(samples.weight[:, 0] * g**2) + std**-2)
        low, high = profiles(given, fit, curved(fit)).interval(STIFFNESS, 0.0)
        assert high - low == pytest.approx(2 * Z95 * own, rel=0.01)


def test_a_doubt_of_a_seventeenth_is_not_symmetric_already():
    """The slopes claim a symmetric doubt; the best of the rest says how much more the far end costs."""
    samples = bending(noise=1.0)
    given, fit = found_in(samples)
    value, std = fit.wear.theta[STIFFNESS], float(np.sqrt(curved(fit)[STIFFNESS, STIFFNESS]))
    assert 0.05 < std / value < 0.08
    low, high = profiles(given, fit, curved(fit)).interval(STIFFNESS, value)
    assert high - value > 1.2 * Z95 * std
    for end in (low, high):
        held = min(
            2.0 * least_squares(lambda x, end=end: residual(samples, end, x[0]), [fit.wear.theta[LENGTH] * near]).cost
            for near in (0.99, 1.0, 1.01)
        )
        assert held - float(np.sum(residual(samples, *fit.wear.theta) ** 2)) == pytest.approx(Z95**2, rel=0.05)


TWO = shared((Band("left", "back", NOWHERE), Band("right", "back", NOWHERE)))


def twisting() -> Motion:
    t = np.linspace(0.0, 30.0, 450)
    b = 0.5 - 0.5 * np.cos(0.7 * t) + 0.05 * np.sin(3.1 * t)
    return Motion(np.column_stack([b, 0.4 * np.sin(0.9 * t + 1.0), 0.0 * t]), bands=2, joints=2)


def pulled(motion: Motion, k: float, taut_from: float) -> np.ndarray:
    return -np.einsum("nwd,nw->nd", motion.jacobian, k * np.maximum(motion.length - taut_from, 0.0))


@pytest.mark.parametrize("seed", [0, 8, 28])
def test_an_interval_holds_the_other_fit_too_where_the_residuals_do_not_tell_them_apart(seed):
    """Between a band that is always taut and one that comes taut late; the weights claim a third of the noise there is,
    so that costs say more than there is."""
    motion, noise = twisting(), 0.4
    soft, hard = pulled(motion, 80.0, 0.585), pulled(motion, 142.0, 0.663)
    torque = 0.55 / 0.6 * hard + 0.45 * soft * np.sqrt(np.sum(hard**2) / np.sum(soft**2)) / 0.6
    torque = torque + noise * np.random.default_rng(seed).normal(size=torque.shape)
    samples = TorqueSamples(motion, torque, np.full(torque.shape, (0.3 * noise) ** -2))
    given, fit = setting(TWO, samples), fit_bands(TWO, samples)
    low, high = profiles(given, fit, curved(fit)).interval(STIFFNESS, 0.0)
    ends = downhill(given, starts(TWO, given.wires, ()))
    assert max(each.cost - fit.cost for each in ends) > 3.0 * Z95**2
    for each in ends:
        assert low < each.wear.springs[STIFFNESS] < high


@pytest.mark.slow
def test_another_fit_counts_until_it_is_surely_worse_though_no_interval_holds_it_any_more():
    motion, noise, beside = twisting(), 0.4, 0
    soft, hard = pulled(motion, 80.0, 0.585), pulled(motion, 142.0, 0.663)
    torque = 0.55 / 0.6 * hard + 0.45 * soft * np.sqrt(np.sum(hard**2) / np.sum(soft**2)) / 0.6
    for seed in range(12):
        noisy = torque + noise * np.random.default_rng(seed).normal(size=torque.shape)
        samples = TorqueSamples(motion, noisy, np.full(torque.shape, noise**-2))
        given, fit = setting(TWO, samples), fit_bands(TWO, samples)
        found = profiles(given, fit, curved(fit))
        low, high = found.interval(STIFFNESS, 0.0)
        near, further = (found.of_other_fits(STIFFNESS, sure) for sure in (Z95, 6.0))
        assert set(near) <= set(further)
        beside += any(not low < each < high for each in further)
    assert beside


@pytest.mark.slow
@pytest.mark.parametrize("declared", [True, False])
def test_what_speaks_against_another_fit_is_as_large_as_declared_errors_make_it(declared):
    """The other one is true but for noise and an error along what the two say differently."""
    motion, noise, size, rng = twisting(), 0.3, 0.4, np.random.default_rng(3)
    soft, hard = pulled(motion, 110.0, 0.58), pulled(motion, 240.0, 0.65)
    found = []
    for _ in range(150):
        torque = hard + size * rng.normal() * (soft - hard) + noise * rng.normal(size=hard.shape)
        given = setting(TWO, TorqueSamples(motion, torque, np.full(torque.shape, noise**-2)))
        if declared:
            inputs = {"declared": (size * (soft - hard))[:, :, None].astype(np.float32)}
            log = replace(given.logs.logs[0], sloped=np.arange(len(torque)), session=inputs)
            logs = WearLogs([log], given.logs.joints, given.logs.names)
            given = replace(given, logs=logs)
        wear = starts(TWO, given.wires, ())[0]
        ours, other = (
            at(given, replace(wear, springs=np.array(each))) for each in ((110.0, 0.58, 0.58), (240.0, 0.65, 0.65))
        )
        found.append(profiles(given, ours, curved(ours))._against(lowered(given, other.wear)))
    spread = float(np.sqrt(np.mean(np.square(found))))
    assert (0.8 < spread < 1.2) if declared else spread > 2.0


@pytest.mark.slow
@drawn(60, 300)
def test_lengths_are_inside_as_often_as_stated_however_little_is_known_of_the_stiffness(draws):
    """A stiffness that is known to a quarter of itself."""
    k, taut_from, rng = 250.0, 0.62, np.random.default_rng(7)
    clean = bending(noise=1e-9, k=k, taut_from=taut_from, samples=200)
    unit = TorqueSamples(clean.motion, clean.torque, np.ones(clean.torque.shape))
    noise = 0.25 * k / np.sqrt(curved(found_in(unit)[1])[STIFFNESS, STIFFNESS])
    inside = []
    for _ in range(draws):
        torque = clean.torque + noise * rng.normal(size=clean.torque.shape)
        given, fit = found_in(TorqueSamples(clean.motion, torque, np.full(clean.torque.shape, noise**-2)))
        stretch = float(given.wires[0].longest - fit.wear.l_0[0])
        low, high = profiles(given, fit, curved(fit)).of_band(0, stretch)[1]
        inside.append(low <= taut_from <= high)
    least, most = met_in(0.95, draws)
    assert least <= np.mean(inside) <= most, np.mean(inside)
