"""What begins between two logs: the logs before are the reference."""

import numpy as np
import pinocchio as pin
import pytest
from tests.discrepancy.conftest import FRICTION

from exogauge.detect.pipeline import find_missing_effects
from exogauge.effects.catalogue import missing_effects
from exogauge.effects.order import begins_among, since_log
from exogauge.findings.verdict import Caveat, Objection, Why
from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording, Settings
from exogauge.identification.sites import LinkSite, end_links
from exogauge.search.afterwards import has_joined, look_into_odd_logs
from exogauge.search.search import searched as searched_for
from exogauge.search.state import Problem
from exogauge.search.taken_out import taken_back
from exogauge.studies.words.finding_sentences import finding_sentence, where_words

pytestmark = pytest.mark.slow

SETTINGS = Settings(cutoff_hz=8.0)
LOAD_KG, LOAD_AT = 0.4, np.array([0.05, -0.02, 0.12])


@pytest.fixture(scope="module")
def loaded(arm_urdf):
    """Torque that a load in the last link asks for, by pinocchio."""
    models = [pin.buildModelFromXML(arm_urdf) for _ in range(2)]
    models[1].appendBodyToJoint(3, pin.Inertia(LOAD_KG, LOAD_AT, 1e-3 * np.eye(3)), pin.SE3.Identity())
    data = [model.createData() for model in models]

    def torque(m):
        a = np.gradient(m.v, m.t, axis=0)
        return np.array([
            pin.rnea(models[1], data[1], *row) - pin.rnea(models[0], data[0], *row)
            for row in zip(m.q, m.v, a, strict=True)
        ])  # fmt: skip

    return torque


def rougher(m):
    """At the second joint, other friction than before; it rises a little less than in proportion to speed."""
    return np.sign(m.v) * (0.5 + 0.4 * np.abs(m.v) ** 0.9) * (np.arange(3) == 1)


@pytest.fixture(scope="module")
def searched(robot, record):
    """(hidden, from which of four logs on) -> what is found; the fourth log is held out."""

    def run(hidden, since):
        logs = [record(seed, *([hidden] if number >= since else [])) for number, seed in enumerate((1, 2, 3, 9))]
        recordings = [Recording(log, held_out=number == 3) for number, log in enumerate(logs)]
        return find_missing_effects(identify(robot, recordings, SETTINGS), recordings, missing_effects(), SETTINGS)

    return run


@pytest.mark.parametrize("since", [1, 2])
def test_a_load_picked_up_between_two_logs_is_named_with_its_mass_and_place(searched, loaded, since):
    (finding,) = searched(loaded, since).discrepancy.findings
    assert (finding.effect, finding.place.kind, finding.place.name) == ("payload", "link", "lj3")
    assert finding.parameters["since"].value == since
    true = dict(zip(("mass", "mx", "my", "mz"), (LOAD_KG, *(LOAD_KG * LOAD_AT)), strict=True))
    for name, value in true.items():
        found = finding.parameters[name]
        assert abs(found.value - value) < 4.0 * found.std + 0.02 * LOAD_KG


def test_friction_that_shifts_is_named_with_the_log_from_which_it_does(searched):
    (finding,) = searched(rougher, 2).discrepancy.findings
    assert (finding.effect, finding.place.name) == ("friction_shift", "j2")
    assert finding.parameters["since"].value == 2
    assert finding.parameters["tau_c_change"].value == pytest.approx(0.5, abs=0.1)
    assert finding.held_out.rmse_after < 0.1 * finding.held_out.rmse_before


def test_friction_that_is_another_in_each_log_has_no_name(robot, record):
    """A step takes most of it: it is no step, and there is no name for it."""
    shares = (0.0, 0.3, 1.0, 0.8)
    logs = [
        record(seed, lambda m, share=share: share * rougher(m))
        for seed, share in zip((1, 2, 3, 9), shares, strict=True)
    ]
    recordings = [Recording(log, held_out=number == 3) for number, log in enumerate(logs)]
    found = find_missing_effects(identify(robot, recordings, SETTINGS), recordings, missing_effects(), SETTINGS)
    assert found.discrepancy.findings == ()
    (left,) = [each for each in found.discrepancy.unexplained if each.channel == "tau.j2"]
    told = {fit.log: fit.rmse_moving for fit in found.identification.validation if fit.channel == "tau.j2"}
    every = np.mean(np.square(list(told.values())))
    assert left.where.logs == tuple(
        sorted((log for log in told if told[log] ** 2 > 1.5 * every), key=lambda log: -told[log])
    )
    assert left.where.logs
    assert left.where.times == pytest.approx(told[left.where.logs[0]] / np.sqrt(every), rel=0.1)
    assert f"most in {left.where.logs[0]}" in where_words(left)
    (why,) = [each.objection for each in found.discrepancy.rejected if each.effect == "friction_shift"
              and each.place.name == "j2"]  # fmt: skip
    assert why.why == Why.ANOTHER_IN_EACH_LOG
    assert 0.5 < why.value < 0.9


