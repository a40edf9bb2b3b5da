"""How often a claim about shares is drawn: few times in every run, where a gross fault shows, many before a release."""

from __future__ import annotations

import pytest
from scipy.stats import binom

RARELY = 1e-3  # that a claim which holds would fail by the draws alone


def drawn(few: int, many: int) -> pytest.MarkDecorator:
    """Parametrises `draws`; the many of `make thorough`."""
    return pytest.mark.parametrize("draws", [few, pytest.param(many, marks=pytest.mark.thorough)])


def met_in(share: float, draws: int) -> tuple[float, float]:
    """Least and largest share of so many draws that are met, where `share` of all are."""
    least, most = binom.ppf([RARELY, 1.0 - RARELY], draws, share) / draws
    return float(least), float(most)
