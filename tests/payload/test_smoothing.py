"""[Payload] V: velocities and accelerations by a Kalman filter."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.payload.conftest import GRAVITY, arm, case, generator

from exogauge.payload.sensor_motion import Chain, from_pose
from exogauge.payload.smoothing import at_times, innovation_variance, likeliest, smooth

Array = NDArray[np.float64]

RATE, STD = 250.0, 2e-5
TIME = np.arange(2500) / RATE


def swing(kind: int) -> Array:
    """(T, 2) angle of two joints, or its derivative."""
    w = np.array([1.7, 3.1])
    phase = np.outer(TIME, w) + kind * np.pi / 2
    return np.asarray(0.5 * w**kind * np.sin(phase))


@pytest.fixture
def logged() -> Array:
    return swing(0) + STD * np.random.default_rng(1).standard_normal((len(TIME), 2))


@pytest.mark.parametrize("density", [10.0, 1e3])
def test_errors_are_what_the_impulse_responses_say(logged: Array, density: float) -> None:
    found = smooth(TIME, logged, STD, density=density)
    inner = slice(found.edge, -found.edge)
    for order in range(3):
        error = (found.state[:, :, order] - swing(order))[inner]
        told = np.linalg.norm(found.noise[0, order])
        assert np.sqrt(np.mean(error**2)) == pytest.approx(told, rel=0.12)


def test_the_covariance_between_rate_and_acceleration_is_told_too(logged: Array) -> None:
    found = smooth(TIME, logged, STD, density=1e3)
    error = np.array([found.state[:, :, k] - swing(k) for k in range(3)])[:, 50:-50].reshape(3, -1)
    told = found.noise[0] @ found.noise[0].T
    scale = np.sqrt(np.outer(np.diag(told), np.diag(told)))
    assert np.abs(np.cov(error) - told).max() / scale.max() < 0.1
    assert np.cov(error)[0, 2] / scale[0, 2] == pytest.approx(told[0, 2] / scale[0, 2], abs=0.1)


def test_likelihood_finds_the_density_and_the_noise_that_made_the_data() -> None:
    rng = np.random.default_rng(2)
    period, density = 1 / RATE, 50.0
    h = 1.0
    Q = np.array([[h**5 / 20, h**4 / 8, h**3 / 6], [h**4 / 8, h**3 / 3, h**2 / 2], [h**3 / 6, h**2 / 2, h]])
    ratio = density * period**5 / STD**2
    L = np.linalg.cholesky(ratio * Q)
    F = np.array([[1, h, h * h / 2], [0, 1, h], [0, 0, 1]])
    x, z = np.zeros(3), np.empty(4000)
    for k in range(len(z)):
        x = F @ x + L @ rng.standard_normal(3)
        z[k] = x[0] + rng.standard_normal()
    step = np.ones(len(z))
    found = likeliest(z, step)
    assert found == pytest.approx(ratio, rel=0.5)
    assert innovation_variance(z, step, found) == pytest.approx(1.0, abs=0.06)
    assert innovation_variance(1.3 * z, step, found) == pytest.approx(1.69, abs=0.1)


def test_lag_of_a_causal_filter_is_gone_after_a_tenth_of_a_second(logged: Array) -> None:
    error = {
        kind: np.sqrt(np.mean((smooth(TIME, logged, STD, kind=kind).state[:, :, 2] - swing(2))[100:-100] ** 2))  # type: ignore[arg-type]
        for kind in ("smoother", "fixed_lag", "causal")
    }
    assert error["causal"] > 3 * error["smoother"]
    assert error["fixed_lag"] == pytest.approx(error["smoother"], rel=0.05)


def test_what_stands_still_is_not_made_to_move() -> None:
    still = 0.3 + STD * np.random.default_rng(4).standard_normal((len(TIME), 1))
    found = smooth(TIME, still, STD, density=1e3)
    assert np.abs(found.state[100:-100, 0, 2]).max() < 1e-3


def test_missing_samples_are_stepped_over(logged: Array) -> None:
    keep = np.ones(len(TIME), dtype=bool)
    keep[1000:1005] = False
    found = smooth(TIME[keep], logged[keep], STD, density=10.0)
    error = found.state[:, :, 2] - swing(2)[keep]
    assert np.abs(error[100:-100]).max() < 1.0


@pytest.mark.parametrize("every", [1, 3])
def test_between_samples_errors_are_no_larger_than_the_noise_says(logged: Array, every: int) -> None:
    """At a third of the rate too, at times that belong to no sample."""
    found = smooth(TIME[::every], logged[::every], STD)
    at = np.linspace(1.0, 9.0, 1777)
    phase = np.outer(at, [1.7, 3.1])
    told = at_times(found, TIME[::every], at).state
    for order in range(3):
        true = 0.5 * np.array([1.7, 3.1]) ** order * np.sin(phase + order * np.pi / 2)
        error = np.sqrt(np.mean((told[:, :, order] - true) ** 2))
        at_samples = np.sqrt(np.mean((found.state[:, :, order] - swing(order)[::every])[60:-60] ** 2))
        assert error < 1.15 * at_samples


def test_a_pose_and_its_position_have_clocks_of_their_own() -> None:
    one = case(0)
    q, dq, ddq = one.exact
    time = np.arange(len(q)) / generator.RATE_HZ
    exact = Chain.of(arm(), "ft").motion(time, np.stack([q, dq, ddq], axis=2), np.zeros((6, 3, 3)), GRAVITY)
    a_B = np.einsum("tij,tj->ti", exact.rotation, exact.acceleration)
    position = np.cumsum(np.cumsum(a_B, axis=0), axis=0) / generator.RATE_HZ**2
    found = from_pose(
        time[::2], exact.rotation[::2], position[3::3], 1e-6, 1e-6, GRAVITY, at=time, position_time=time[3::3]
    )
    which = np.flatnonzero(np.isin(time, found.time))
    assert 0.8 * len(time) < len(which) < len(time)
    inner = slice(100, -100)
    assert np.abs(found.omega - exact.omega[which])[inner].max() < 1e-3
    assert np.abs(found.acceleration - exact.acceleration[which])[inner].max() < 0.1


def test_a_logged_pose_gives_what_joint_angles_give() -> None:
    one = case(0)
    q, dq, ddq = one.exact
    time = np.arange(len(q)) / generator.RATE_HZ
    exact = Chain.of(arm(), "ft").motion(time, np.stack([q, dq, ddq], axis=2), np.zeros((6, 3, 3)), GRAVITY)
    R, a, alpha, omega = exact.rotation, exact.acceleration, exact.alpha, exact.omega
    a_B = np.einsum("tij,tj->ti", R, a)
    position = np.cumsum(np.cumsum(a_B, axis=0), axis=0) / generator.RATE_HZ**2  # up to a straight line
    found = from_pose(time, R, position, 1e-6, 1e-6, GRAVITY)
    inner = slice(100, -100)
    assert np.abs(found.omega - omega)[inner].max() < 1e-3
    assert np.abs(found.alpha - alpha)[inner].max() < 0.02
    assert np.abs(found.acceleration - a)[inner].max() < 0.05
