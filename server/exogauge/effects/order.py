"""Effects that begin with one of the logs: the shape that says with which."""

from __future__ import annotations

from collections.abc import Sequence

from exogauge.effects.shaped import Shape

SINCE = "since"
LATEST = 8  # log that is tried


def since_log() -> Shape:
    """Number of the first log with the effect, from 0 in the order of the study; the first log never has it."""
    return Shape(SINCE, "1", 1.0, float(LATEST), tuple(float(k) for k in range(1, LATEST + 1)), choice=True)


def begins_among(shapes: Sequence[Shape], values: Sequence[float], numbers: Sequence[int]) -> bool:
    """Whether an effect with these values of its shapes begins after the first and not after the last of the logs with
    these numbers; true of one that does not begin anywhere."""
    since = [value for shape, value in zip(shapes, values, strict=True) if shape.name == SINCE]
    return all(min(numbers, default=0) < value <= max(numbers, default=0) for value in since)
