"""[Payload] 3.2: motion that excites."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.payload.conftest import GRAVITY, STD, arm, generator, parameters
from tests.payload.planned import COMPONENT, arm_of, task_of, wrist_limits

from exogauge.errors import NotIdentifiable
from exogauge.payload.dynamics import batch, dynamic_rows, prior_information, static_prior
from exogauge.payload.planning.excitation import Series, Task, improve, point, random_motion, touches, within
from exogauge.payload.sensor_motion import SensorMotion, rotations

Array = NDArray[np.float64]


@cache
def planned(gravity: bool = True) -> tuple[Task, list[Array]]:
    """Motions from two starts."""
    task, rng = task_of(), np.random.default_rng(1)
    return task, [improve(task, random_motion(task, rng, 0.8), gravity=gravity) for _ in range(2)]


def quality(task: Task, x: Array) -> float:
    return float(np.mean(np.log(task.std_of(x)[:10])))


def test_a_planned_wrench_is_that_of_the_other_simulator() -> None:
    """MuJoCo on a base that is not level."""
    q, dq, ddq = (each[::100] for each in generator.wrist_motion(np.random.default_rng(2)))
    inertia = COMPONENT.inertia
    body = generator.Body(COMPONENT.mass, COMPONENT.centre, inertia.inertia, np.zeros(6))
    assert parameters(body) == pytest.approx(COMPONENT.phi)
    U, V = np.radians(generator.TILT_DEG)
    level = arm_of()
    tilted = type(level)(
        generator.arm_urdf().encode(), generator.JOINTS, "base", "ft",
        generator.GRAVITY * np.array([np.cos(U) * np.sin(V), -np.sin(U), -np.cos(U) * np.cos(V)]), COMPONENT,
        generator.JOINTS[3:], generator.WORK,
    )  # fmt: skip
    moving = tilted.moving(q[:, 3:], dq[:, 3:], ddq[:, 3:])
    assert tilted.wrench(moving, -1) == pytest.approx(generator.simulate(body, q, dq, ddq), abs=1e-8)
    assert moving.rotation == pytest.approx(rotations(arm(), "ft", q), abs=1e-12)


def test_ends_are_at_rest_whatever_the_numbers() -> None:
    series, rng = Series(10.0, 5), np.random.default_rng(0)
    for _ in range(20):
        x = rng.standard_normal((3, series.size))
        q, dq, ddq = series.motion(x, np.array([0.0, 10.0]))
        assert q == pytest.approx(np.stack([x[:, -1]] * 2), abs=1e-9)
        assert np.abs([dq, ddq]).max() < 1e-9


def test_velocity_and_acceleration_are_the_derivatives_of_41() -> None:
    series, h = Series(8.0, 4), 1e-5
    x, t = np.random.default_rng(1).standard_normal((2, series.size)), np.linspace(0.3, 7.0, 9)
    _, dq, ddq = series.motion(x, t)
    before, after = series.motion(x, t - h), series.motion(x, t + h)
    assert dq == pytest.approx((after[0] - before[0]) / (2 * h), abs=1e-8)
    assert ddq == pytest.approx((after[1] - before[1]) / (2 * h), abs=1e-8)


def test_printed_42_bounds_no_position() -> None:
    """|q| <= |Σ + q_0| fails where q_0 is negative; |q - q_0| <= Σ holds."""
    series, rng, t = Series(10.0, 5), np.random.default_rng(3), np.linspace(0.0, 10.0, 400)
    w = 2 * np.pi / 10.0 * np.arange(1, 6)
    broken = 0
    for _ in range(200):
        x = rng.standard_normal((1, series.size))
        x[0, -1] *= 3.0
        a, b = series.bases[0] @ x[0, :4], series.bases[1] @ x[0, 4:7]
        total, q = float(np.sum(np.hypot(a, b) / w)), series.motion(x, t)[0][:, 0]
        broken += bool(np.abs(q).max() > abs(total + x[0, -1]))
        assert np.abs(q - x[0, -1]).max() <= total + 1e-12
    assert broken > 20


@pytest.mark.parametrize("gravity", [True, False])
def test_the_gradient_is_that_of_differences(gravity: bool) -> None:
    task = task_of()
    x = random_motion(task, np.random.default_rng(4), 0.8)
    x = np.concatenate([1.6 * x[:, :-1], x[:, -1:]], axis=1)  # beyond some bounds
    assert task.largest(x) > 1.1
    slopes = point(task, x, 100.0, gravity=gravity)[1]
    for place in ((0, 0), (1, 4), (2, 6), (0, 7), (1, 7)):
        step = np.zeros_like(x)
        step[place] = 1e-3  # without gravity the information has few digits
        before, after = (point(task, x + sign * step, 100.0, gravity=gravity)[0] for sign in (-1.0, 1.0))
        assert slopes[place] == pytest.approx((after - before) / 2e-3, rel=2e-4)


def test_an_excess_costs_by_its_square_and_what_is_within_costs_nothing() -> None:
    task = task_of()
    x = random_motion(task, np.random.default_rng(6), 0.8)
    assert point(task, x, 1e3)[0] == point(task, x, 0.0)[0]
    x[:, :-1] *= 1.5
    free, dear, dearer = (point(task, x, price)[0] for price in (0.0, 1.0, 2.0))
    assert dearer - free == pytest.approx(2.0 * (dear - free))
    assert dear - free > 1e-4


def test_standard_deviations_are_those_of_the_dynamic_stages_information() -> None:
    task = task_of()
    x = random_motion(task, np.random.default_rng(7))
    t = np.arange(2500) / 250.0
    q, dq, ddq = task.series.motion(x, t)
    moving = task.arm.moving(q, dq, ddq)

    b, alpha, omega = np.split(moving.state, 3, axis=1)
    level = np.tile(np.eye(3), (2500, 1, 1))
    exact = SensorMotion(t, level, b + GRAVITY, alpha, omega, np.zeros((2500, 9, 1)))
    rows = dynamic_rows(exact, task.arm.wrench(moving, -1), GRAVITY, -1, STD)
    prior = static_prior(None)
    H = batch(rows, prior, "ls").information + prior_information(prior)
    assert task.std_of(x) == pytest.approx(np.sqrt(np.diag(np.linalg.inv(H))), rel=1e-3)


@pytest.mark.slow
def test_every_bound_holds_at_1_khz() -> None:
    task, found = planned()
    limits = wrist_limits()
    t = np.arange(10001) / 1000.0
    for x in found:
        q, dq, ddq = task.series.motion(x, t)
        assert (q >= limits.lower[3:]).all()
        assert (q <= limits.upper[3:]).all()
        assert (np.abs(dq) <= limits.velocity[3:]).all()
        assert (np.abs(ddq) <= limits.acceleration[3:]).all()
        moving = task.arm.moving(q, dq, ddq)
        assert (np.abs(moving.torque) <= limits.torque).all()
        assert (np.abs(task.arm.wrench(moving, -1)) <= task.rated).all()
        assert np.degrees(np.arccos(moving.rotation[:, 2, 2])).min() >= 120.0 - 1e-9
        assert np.abs([dq[[0, -1]], ddq[[0, -1]]]).max() < 1e-9


@pytest.mark.slow
def test_planned_motions_leave_smaller_standard_deviations_than_twelve_at_random() -> None:
    task, found = planned()
    rng = np.random.default_rng(8)
    others = [random_motion(task, rng) for _ in range(12)]
    assert all(0.9 < task.largest(x) <= 1.0 for x in others)  # as large as the same bounds let them be
    best = min(found, key=lambda x: quality(task, x))
    assert quality(task, best) < min(quality(task, x) for x in others) - 0.3  # a quarter off each, on average
    assert max(quality(task, x) for x in found) < min(quality(task, x) for x in others)
    each = np.array([task.std_of(x)[:10] for x in others])
    assert (task.std_of(best)[:10] < np.median(each, axis=0)).all()


@pytest.mark.slow
def test_the_criterion_without_gravity_leaves_larger_standard_deviations() -> None:
    task, found = planned()
    _, without = planned(gravity=False)
    with_gravity, blind = ([quality(task, x) for x in each] for each in (found, without))
    assert np.mean(blind) > np.mean(with_gravity) + 0.02
    assert min(blind) > min(with_gravity)


@pytest.mark.slow
@pytest.mark.parametrize("times", [1.5, 40.0])
def test_a_motion_that_passes_its_bounds_is_shrunk_until_it_does_not(times: float) -> None:
    task = task_of()
    x = random_motion(task, np.random.default_rng(4))
    x[:, :-1] *= times
    assert task.largest(x) > 1.0
    assert 0.5 < task.largest(within(task, x)) <= 1.0


@pytest.mark.slow
def test_a_motion_that_would_collide_is_shrunk_until_nothing_touches() -> None:
    """A ball on the link before the wrist, which the component's box clears at home."""
    ball = '<collision><origin xyz="0.2 0 -0.2"/><geometry><sphere radius="0.1"/></geometry></collision>'
    urdf = generator.arm_urdf().replace('<link name="link3">', f'<link name="link3">{ball}')
    task = replace(task_of(), arm=arm_of(urdf=urdf))
    wide = random_motion(task, np.random.default_rng(4))
    assert not task.arm.touching(task.arm.home[task.arm.moved])
    assert touches(task, wide)
    clear = within(task, wide, clear=True)
    assert not touches(task, clear)
    share = (clear - np.eye(task.series.size)[-1] * task.arm.home[task.arm.moved][:, None])[:, :-1] / wide[:, :-1]
    assert np.ptp(share) < 1e-9
    assert 0.0 < share.mean() < 1.0


