"""What was named first is doubted once more is in the model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exogauge.effects.catalogue import shaped_effects
from exogauge.findings.result import Place
from exogauge.findings.verdict import Why
from exogauge.identification.model import AddedEffect
from exogauge.identification.sites import AxisSite
from exogauge.search.state import Step
from exogauge.search.taken_out import identified_again, without_what_is_not_needed

pytestmark = pytest.mark.slow


def peak(motion):
    """Stribeck's curve at j2, fading slower than the catalogue's."""
    torque = np.zeros_like(motion.q)
    torque[:, 1] = 0.9 * np.sign(motion.v[:, 1]) / (1.0 + (motion.v[:, 1] / 0.08) ** 2)
    return torque


@pytest.fixture
def named(study, searched):
    """A search that has named what is hidden."""
    return searched(study(peak))


def test_several_that_later_ones_make_needless_are_all_taken_back(named):
    (true,) = named.steps
    needless = [AddedEffect(shaped_effects()["joint_spring"], AxisSite(axis), (0.0,)) for axis in (0, 2)]
    guesses = [
        Step(
            added, replace(true.finding, effect="joint_spring", place=Place("joint", name)), true.identified, true.gone
        )
        for added, name in zip(needless, ("j1", "j3"), strict=True)
    ]
    true_again = replace(true, identified=named.when_asked([*needless, true.added]))
    named = without_what_is_not_needed(replace(named, steps=(*guesses, true_again)))
    assert [each.added for each in named.steps] == [true.added]
    assert [each.finding.rank for each in named.steps] == [1]
    for added in needless:
        assert named.failed["joint_spring", added.site].objection.why is Why.NOT_NEEDED


def test_what_is_needed_stays(named):
    before = list(named.steps)
    other = AddedEffect(shaped_effects()["joint_spring"], AxisSite(0), (0.0,))
    second = replace(before[0], added=other, identified=named.when_asked([before[0].added, other]))
    named = without_what_is_not_needed(replace(named, steps=(*before, second)))
    assert [each.added for each in named.steps] == [before[0].added, other]


def test_a_chain_gone_through_again_costs_no_identification_that_nobody_asks_for(named):
    (true,) = named.steps
    other = AddedEffect(shaped_effects()["joint_spring"], AxisSite(0), (0.0,))
    first, last = identified_again(named, [true, replace(true, added=other)]).steps
    assert np.array_equal(last.found.phi, named.problem.identified(named.eyes, [true.added, other]).phi)
    assert [each.identified.cache_info().currsize for each in (first, last)] == [0, 1]
    assert np.array_equal(first.found.phi, true.found.phi)


def test_what_is_taken_out_of_a_round_leaves_its_model_too(named):
    (true,) = named.steps
    other = AddedEffect(shaped_effects()["joint_spring"], AxisSite(0), (0.0,))
    both = named.when_asked([true.added, other])
    needless = replace(true, added=other, identified=both, beside=True)
    named = without_what_is_not_needed(replace(named, steps=(replace(true, identified=both), needless)))
    assert [each.added for each in named.steps] == [true.added]
    assert named.current.model.extension.effects == (true.added,)