@pytest.mark.parametrize("until", [np.inf, 20.0])
def test_soft_friction_of_a_joint_that_creeps_in_later_logs_is_no_shift_of_its_friction(robot, record, until):
    """Where it does not creep its friction is that of the sign; which log it is does not matter, nor that it is fast in
    another part of it."""

    def soft(m):
        return FRICTION["tau_c"] * (np.tanh(m.v / 0.02) - np.sign(m.v)) * (np.arange(3) == 1)

    logs = [record(seed, soft, creeps=1 if seed > 3 else None, until=until) for seed in (1, 2, 3, 9, 10)]
    recordings = [Recording(log, held_out=number > 1) for number, log in enumerate(logs)]
    found = find_missing_effects(identify(robot, recordings, SETTINGS), recordings, missing_effects(), SETTINGS)
    assert "friction_shift" not in {each.effect for each in found.discrepancy.findings}


def test_friction_that_shifts_with_the_only_held_out_log_is_named_once_that_log_is_fitted(searched):
    found = searched(rougher, 3).discrepancy
    (finding,) = found.findings
    assert (finding.effect, finding.place.name) == ("friction_shift", "j2")
    assert finding.parameters["since"].value == 3
    assert finding.parameters["tau_c_change"].value == pytest.approx(0.5, abs=0.1)
    log = finding.held_out.log
    assert log
    assert f"the error in {log}" in finding_sentence(finding)
    assert found.notes == (Caveat("joined", log),)
    assert finding.held_out.rmse_after < 0.3 * finding.held_out.rmse_before


def test_a_log_has_joined_for_as_long_as_something_is_named_that_begins_with_it(robot, record):
    """What was named may be taken back, as it may not be told beside all others."""
    logs = [record(seed, *([rougher] if seed == 9 else [])) for seed in (1, 2, 3, 9)]
    recordings = [Recording(log, held_out=number == 3) for number, log in enumerate(logs)]
    search = searched_for(Problem(identify(robot, recordings, SETTINGS), recordings, missing_effects(), SETTINGS))
    assert not has_joined(search)
    joined, notes = look_into_odd_logs(search)
    assert notes
    assert has_joined(joined)
    without = taken_back(joined, len(joined.steps) - 1, Objection(Why.AT_FLOOR))
    assert not has_joined(without)


def test_without_a_change_the_held_out_log_stays_held_out(searched):
    found = searched(lambda m: np.zeros_like(m.v), 0)
    assert found.discrepancy.notes == ()
    assert {fit.held_out for fit in found.identification.validation} == {True, False}


def test_only_a_beginning_among_the_fitted_logs_is_tried():
    shapes = (since_log(),)
    assert [begins_among(shapes, (value,), (0, 1, 3)) for value in (0.0, 1.0, 3.0, 4.0)] == [False, True, True, False]
    assert begins_among((), (), ())


def test_rows_of_a_load_are_what_the_heavier_body_asks_for_more(robot, record):
    recordings = [Recording(record(1), False)]
    model = identify(robot, recordings, SETTINGS).model
    (site,) = end_links(model.equations)
    assert site == LinkSite(2)
    prepared = model.prepare(recordings[0].log)
    (effect,) = [each for each in missing_effects() if each.place == "link"]
    columns = site.see(model, prepared).columns(effect, (-1.0,))
    base = model.equations.base.regroup
    more = np.zeros(robot.tree.phi.shape)
    more[2, :4] = [1.0, 0.1, -0.2, 0.3]
    asked = model.equations.of_bodies(prepared.motion, base @ more.ravel())
    told = -np.einsum("tck,c->tk", columns, more[2, :4])
    np.testing.assert_allclose(told, asked[:, model.equations.layout.in_told(site.kinds(model.equations))], atol=1e-9)
