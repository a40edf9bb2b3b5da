"""Two causes that no motion can tell apart, and two that one can, at a force/torque sensor inside the robot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.sensor_arm import JOINTS, describe, record, wrist

from exogauge.effects.catalogue import sensor_effects
from exogauge.effects.effect import Quantity
from exogauge.experiment.design import tell_apart
from exogauge.identification.identify import identify
from exogauge.identification.model import Seen
from exogauge.identification.settings import Recording, Settings
from exogauge.identification.sites import SensorSite
from exogauge.search.ambiguity import undecided
from exogauge.search.candidates import Candidate
from exogauge.search.score import Score
from exogauge.search.site_rows import collect_rows
from exogauge.studies.words.motion_sentences import not_told


class Whole:
    """All six components of a sensor, or all that hangs on it: the same rows."""

    def __init__(self, name, columns):
        self.name, self.of = name, columns

    def label(self, equations):
        return "sensor", self.name, ""

    def kinds(self, equations):
        return tuple(equations.layout.sensor(0))

    def see(self, model, prepared):
        return Seen(None, lambda effect, shape: self.of(model, prepared)[:, None, :])


def read_too_much(model, prepared):
    """(T, 6) per unit of a gain that all components share: what each should read."""
    readings = []
    for component in range(6):
        readings.append(SensorSite(0, component).see(model, prepared).signals.reading)
    sign = model.robot.cuts[0].sign
    return sign * np.stack(readings, axis=1)


def weigh_more(model, prepared):
    """(T, 6) per unit of a factor on all masses beyond the sensor, by the regressor."""
    equations, phi = model.equations, model.equations.base.regroup @ model.identified.phi.ravel()
    (cut,) = equations.cuts
    rows = [block @ phi[own] for block, own in zip(cut.fill(prepared.motion), cut.columns, strict=True)]
    return -np.stack(rows, axis=1)


class Factor:
    name, place, sentence, shapes, confounds, needs, coordinate = "factor", "sensor", "", (), (), "", "reading"
    coefficients = (Quantity("factor", "1"),)


def sure(site, effect, shape, size) -> Score:
    return Score(Candidate(effect, site, shape), 1.0, 1.0, np.atleast_1d(size), np.zeros(0), np.zeros(0), 1.0)


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    robot = describe(tmp_path_factory.mktemp("arm"), [wrist()])
    recordings = [Recording(record(seed, [wrist()], seconds=12.0), False) for seed in (1, 2)]
    return identify(robot, recordings, Settings(cutoff_hz=5.0)).model, recordings


def outcome_of(case, scores):
    model, recordings = case
    scores = [replace(each, step=np.zeros(model.equations.size)) for each in scores]
    rows = collect_rows(model, recordings, list(dict.fromkeys(each.candidate.site for each in scores)))
    kind = model.equations.layout.sensor(0)[0]
    doubt = undecided(model, scores, kind, float(model.solution.weights[kind]) ** -0.5, rows)
    return tell_apart(doubt, [each.log for each in recordings])


@pytest.mark.slow
def test_a_gain_of_all_components_is_a_mass_whatever_the_motion(case):
    gain, mass = Whole("gain", read_too_much), Whole("mass", weigh_more)
    outcome = outcome_of(case, [sure(gain, Factor(), (), 0.05), sure(mass, Factor(), (), 0.05)])
    assert outcome.motions == ()
    (apart,) = outcome.pairs
    assert apart.seconds is None
    assert max(apart.left_now, apart.left_then) < 1e-6
    assert "both look the same" in not_told(apart)


@pytest.mark.slow
def test_a_gain_of_one_component_is_told_from_a_leak_by_turning_the_wrist(case):
    site, known = SensorSite(0, 0), sensor_effects()
    scores = [sure(site, known["ft_gain"], (), 0.01), sure(site, known["ft_crosstalk"], (1.0,), 0.01)]
    outcome = outcome_of(case, scores)
    (apart,) = outcome.pairs
    assert apart.seconds is not None
    assert outcome.motions[0].joint in JOINTS
    assert apart.evidence > 10.0
