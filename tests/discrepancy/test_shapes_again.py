"""A shape that was found with a robot bent by what it lacked is sought once more with the model that has it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exogauge.search.afterwards import shapes_again
from exogauge.search.residual_correction import held_out_rmse
from exogauge.search.state import Search
from exogauge.studies.words.finding_sentences import finding_sentence

pytestmark = pytest.mark.slow

PEAK, SPEED = 1.5, 0.15


def peak(motion):
    """Stribeck's curve at j2, as in the catalogue."""
    torque = np.zeros_like(motion.q)
    v = motion.v[:, 1]
    torque[:, 1] = PEAK * np.sign(v) * np.exp(-((v / SPEED) ** 2))
    return torque


@pytest.fixture
def named(study, searched):
    return searched(study(peak))


def at_shape(search: Search, shape: tuple[float, ...]) -> Search:
    """The same steps, the only one's shape replaced."""
    (step,) = search.steps
    added = replace(step.added, shape=shape)
    return replace(search, steps=(replace(step, added=added, identified=search.when_asked([added])),))


def test_a_shape_that_is_off_is_put_right_and_told(named):
    (right,) = named.steps
    assert right.finding.effect == "stribeck"
    v_s, delta = right.added.shape
    named = at_shape(named, (3.0 * v_s, delta))
    (off,) = named.steps
    worse, floor = held_out_rmse(off.finding, off.finding.held_out.channel, off.found)
    assert worse > 1.2 * floor, "three times too wide a peak hardly shows: this shows nothing"
    (again,) = shapes_again(named).steps
    found = again.finding.parameters
    assert found["v_s"].value == pytest.approx(SPEED, rel=0.1)
    assert found["tau_b"].value == pytest.approx(PEAK, rel=0.1)
    assert again.found.model.extension.effects == (again.added,), "the model that is handed on has the new shape"
    assert again.finding.held_out.rmse_after < 1.05 * floor
    assert [each.what for each in again.finding.refined] == ["shape"]
    assert "With its shape sought again" in finding_sentence(again.finding)


def test_one_that_leaves_nothing_stays(named):
    assert len(named.steps) == 1
    assert shapes_again(named) is named


def test_a_try_that_failed_leaves_nothing_behind(named):
    """What the next identification sees loads with would move its offsets by some per cent."""
    (step,) = named.steps
    far = replace(step.finding, held_out=replace(step.finding.held_out, channel="tau.j1"))
    named = replace(named, steps=(replace(step, finding=far),))  # no shape of j2's friction lowers the error of j1
    settings = named.problem.settings
    always = replace(settings.criteria, search=replace(settings.criteria.search, shapes_above=0.0))
    named = replace(named, problem=replace(named.problem, settings=replace(settings, criteria=always)))
    assert shapes_again(named) is named
