"""How far a count out of few cases can be believed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from scipy.stats import beta

CONFIDENCE = 0.95
NO_CASES = ("n", "names")  # keys of a score that count no cases of its n


def interval_95(count: int, n: int) -> tuple[float, float]:
    """The shares that `count` of `n` cases leave possible, by Clopper and Pearson: exact, never too narrow.

    Two-sided, 2.5 % to either side; where none or all were counted one side is certain, and the other one has all 5 %:
    0 of 50 is below 5.8 %.
    """
    if n == 0:
        return 0.0, 1.0
    beyond = (1.0 - CONFIDENCE) / (1.0 if count in (0, n) else 2.0)
    low = 0.0 if count == 0 else float(beta.ppf(beyond, count, n - count + 1))
    high = 1.0 if count == n else float(beta.ppf(1.0 - beyond, count + 1, n - count))
    return low, high


def intervals(found: Mapping[str, Any]) -> dict[str, Any]:
    """The interval of every count in `found` that has its number of cases `n` beside it, under the same keys."""
    told: dict[str, Any] = {}
    for key, value in found.items():
        if isinstance(value, Mapping):
            if inner := intervals(value):
                told[key] = inner
        elif found.get("n") and isinstance(value, int) and key not in NO_CASES:
            told[key] = [round(bound, 4) for bound in interval_95(value, found["n"])]
    return told


def in_words(count: int, n: int) -> str:
    """`94 %, 83 to 99 %`; `0 %, below 5.8 %`."""
    low, high = (100.0 * bound for bound in interval_95(count, n))
    if count == 0:
        doubt = f"below {_per_cent(high)} %"
    elif count == n:
        doubt = f"above {low:.0f} %"
    else:
        doubt = f"{_per_cent(low)} to {_per_cent(high)} %"
    return f"{100.0 * count / n:.0f} %, {doubt}"


def _per_cent(value: float) -> str:
    """Two digits below ten, whole from there on, tenths where it is next to nothing: never a power of ten."""
    if value < 0.1:
        return f"{value:.1f}"
    return f"{value:.2g}" if value < 9.95 else f"{value:.0f}"
