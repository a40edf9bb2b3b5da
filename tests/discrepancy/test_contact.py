"""A push that no log tells of is found, named with its link, and its time left out; friction and gears are none."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from exogauge.detect.contact.detector import contacts
from exogauge.detect.contact.rows import force_columns, log_rows, middles
from exogauge.detect.pipeline import find_missing_effects
from exogauge.effects.catalogue import shaped_effects
from exogauge.identification.identify import identify
from exogauge.identification.preparation import prepare
from exogauge.identification.settings import Recording, Settings
from exogauge.robots.kinematics import forward
from exogauge.robots.motion import Motion
from exogauge.robots.regressor import contact_effect
from exogauge.studies.words.finding_sentences import finding_sentence
from exogauge.studies.words.motion_sentences import motion_words

pytestmark = pytest.mark.slow

SETTINGS = Settings(cutoff_hz=8.0)
MIDDLE = np.array([0.06, -0.04, 0.1])  # of every link's mass


@pytest.fixture(scope="module")
def pushed(arm_urdf):
    """(link, force (3,) in base axes, begin, length) -> what the motors give beyond the model, by pinocchio alone."""

    def hidden(link, force, begin, length, beside=(0.0, 0.0, 0.0)):
        model = pin.buildModelFromXML(arm_urdf)
        frame = model.addFrame(
            pin.Frame("push", model.getJointId(link), 0, pin.SE3(np.eye(3), MIDDLE + beside), pin.FrameType.OP_FRAME)
        )
        own = model.createData()

        def torque(motion):
            phase = (motion.t - begin) / length
            out = np.zeros_like(motion.q)
            for k in np.flatnonzero((phase > 0.0) & (phase < 1.0)):
                J = pin.computeFrameJacobian(model, own, motion.q[k], frame, pin.LOCAL_WORLD_ALIGNED)[:3]
                out[k] = -J.T @ (np.sin(np.pi * phase[k]) * np.asarray(force))
            return out

        return torque

    return hidden


@pytest.fixture(scope="module")
def look(robot):
    def run(recordings):
        def anew(each):
            return identify(robot, each, SETTINGS)

        return contacts(anew(recordings), recordings, anew)

    return run


@pytest.fixture
def touched(record, pushed):
    """(push, in which of the logs 1, 2, 9) -> two logs to fit and one held out."""

    def make(push, where, **how):
        return [
            Recording(record(seed, push, **how) if seed == where else record(seed, **how), seed == 9)
            for seed in (1, 2, 9)
        ]

    return make


def test_columns_are_what_a_known_contact_does(robot, study, identified):
    recordings = study(seconds=8.0)
    model = identified(recordings).model
    rows = log_rows(model, recordings[:1])[0]
    wrench = np.array([3.0, -2.0, 5.0, 0.3, 0.1, -0.2])
    columns = np.stack(list(force_columns(model, rows)))
    q = rows.prepared.motion.q[rows.prepared.kept]
    tree = model.robot.tree
    for body, link in enumerate(tree.bodies):
        middle = pin.SE3(np.eye(3), middles(tree)[body])
        there = replace(tree, frames={**tree.frames, "middle": (body, middle)})
        in_base = columns[body] @ wrench
        still, none = np.zeros_like(q), np.zeros((len(q), 3))
        R = forward(tree, Motion(q, still, still, none, none, none)).rotation[:, body]
        local = np.concatenate([np.einsum("tji,j->ti", R, part) for part in (wrench[:3], wrench[3:])], axis=1)
        np.testing.assert_allclose(in_base, -contact_effect(there, q, "middle", local), atol=1e-9, err_msg=link)


@pytest.mark.parametrize(("where", "begin", "length"), [(1, 17.64, 0.45), (9, 20.45, 0.25)], ids=["fitted", "held out"])
@pytest.mark.parametrize("link", ["j2", "j3"])
def test_log_time_link_and_size_of_a_push_come_out(touched, pushed, look, link, where, begin, length):
    """While the last two joints move: one that rests or turns does not show what pulls at it."""
    force = np.array([18.0, -24.0, 16.0])
    found = look(touched(pushed(link, force, begin, length, (0.02, 0.01, -0.02)), where))
    assert found is not None
    (finding,) = found.findings
    assert finding.effect == "contact"
    assert finding.place.kind == "link"
    assert f"l{link}" in [finding.place.name, *(each.place.name for each in finding.also_possible)]
    size, start, lasts = (finding.parameters[f"{name}[log{where}]"] for name in ("force", "start", "duration"))
    assert abs(size.value - np.linalg.norm(force)) < 3.0 * size.std
    assert start.value == pytest.approx(begin, abs=0.05)
    assert lasts.value == pytest.approx(length, abs=0.1)
    assert f"log{where} from {start.value:.2f}\u00a0s" in finding_sentence(finding)
    assert np.abs(finding.evidence.before).max() > 5.0 * np.abs(finding.evidence.after).max()


def test_a_push_that_the_last_joint_feels_is_at_the_last_link(touched, pushed, look):
    found = look(touched(pushed("j3", [9.0, -12.0, 8.0], 17.64, 0.45), 1))
    assert found is not None
    (finding,) = found.findings
    assert finding.place.name == "lj3"
    assert finding.also_possible == ()
    assert motion_words(finding) == ""


def test_links_that_a_resting_joint_cannot_tell_apart_are_said(touched, pushed, look):
    """The last joint never moves."""
    found = look(touched(pushed("j3", [9.0, -12.0, 8.0], 17.64, 0.45), 1, still=2))
    assert found is not None
    (finding,) = found.findings
    assert "lj3" in [finding.place.name, *(each.place.name for each in finding.also_possible)]
    assert finding.also_possible
    assert "once more" in motion_words(finding)


@pytest.mark.slow
def test_the_time_of_a_push_is_left_out_and_the_robot_comes_out_as_without_it(robot, touched, pushed, look, record):
    push = pushed("j3", [20.0, 20.0, -25.0], 8.0, 0.8)
    recordings = touched(push, 1)
    found = look(recordings)
    assert found is not None
    clean = identify(robot, touched(lambda motion: np.zeros_like(motion.q), 1), SETTINGS)
    bent = identify(robot, recordings, SETTINGS)

    def off(each):
        return np.abs(each.joint_values["k_d"] - clean.joint_values["k_d"]).max()

    assert off(found.identification) < 0.2 * off(bent)
    ((start, stop),) = found.recordings[0].log.left_out
    assert start < 8.0
    assert stop > 8.8
    assert stop - start < 1.5
    assert found.recordings[1:] == tuple(recordings[1:])


@pytest.mark.slow
def test_two_pushes_at_one_link_are_one_finding(record, pushed, look):
    recordings = [
        Recording(record(1, pushed("j3", [15.0, -10.0, 8.0], 6.0, 0.4)), False),
        Recording(record(2), False),
        Recording(record(9, pushed("j3", [-12.0, 14.0, 9.0], 21.0, 0.7)), True),
    ]
    found = look(recordings)
    assert found is not None
    (finding,) = found.findings
    assert finding.place.name == "lj3"
    assert {"force[log1]", "force[log9]"} <= set(finding.parameters)


def stribeck(motion):
    return 2.0 * np.sign(motion.v) * np.exp(-((motion.v / 0.1) ** 2)) * (np.arange(3) == 1)


def gap(motion):
    """Teeth that land with a jolt of 60 ms, whenever the load changes sign."""
    torque = np.zeros_like(motion.q)
    for k in np.flatnonzero(np.diff(np.sign(motion.load[:, 1]))):
        torque[k : k + 12, 1] += 4.0 * np.sin(np.linspace(0.0, np.pi, 12))[: len(torque) - k]
    return torque


def offset_from_ten_seconds_on(motion):
    return 2.0 * (motion.t[:, None] > 10.0) * (np.arange(3) == 1)


def drift(motion):
    return 3.0 * (motion.t / (motion.t + 10.0))[:, None] * (np.arange(3) == 1)


NO_CONTACT = {
    "nothing": lambda motion: np.zeros_like(motion.q),
    "stribeck": stribeck,
    "backlash": gap,
    "a step that stays": offset_from_ten_seconds_on,
    "drift": drift,
}


@pytest.mark.parametrize("hidden", NO_CONTACT)
def test_what_recurs_or_stays_is_no_contact(study, look, hidden):
    assert look(study(NO_CONTACT[hidden])) is None


@pytest.mark.parametrize("at_its_end", [False, True])
def test_what_a_log_begins_or_ends_with_is_no_contact(robot, record, look, at_its_end):
    """A drive that settles as recording starts, in one log alone."""

    def settling(motion):
        since = motion.t[-1] - motion.t if at_its_end else motion.t
        return 6.0 * np.exp(-((since / 0.8) ** 2))[:, None] * (np.arange(3) == 1)

    assert (
        look([Recording(record(1, settling), False), Recording(record(2), False), Recording(record(9), True)]) is None
    )


def test_a_little_push_within_the_noise_is_not_named(touched, pushed, look):
    assert look(touched(pushed("j3", [0.05, 0.05, 0.05], 12.0, 0.4), 1)) is None


def test_samples_left_out_are_neither_kept_nor_steady(robot, record, identified, study):
    model = identified(study(seconds=8.0)).model
    log = record(1, seconds=20.0)
    without = prepare(robot, replace(log, left_out=((6.0, 7.0),)), model.cutoff_hz, model.at_rest)
    times = log.time[without.kept]
    assert not np.any((times > 6.0) & (times < 7.0))
    assert not without.steady[(log.time > 6.0) & (log.time < 7.0)].any()
    whole = prepare(robot, log, model.cutoff_hz, model.at_rest)
    assert set(without.kept) < set(whole.kept)


@pytest.mark.slow
def test_a_joint_effect_beside_a_push_is_still_found(robot, record, pushed):
    push = pushed("j3", [15.0, -20.0, 18.0], 9.0, 0.6)
    recordings = [
        Recording(record(1, lambda motion: stribeck(motion) + push(motion)), False),
        Recording(record(2, stribeck), False),
        Recording(record(9, stribeck), True),
    ]
    found = find_missing_effects(
        identify(robot, recordings, SETTINGS), recordings, tuple(shaped_effects().values()), SETTINGS
    ).discrepancy
    assert [(each.rank, each.effect) for each in found.findings] == [(1, "contact"), (2, "stribeck")]
    assert len(found.chain) == 3
