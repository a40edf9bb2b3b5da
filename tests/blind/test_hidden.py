"""What is hidden obeys the physics it stands for, and is as large as the answers say."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from exogauge.blind.generator.arm import ARM
from exogauge.blind.generator.hidden.backlash import Backlash
from exogauge.blind.generator.hidden.kinds import KINDS
from exogauge.blind.generator.hidden.motor import TorqueDelay, late
from exogauge.blind.generator.hidden.presliding import Presliding, bristle
from exogauge.blind.generator.motion import RATE_HZ
from exogauge.blind.generator.placed import Bench, Placed, hide, motor_torque
from exogauge.blind.generator.plan import CasePlan

FRICTION = ("stribeck", "load_coulomb", "nonlinear_viscous")


@pytest.mark.parametrize("name", [name for name, kind in KINDS.items() if kind.linear])
def test_twice_the_size_is_twice_the_torque(arm6, name: str) -> None:
    run = arm6.runs[1]
    effect = KINDS[name].draw(np.random.default_rng(3), run)
    once, twice = effect.torque(run, 0.1), effect.torque(run, 0.2)
    np.testing.assert_allclose(twice, 2.0 * once, atol=1e-12)
    assert np.abs(once).max() > 0.0


@pytest.mark.parametrize("name", FRICTION)
def test_friction_takes_power_and_gives_none(arm6, name: str) -> None:
    run = arm6.runs[1]
    for seed in range(5):
        torque = KINDS[name].draw(np.random.default_rng(seed), run).torque(run, 0.1)
        assert np.all(torque * run.dq >= 0.0)


@pytest.mark.parametrize("name", ["asym_viscous", "thermal_viscous"])
def test_viscous_friction_stays_friction_however_much_is_hidden(arm6, name: str) -> None:
    run = arm6.runs[1]
    for seed in range(5):
        effect = KINDS[name].draw(np.random.default_rng(seed), run)
        total = run.drive.k_d * run.dq + effect.torque(run, effect.largest(run)) + run.drive.tau_c * run.direction
        assert np.all(total * run.dq >= 0.0)


@pytest.mark.parametrize("power", [1.2, 1.6])
def test_a_bristle_solves_its_own_law(power: float) -> None:
    """dF/dx = (1 - F sgn dx)^power / way, integrated by another solver along a path with turns and a rest."""
    time = np.linspace(0.0, 6.0, 1201)
    q = 0.05 * np.sin(2.1 * time) + 0.01 * np.sin(5.3 * time)
    q[400:500], q[500:] = q[400], q[500:] - q[500] + q[400]
    way, force = 0.004, [0.0]
    for start, stop in pairwise(q):
        sign = np.sign(stop - start)
        if sign == 0.0:
            force.append(force[-1])
            continue
        law = solve_ivp(
            lambda x, F, sign=sign: (np.maximum(1.0 - F * sign, 0.0)) ** power / way, (start, stop), [force[-1]],
            rtol=1e-8, atol=1e-10,
        )  # fmt: skip
        force.append(float(law.y[0, -1]))
    np.testing.assert_allclose(bristle(q, way, power), force, atol=1e-5)


def test_bristles_end_as_coulomb_friction_and_never_exceed_it(arm6) -> None:
    run = arm6.runs[2]
    total = Presliding(1.4, 0.3, 3.0).torque(run, 0.004) + run.friction
    assert np.abs(total).max() <= run.drive.tau_c
    fine = Presliding(1.4, 0.3, 3.0).torque(run, 1e-6)
    moving = np.abs(run.dq) > 0.05
    assert np.abs(fine[moving]).max() < 0.02 * run.drive.tau_c


def test_a_link_in_its_play_moves_as_two_masses_do(arm6) -> None:
    """Against an integrator with adaptive steps, over a stretch with changes of the load's sign, on smooth inertia."""
    samples = 200
    time = np.arange(samples) / RATE_HZ
    constant = np.ones((1, samples))
    load = 3.0 * np.cos(2 * np.pi * 0.8 * time)[None]
    fields = {"q": 0.0 * constant, "load": load, "inertia": 0.8 * constant, "stiffness": 5.0 * constant, "time": time}
    run = replace(arm6.runs[0], **fields)
    effect, gap = Backlash(30.0, 0.3), 0.006
    k, I, K = (2 * np.pi * 30.0) ** 2 * 0.8, 0.8, 5.0  # noqa: E741
    c = 2 * 0.3 * np.sqrt(k * I)

    def law(t: float, state: np.ndarray) -> list[float]:
        r, v = state
        over = r - np.clip(r, -gap / 2, gap / 2)
        damping = (c if over else 0.0) + 0.02 * c
        return [v, -(k * over + damping * v + np.interp(t, time, load[0]) + K * r) / I]

    start, fine = [-gap / 2 - load[0, 0] / k, 0.0], np.arange(10 * samples) / (10 * RATE_HZ)
    exact = solve_ivp(law, (0.0, fine[-1]), start, t_eval=fine, rtol=1e-8, atol=1e-12, max_step=1e-3)
    felt = np.array([I * law(t, y)[1] + K * y[0] for t, y in zip(fine, exact.y.T, strict=True)])
    expected, got = felt.reshape(samples, 10).mean(axis=1), effect.torque(run, gap)[0]
    assert np.abs(expected).max() > 1.0
    landing = np.exp(-0.5 * (np.arange(-12, 13) / 4.0) ** 2)  # a few milliseconds earlier or later are no matter
    close, exactly = (np.convolve(each, landing / landing.sum(), "same") for each in (got, expected))
    assert np.sqrt(np.mean((close - exactly) ** 2)) < 0.1 * np.sqrt(np.mean(exactly**2))


