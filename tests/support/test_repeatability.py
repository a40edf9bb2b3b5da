"""Two runs subtracted: aligned, compared only where friction is the same, and what comes of runs that are alike."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exogauge.support.balance import balance
from exogauge.support.difference import difference
from exogauge.support.repeatability import Plain, repeatability
from exogauge.support.same_motion import Posture, match
from exogauge.support.settings import SupportSettings

SETTINGS = SupportSettings()
AWAY = 3  # samples from a turn at which nothing counts


def stribeck(speed):
    """More friction at low speed than any model here knows."""
    return 2.0 * np.sign(speed) * np.exp(-((speed / 0.3) ** 2))


def ready(model, recorded, joints, motion="wander"):
    own = balance(model, model.prepare(recorded.log), np.array(joints))
    return Plain(own, Posture(recorded.log, [model.robot.joints[j].name for j in joints]), motion)


def subtracted(this, other):
    return difference(this.balance, other.balance, match(this.posture, other.posture, SETTINGS))


def turning(speed):
    """(T, A) samples within AWAY of a change of sign."""
    change = np.diff(np.sign(speed), axis=0) != 0
    near = np.zeros(speed.shape, dtype=bool)
    for shift in range(-AWAY, AWAY):
        near[max(0, -shift) : len(speed) - max(shift, 0) - 1] |= change[max(0, shift) :][: len(speed) - abs(shift) - 1]
    return near


@pytest.mark.parametrize("begin", [0.37, 0.3741])
def test_a_run_that_begins_later_is_subtracted_at_the_same_posture(biped, suit, wander, low_passed, inner, begin):
    """Friction that the model does not know drops out only if it is that of the same moment of the motion."""
    model, joints = biped.known(), biped.torso
    worn = biped.record(wander(1, base_seed=2), "worn", suit.bands, extra=stribeck)
    plain = biped.record(wander(1, begin=begin), "plain", extra=stribeck)
    found = subtracted(ready(model, worn, joints), ready(model, plain, joints))
    truth, counts = low_passed(worn.support)[:, joints], found.compared.copy()
    counts[: inner.start + round(100 * begin)] = counts[inner.stop :] = False
    assert counts.mean() > 0.25
    assert np.abs(found.torque - truth)[counts].max() < 0.02
    unaligned = ready(model, worn, joints).balance.torque - ready(model, plain, joints).balance.torque
    assert np.abs(unaligned - truth)[counts].max() > 0.5
    assert np.isnan(found.torque[: round(100 * begin) - 1]).all()


def test_runs_are_compared_only_where_both_move_the_same_way(any_biped, wander):
    """In the second run one joint goes the other way: it is not compared at all; the others are, but at turns."""
    model, course = any_biped.known(), wander(1)
    mirrored = replace(course, q=course.q.copy(), dq=course.dq.copy(), ddq=course.ddq.copy())
    hip = any_biped.places("l_hip")[0]
    for values in (mirrored.q, mirrored.dq, mirrored.ddq):
        values[:, hip] *= -1.0
    joints = list(range(6))
    this, other = (ready(model, any_biped.record(each), joints) for each in (course, mirrored))
    found = difference(this.balance, other.balance, replace(match(this.posture, this.posture, SETTINGS), lag_s=0.0))
    assert not found.compared[:, hip].any()
    assert np.delete(found.compared, hip, axis=1).mean(axis=0).min() > 0.4
    C = any_biped.robot.axes_from_joints
    near = turning(course.dq @ C.T)
    for joint in joints:
        axes = np.flatnonzero(C[:, joint])
        assert not near[found.compared[:, joint]][:, axes].any()


def test_a_joint_that_rests_in_one_run_and_moves_in_the_other_is_not_compared(biped, wander):
    model, course = biped.known(), wander(1)
    yaw, pitch = biped.places("torso_yaw", "torso_pitch")
    resting = replace(course, q=course.q.copy(), dq=course.dq.copy(), ddq=course.ddq.copy())
    for values in (resting.q, resting.dq, resting.ddq):
        values[300:, yaw] = values[300, yaw] if values is resting.q else 0.0
    runs = [ready(model, biped.record(each), [yaw, pitch]) for each in (course, resting)]
    alike = replace(match(runs[0].posture, runs[0].posture, SETTINGS), lag_s=0.0)
    for this, other in (runs, runs[::-1]):
        found = difference(this.balance, other.balance, alike)
        assert not found.compared[300:, 0].any()
        assert found.compared[300:, 1].mean() > 0.4


def test_a_joint_moves_steadily_only_if_all_axes_that_move_it_do(any_biped, wander):
    course, model = wander(1), any_biped.known()
    own = balance(model, model.prepare(any_biped.record(course).log), np.arange(6))
    C = any_biped.robot.axes_from_joints
    near = turning(course.dq @ C.T)
    for joint in range(6):
        axes = np.flatnonzero(C[:, joint])
        assert not near[own.steady[:, joint]][:, axes].any()
        assert own.steady[:, joint].mean() > 0.4
        assert np.flatnonzero(own.acts[joint]).tolist() == axes.tolist()


def test_what_is_found_where_there_is_nothing_is_what_the_model_lacks_and_what_does_not_repeat(
    biped, wander, low_passed
):
    """Unknown friction that repeats is all of B's error and none of A's; a torque that only one run has is in both."""
    model, joints, held = biped.known(), biped.torso, np.ones(2)
    bump = 0.8 * np.sin(2.0 * wander(1).time)[:, None] * np.eye(6)[joints[0]]
    runs = [biped.record(wander(1, base_seed=k), f"run{k}", extra=stribeck) for k in range(2)]
    plains = [ready(model, each, joints) for each in runs]
    found = repeatability(plains, held, SETTINGS)
    missed = low_passed(stribeck(wander(1).dq))[:, joints]
    steady = plains[0].balance.steady
    expected = [np.sqrt(np.mean(missed[steady[:, d], d] ** 2)) for d in range(2)]
    np.testing.assert_allclose(found.b.steady, expected, rtol=0.02)  # ends of filters differ
    assert max(found.a.steady.max(), found.a.beyond["moves"].max(), found.paired.steady.max()) < 1e-3
    shaken = biped.record(wander(1, base_seed=1), "shaken", extra=lambda speed: stribeck(speed) + bump)
    found = repeatability([plains[0], ready(model, shaken, joints)], held, SETTINGS)
    differing = low_passed(bump)[:, joints[0]][steady[:, 0]]
    assert found.a.steady[0] == pytest.approx(np.sqrt(np.mean(differing**2)), rel=0.02)
    assert found.a.steady[1] < 1e-3


def test_runs_of_unnamed_or_of_different_motions_are_not_taken_for_repeats(biped, wander):
    model, joints = biped.known(), biped.torso
    recorded = biped.record(wander(1))
    for motions in ((None, None), ("lift", "bend"), ("bend",)):
        plains = [ready(model, recorded, joints, motion) for motion in motions]
        found = repeatability(plains, np.ones(2), SETTINGS)
        assert found.a is None
        assert found.paired is None
        assert found.b.whole.shape == (2,)


def test_what_drifts_slowly_is_in_the_null_test_of_what_compares_runs(biped, wander):
    """An offset that grows by 0.1 N·m from run to run: neighbours would show a third of what the session does."""
    model, joints = biped.known(), biped.torso
    plains = [
        ready(model, biped.record(wander(1), f"run{k}", extra=lambda speed, k=k: np.full_like(speed, 0.1 * k)), joints)
        for k in range(4)
    ]
    found = repeatability(plains, np.ones(2), SETTINGS)
    for each in (found.a, found.paired):
        np.testing.assert_allclose(each.steady, 0.3, rtol=0.05)
        np.testing.assert_allclose(each.mean, 0.3, rtol=0.2)