def test_a_home_outside_the_bounds_is_refused() -> None:
    task = task_of()
    task.arm.home[4] -= 2.0  # the flange looks up
    assert task_of().arm.home[4] == task.arm.home[4] + 2.0  # of this arm alone
    with pytest.raises(NotIdentifiable, match="home posture is outside"):
        random_motion(task, np.random.default_rng(0))


def test_torques_and_their_slopes_are_those_of_an_arm_with_the_payload_on_it() -> None:
    carrying, rng = arm_of(), np.random.default_rng(9)
    q, dq, ddq = rng.uniform(-1.0, 1.0, (3, 4, 3))
    moving = carrying.moving(q, dq, ddq, slopes=True)
    assert moving.torque == pytest.approx(carrying.moving(q, dq, ddq).torque, abs=1e-9)
    assert moving.torque_slopes is not None
    h = 1e-6
    for k in range(3):
        for j in range(3):
            ends = []
            for side in (-1.0, 1.0):
                states = [q.copy(), dq.copy(), ddq.copy()]
                states[k][:, j] += side * h
                ends.append(carrying.moving(*states).torque)
            assert moving.torque_slopes[:, :, j, k] == pytest.approx((ends[1] - ends[0]) / (2 * h), abs=1e-4)
    lift = carrying.moving(np.array([generator.WORK[3:]]), np.zeros((1, 3)), np.zeros((1, 3))).torque[0, 1]
    assert abs(lift) > 40.0 * 9.81 * 0.5
