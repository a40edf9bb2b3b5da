"""Alignment in time and sameness of two recorded motions."""

from __future__ import annotations

import numpy as np
import pytest

from exogauge.errors import BadStudy
from exogauge.logs.model import Log
from exogauge.studies.words.remark_words import sentence
from exogauge.support.motions import acted_joints, doubts, pairs, require_same_motions
from exogauge.support.same_motion import Posture, match
from exogauge.support.settings import PlainLog, SupportSettings, WornLog

SETTINGS = SupportSettings()


def angles(t, seed=0, size=1.0):
    """(T, 2): a motion of its own kind for every seed, defined for all times."""
    rng = np.random.default_rng(seed)
    omega, phase = 2 * np.pi * rng.uniform(0.1, 0.9, (5, 2)), rng.uniform(0, 6.28, (5, 2))
    return size * np.sum(0.2 * np.sin(t[:, None, None] * omega + phase), axis=1)


def run(motion, start=0.0, seconds=12.0, rate=200.0, clock=0.0, noise=0.0, name="run"):
    """A log of the joints a and b that begins at `start` of a motion; its own clock begins at `clock`."""
    t = np.arange(0.0, seconds, 1.0 / rate)
    q = motion(t + start) + noise * np.random.default_rng(1).normal(size=(len(t), 2))
    return Log(name, clock + t, {"q.a": q[:, 0], "q.b": q[:, 1]})


def matched(this, other, settings=SETTINGS):
    return match(Posture(this, ("a", "b")), Posture(other, ("a", "b")), settings)


@pytest.mark.parametrize("shift", [0.0, 0.0017, -0.0131, 0.4026, -1.2374, 3.3])
def test_a_shift_comes_back_to_a_fraction_of_a_sample(shift):
    """lag: the other log shows the same posture that much later."""
    found = matched(run(angles), run(angles, start=-shift))
    assert abs(found.lag_s - shift) < 1e-4
    assert found.worst == "equal"


def test_a_run_covers_all_of_one_that_is_as_long():
    found = matched(run(angles), run(angles, noise=1e-5))
    assert (found.first, found.last) == (0, run(angles).samples)


@pytest.mark.parametrize(("rate", "other_rate"), [(200.0, 125.0), (100.0, 500.0), (250.0, 240.0)])
@pytest.mark.parametrize(("seconds", "other_seconds"), [(12.0, 20.0), (20.0, 9.0)])
def test_rates_and_lengths_may_differ_and_clocks_begin_anywhere(rate, other_rate, seconds, other_seconds):
    this = run(angles, start=4.0, seconds=seconds, rate=rate, clock=1.7e9, noise=1e-4)
    other = run(angles, start=4.0 - 1.2374, seconds=other_seconds, rate=other_rate, clock=55.0, noise=1e-4)
    found = matched(this, other)
    assert abs(found.lag_s - 1.2374) < 1e-3
    assert found.worst == "equal"
    time = this.time - this.time[0] + found.lag_s
    assert time[found.first] >= 0.0
    assert time[found.last - 1] <= other.time[-1] - other.time[0]
    assert found.first <= 1
    assert found.last == this.samples or time[found.last] > other.time[-1] - other.time[0]


def test_of_equal_shifts_of_a_periodic_motion_the_smallest_is_taken():
    def swing(t):
        return 0.4 * np.column_stack([np.sin(np.pi * t), 0.3 * np.cos(2 * np.pi * t)])  # 2 s

    for shift in (0.3, -0.8, 0.95):
        assert abs(matched(run(swing), run(swing, start=-shift)).lag_s - shift) < 1e-3


def bend(at, height=1.0):
    """One bend of 3 s in a long stand."""

    def motion(t):
        s = np.clip(1.0 - np.abs(t - at) / 1.5, 0.0, 1.0)
        return np.outer(height * s**2 * (3 - 2 * s), [0.8, 0.1])

    return motion


