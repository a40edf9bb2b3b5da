"""What is hidden is named, where it is, and nothing else; what cannot be shown on a held-out log is not."""

import numpy as np
import pytest

from exogauge.detect.pipeline import find_missing_effects
from exogauge.effects.catalogue import shaped_effects
from exogauge.findings.result import ChainStep, Place
from exogauge.findings.verdict import Caveat, Why
from exogauge.identification.settings import Recording, Settings
from exogauge.identification.sites import AxisSite
from exogauge.studies.words.finding_sentences import finding_sentence

pytestmark = pytest.mark.slow


def falling_with_speed(m):
    """Friction near rest, by another formula than the catalogue's exponential."""
    return 1.5 * np.sign(m.v) / (1.0 + (m.v / 0.1) ** 2)


def growing_with_load(m):
    return 0.12 * np.sqrt(m.load**2 + 1.0) * np.sign(m.v)


def one_way(m):
    return 0.8 * np.maximum(m.v, 0.0) ** 1.1


def late_by(seconds):
    """What arrives was logged so long before."""
    return lambda m: np.stack([np.interp(m.t + seconds, m.t, drive) for drive in m.drive.T], axis=1) - m.drive


late = late_by(0.03)


def wound(m):
    """A cable that winds up beyond an angle: while it winds on it rubs along, and pulls more than on its way back."""
    beyond = np.maximum(m.q - 0.1, 0.0)
    return 4.0 * beyond**1.3 * np.exp(0.6 * np.sign(m.v) * beyond)


def named(found):
    return [(each.effect, each.place.kind, each.place.name) for each in found.discrepancy.findings]


@pytest.fixture(scope="module")
def stribeck(search, study, on_joint):
    return search(study(on_joint(1, falling_with_speed)))


def test_friction_that_falls_with_speed_is_named_at_its_joint_and_nothing_else(stribeck):
    assert named(stribeck) == [("stribeck", "joint", "j2")]
    assert stribeck.discrepancy.verdict == "effects"
    held_out = stribeck.discrepancy.findings[0].held_out
    assert held_out.channel == "tau.j2"
    assert held_out.rmse_after < 0.7 * held_out.rmse_before
    assert stribeck.discrepancy.findings[0].score > 0.5


def test_what_was_named_is_part_of_the_robot_that_is_handed_on(stribeck):
    (added,) = stribeck.identification.model.extension.effects
    assert (added.effect.name, added.site) == ("stribeck", AxisSite(1))
    values = {each.name: each.value for each in stribeck.identification.parameters}
    assert values["stribeck.tau_b[j2]"] > 0.0
    assert [(each.parent, each.added) for each in stribeck.discrepancy.lineage] == [
        (None, None), ("identified", ChainStep("effect", "stribeck", Place("joint", "j2"))),
    ]  # fmt: skip
    first, last = stribeck.discrepancy.chain
    assert last.rmse < first.rmse
    assert last.noise_floor == first.noise_floor  # sensors do not get better with the model


def test_the_sentence_of_a_finding_holds_its_own_numbers(stribeck):
    finding = stribeck.discrepancy.findings[0]
    said = finding_sentence(finding)
    assert said.startswith("j2: ")
    for number in (finding.held_out.rmse_before, finding.held_out.rmse_after, finding.held_out.noise_floor):
        assert f"{number:.2g}" in said
    assert "up to ." not in said


def test_evidence_is_shown_from_short_logs_too(stribeck):
    shown = stribeck.discrepancy.findings[0].evidence
    assert shown.coordinate == "velocity"
    assert len(shown.at) >= 10
    assert np.all(np.diff(shown.at) > 0.0)
    strong = np.abs(shown.model) > 0.2 * np.abs(shown.model).max()
    assert np.all(np.sign(shown.model[strong]) == -np.sign(shown.at[strong]))  # friction opposes motion
    assert np.abs(shown.after).max() < np.abs(shown.before).max()


@pytest.mark.parametrize("first", [1, 20, 25])
def test_nothing_is_named_where_nothing_is_hidden(search, record, first):
    found = search([Recording(record(first + k), k == 2) for k in range(3)])
    assert found.discrepancy.verdict == "none"
    assert found.discrepancy.findings == found.discrepancy.located == found.discrepancy.unexplained == ()
    assert len(found.discrepancy.chain) == len(found.discrepancy.lineage) == 1
    assert found.discrepancy.candidates > 100
    assert found.identification.model.extension is None


def test_two_effects_on_two_joints_are_both_named(search, study, on_joint):
    two = [on_joint(1, falling_with_speed), on_joint(0, growing_with_load)]
    found = search(study(lambda motion: sum(each(motion) for each in two)))
    assert set(named(found)) == {("stribeck", "joint", "j2"), ("load_coulomb", "joint", "j1")}
    assert [each.rank for each in found.discrepancy.findings] == [1, 2]
    assert [each.parent for each in found.discrepancy.lineage[1:]] == [
        each.version for each in found.discrepancy.lineage[:-1]
    ]


