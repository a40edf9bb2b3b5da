"""Live: what comes out is what logs give, a tenth of a second later, and does not depend on how samples arrive."""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.payload.conftest import GRAVITY, STD, arm, case, generator

from exogauge.payload.contact import false_alarm_limit
from exogauge.payload.dynamics import batch, dynamic_rows, static_prior
from exogauge.payload.live import Known, Live, SecondZero, Sensed, Start
from exogauge.payload.live_fit import exciting
from exogauge.payload.live_track import Pose, Track
from exogauge.payload.sensor_motion import Chain, SensorMotion, from_joints, from_pose
from exogauge.payload.smoothing import smooth
from exogauge.synthetic.random_streams import stream

Array = NDArray[np.float64]
RATE, NOISE, DENSITY = generator.RATE_HZ, generator.ENCODER_NOISE, 5.0
JOINTS = Pose(Chain.of(arm(), "ft"), np.full(6, NOISE), np.full(6, DENSITY))


def start(seed: int) -> Start:
    static = case(seed).static
    believed = np.sqrt(np.diag(static_prior(None).covariance))
    return Start(JOINTS, static.gravity, -1, STD, static_prior(static), believed)


def run(live: Live, q: Array, wrench: Array, sizes: Sequence[int] = (1000,), first: float = 0.0):
    """(Sensed joined, list of Known)."""
    time, out, k, n = first + np.arange(len(q)) / RATE, [], 0, 0
    while k < len(q):
        size = sizes[n % len(sizes)]
        out += live.push(time[k : k + size], q[k : k + size], wrench[k : k + size])
        k, n = k + size, n + 1
    out += live.flush()
    return joined(out), [each for each in out if isinstance(each, Known)]


def joined(out: Sequence[Sensed | Known]) -> Sensed:
    parts = [each for each in out if isinstance(each, Sensed)]
    names = ("time", "wrench", "std", "alarm", "settled")
    return Sensed(*(np.concatenate([getattr(each, name) for each in parts]) for name in names), parts[-1].zero)


@cache
def excited(seed: int):
    """The live engine after ten seconds of excitation, with what it said."""
    live = Live(start(seed))
    return live, *run(live, *case(seed).excitation, sizes=(1,) if seed == 0 else (25,))


def wandering(samples: int, seed: int = 1) -> Array:
    """(T, 6) angles of all joints, with the encoders' noise."""
    rng, t = np.random.default_rng(seed), np.arange(samples) / RATE
    q = generator.WORK + 0.3 * np.sin(np.outer(t, rng.uniform(0.5, 2.5, 6)) + rng.uniform(0, 6, 6))
    return np.asarray(q + NOISE * rng.standard_normal(q.shape))


@pytest.mark.slow
def test_the_smoother_is_that_of_logs_with_a_fixed_lag() -> None:
    q = wandering(700)
    time = np.arange(len(q)) / RATE
    track = Track(JOINTS, RATE, GRAVITY, still="as_moving")
    parts = [track.push(time[k : k + 7], q[k : k + 7]).motion for k in range(0, len(q), 7)] + [track.flush().motion]
    found = np.concatenate([part.acceleration for part in parts])
    logged = from_joints(arm(), "ft", time, q, NOISE, GRAVITY, density=DENSITY, kind="fixed_lag")
    assert found == pytest.approx(logged.acceleration, abs=1e-8)
    assert parts[50].noise[-1] == pytest.approx(logged.noise[50 * 7 + 6 - 25], abs=1e-6)


