"""A band whose course is longer throughout than described: its natural length is, by as much, to both sides."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.discrepancy import test_band_effects as trunk_and_bands
from tests.discrepancy.test_band_effects import JOINTS, LENGTHS, NOISE, elsewhere, gathered, measured, trunk

from exogauge.devices.routing import Routing
from exogauge.support.stiffness import identify_bands

__all__ = ["trunk"]

KNOWN_TO = 0.006  # [m]
LOOSER = 0.085  # [m] than in the other tests


def lengths_of(trunk, bands):
    """(bands,) [m] upright."""
    return Routing(trunk.model.robot.tree, bands).geometry(np.zeros((1, 3))).length[0]


@pytest.fixture
def slack_upright(monkeypatch):
    """Every band comes taut only where it is stretched by more than upright."""
    monkeypatch.setattr(trunk_and_bands, "LENGTHS", {name: each + LOOSER for name, each in LENGTHS.items()})


@pytest.mark.slow
def test_an_interval_reaches_as_far_up_as_down_where_a_longer_band_were_slack_for_longer(trunk, slack_upright):
    rng = np.random.default_rng(5)
    described = replace(measured(trunk, KNOWN_TO).device, bands=tuple(
        replace(each, point_std=KNOWN_TO, donning_std=0.0) for each in trunk.device.bands))  # fmt: skip
    drawn = [lengths_of(trunk, [elsewhere(each, KNOWN_TO, int(rng.integers(1 << 30))) for each in described.bands])
             for _ in range(200)]  # fmt: skip
    of_course = np.std(drawn, axis=0)
    seen = gathered(trunk, None, 3, motions=("bend", "mix"), repetitions=2)
    told = identify_bands(trunk.model, described, "A", seen.evidences, np.full(3, NOISE), [], JOINTS)
    slack = [np.concatenate([each.length[:, b] for each in seen.evidences]) < LENGTHS[band.name] + LOOSER
             for b, band in enumerate(described.bands)]  # fmt: skip
    for band, std, below in zip(told.bands, of_course, slack, strict=True):
        assert 0.05 < np.mean(below) < 0.8
        low, high = band.natural_length_interval
        value = band.natural_length.value
        assert value - low > 1.6 * std, band.band
        assert high - value > 1.6 * std, band.band
        assert band.natural_length.std < 2.0 * std
