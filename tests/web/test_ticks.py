"""What stands at an axis is the place of its tick, to the last digit: `web/src/plots/ticks.ts`."""

from __future__ import annotations

import re
from decimal import Decimal

import pytest
from tests.web.page_code import by_the_page

RAISED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


@pytest.mark.parametrize("factor", ["1", "2", "2.5", "5"])
@pytest.mark.parametrize("first", [-3, 0, 7, 399])
def test_a_label_says_exactly_where_its_tick_is(factor: str, first: int) -> None:
    """The steps that uPlot and our own axes take, from 10⁻¹² to 10⁶."""
    powers = range(-12, 7)
    exact = [[Decimal(factor).scaleb(power) * (first + k) for k in range(5)] for power in powers]
    words = by_the_page("plots/ticks.ts", [("tickWords", [[float(each) for each in axis]]) for axis in exact])
    for asked, said in zip(exact, words, strict=True):
        assert [read(each) for each in said] == asked, said


def test_labels_have_no_places_that_the_step_does_not_need() -> None:
    axes = {(0.0, 0.5, 1.0): ["0.0", "0.5", "1.0"], (0.0, 0.1 + 0.2, 0.6): ["0.0", "0.3", "0.6"]}
    axes |= {(10.0, 20.0): ["10", "20"], (-2.5, 0.0, 2.5): ["−2.5", "0.0", "2.5"], (3.25,): ["3.25"]}
    assert by_the_page("plots/ticks.ts", [("tickWords", [list(axis)]) for axis in axes]) == [*axes.values()]


def read(text: str) -> Decimal:
    mantissa, _, power = text.replace("−", "-").partition("·10")
    assert re.fullmatch(r"-?[\d.]+", mantissa), text
    return Decimal(mantissa).scaleb(int(power.translate(RAISED) or 0))