def test_a_logged_pose_is_smoothed_like_one_in_a_log() -> None:
    q = wandering(500)
    time = np.arange(len(q)) / RATE
    exact = Chain.of(arm(), "ft").motion(
        time, smooth(time, q, NOISE, density=DENSITY).state, np.zeros((6, 3, 3)), GRAVITY
    )
    position = (
        np.cumsum(np.cumsum(np.einsum("tij,tj->ti", exact.rotation, exact.acceleration), axis=0), axis=0) / RATE**2
    )
    told = from_pose(time, exact.rotation, position, 1e-6, 1e-6, GRAVITY, density=DENSITY, kind="fixed_lag")
    assert told.density is not None
    turning = smooth(time, exact.rotation.reshape(-1, 9), 1e-6, kind="fixed_lag").density
    pose = Pose(None, np.full(12, 1e-6), np.concatenate([np.full(9, turning.max()), np.full(3, DENSITY)]))
    track = Track(pose, RATE, GRAVITY, still="as_moving")
    tracked = track.push(time, np.column_stack([exact.rotation.reshape(-1, 9), position]))
    motion, settled = tracked.motion, tracked.settled
    which = settled & (np.arange(len(settled)) > 100)
    assert motion.acceleration[which] == pytest.approx(told.acceleration[: len(settled)][which], abs=0.01)
    assert motion.omega[which] == pytest.approx(told.omega[: len(settled)][which], abs=1e-3)
    assert motion.noise.shape == (len(settled), 9, 18)


@pytest.mark.slow
def test_what_comes_out_does_not_depend_on_how_many_came_at_once() -> None:
    _, one, known = excited(0)
    other, known_other = run(Live(start(0)), *case(0).excitation, sizes=(3, 100, 1, 26))
    for name in ("time", "wrench", "std", "alarm", "settled"):
        assert getattr(one, name) == pytest.approx(getattr(other, name), rel=1e-8, abs=1e-9)
    assert len(known) == len(known_other) == 100
    for a, b in zip(known, known_other, strict=True):
        assert a.estimate.value == pytest.approx(b.estimate.value, rel=1e-8, abs=1e-9)
        assert (a.estimate.state, a.time, a.left_out) == (b.estimate.state, b.time, b.left_out)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_after_ten_seconds_the_recursion_is_the_batch(seed: int) -> None:
    """Of the same rows: those that excite, as the tracker gives them."""
    live, _, known = excited(seed)
    first, track = start(seed), Track(JOINTS, RATE, case(seed).static.gravity)
    tracked = track.push(np.arange(2500) / RATE, case(seed).excitation[0])
    motion = tracked.motion
    rows = dynamic_rows(motion, case(seed).excitation[1][: len(motion.time)], first.gravity, -1, STD)
    use = tracked.settled & tracked.noise_known & exciting(rows)
    told = batch(type(rows)(rows.z[use], rows.noise[use], STD, -1), first.prior, "gtls")
    assert live.fit.used == use.sum()
    assert known[-1].estimate.value == pytest.approx(told.value, abs=1e-5 * np.abs(told.value).max())
    assert live.fit.recursion.value == pytest.approx(told.value, abs=1e-5)


@pytest.mark.slow
def test_the_payload_comes_back_and_intervals_hold() -> None:
    seeds = range(8)
    found = [excited(seed)[2][-1].estimate for seed in seeds]
    error = np.array([each.value - case(seed).truth for each, seed in zip(found, seeds, strict=True)])
    std = np.array([each.std for each in found])
    assert np.sqrt(np.mean(error[:, 0] ** 2)) < 0.005
    assert np.sqrt(np.mean(error[:, 4:10] ** 2, axis=0)).max() < 0.004
    assert np.mean([each.mu for each in found]) == pytest.approx(1.0, abs=0.03)
    assert np.mean(np.abs(error) < 1.96 * std) > 0.90
    for each in found:
        assert each.mu == pytest.approx(1.0, abs=4 * each.mu_std)


