"""The link on the gear's spring, against an integrator of its own."""

import numpy as np
from scipy.integrate import solve_ivp

from exogauge.effects.elasticity import deflection


def test_the_link_swings_on_its_spring_as_a_finer_integration_says():
    t = np.arange(0.0, 6.0, 0.005)

    def load(time):
        return 8.0 * np.sin(2.0 * time) + 3.0 * np.sin(9.0 * time + 1.0)

    def inertia(time):
        return 0.6 + 0.3 * np.sin(1.5 * time)

    def stiffness(time):
        return 900.0 + 60.0 * np.cos(1.1 * time)

    def swing(time, state):
        r, speed = state
        return [speed, (-load(time) - 4.0 * speed - stiffness(time) * r) / inertia(time)]

    rest = -load(0.0) / stiffness(0.0)
    fine = solve_ivp(swing, (0.0, t[-1]), [rest, 0.0], t_eval=t, rtol=1e-9, atol=1e-12).y[0]
    found = deflection(load(t), inertia(t), 4.0, stiffness(t), 0.005)
    assert np.abs(found - fine).max() < 0.01 * np.abs(fine).max()


def test_under_a_constant_load_it_stays_where_the_spring_holds_it():
    steady = np.ones(50)
    np.testing.assert_allclose(deflection(5.0 * steady, steady, 2.0, 400.0 * steady, 0.01), -5.0 / 400.0, rtol=1e-9)
