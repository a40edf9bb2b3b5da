"""The link on the gear's spring, against an integrator of its own."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from exogauge.effects.catalogue import shaped_effects
from exogauge.effects.elasticity import deflection
from exogauge.effects.shaped import AxisSignals

T = np.arange(0.0, 6.0, 0.005)


def load(time):
    return 8.0 * np.sin(2.0 * time) + 3.0 * np.sin(9.0 * time + 1.0)


def inertia(time):
    return 0.6 + 0.3 * np.sin(1.5 * time)


def slope(time):
    return 60.0 * np.cos(1.1 * time)


def one_spring(load, inertia, damping, stiffness, harder, power, slope, step):
    numbers = (np.array([each]) for each in (damping, stiffness, harder, power))
    r, r_ddot = deflection(load, inertia, *numbers, slope[:, None], step)
    return r[:, 0], r_ddot[:, 0]


def integrated(k: float, d: float, cubic: float) -> tuple[np.ndarray, np.ndarray]:
    """r and its second derivative, by steps that SciPy chooses."""

    def swing(time, state):
        r, speed = state
        return [speed, (-load(time) - d * speed - (k * (1.0 + cubic * r**2) + slope(time)) * r) / inertia(time)]

    start = [np.roots([k * cubic, 0.0, k + slope(0.0), load(0.0)])[-1].real if cubic else -load(0.0) / (k + slope(0.0))]
    found = solve_ivp(swing, (0.0, T[-1]), [*start, 0.0], t_eval=T, rtol=1e-9, atol=1e-12).y
    return found[0], np.array([swing(*each)[1] for each in zip(T, found.T, strict=True)])


@pytest.mark.parametrize("cubic", [0.0, 3000.0])
def test_the_link_swings_on_its_spring_as_a_finer_integration_says(cubic: float):
    r, r_ddot = integrated(900.0, 4.0, cubic)
    found = one_spring(load(T), inertia(T), 4.0, 900.0, cubic, 2.0, slope(T), 0.005)
    stiffer = cubic * float(np.max(r**2))
    assert cubic == 0.0 or stiffer > 0.2, "the spring hardly stiffens: this shows nothing"
    assert np.abs(found[0] - r).max() < 0.01 * np.abs(r).max()
    assert np.abs(found[1] - r_ddot)[20:].max() < 0.03 * np.abs(r_ddot).max()


@pytest.mark.slow
def test_springs_side_by_side_give_way_as_each_would_alone():
    stiffness, harder, damping = np.array([500.0, 900.0, 4000.0]), np.array([0.0, 3000.0, 800.0]), np.array([1.0, 4, 9])
    slopes = slope(T)[:, None] * np.array([1.0, 0.0, 2.0])
    together = deflection(load(T), inertia(T), damping, stiffness, harder, np.full(3, 2.0), slopes, 0.005)
    for k in range(3):
        alone = one_spring(load(T), inertia(T), damping[k], stiffness[k], harder[k], 2.0, slopes[:, k], 0.005)
        np.testing.assert_array_equal([one[:, k] for one in together], alone)


@pytest.mark.parametrize("cubic", [0.0, 2000.0])
def test_under_a_constant_load_it_stays_where_the_spring_holds_it(cubic: float):
    steady = np.ones(50)
    r, r_ddot = one_spring(5.0 * steady, steady, 2.0, 400.0, cubic, 2.0, 0.0 * steady, 0.01)
    np.testing.assert_allclose(400.0 * r * (1.0 + cubic * r**2), -5.0, rtol=1e-9)
    np.testing.assert_allclose(r_ddot, 0.0, atol=1e-9)


@pytest.mark.slow
def test_an_elastic_gear_lacks_what_its_link_does_beside_the_motor():
    """gamma: by which share the spring is stiffer where it gives way as, were it straight, under the rms torque."""
    J, f, zeta, torque, gamma = 0.7, 6.0, 0.2, 4.0, 0.15
    omega = 2.0 * np.pi * f
    k, d, ones = J * omega**2, 2.0 * zeta * omega * J, np.ones(len(T))
    rise = np.clip(T, 0.0, 1.0)
    asked = rise * (5.0 * np.sin(9.0 * T) + 3.0 * np.sin(15.0 * T + 1.0))

    def swing(time, state):
        r, speed = state
        return [speed, (-np.interp(time, T, asked) - d * speed - k * r * (1.0 + gamma * (k * r / torque) ** 2)) / J]

    found = solve_ivp(swing, (0.0, T[-1]), [0.0, 0.0], t_eval=T, rtol=1e-8, atol=1e-12, max_step=2e-3).y
    expected = -(omega**2) * J * np.array([swing(*each)[1] for each in zip(T, found.T, strict=True)])
    seen = AxisSignals(T, 0 * T, 0 * T, 0 * T, 0 * T, asked, asked, None, 1.0, torque, 1.0, 0, ones * J, 0 * T, J)
    straight, bent = (shaped_effects()["elasticity"].columns(seen, (f, zeta, own, 2.0))[:, 0] for own in (0.0, gamma))
    settled = T > 1.0
    size = np.abs(expected[settled]).max()
    assert np.abs(straight - expected)[settled].max() > 0.1 * size, "the spring hardly stiffens: this shows nothing"
    assert np.abs(bent - expected)[settled].max() < 0.03 * size