def test_states_follow_what_moves() -> None:
    live = Live(start(3))
    q, wrench = case(3).excitation
    rest = np.random.default_rng(0)
    still_q = q[0] + NOISE * rest.standard_normal((500, 6))
    still_w = wrench[:20].mean(axis=0) + STD * rest.standard_normal((500, 6))
    end_q = q[-20:].mean(axis=0) + NOISE * rest.standard_normal((500, 6))
    end_w = wrench[-20:].mean(axis=0) + STD * rest.standard_normal((500, 6))
    _, known = run(live, np.vstack([still_q, q, end_q]), np.vstack([still_w, wrench, end_w]), sizes=(5,))
    states = [each.estimate.state for each in known]
    assert set(states[:18]) == {"static"}
    assert "converging" in states[20:30]
    assert states[20 + 95] == "converged"
    assert states[-1] == "frozen"
    assert list(dict.fromkeys(states)) == ["static", "converging", "converged", "frozen"]
    assert known[-1].estimate.used <= len(q) + 60


@cache
def pushed(seed: int):
    """The contact log of the sample, after an excitation."""
    body = case(seed).body
    q, dq, ddq = generator.wrist_motion(stream(seed, "contact"), share=0.3, harmonics=3)
    pushes = generator.pushed(len(q))
    logged = generator.measured(q, generator.simulate(body, q, dq, ddq, pushes), stream(seed, "noise of contact"))
    return *logged, pushes


def test_a_state_that_is_told_lasts() -> None:
    """A person reads it: none comes and goes within a blink, nor is anything frozen that never moved."""
    for seed in range(4):
        _, _, known = excited(seed)
        states = [each.estimate.state for each in known]
        changes = [k for k in range(1, len(states)) if states[k] != states[k - 1]]
        assert len(changes) <= 4, states
        assert states[0] == "static"
        assert states[changes[0]] == "converging"
        assert states[-1] == "converged"
        assert min(np.diff(changes), default=10) >= 3, states


def test_a_push_is_seen_timed_and_measured_and_does_not_change_the_payload() -> None:
    live = deepcopy(excited(0)[0])
    before = live.fit.estimate(True)
    q, wrench, pushes = pushed(0)
    found, known = run(live, q, wrench, sizes=(10,), first=100.0)
    time = found.time - 100.0
    for begin, length, force, _ in generator.PUSHES:
        inside = (time >= begin - 0.1) & (time <= begin + length + 0.1)
        seen = time[inside & found.alarm]
        assert begin <= seen[0] < begin + 0.1 * length
        assert begin + 0.9 * length < seen[-1] <= begin + length
        assert found.alarm[(time > seen[0]) & (time < seen[-1])].mean() > 0.97
        error = (found.wrench - pushes)[inside & found.alarm] / found.std[inside & found.alarm]
        assert np.abs(error).max() < 5.5
        middle = np.abs(time - begin - length / 2) < 0.01
        assert found.wrench[middle, :3].mean(axis=0) == pytest.approx(force, abs=1.0)
    quiet = ~np.any([(time > a - 0.02) & (time < a + b + 0.02) for a, b, *_ in generator.PUSHES], axis=0)
    assert not found.alarm[quiet].any()
    after = known[-1].estimate
    assert np.all(np.abs(after.value - before.value) < 4 * before.std)
    assert known[-1].left_out > 250


def test_a_stream_with_another_zero_says_that_it_learns_nothing() -> None:
    """Tared since: all of it is an alarm, and what is told is what was known before."""
    q, wrench = case(0).excitation
    _, known = run(Live(start(0)), q, wrench + np.array([5.0, -4.0, 3.0, 0.3, 0.2, -0.3]))
    assert known[-1].estimate.used < 50
    assert not known[20].in_doubt
    assert len(known[-1].in_doubt) == 1
    assert "zero" in known[-1].in_doubt[0]
    assert not excited(0)[2][-1].in_doubt


