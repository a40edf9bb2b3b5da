"""The count itself: honest claims are inside as often as they say, claims of half the doubt are not."""

from __future__ import annotations

import numpy as np
import pytest
from tests.calibration.__main__ import table
from tests.calibration.kinds import Told


def claims(overconfident: float, told: bool = True) -> list[Told]:
    rng = np.random.default_rng(0)
    return [Told("k_T", "k_T[j]", 5.0 + 0.1 * overconfident * z, 0.1, 5.0, told) for z in rng.normal(size=4000)]


@pytest.mark.slow
def test_honest_claims_hold_as_often_as_they_say():
    shares = [np.mean([each.inside(level) for each in claims(1.0)]) for level in (0.5, 0.8, 0.95)]
    np.testing.assert_allclose(shares, (0.5, 0.8, 0.95), atol=0.02)


def test_claims_of_half_the_doubt_do_not():
    assert np.mean([each.inside(0.95) for each in claims(2.0)]) < 0.7


def test_a_stated_interval_is_what_counts_at_its_level():
    one = Told("stiffness, A", "stiffness[left]", 200.0, 1.0, 210.0, True, (195.0, 211.0))
    assert one.inside(0.95)
    assert not one.inside(0.8)


@pytest.mark.slow
@pytest.mark.parametrize(("told", "lines"), [(True, 3), (False, 2)])
def test_what_a_result_does_not_tell_does_not_count(told, lines):
    assert len(table(claims(1.0, told)).splitlines()) == lines
