"""The report's axes say where their ticks are, without a number to be added in a corner."""

from __future__ import annotations

import re

import numpy as np
import pytest

from exogauge.identification.result import Channels, Prediction
from exogauge.studies.report.figures import draw_curve, draw_series


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (1000.0, 1000.01), (-0.6, 0.5), (-12500.0, -12490.0)])
def test_labels_lie_among_the_values_evenly_and_no_offset_is_written(low: float, high: float) -> None:
    values = np.linspace(low, high, 50)
    told = {"tau.a": values}
    channels = Channels(told, told, told, {})
    prediction = Prediction("id", False, np.arange(50.0), {"tau.a": "N·m"}, lambda: channels)
    drawn = draw_series(prediction, channels, ["tau.a"], {}, "k")
    words = re.findall(r"<text[^>]*>([^<]*)</text>", drawn)
    labels = [float(each.replace("−", "-")) for each in words[words.index("time [s]") + 1 : words.index("[N·m]")]]
    assert len(labels) > 2
    assert min(labels) >= low - (high - low)
    assert max(labels) <= high + (high - low)
    assert np.ptp(np.diff(labels)) < 1e-6 * (high - low)
    assert words[words.index("[N·m]") + 1 :] == ["a"]


def test_powers_of_ten_of_the_priors_weight_are_text_of_their_own() -> None:
    svg = draw_curve([(10.0**power, 1.0 + power**2) for power in (-2, -1, 0, 1, 2)], 1.0, "curve")
    found = re.findall(r">([^<>\n]+)<", svg)
    assert found[:5] == ["10⁻²", "10⁻¹", "10⁰", "10¹", "10²"]