@pytest.mark.slow
def test_alarms_without_contact_are_as_rare_as_stated() -> None:
    """One sample in a hundred, over seeds: in fast motion after the excitation, and at rest."""
    share, rest = [], []
    for seed in range(5):
        live = deepcopy(excited(seed)[0])
        live.limit = false_alarm_limit(0.01)
        q, dq, ddq = generator.wrist_motion(stream(seed, "fast"))
        body = case(seed).body
        logged = generator.measured(q, generator.simulate(body, q, dq, ddq), stream(seed, "noise of fast"))
        found, _ = run(live, *logged, first=100.0)
        share.append(found.alarm[found.settled].mean())
        still = tuple(np.repeat(each[:1], 2500, axis=0) for each in (q, 0 * dq, 0 * ddq))
        logged = generator.measured(still[0], generator.simulate(body, *still), stream(seed, "noise at rest"))
        found, _ = run(live, *logged, first=200.0)
        rest.append(found.alarm[found.settled].mean())
    assert 0.006 < np.mean(share) < 0.014
    assert 0.006 < np.mean(rest) < 0.014


def turned(angle: float) -> Array:
    """(200, 3, 3) R_BS of a sensor that is tipped by `angle` about its x."""
    c, s = np.cos(angle), np.sin(angle)
    return np.tile(np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]), (200, 1, 1))


def motion_of(rotation: Array) -> SensorMotion:
    still = np.zeros((len(rotation), 3))
    return SensorMotion(np.arange(len(rotation)) / RATE, rotation, still, still, still, np.zeros((len(rotation), 9, 1)))


def test_the_secondary_zero_takes_a_mass_error_off_up_to_sixty_degrees_and_is_left_off_beyond() -> None:
    wrong, quiet, settled = 0.3, np.zeros(200, bool), np.ones(200, bool)
    zero = SecondZero(GRAVITY, 125)

    def left(angle: float) -> Array:
        force = wrong * np.einsum("tji,j->ti", turned(angle), GRAVITY)
        return np.concatenate([force, np.zeros((200, 3))], axis=1)

    assert zero.applied(motion_of(turned(0.0)), left(0.0), quiet, settled)[1] == "none"
    zero.begin()
    external, state = zero.applied(motion_of(turned(0.0)), left(0.0), quiet, settled)
    assert state == "held"
    assert np.array_equal(external, left(0.0))  # from the next sample on
    for degrees, told in ((0.0, "held"), (59.0, "held"), (61.0, "beyond")):
        angle = np.radians(degrees)
        external, state = zero.applied(motion_of(turned(angle)), left(angle), quiet, settled)
        assert state == told
        size = np.linalg.norm(external[0, :3])
        expected = wrong * 9.81 * (2 * np.sin(angle / 2) if told == "held" else 1.0)
        assert size == pytest.approx(expected, rel=1e-12, abs=1e-12)
    assert 2 * np.sin(np.radians(30.5)) > 1.0  # beyond, it would be worse than none


def test_a_secondary_zero_is_refused_where_something_touches() -> None:
    zero, alarm = SecondZero(GRAVITY, 125), np.zeros(200, bool)
    alarm[50] = True
    zero.begin()
    external, state = zero.applied(motion_of(turned(0.0)), np.ones((200, 6)), alarm, np.ones(200, bool))
    assert state == "refused"
    assert np.array_equal(external, np.ones((200, 6)))


@pytest.mark.slow
@pytest.mark.parametrize("way", [0.05, 0.1, 0.3])
def test_a_joint_that_starts_to_move_is_no_contact(way: float) -> None:
    """After a second at rest, in which it was filtered as one that hardly moves, of all joints in turn."""
    body, rng = case(0).body, np.random.default_rng(5)
    t = np.arange(750) / RATE
    u = np.clip(t - 1.5, 0.0, 1.0)
    angle, rate = 10 * u**3 - 15 * u**4 + 6 * u**5, 30 * u**2 - 60 * u**3 + 30 * u**4
    blend = way * np.array([angle, rate, 60 * u - 180 * u**2 + 120 * u**3])
    live = deepcopy(excited(0)[0])
    for joint in range(6):
        state = np.zeros((3, len(t), 6))
        state[0] = generator.WORK
        state[:, :, joint] += blend
        logged = generator.measured(*state[:1], generator.simulate(body, *state), rng)
        found, _ = run(live, *logged, first=100.0 * (joint + 1))
        assert not found.alarm.any(), joint
        assert np.median(found.std[300:340, 0]) < 0.6