@pytest.mark.parametrize(("at", "other_at"), [(9.0, 3.0), (3.0, 9.0), (8.0, 4.0), (5.0, 7.5), (10.0, 2.5)])
def test_stand_is_not_laid_upon_stand(at, other_at):
    """Of the shifts that bring no motion together, none is taken, however small and however equal the rest is."""
    found = matched(run(bend(at)), run(bend(other_at)))
    assert found.lag_s == pytest.approx(other_at - at, abs=1e-3)
    assert found.worst == "equal"


def test_a_run_is_found_in_a_longer_one_that_holds_larger_motions_too():
    def several(t):
        return bend(4.0)(t) + bend(14.0, height=1.6)(t) + bend(20.0, height=0.5)(t)

    found = matched(run(bend(5.0)), run(several, seconds=24.0))
    assert found.lag_s == pytest.approx(-1.0, abs=1e-3)
    back = matched(run(several, seconds=24.0), run(bend(5.0)))
    assert back.lag_s == pytest.approx(1.0, abs=1e-3)
    assert (found.worst, back.worst) == ("equal", "equal")


def test_motions_that_two_logs_do_not_share_are_different():
    """The bend comes so early in one and so late in the other that too little would be left to compare."""
    found = matched(run(bend(13.4), seconds=15.0), run(bend(1.6), seconds=15.0))
    assert [each.verdict for each in found.equality] == ["different"] * 2
    assert all(each.dq_share > 0.9 for each in found.equality)


def test_another_motion_is_different_and_a_slightly_other_one_doubtful():
    def slower(t):
        return angles(0.97 * t)

    assert matched(run(angles), run(lambda t: angles(t, seed=5))).worst == "different"
    assert matched(run(angles), run(slower)).worst == "doubtful"
    assert matched(run(angles), run(lambda t: angles(t, size=1.25))).worst == "doubtful"
    assert matched(run(angles), run(lambda t: angles(t, size=1.05))).worst == "equal"


def test_a_joint_that_stands_elsewhere_is_doubtful_though_it_does_not_move():
    def held(angle):
        return lambda t: np.column_stack([angles(t)[:, 0], np.full(len(t), angle)])

    found = matched(run(held(0.2)), run(held(0.35)))
    assert [each.verdict for each in found.equality] == ["equal", "doubtful"]
    assert found.equality[1].q_rms == pytest.approx(0.15, abs=1e-9)
    assert found.equality[1].dq_share == 0.0


def test_a_joint_that_has_next_to_no_part_in_the_motion_is_doubtful_and_refuses_nothing(biped, suit):
    """A hip that gives way to a bend by milliradians, each time otherwise; then one that carries it."""

    def swaying(size, seed):
        return lambda t: np.column_stack([angles(t)[:, 0], size * angles(t, seed=seed)[:, 1]])

    found = matched(run(swaying(0.06, 5)), run(swaying(0.06, 6)))
    assert [each.verdict for each in found.equality] == ["equal", "doubtful"]
    assert found.equality[1].dq_share > SETTINGS.different
    assert matched(run(swaying(0.5, 5)), run(swaying(0.5, 6))).worst == "different"
    worn = WornLog(robot_log(biped, "worn", swaying(0.06, 5)), "bend", suit)
    plain = PlainLog(robot_log(biped, "plain", swaying(0.06, 6)), "bend", True)
    require_same_motions(biped.robot, [worn], [plain], SETTINGS)


def test_equality_is_stated_in_the_joints_own_terms():
    """A difference of known size: 0.01 rad at 0.5 Hz on one joint."""
    omega = np.pi

    def more(t):
        return angles(t) + np.column_stack([0.01 * np.sin(omega * t), np.zeros(len(t))])

    found = matched(run(angles, seconds=20.0), run(more, seconds=20.0))
    a, b = found.equality
    velocity = np.gradient(angles(np.arange(0, 20, 1e-3))[:, 0], 1e-3)
    assert a.q_rms == pytest.approx(0.01 / np.sqrt(2), rel=0.03)
    assert a.dq_rms == pytest.approx(0.01 * omega / np.sqrt(2), rel=0.03)
    assert a.dq_share == pytest.approx(a.dq_rms / np.sqrt(np.mean(velocity**2)), rel=0.03)
    assert b.dq_share < 0.02


