"""How many digits a number deserves: two of its standard deviation, and the value to the same place."""

from __future__ import annotations

import math


def with_std(value: float, std: float) -> tuple[str, str]:
    """(value, std) as text, the value to the place of the std's second digit: 5.0316, 0.0412 -> 5.032, 0.041."""
    if not math.isfinite(std) or std <= 0.0:
        return significant(value, 4), "–"
    place = 1 - math.floor(math.log10(std))
    if round(std * 10.0**place) >= 100:  # 0.0998 rounds to 0.10
        place -= 1
    if place < 0:
        return _minus(f"{round(value, place):.0f}"), f"{round(std, place):.0f}"
    if place > 6:
        return significant(value, 4), significant(std, 2)
    return _minus(f"{value:.{place}f}"), f"{std:.{place}f}"


def significant(value: float, digits: int = 3) -> str:
    """Rounded to so many digits; powers of ten only outside 1e-4 … 1e5."""
    if not math.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    exponent = math.floor(math.log10(abs(float(f"{value:.{digits - 1}e}"))))
    if not -4 <= exponent < 5:
        mantissa, _, power = f"{value:.{digits - 1}e}".partition("e")
        return f"{_minus(mantissa)}·10{_raised(int(power))}"
    return _minus(f"{value:.{max(digits - 1 - exponent, 0)}f}")


def rounded(value: float, places: int) -> str:
    return _minus(f"{value:.{places}f}")


def between(low: float, high: float) -> str:
    """An interval, both ends to the place of its half width's second digit: 190.71, 200.93 -> 190.7 … 200.9."""
    if not (math.isfinite(low) and math.isfinite(high) and high > low):
        return "no bounds"
    place = max(0, 1 - math.floor(math.log10(0.5 * (high - low))))
    return f"{rounded(low, place)} … {rounded(high, place)}"


def _minus(text: str) -> str:
    """A true minus sign, and none before a zero."""
    return text.lstrip("-") if not text.strip("-0.") else text.replace("-", "\u2212")


def _raised(power: int) -> str:
    return str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
