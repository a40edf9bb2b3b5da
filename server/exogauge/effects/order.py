"""Effects that begin with one of the logs, or sit in one of them: the shape that says which."""

from __future__ import annotations

from collections.abc import Sequence

from exogauge.effects.shaped import Shape

SINCE, LOG = "since", "log"
LATEST = 8  # log that is tried


def since_log() -> Shape:
    """Number of the first log with the effect, from 0 in the order of the study; the first log never has it."""
    return Shape(
        SINCE,
        "1",
        1.0,
        float(LATEST),
        tuple(float(k) for k in range(1, LATEST + 1)),
        choice=True,
        words="number of the first log that has it, from 0",
    )


def one_log() -> Shape:
    """Number of the only log with the effect, from 0 in the order of the study; -1: every log has it."""
    return Shape(
        LOG,
        "1",
        -1.0,
        float(LATEST),
        tuple(float(k) for k in range(-1, LATEST + 1)),
        choice=True,
        words="number of the only log that has it, from 0; -1: all have it",
    )


def bounded(shapes: Sequence[Shape]) -> bool:
    """Whether an effect begins with a log or sits in one."""
    return any(each.name in (SINCE, LOG) for each in shapes)


def about(shapes: Sequence[Shape], values: Sequence[float], number: int) -> bool:
    """Whether an effect with these values of its shapes begins with the log of this number, or sits in it alone."""
    return any(each.name in (SINCE, LOG) and value == number for each, value in zip(shapes, values, strict=True))


def present(shapes: Sequence[Shape], values: Sequence[float], number: int) -> bool:
    """Whether an effect with these values of its shapes is there in the log of this number; -1: not known, it is."""
    named = dict(zip((shape.name for shape in shapes), values, strict=True))
    since, log = named.get(SINCE, -1.0), named.get(LOG, -1.0)
    return number < 0 or (number >= since and (log < 0.0 or number == int(log)))


def whatever_log(shapes: Sequence[Shape], values: Sequence[float]) -> tuple[float, ...]:
    """The other shapes' values: in one log, effects that differ in nothing else are there alike, or not at all."""
    return tuple(value for each, value in zip(shapes, values, strict=True) if each.name not in (SINCE, LOG))


def begins_among(shapes: Sequence[Shape], values: Sequence[float], numbers: Sequence[int]) -> bool:
    """Whether an effect with these values of its shapes begins after the first and not after the last of the logs with
    these numbers, or sits in one of them; true of one that no log bounds."""
    named = dict(zip((shape.name for shape in shapes), values, strict=True))
    first, last = min(numbers, default=0), max(numbers, default=0)
    begins = SINCE not in named or first < named[SINCE] <= last
    return begins and (LOG not in named or named[LOG] < 0.0 or named[LOG] in numbers)