def robot_log(biped, name, motion):
    """All joints still but the torso."""
    t = np.arange(0.0, 10.0, 0.01)
    q = dict.fromkeys((joint.name for joint in biped.robot.joints), np.zeros(len(t)))
    q["torso_yaw"], q["torso_pitch"] = motion(t).T
    return Log(name, t, {f"q.{joint}": values for joint, values in q.items()})


def test_other_motions_are_refused_with_joint_numbers_and_advice(biped, suit):
    def other_pitch(t):
        return np.column_stack([angles(t)[:, 0], angles(t, seed=5)[:, 1]])

    plain = [PlainLog(robot_log(biped, "plain", angles), "bend", True)]
    worn = [
        WornLog(robot_log(biped, "same", angles), "bend", suit),
        WornLog(robot_log(biped, "other", other_pitch), "bend", suit),
    ]
    require_same_motions(biped.robot, worn[:1], plain, SETTINGS)
    with pytest.raises(BadStudy) as caught:
        require_same_motions(biped.robot, worn, plain, SETTINGS)
    (fault,) = caught.value.faults
    assert (fault.rule, fault.file, fault.column) == ("motions_differ", "other", "q.torso_pitch")
    postures = (Posture(each.log, ("torso_yaw", "torso_pitch")) for each in (worn[1], plain[0]))
    (found,) = (e for e in match(*postures, SETTINGS).equality if e.joint == "torso_pitch")
    assert float(fault.value) == pytest.approx(found.dq_share, rel=0.01)
    assert float(fault.value) > SETTINGS.different
    for words in ("torso_pitch", "plain", "'bend'", "rad/s", "%"):
        assert words in fault.detail
    assert "`motion`" in fault.advice
    require_same_motions(biped.robot, worn, plain, SupportSettings(doubtful=2.0, different=3.0))


def test_only_joints_that_the_bands_pass_must_move_alike(biped, suit):
    assert [biped.robot.joints[j].name for j in acted_joints(biped.robot, [WornLog(None, "bend", suit)])] == [
        "torso_pitch", "torso_yaw",
    ]  # fmt: skip
    kicking = robot_log(biped, "kicking", angles)
    kicking.channels["q.l_knee"][:] = np.sin(kicking.time)
    plain = [PlainLog(robot_log(biped, "plain", angles), "bend", True)]
    require_same_motions(biped.robot, [WornLog(kicking, "bend", suit)], plain, SETTINGS)


def test_a_motion_that_no_log_without_the_device_has_is_not_compared(biped, suit):
    worn = WornLog(robot_log(biped, "alone", angles), "lift", suit)
    plain = [PlainLog(robot_log(biped, "plain", lambda t: angles(t, seed=5)), "bend", True)]
    require_same_motions(biped.robot, [worn], plain, SETTINGS)
    assert pairs([worn], plain)[0].reference is None


def test_the_kth_trial_goes_with_the_kth_log_without_the_device(suit):
    plain = [PlainLog(None, motion, True) for motion in ("bend", None, "twist", "bend")]
    worn = [WornLog(None, motion, suit) for motion in ("bend", "twist", "bend", "bend", "twist")]
    assert [pair.reference for pair in pairs(worn, plain)] == [0, 2, 3, 0, 2]


def test_a_doubt_names_logs_joint_and_size():
    found = matched(run(angles, name="worn"), run(lambda t: angles(t, size=1.25), name="plain"))
    sentences = [sentence(each) for each in doubts({"worn": ("plain", found.equality)}, SETTINGS)]
    assert len(sentences) == 2
    assert sentences[0].startswith("worn and plain differ in the motion of a: 20 % ")
    assert not doubts({"worn": ("plain", matched(run(angles), run(angles)).equality)}, SETTINGS)
