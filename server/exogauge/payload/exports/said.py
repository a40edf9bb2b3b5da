"""What every export says of itself: what it is of, its frame and its units; and numbers without loss."""

from __future__ import annotations

from collections.abc import Iterable

from exogauge.payload.exports.body import TENSOR, Body


def said(body: Body, units: str, before: str = "") -> str:
    """Lines of a comment, each after `before`, which programs of controllers have: these are ASCII. Nothing in them
    ends a comment of any of the formats."""
    doubts = zip(("m", "cx", "cy", "cz", *TENSOR), body.std, strict=False)
    lines = [
        f"exogauge: {body.name}",
        f"frame: {body.frame}",
        "of: what hangs on the sensor; the sensor's own body is not in it",
        f"units: {units}",
        f"standard deviations (kg, m, kg·m²): {', '.join(f'{name} {std:.2g}' for name, std in doubts)}",
    ]
    if body.possible:
        lines.append("the estimate was no possible body; these are the values of the likeliest one that is")
    if body.lacking:
        lines.append(f"look into the results first. {body.lacking}")
    text = "\n".join(before + plain(line) for line in lines)
    return text.replace("·", " ").replace("²", "^2").encode("ascii", "replace").decode() if before else text


def plain(text: str) -> str:
    """Names come from uploads: one line, and no end of a comment in it."""
    return " ".join(text.replace("--", "- -").replace("\0", " ").split())


def numbers(values: Iterable[float]) -> str:
    """With every digit."""
    return " ".join(repr(float(value)) for value in values)


def fixed(value: float, digits: int) -> str:
    """Without an exponent, which not every controller reads; zero has no sign."""
    return f"{value + 0.0:.{digits}f}" if round(value, digits) else f"{0:.{digits}f}"
