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
from exogauge.search.taken_out import without_what_is_not_needed

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
        Step(added, replace(true.finding, effect="joint_spring", place=Place("joint", name)), true.found, true.gone)
        for added, name in zip(needless, ("j1", "j3"), strict=True)
    ]
    true_again = replace(true, found=named.identified([*needless, true.added]))
    named = without_what_is_not_needed(replace(named, steps=(*guesses, true_again)))
    assert [each.added for each in named.steps] == [true.added]
    assert [each.finding.rank for each in named.steps] == [1]
    for added in needless:
        assert named.failed["joint_spring", added.site].objection.why is Why.NOT_NEEDED


def test_what_is_needed_stays(named):
    before = list(named.steps)
    other = AddedEffect(shaped_effects()["joint_spring"], AxisSite(0), (0.0,))
    second = replace(before[0], added=other, found=named.identified([before[0].added, other]))
    named = without_what_is_not_needed(replace(named, steps=(*before, second)))
    assert [each.added for each in named.steps] == [before[0].added, other]