def test_a_delayed_log_is_the_undelayed_one_some_samples_later(arm6) -> None:
    run = arm6.runs[0]
    delayed = run.motor + TorqueDelay(lag=False).torque(run, 3 / RATE_HZ)
    np.testing.assert_allclose(delayed[:, 3:], run.motor[:, :-3], atol=1e-9)
    ramp = np.arange(2000.0)[None] / RATE_HZ
    lagging = late(ramp, 0.02, lag=True)
    np.testing.assert_allclose(ramp[0, -1] - lagging[0, -1], 0.02, atol=1.0 / RATE_HZ)


def test_a_baseline_absorbs_what_is_its_own(arm6) -> None:
    run, absorbing = arm6.runs[1], arm6.absorbing[1]
    own = 3.0 * run.dq + 2.0 * run.ddq + 4.0
    assert absorbing.excess(own) < 1e-9
    assert absorbing.excess(1.2 * run.load) < 0.01 * np.sqrt(np.mean(run.load**2))
    assert absorbing.excess(run.direction) < 0.02


def _bench(arm6) -> Bench:
    return Bench(arm6.runs, arm6.absorbing, [0.02 * run.drive.k_T for run in arm6.runs])


@pytest.mark.parametrize("name", [name for name in KINDS if name != "backlash"])
def test_what_is_hidden_is_as_large_as_the_answer_says(arm6, name: str) -> None:
    bench = _bench(arm6)
    plan = CasePlan(1, (name,), (2.0,), clutter=False, actuation="current", temperature=True, robot=ARM)
    (placed,) = hide(np.random.default_rng(8), plan, bench)
    joints = range(6) if placed.joint is None else [placed.joint]
    ratios = [
        bench.baselines[j].excess(motor_torque(arm6.runs[j], [placed], j) - arm6.runs[j].motor) / bench.floors[j]
        for j in joints
    ]
    assert max(ratios) == pytest.approx(placed.ratio, rel=1e-6)
    assert placed.ratio == pytest.approx(2.0, rel=0.1) or placed.size == placed.effect.largest(arm6.runs[joints[0]])
    others = [j for j in range(6) if not placed.on(j)]
    assert all(motor_torque(arm6.runs[j], [placed], j) is not None for j in others)
    for j in others:
        np.testing.assert_array_equal(motor_torque(arm6.runs[j], [placed], j), arm6.runs[j].motor)


def test_what_the_log_reports_is_changed_last(arm6) -> None:
    """A delayed current carries the hidden torque as late as all else, in whatever order both are told."""
    run = arm6.runs[1]
    spring = KINDS["joint_spring"].draw(np.random.default_rng(1), run)
    delay = Placed(TorqueDelay(lag=False), 1, 4 / RATE_HZ, 1.0, 1.0, 1.0)
    pull = Placed(spring, 1, 2.0, 1.0, 1.0, 1.0)
    for order in ([delay, pull], [pull, delay]):
        torque = motor_torque(run, order, 1)
        np.testing.assert_allclose(torque[:, 4:], (run.motor + spring.torque(run, 2.0))[:, :-4], atol=1e-9)
