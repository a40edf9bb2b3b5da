"""What single effects do, against loops, closed forms and their own claims about when they cannot be told."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from exogauge.effects.backlash import between_teeth
from exogauge.effects.band import relaxed
from exogauge.effects.catalogue import shaped_effects
from exogauge.effects.presliding import bristle
from exogauge.effects.shaped import AxisSignals, ManyShapes
from exogauge.search.candidates import grid

EFFECTS = shaped_effects()


def axis(t, q, load, drive=None, temperature=None):
    v = np.gradient(q, t)
    return AxisSignals(
        t, q, v, np.gradient(v, t), np.sign(v), load if drive is None else drive, load, temperature,
        float(np.sqrt(np.mean(v**2))), float(np.sqrt(np.mean(load**2))), float(np.ptp(q)),
    )  # fmt: skip


def test_what_relaxes_is_stepped_sample_by_sample():
    rng = np.random.default_rng(3)
    kept, gained = rng.uniform(0.2, 1.0, 777), rng.normal(size=777)
    x, slow = 0.0, []
    for a, b in zip(kept, gained, strict=True):
        x = a * x + b
        slow.append(x)
    np.testing.assert_allclose(relaxed(kept, gained), slow, rtol=1e-10, atol=1e-12)


def test_presliding_friction_builds_up_exponentially_with_the_way_and_turns_over_twice_that():
    t = np.linspace(0.0, 2.0, 2001)
    q = np.where(t < 1.0, t, 2.0 - t)  # one radian there and back, range 1 rad
    F = EFFECTS["presliding"].columns(axis(t, q, np.sin(q)), (0.05, 1.0))[:, 0]
    np.testing.assert_allclose(F[:1001], -(1.0 - np.exp(-q[:1001] / 0.05)), atol=1e-9)
    back = 1.0 - q[1000:]
    np.testing.assert_allclose(F[1000:], 1.0 - 2.0 * np.exp(-back / 0.05), atol=1e-6)


@pytest.mark.parametrize("n", [1.0, 1.3, 2.0])
def test_presliding_is_dahls_law_integrated_step_by_step(n):
    pace = np.where(np.arange(100_000) // 20_000 == 2, 0.0, 25.0 / 100_000)  # runs, rests, runs on
    phase = np.cumsum(pace)
    q = np.sin(phase) + 0.8 * np.sin(2.7 * phase)
    x, slow = 0.0, [0.0]
    for dw in np.diff(q).tolist():
        x += (1.0 - x * np.sign(dw)) ** n * dw
        slow.append(x)
    np.testing.assert_allclose(bristle(q, n), slow, atol=1e-3)


def test_presliding_does_not_depend_on_how_fast_the_way_is_covered():
    slow, fast = np.linspace(0.0, 20.0, 2001), np.linspace(0.0, 2.0, 2001)
    q = np.sin(np.linspace(0.0, 9.0, 2001))
    columns = [EFFECTS["presliding"].columns(axis(t, q, q), (0.1, 1.4)) for t in (slow, fast)]
    np.testing.assert_allclose(columns[0], columns[1], atol=1e-12)


def one_body(pull, back, tooth, damping, drag, step):
    s, s_ddot = between_teeth(pull[:, None], back, tooth[:, None], damping[:, None], drag[:, None], step)
    return s[:, 0], s_ddot[:, 0]


def swinging(t: np.ndarray) -> np.ndarray:
    return 900.0 * np.sin(2.0 * np.pi * 0.7 * t) + 150.0 * np.cos(9.0 * t)


@pytest.mark.parametrize("drag", [0.0, 4.0])
def test_a_body_between_teeth_moves_as_another_solver_says(drag: float) -> None:
    t, omega, zeta, back = np.arange(0.0, 3.0, 0.005), 2.0 * np.pi * 30.0, 0.25, 12.0
    even = np.ones_like(t)
    s, s_ddot = one_body(swinging(t), back * even, omega**2 * even, 2.0 * zeta * omega * even, drag * even, t[1])

    def law(time: float, x: np.ndarray) -> list[float]:
        over = max(x[0] - 1.0, 0.0) + min(x[0] + 1.0, 0.0)
        tooth = omega**2 * over + 2.0 * zeta * omega * x[1] * (over != 0.0)
        return [x[1], swinging(time) - back * x[0] - drag * x[1] - tooth]

    fine = np.linspace(0.0, t[-1], 20 * (len(t) - 1) + 1)
    start = [1.0 + swinging(0.0) / omega**2, 0.0]
    x = solve_ivp(law, (0.0, t[-1]), start, t_eval=fine, rtol=1e-9, atol=1e-9, max_step=1e-3).y
    place = x[0, :-1].reshape(-1, 20).mean(axis=1)
    assert np.count_nonzero(np.diff(np.sign(place))) >= 4
    assert np.sqrt(np.mean((s[:-1] - place) ** 2)) < 0.02
    gained = np.cumsum(s_ddot[:-1]) * t[1]
    assert np.sqrt(np.mean((gained - x[1, 20::20]) ** 2)) < 0.03 * np.abs(x[1]).max()


@pytest.mark.slow
def test_bodies_side_by_side_move_as_each_would_alone() -> None:
    t, frequencies = np.arange(0.0, 3.0, 0.005), (12.0, 30.0, 55.0)
    even, omegas = np.ones((len(t), 1)), 2.0 * np.pi * np.array(frequencies)
    pull = swinging(t)[:, None] * np.array([1.0, 0.4, 2.0])
    each = pull, 5.0 * np.cos(t), omegas**2 * even, 0.4 * omegas * even, np.array([0.0, 2.0, 5.0]) * even
    together = between_teeth(*each, t[1])
    for k in range(len(frequencies)):
        alone = one_body(*(values if values.ndim == 1 else values[:, k] for values in each), t[1])
        assert np.count_nonzero(np.diff(np.sign(alone[0]))) >= 4, "it never crosses the gap: this shows nothing"
        np.testing.assert_array_equal([one[:, k] for one in together], alone)


def test_a_flight_through_the_gap_takes_the_time_of_a_free_fall() -> None:
    """Pull -a from side +1: two units of way in sqrt(4 / a) seconds, then rest near -1."""
    t, a = np.arange(0.0, 2.0, 1e-3), 40.0
    even, fall = np.ones_like(t), np.sqrt(4.0 / 40.0)
    s, _ = one_body(np.where(t < 0.5, 1.0, -a), 0.0 * t, 4e4 * even, 200.0 * even, 0.0 * t, t[1])
    inside = (t >= 0.5) & (t < 0.5 + fall - 0.002)
    np.testing.assert_allclose(s[inside], 1.0 - 0.5 * a * (t[inside] - 0.5) ** 2, atol=0.02)
    np.testing.assert_allclose(s[t < 0.499], 1.0, atol=1e-3)
    np.testing.assert_allclose(s[t > 0.5 + fall + 0.3], -1.0, atol=2e-3)


def test_a_pull_that_comes_back_in_time_keeps_the_flank() -> None:
    t = np.arange(0.0, 3.0, 1e-3)
    even = np.ones_like(t)
    s, _ = one_body(np.where((t > 1.0) & (t < 1.05), -50.0, 50.0), 0.0 * t, 4e4 * even, 200.0 * even, 0.0 * t, t[1])
    assert s.min() > 0.5
    assert s[-1] == pytest.approx(1.0, abs=2e-3)


def test_no_pull_at_all_moves_nothing_from_its_tooth() -> None:
    even = np.ones(50)
    s, s_ddot = one_body(0.0 * even, 0.0 * even, 4e4 * even, 200.0 * even, even, 0.005)
    np.testing.assert_allclose(s, 1.0, rtol=1e-12)
    np.testing.assert_array_equal(s_ddot, 0.0)


def test_a_drive_that_comes_late_by_some_milliseconds_is_its_own_rate_of_change():
    t = np.arange(0.0, 10.0, 0.005)
    u = 5.0 * np.sin(2.0 * np.pi * 0.8 * t) + 2.0 * np.sin(2.0 * np.pi * 1.7 * t + 1.0)
    late = 5.0 * np.sin(2.0 * np.pi * 0.8 * (t - 0.006)) + 2.0 * np.sin(2.0 * np.pi * 1.7 * (t - 0.006) + 1.0)
    column = EFFECTS["torque_delay"].columns(axis(t, np.sin(t), u), ())[:, 0]
    assert (column @ (late - u)) / (column @ column) == pytest.approx(0.006, rel=0.01)


def test_friction_falls_with_the_logged_temperature_and_without_one_with_time():
    t = np.arange(0.0, 100.0, 0.05)
    warm = axis(t, np.sin(t), np.sin(t), temperature=np.full(len(t), 35.0))
    thermal = EFFECTS["thermal_viscous"]
    np.testing.assert_allclose(thermal.columns(replace(warm, temperature=np.full(len(t), 25.0)), (50.0, 0.03)), 0.0)
    for beta in (0.0, 0.03, 0.09):
        shares = [
            thermal.columns(replace(warm, temperature=np.full(len(t), at)), (50.0, beta))[:, 0] / warm.velocity
            for at in (35.0, 45.0)
        ]
        np.testing.assert_allclose(shares[0], 1.0)
        np.testing.assert_allclose(shares[1], 1.0 + np.exp(-10.0 * beta))
    unknown = replace(warm, temperature=None)
    np.testing.assert_allclose(
        thermal.columns(unknown, (50.0, 0.03))[:, 0], unknown.velocity * (1.0 - np.exp(-t / 50.0))
    )


def test_grease_follows_a_thermometer_that_jumps_with_its_time_constant():
    t = np.arange(0.0, 100.0, 0.01)
    jump = axis(t, t, np.sin(t), temperature=np.where(t < 20.0, 25.0, 35.0))
    taken = EFFECTS["thermal_viscous"].columns(jump, (30.0, 0.0))[:, 0] / jump.velocity
    expected = np.where(t < 20.0, 25.0, 35.0 - 10.0 * np.exp(-(t - 20.0) / 30.0))
    np.testing.assert_allclose(25.0 + 10.0 * taken, expected, atol=0.01)


def test_drift_has_no_mean_in_any_log():
    t = np.arange(0.0, 33.0, 0.01)
    columns = EFFECTS["torque_offset_drift"].columns(axis(t, np.sin(t), np.sin(t)), (7.0,))
    np.testing.assert_allclose(columns.mean(axis=0), 0.0, atol=1e-12)


def test_ripple_on_half_a_turn_of_motion_has_twice_as_many_cycles_in_a_revolution():
    t = np.arange(0.0, 20.0, 0.005)
    q = 0.5 * np.pi * np.sin(t)
    ripple = np.sin(24.0 * q + 0.4)
    columns = EFFECTS["torque_ripple"].columns(axis(t, q, np.sin(q)), (24.0 * float(np.ptp(q)) / (2.0 * np.pi),))
    left = ripple - columns @ np.linalg.lstsq(columns, ripple, rcond=None)[0]
    assert np.abs(left).max() < 1e-9


@pytest.mark.parametrize(
    ("effect", "load", "why"),
    [
        ("load_coulomb", lambda q, t: 5.0 + 0.0 * t, "one load is Coulomb friction"),
        ("backlash", lambda q, t: 5.0 + np.sin(q), "the load never turns"),
        ("elasticity", lambda q, t: np.sin(2.0 * np.pi * 0.1 * t), "slow against any resonance"),
    ],
)
def test_it_is_not_looked_for_where_it_cannot_be_told(effect, load, why):
    t = np.arange(0.0, 30.0, 0.005)
    q = np.sin(2.0 * np.pi * 0.3 * t)
    assert not EFFECTS[effect].applies(axis(t, q, load(q, t))), why
    rich = 3.0 * np.sin(2.0 * np.pi * 1.5 * t)
    assert EFFECTS[effect].applies(axis(t, q, rich))


def test_a_gear_that_gives_way_under_a_weight_is_looked_for_in_slow_motion_too():
    """Where it hangs lower gravity asks for less: 30 N·m, at an inertia of 1 kg·m², bend 5 Hz by 0.03 rad."""
    t = np.arange(0.0, 60.0, 0.005)
    q = 1.2 * np.sin(2.0 * np.pi * 0.1 * t)
    light = axis(t, q, 30.0 * np.sin(q))
    assert not EFFECTS["elasticity"].applies(light)
    heavy = replace(light, inertia=np.ones(len(t)), slope=30.0 * np.cos(q), usual_inertia=1.0)
    assert EFFECTS["elasticity"].applies(heavy)
    lacking = EFFECTS["elasticity"].columns(heavy, (5.0, 0.15, 0.0, 2.0))[:, 0] / (2.0 * np.pi * 5.0) ** 2
    k = (2.0 * np.pi * 5.0) ** 2
    np.testing.assert_allclose(
        lacking[400:], (30.0 * np.cos(q) * 30.0 * np.sin(q) / (k + 30.0 * np.cos(q)))[400:], atol=0.02
    )


def test_warmth_is_not_looked_for_in_a_short_log_without_a_thermometer():
    t = np.arange(0.0, 15.0, 0.01)
    brief = axis(t, np.sin(t), np.sin(t))
    assert not EFFECTS["thermal_viscous"].applies(brief)
    assert EFFECTS["thermal_viscous"].applies(replace(brief, temperature=20.0 + t))
    assert not EFFECTS["thermal_viscous"].applies(replace(brief, temperature=np.where(t < 1.0, np.nan, 20.0)))


def test_a_ripple_of_the_motors_turns_is_seen_in_what_a_model_leaves():
    """100 cycles per revolution, at a fifth of the noise, in two logs of different places."""
    rng = np.random.default_rng(5)
    t = np.arange(0.0, 60.0, 0.02)
    q = np.concatenate([0.9 * np.sin(0.3 * t), 0.3 + 0.5 * np.sin(0.2 * t)])
    residual = 0.1 * np.sin(100.0 * q + 1.0) + 0.5 * rng.normal(size=len(q))
    span = float(np.ptp(q))
    first, *_ = EFFECTS["torque_ripple"].promising(q, residual, span)
    assert 2.0 * np.pi * first / span == pytest.approx(100.0, abs=1.5)
    both = EFFECTS["torque_ripple"].promising(q, residual + 0.1 * np.cos(31.0 * q), span, 2)
    assert sorted(2.0 * np.pi * np.array(both) / span) == pytest.approx([31.0, 100.0], abs=1.5)
    assert EFFECTS["torque_ripple"].promising(q[:0], q[:0], span) == ()
    assert EFFECTS["torque_ripple"].promising(q[:9], np.zeros(9), span) == ()


@pytest.mark.parametrize("name", [name for name, each in EFFECTS.items() if isinstance(each, ManyShapes)])
def test_all_shapes_at_once_are_each_shape_by_itself(name: str) -> None:
    t = np.arange(0.0, 20.0, 0.005)
    seen = axis(t, np.sin(1.7 * t) + 0.4 * np.sin(4.1 * t), 6.0 * np.sin(np.sin(1.7 * t)) + np.cos(4.1 * t))
    uneven = [tuple(one.at(share) for one in EFFECTS[name].shapes) for share in (0.2, 0.25, 0.7)]
    for shapes in (list(grid(EFFECTS[name])), uneven):
        alone = np.concatenate([EFFECTS[name].columns(seen, shape) for shape in shapes], axis=1)
        together = EFFECTS[name].columns_of_all(seen, shapes)
        np.testing.assert_allclose(together, alone.T, rtol=0.0, atol=1e-12 * np.abs(alone).max())
