"""What is hidden obeys the physics it stands for, and is as large as the answers say."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import butter, sosfreqz
from tests.blind.conftest import plan

from exogauge.blind.generator.hidden.backlash import Backlash, Elasticity
from exogauge.blind.generator.hidden.bodies import BaseTilt, Contact, Payload
from exogauge.blind.generator.hidden.friction import Presliding, bristle
from exogauge.blind.generator.hidden.kinds import ELSEWHERE, IN_BANDS, IN_LOGS, ON_JOINTS
from exogauge.blind.generator.hidden.log_filter import BandLimitedLog
from exogauge.blind.generator.hidden.motor import TorqueDelay, late
from exogauge.blind.generator.motion import RATE_HZ
from exogauge.blind.generator.placed import HowLarge, Placed, clutter, hide, motor_torque, pull, sensed
from exogauge.blind.generator.places import poses
from exogauge.blind.generator.robot_kind import ARM, TORSO

SOME = HowLarge(1.0, 1.0, 1.0, "tau.joint_2")
FRICTION = ("stribeck", "load_coulomb", "nonlinear_viscous")


@pytest.mark.parametrize("name", [name for name, kind in ON_JOINTS.items() if kind.linear])
def test_twice_the_size_is_twice_the_torque(arm6, name: str) -> None:
    run = arm6.runs[1]
    effect = ON_JOINTS[name].draw(np.random.default_rng(3), run)
    once, twice = effect.torque(run, 0.1), effect.torque(run, 0.2)
    np.testing.assert_allclose(twice, 2.0 * once, atol=1e-12)
    assert np.abs(once).max() > 0.0


@pytest.mark.parametrize("name", FRICTION)
def test_friction_takes_power_and_gives_none(arm6, name: str) -> None:
    run = arm6.runs[1]
    for seed in range(5):
        torque = ON_JOINTS[name].draw(np.random.default_rng(seed), run).torque(run, 0.1)
        assert np.all(torque * run.dq >= 0.0)


@pytest.mark.parametrize("name", ["asym_viscous", "thermal_viscous"])
def test_viscous_friction_stays_friction_however_much_is_hidden(arm6, name: str) -> None:
    run = arm6.runs[1]
    for seed in range(5):
        effect = ON_JOINTS[name].draw(np.random.default_rng(seed), run)
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
    effect, gap = Backlash(30.0, 0.3, 0.2, 1.2), 0.006
    k, I, K = (2 * np.pi * 30.0) ** 2 * 0.8, 0.8, 5.0  # noqa: E741
    c, give = 2 * 0.3 * np.sqrt(k * I), np.sqrt(2.0 * np.sqrt(np.mean(load**2)) * gap / I) / (2 * np.pi * 30.0)

    def law(t: float, state: np.ndarray) -> list[float]:
        r, v = state
        over = r - np.clip(r, -gap / 2, gap / 2)
        damping = (c if over else 0.0) + 0.02 * c
        tooth = k * over * (1.0 + 0.2 * (np.exp(1.2 * abs(over) / give) - 1.0) / (np.exp(1.2) - 1.0))
        return [v, -(tooth + damping * v + np.interp(t, time, load[0]) + K * r) / I]

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
    run, absorbing = arm6.runs[1], arm6.baselines[1]
    own = 3.0 * run.dq + 2.0 * run.ddq + 4.0
    assert absorbing.excess(own) < 1e-9
    assert absorbing.excess(1.2 * run.load) < 0.01 * np.sqrt(np.mean(run.load**2))
    assert absorbing.excess(run.direction) < 0.02


SLOW = ("backlash", "elasticity")


@pytest.mark.parametrize("name", [name for name in ON_JOINTS if name not in SLOW])
def test_what_is_hidden_in_a_joint_is_as_large_as_the_answer_says(arm6, name: str) -> None:
    (placed,) = hide(np.random.default_rng(8), plan(ARM, name), arm6)
    every = range(6) if placed.joint is None else [placed.joint]
    more = {j: motor_torque(arm6.runs[j], [placed], j) - arm6.runs[j].motor for j in range(6)}
    look = {j: arm6.baselines[j].held if name == "kt_gain" else arm6.baselines[j].excess for j in every}
    ratios = [look[j](more[j]) / arm6.floors[j] for j in every]
    stated = [placed.size / 0.02] if name == "kt_gain" else []
    assert min(max(ratios), *stated, np.inf) == pytest.approx(placed.found.ratio, rel=1e-6)
    largest = min(placed.effect.largest(arm6.runs[j]) for j in every)
    assert placed.found.ratio == pytest.approx(2.0, rel=0.1) or placed.size in (largest, 0.05)
    for j in set(range(6)) - set(every):
        assert np.all(more[j] == 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", [*ELSEWHERE, IN_LOGS])
def test_what_is_hidden_elsewhere_shows_where_the_answer_says(torso8, name: str) -> None:
    """What is put into the logs leaves the ratio of the answer on the channel of the answer."""
    (placed,) = hide(np.random.default_rng(8), plan(TORSO, name), torso8)
    assert placed.found.ratio > 0.3
    kind, channel = placed.found.channel.split(".", 1)
    if name == IN_LOGS:
        assert kind == "tau"
        return
    more, felt = pull(torso8, [placed]), sensed(torso8, [placed]) - torso8.wrench
    believed = placed.effect.believed(torso8)
    on = placed.effect.change(torso8, placed.size).on
    if kind == "tau":
        joint = torso8.joints.index(channel)
        look = torso8.baselines[joint].excess if believed is None else torso8.baselines[joint].held
        ratio = look(more[:, :, joint], on) / torso8.floors[joint]
    else:
        look = torso8.cut_baseline.excess if believed is None else torso8.cut_baseline.held
        ratio = look(felt, on)[["mount.fx", "mount.fy", "mount.fz", "mount.mx", "mount.my", "mount.mz"].index(channel)]
    assert min(ratio, placed.size / believed if believed else np.inf) == pytest.approx(placed.found.ratio, rel=1e-6)
    if name in IN_BANDS:
        assert np.all(felt == 0.0), "a worn band is an internal force: the sensor below does not feel it"
    if name.startswith("ft_"):
        assert more is None, "a sensor's fault moves no joint"


@pytest.mark.parametrize("name", [name for name, kind in ELSEWHERE.items() if kind.linear])
def test_twice_the_size_is_twice_the_change(torso8, name: str) -> None:
    kind = ELSEWHERE[name]
    effect = kind.draw(np.random.default_rng(3), torso8, kind.places(torso8)[0])
    once, twice = effect.change(torso8, 0.1), effect.change(torso8, 0.2)
    pairs = [(a, b) for a, b in ((once.torque, twice.torque), (once.wrench, twice.wrench)) if a is not None]
    assert pairs
    for a, b in pairs:
        assert np.abs(a).max() > 0.0
        np.testing.assert_allclose(b, 2.0 * a, atol=1e-12)


def test_a_payload_weighs_on_the_wrist_from_its_log_on(arm6) -> None:
    change = Payload("tool", (0.01, 0.02, 0.03), since=2).change(arm6, 0.7)
    assert np.all(change.wrench[:2] == 0.0)
    assert np.all(change.torque[:2] == 0.0)
    resting = np.all(arm6.motion.dq == 0.0, axis=2)[2:]
    np.testing.assert_allclose(np.linalg.norm(change.wrench[2:][resting][:, :3], axis=1), 0.7 * 9.81, rtol=1e-9)


def test_a_push_does_the_same_work_on_joints_as_on_the_point(torso8) -> None:
    """Power of the force at the point is the power that joints do not have to give."""
    effect = Contact("l_forearm", (0.01, 0.02, -0.1), (0.6, 0.0, 0.8), ((1, 5.0, 0.8),), 1.0, 20.0)
    change = effect.change(torso8, 20.0)
    tree, motion = torso8.robot.tree, torso8.motion
    at = poses(tree, motion.q[1]).at((tree.names.index("l_forearm"), np.array(effect.place)))
    speed = np.gradient(at, 1.0 / RATE_HZ, axis=0)
    power = np.sum(change.wrench[1, :, :3] * speed, axis=1)
    given = -np.sum(change.torque[1] * motion.dq[1], axis=1)
    np.testing.assert_allclose(given, power, atol=0.02 * np.abs(power).max() + 1e-3)
    assert np.abs(power).max() > 0.1
    np.testing.assert_allclose(np.linalg.norm(change.wrench[1, :, :3], axis=1).max(), 20.0, rtol=1e-3)
    assert change.on.sum() == round(0.8 * RATE_HZ)


def test_a_coupled_motor_takes_from_both_joints_the_power_that_it_loses(arm6) -> None:
    kind = ELSEWHERE["coupling"]
    for seed, where in enumerate(kind.places(arm6)):
        effect = kind.draw(np.random.default_rng(seed), arm6, where)
        torque, dq = effect.change(arm6, 0.3).torque, arm6.motion.dq
        w = dq[:, :, effect.own] + effect.ratio * dq[:, :, effect.other]
        assert arm6.joints[effect.own] == where["joint"]
        assert effect.own == effect.other + 1, "the arm is a chain"
        np.testing.assert_allclose(np.sum(torque * dq, axis=2), torque[:, :, effect.own] * w, atol=1e-12)
        if not effect.inertial:
            assert np.all(torque[:, :, effect.own] * w >= 0.0)
            assert np.all(torque[w == 0.0] == 0.0)


def test_a_leaning_base_turns_gravity_and_nothing_else(arm6) -> None:
    lean = BaseTilt(0.7)
    up = lean.up(0.05)
    np.testing.assert_allclose(np.linalg.norm(up), 9.81)
    np.testing.assert_allclose(np.arccos(up[2] / 9.81), 0.05)
    change = lean.change(arm6, 0.05)
    assert np.sqrt(np.mean(change.torque[:, :, 0] ** 2)) > 0.1, "joint 1 carries no weight on an upright base"
    np.testing.assert_allclose(
        np.linalg.norm((arm6.wrench + change.wrench)[:, 0, :3], axis=1), np.linalg.norm(arm6.wrench[:, 0, :3], axis=1)
    )


def test_a_spring_in_a_joint_gives_way_by_the_load_over_its_stiffness(arm6) -> None:
    """A load that rises slowly: the link's shift changes its load by gravity's slope times the shift."""
    samples = 1600
    time = np.arange(samples) / RATE_HZ
    ones = np.ones((1, samples))
    load = 4.0 * np.sin(2 * np.pi * 0.25 * time)[None]
    run = replace(arm6.runs[0], q=0 * ones, load=load, inertia=0.5 * ones, stiffness=6.0 * ones, time=time)
    size = (2 * np.pi * 15.0) ** -2
    felt = Elasticity(0.3, 0.0, 1.0).torque(run, size)[0]
    k = 0.5 / size
    np.testing.assert_allclose(felt[200:-1], (-6.0 * load / (k + 6.0))[0, 200:-1], atol=0.02 * 6.0 * 4.0 / k + 2e-3)


@pytest.mark.parametrize("there_and_back", [False, True])
def test_a_stored_log_is_low_passed_alike_in_all_signals(arm6, there_and_back: bool) -> None:
    """So a linear law between two signals still holds; and what is far above the cut-off is gone."""
    effect = BandLimitedLog(None, 2, "butter", there_and_back)
    q, load = arm6.motion.q[0, :, 1], arm6.runs[1].load[0]
    together = effect.filtered(2.0 * q + load, 1 / 3.0)
    np.testing.assert_allclose(together, 2.0 * effect.filtered(q, 1 / 3.0) + effect.filtered(load, 1 / 3.0), atol=1e-9)
    quick = np.sin(2 * np.pi * 30.0 * arm6.motion.time)
    assert np.abs(effect.filtered(quick, 1 / 3.0)[200:-200]).max() < 0.02
    np.testing.assert_allclose(effect.filtered(np.full(500, 3.0), 1 / 3.0), 3.0)


def test_clutter_is_small_beside_known_bodies_and_beside_the_noise_that_a_low_pass_leaves(arm6) -> None:
    """White noise behind a filter: its power is the mean of the squared gain."""
    low_pass = BandLimitedLog(None, 2, "butter", False)
    gain = np.abs(sosfreqz(butter(2, 4.0, fs=RATE_HZ, output="sos"), 20_000)[1])
    left = np.sqrt(np.mean(gain**2))
    everywhere = Placed(low_pass, None, {"log": "all"}, 1 / 4.0, SOME)
    for hidden, noise in ([], 1.0), ([everywhere], left):
        small = clutter(np.random.default_rng(5), arm6, hidden)
        assert len(small) == 12
        for each in small:
            torque = each.effect.torque(arm6.runs[each.joint], each.size)
            baseline, floor = arm6.baselines[each.joint], arm6.floors[each.joint] * noise
            assert baseline.held(torque) < 0.501 * floor
            assert baseline.excess(torque) < 0.251 * floor


def test_what_the_log_reports_is_changed_last(arm6) -> None:
    """A delayed current carries the hidden torque as late as all else, in whatever order both are told."""
    run = arm6.runs[1]
    spring = ON_JOINTS["joint_spring"].draw(np.random.default_rng(1), run)
    delay = Placed(TorqueDelay(lag=False), 1, {"joint": "joint_2"}, 4 / RATE_HZ, SOME)
    pull = Placed(spring, 1, {"joint": "joint_2"}, 2.0, SOME)
    for order in ([delay, pull], [pull, delay]):
        torque = motor_torque(run, order, 1)
        np.testing.assert_allclose(torque[:, 4:], (run.motor + spring.torque(run, 2.0))[:, :-4], atol=1e-9)
