"""What the doctor is told about a robot, and what it says about a log."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.examining import Examining
from exogauge.logs.model import Log

Array = NDArray[np.float64]
ACC, GYRO = ("acc.x", "acc.y", "acc.z"), ("gyro.x", "gyro.y", "gyro.z")
Severity = Literal["error", "warning", "note"]


@final
@dataclass(frozen=True)
class Finding:
    """One thing seen in a log. error: results would be wrong; warning: they may be; note: good to know.

    channel: contract name, `t` for the clock, `ft.*` for all contact sensors together. rule: a stable short code.
    row counts data rows from 1. value: the number behind the verdict, its meaning is in `detail`.
    """

    severity: Severity
    channel: str
    rule: str
    detail: str
    advice: str
    row: int | None = None
    value: float | None = None


@final
@dataclass(frozen=True)
class JointLimits:
    """Of one joint. lower, upper: [rad or m]; velocity: [rad/s or m/s]; infinite where unknown. gear: motor turns per
    joint turn. turns: whether it rotates."""

    lower: float = -np.inf
    upper: float = np.inf
    velocity: float = np.inf
    gear: float = 1.0
    turns: bool = True


@final
@dataclass(frozen=True)
class Expectation:
    """What a log of this robot should look like; whatever is None or empty is not checked.

    rate_hz: as declared. joints: by name. weight_n: total mass x g [N]. contacts: sign of each contact sensor that
    carries the standing robot (+1: world on robot). actuation: `current`, `torque` or `none` by joint. noise: std
    by channel kind, as in robot.yaml. criteria: by which it is examined.
    """

    rate_hz: float | None = None
    joints: Mapping[str, JointLimits] = field(default_factory=dict)
    weight_n: float | None = None
    contacts: Mapping[str, float] = field(default_factory=dict)
    actuation: Mapping[str, str] = field(default_factory=dict)
    noise: Mapping[str, float] = field(default_factory=dict)
    criteria: Examining = field(default_factory=Examining)


Rule = Callable[[Log, Expectation], Iterator[Finding]]


def kind_of(channel: str) -> str:
    return channel.partition(".")[0]


def joint_channels(log: Log, kind: str) -> dict[str, Array]:
    """joint name -> (T,) of the channels `<kind>.<joint>`."""
    return {name.partition(".")[2]: values for name, values in log.channels.items() if kind_of(name) == kind}


def varies(values: Array) -> bool:
    """Whether the finite values differ by more than round-off."""
    finite = values[np.isfinite(values)]
    return bool(finite.size and np.ptp(finite) > 1e-12 * np.max(np.abs(finite)))


def vector(log: Log, names: tuple[str, str, str]) -> Array | None:
    """(T, 3), or None where a column or a value is missing."""
    if not log.has(*names):
        return None
    values = log.stack(names)
    return values if np.isfinite(values).all() and values.any() else None


def joints_move(log: Log, span: slice, criteria: Examining, joint: str | None = None) -> bool:
    """Whether any position, or that of the joint, goes through a good part of its range there."""
    return any(
        np.ptp(values[span]) > criteria.in_motion * np.ptp(values)
        for each, values in joint_channels(log, "q").items()
        if joint in (None, each)
    )


def first_row(flags: NDArray[np.bool_]) -> int:
    """The data row, from 1, of the first True."""
    return int(np.argmax(flags)) + 1


def runs(flags: NDArray[np.bool_]) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """Starts and lengths of all runs of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return edges[::2], edges[1::2] - edges[::2]


def longest_run(flags: NDArray[np.bool_]) -> tuple[int, int]:
    """(start, length) of the longest run of True; length 0 where there is none."""
    starts, lengths = runs(flags)
    if starts.size == 0:
        return 0, 0
    longest = int(np.argmax(lengths))
    return int(starts[longest]), int(lengths[longest])
