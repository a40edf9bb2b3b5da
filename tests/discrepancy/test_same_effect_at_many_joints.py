"""Drives of one make lack the same: what many joints show beyond doubt is named in one round."""

from __future__ import annotations

import numpy as np
import pytest

from exogauge.findings.result import Place
from exogauge.search.state import rounds_of

from .conftest import JOINTS

pytestmark = pytest.mark.slow


def peaks(motion):
    """Stribeck's curve at all joints, each of its own size."""
    return np.array([0.9, 1.1, 0.7]) * np.sign(motion.v) * np.exp(-np.abs(motion.v) / 0.3)


def one_peak(motion):
    torque = np.zeros_like(motion.q)
    torque[:, 1] = peaks(motion)[:, 1]
    return torque


@pytest.fixture(scope="module")
def named(study, searched):
    return searched(study(peaks))


def test_all_are_named_in_one_round(named):
    assert {(each.finding.effect, each.finding.place) for each in named.steps} == {
        ("stribeck", Place("joint", name)) for name in JOINTS
    }
    assert [len(each) for each in rounds_of(named.steps)] == [3]
    assert [each.finding.rank for each in named.steps] == [1, 2, 3]
    assert named.rounds == 2


def test_each_takes_its_own_error_off(named):
    for step in named.steps:
        held = step.finding.held_out
        assert held.channel == f"tau.{step.finding.place.name}"
        assert held.rmse_after < 1.1 * held.noise_floor < held.rmse_before


def test_joints_that_lack_nothing_are_not_drawn_in(study, searched):
    named = searched(study(one_peak))
    assert [(each.finding.effect, each.finding.place.name) for each in named.steps] == [("stribeck", "j2")]