def test_an_effect_that_only_the_fitted_logs_have_is_rejected(search, study, on_joint):
    found = search(study(on_joint(1, falling_with_speed), held_out=lambda m: np.zeros_like(m.q)))
    assert named(found) == []
    (objection,) = [each.objection for each in found.discrepancy.rejected if each.effect == "stribeck"]
    assert objection.why in (Why.LITTLE, Why.NOT_SURE)


def test_a_cable_that_holds_once_is_a_contact_and_no_effect_of_its_joint(search, study, on_joint, record):
    """Far above all other moments, so that it does not matter that the joint turns meanwhile."""

    def caught(m):
        """Once, at the heaviest moment of the log: a cable that holds for half a second."""
        heaviest = m.t[np.argmax(np.abs(m.drive[:, 2]))]
        return 4.0 * np.sign(m.drive) * np.exp(-(((m.t - heaviest) / 0.25) ** 2))[:, None]

    found = search([Recording(record(1, on_joint(2, caught)), False), *study()[1:]])
    assert named(found) == [("contact", "link", "lj3")]


def test_without_a_held_out_log_nothing_is_claimed_and_the_result_says_why(search, study, on_joint):
    found = search(study(on_joint(1, falling_with_speed))[:2])
    assert named(found) == []
    assert found.discrepancy.verdict == "undecided"
    assert found.discrepancy.notes == (Caveat("not_held_out"),)
    assert ("stribeck", "j2") in [(each.effect, each.place.name) for each in found.discrepancy.rejected]


@pytest.mark.parametrize("place", [0, 2])
def test_a_log_in_which_the_joint_stands_still_does_not_decide_what_is_tried(search, study, on_joint, record, place):
    recordings = study(on_joint(1, one_way))
    recordings.insert(place, Recording(record(5, seconds=15.0, still=1), False))
    assert named(search(recordings)) == [("asym_viscous", "joint", "j2")]


def test_the_widest_gap_is_closed_first(search, study, on_joint):
    spring = on_joint(2, lambda m: 1.5 * np.sinh(1.5 * (m.q + 0.3)))
    small = on_joint(1, falling_with_speed)
    found = search(study(lambda motion: spring(motion) + small(motion)))
    assert named(found) == [("joint_spring", "joint", "j3"), ("stribeck", "joint", "j2")]


def test_an_effect_sits_on_an_axis_once(search, study, on_joint):
    found = search(study(on_joint(2, lambda m: one_way(m) + falling_with_speed(m))))
    placed = [(each.effect.name, each.site) for each in found.identification.model.extension.effects]
    assert len(placed) == len(set(placed))
    assert ("asym_viscous", AxisSite(2)) in placed


def test_one_delay_of_all_joints_is_one_finding(search, study):
    found = search(study(late))
    assert named(found) == [("torque_delay", "joint", "all")]
    (finding,) = found.discrepancy.findings
    assert sorted(each.name for each in finding.alike) == ["j1", "j2", "j3"]
    assert finding.parameters["delta"].value == pytest.approx(0.03, abs=0.003)
    assert {each.site for each in found.identification.model.extension.effects} == {AxisSite(k) for k in range(3)}


def test_a_delay_of_one_joint_stays_at_that_joint(search, study, on_joint):
    assert named(search(study(on_joint(1, late)))) == [("torque_delay", "joint", "j2")]


def test_what_follows_no_law_of_the_catalogue_is_not_given_the_nearest_one(search, study, on_joint):
    found = search(study(on_joint(1, wound))).discrepancy
    assert (found.verdict, found.findings) == ("unexplained", ())
    assert found.unexplained[0].channel == "tau.j2"
    refuted = [each for each in found.rejected if each.objection.why is Why.OTHER_LAW]
    assert refuted
    assert all(each.place == Place("joint", "j2") for each in refuted)
    assert all(each.objection.value > 0.5 for each in refuted), "a law that is near, and not it"


@pytest.mark.parametrize("seconds", [0.15, 0.25])
def test_a_size_at_the_edge_of_what_can_be_is_no_name_where_more_than_noise_is_left(search, study, on_joint, seconds):
    found = search(study(on_joint(1, late_by(seconds)))).discrepancy
    assert found.findings == ()
    assert [each.channel for each in found.unexplained] == ["tau.j2"]
    assert {each.objection.why for each in found.rejected if each.effect == "torque_delay"} == {Why.AT_ITS_EDGE}


def test_progress_rises_and_ends_at_one(identified, study, on_joint):
    told = []
    recordings = study(on_joint(2, one_way))
    find_missing_effects(
        identified(recordings), recordings, tuple(shaped_effects().values()), Settings(cutoff_hz=8.0),
        lambda fraction, doing, of="": told.append(fraction),
    )  # fmt: skip
    assert told == sorted(told)
    assert told[-1] == 1.0
