"""The page rounds as the report does: `web/src/parts/digits.ts` and `studies/words/rounding.py` hold the same rules."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from tests.web import page_code

from exogauge.studies.words import rounding

by_the_page = partial(page_code.by_the_page, "parts/digits.ts")
SIZES = [mantissa * 10.0**power for power in range(-9, 8) for mantissa in (0.998, 1.0, 2.5316, 9.96)]
VALUES = [0.0, *SIZES, *(-size for size in SIZES)]


def test_numbers_alone_have_the_digits_of_the_report() -> None:
    calls: list[tuple[str, Sequence[Any]]] = [
        ("significant", (value, digits)) for value in VALUES for digits in (2, 3, 4)
    ]
    assert by_the_page(calls) == [rounding.significant(*given) for _, given in calls]


def test_a_value_beside_its_doubt_has_the_places_of_the_report() -> None:
    pairs = [(value, std) for value in VALUES for std in SIZES if std > 2e-5 * abs(value)]
    assert len(pairs) > 1000
    assert by_the_page([("withStd", [*pair]) for pair in pairs]) == [[*rounding.with_std(*pair)] for pair in pairs]


def test_what_somebody_wrote_is_shown_without_needless_zeros() -> None:
    written = {0.25: "0.25", 3.0: "3", 100.0: "100", -1200.0: "−1200", 2e-7: "2·10⁻⁷", 0.0: "0", 30.50: "30.5"}
    assert by_the_page([("figure", [value]) for value in written]) == [*written.values()]


def test_what_is_missing_is_a_dash_and_a_value_without_doubt_stands_alone() -> None:
    asked: list[tuple[str, list[Any]]] = [
        ("figure", [None]),
        ("fixed", [None, 2]),
        ("significant", [None]),
        ("plusMinus", [None, 1.0]),
    ]
    assert by_the_page(asked) == ["–"] * 4
    assert by_the_page([("plusMinus", [3.0, None]), ("plusMinus", [197.83, 0.61])]) == ["3", "197.83 ± 0.61"]
