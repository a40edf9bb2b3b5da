"""Numbers and curve of a named effect are those of one model: the last."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exogauge.detect.pipeline import find_missing_effects
from exogauge.effects.catalogue import shaped_effects
from exogauge.identification.settings import Settings
from exogauge.search.final_numbers import coefficients, place_of, with_final_numbers

AXIS = 1


@pytest.fixture(scope="module")
def found(identified, study):
    def falling(m):
        return 3.0 * np.sign(m.v) * np.exp(-(np.abs(m.v / 0.3) ** 1.4)) * (np.arange(3) == AXIS)

    recordings = study(falling, noise=0.05)
    chosen = (shaped_effects()["stribeck"],)
    return find_missing_effects(identified(recordings), recordings, chosen, Settings(cutoff_hz=8.0))


@pytest.mark.slow
def test_a_later_model_moves_numbers_doubt_and_curve_together(found):
    """As if a joint's scale had been found to be 5 % off, which the whole fit knows to 20 %."""
    (finding,) = found.discrepancy.findings
    model = found.identification.model
    added = model.extension.effects[0]
    values, place = model.identified.added.copy(), place_of(model, added)
    values[place] *= 1.05
    doubt = model.covariance.copy()
    doubt[place, place] += np.diag((0.2 * values[place]) ** 2)
    moved = replace(model, identified=replace(model.identified, added=values), covariance=doubt)
    np.testing.assert_array_equal(coefficients(moved, added), 1.05 * coefficients(model, added))
    now = with_final_numbers(finding, added, moved)
    for quantity in added.effect.coefficients:
        was, is_now = (each.parameters[quantity.name] for each in (finding, now))
        assert is_now.value == pytest.approx(1.05 * was.value, rel=1e-6)
        assert is_now.std >= 0.2 * abs(is_now.value)
    np.testing.assert_allclose(now.evidence.model, 1.05 * finding.evidence.model, rtol=1e-6)
