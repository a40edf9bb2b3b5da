"""Friction of a motor that turns with two joints is named at the right pair, with its ratio."""

from __future__ import annotations

import numpy as np
import pytest

from exogauge.detect.pipeline import Found, find_missing_effects
from exogauge.effects.catalogue import missing_effects
from exogauge.identification.settings import Settings
from exogauge.identification.sites import PairSite, neighbours

pytestmark = pytest.mark.slow

SETTINGS = Settings(cutoff_hz=8.0)


def of_the_wrist(ratio):
    """Motor of j3 turns with j3 + ratio j2. Smooth friction: no sign() as in the catalogue."""

    def hidden(motion):
        speed = motion.v[:, 2] + ratio * motion.v[:, 1]
        drag = 0.5 * np.tanh(speed / 0.05) + 0.35 * speed
        return np.stack([np.zeros_like(drag), ratio * drag, drag], axis=1)

    return hidden


@pytest.fixture(scope="module")
def search(identified, study):
    def run(**how) -> Found:
        recordings = study(**how)
        return find_missing_effects(identified(recordings), recordings, missing_effects(), SETTINGS)

    return run


def test_neighbours_are_each_joint_and_the_driven_one_before_it(robot):
    assert neighbours(robot) == [PairSite(1, 0), PairSite(2, 1)]


@pytest.mark.slow
def test_what_every_model_has_is_no_coupling(search):
    assert search().discrepancy.findings == ()


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [1.0, -0.7])
def test_a_motor_that_turns_with_two_joints_is_named_with_its_ratio(search, ratio):
    first = search(hidden=of_the_wrist(ratio)).discrepancy.findings[0]
    assert (first.effect, first.place.kind, first.place.name) == ("coupling", "joint", "j3")
    found = first.parameters["ratio"]
    assert abs(found.value - ratio) < max(3.0 * found.std, 0.02)
    assert first.parameters["coupled_viscous"].value == pytest.approx(0.35, rel=0.06)  # tanh is a little viscous
    assert first.parameters["coupled_inertia"].value < 0.005
