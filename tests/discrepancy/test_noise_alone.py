"""Noise of the positions that an effect smooths is no effect; what a spring takes off beside such noise is."""

from dataclasses import replace

import numpy as np
import pytest
from tests.discrepancy.conftest import RATE, SETTINGS, Motion, nothing

from exogauge.detect.pipeline import find_missing_effects
from exogauge.effects.catalogue import shaped_effects
from exogauge.findings.verdict import Why
from exogauge.identification.identify import identify
from exogauge.identification.settings import Recording
from exogauge.search import search

pytestmark = pytest.mark.slow

WIDE = replace(SETTINGS, cutoff_hz=40.0)  # accelerations hold more noise than motion there


def found(robot, recordings):
    effects = tuple(shaped_effects().values())
    return find_missing_effects(identify(robot, recordings, WIDE), recordings, effects, WIDE).discrepancy


def test_a_spring_that_would_smooth_a_noisy_acceleration_is_not_named(robot, study, record, monkeypatch):
    noise = {"encoder": 2e-5, "noise": 0.02}
    recordings = [*study(nothing, **noise), Recording(record(10, **noise), True)]
    taken, in_any_order = search.noise_taken, []

    def asked_twice(model, judged, rows, some):
        in_any_order.append((taken(model, judged, rows, some), taken(model, judged, rows, some[::-1])))
        return in_any_order[-1][0]

    monkeypatch.setattr(search, "noise_taken", asked_twice)
    said = found(robot, recordings)
    assert in_any_order
    assert all(one == other for one, other in in_any_order)  # logs are looked at side by side
    assert said.findings == ()
    whys = {each.effect: each.objection.why for each in said.rejected}
    assert whys["elasticity"] == Why.NOISE_ALONE


def test_a_spring_that_takes_off_more_than_noise_is_named_beside_it(robot, study, on_joint):
    def given_way(motion: Motion) -> np.ndarray:
        return -5e-3 * np.gradient(np.gradient(motion.load, 1.0 / RATE, axis=0), 1.0 / RATE, axis=0)

    said = found(robot, study(on_joint(1, given_way), encoder=2e-5, noise=0.02))
    assert [(each.effect, each.place.name) for each in said.findings] == [("elasticity", "j2")]
