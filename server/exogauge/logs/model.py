"""A log: channels of one recording on one clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:  # whoever only reads a log need not load SciPy
    from exogauge.logs.filtering import StoredPass

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Note:
    """What was done to a log before anything was computed from it. rule: a stable short code; row from 1."""

    rule: str
    detail: str
    advice: str = ""
    row: int | None = None


@final
@dataclass(frozen=True)
class Beside:
    """What was recorded right before and after a log that is a part of a recording: channel -> values at the log's own
    rate, oldest first. For filters alone: nothing of it is fitted or told with the log."""

    before: Mapping[str, Array]
    after: Mapping[str, Array]


@final
@dataclass(frozen=True)
class Log:
    """One recording, SI units, contract channel names (`q.<joint>`, `acc.x`, `ft.<sensor>.fx` …).

    time: (T,) [s] strictly increasing. channels: name -> (T,) in the channel's SI unit.
    stored: the low-pass that all channels have passed before they were stored, None where nothing is known of one.
    What is computed from such a log has to pass it as well.
    left_out: spans (from, to) [s] of its time in which something happened that is not the robot's own, such as a push:
    nothing is fitted there, and no error counted.
    notes: what was done to it. part_of: the recording that it is a stretch of (`segments`), "" for a whole one.
    beside: what of that recording filters may lean on at its ends (`beside`), None where there is nothing.
    """

    name: str
    time: Array
    channels: Mapping[str, Array]
    stored: StoredPass | None = None
    left_out: tuple[tuple[float, float], ...] = ()
    notes: tuple[Note, ...] = ()
    part_of: str = ""
    beside: Beside | None = None

    def __post_init__(self) -> None:
        if self.time.ndim != 1:
            raise ValueError(f"time of log {self.name!r} must be one-dimensional")
        for name, values in self.channels.items():
            if values.shape != self.time.shape:
                raise ValueError(
                    f"channel {name!r} of log {self.name!r} has shape {values.shape}, time {self.time.shape}"
                )

    @property
    def recording(self) -> str:
        """The log's name in study.yaml."""
        return self.part_of or self.name

    @property
    def samples(self) -> int:
        return self.time.size

    @cached_property
    def rate_hz(self) -> float:
        """Median sampling rate [Hz]."""
        return float(1.0 / np.median(np.diff(self.time)))

    def as_stored(self, values: Array) -> Array:
        """(T, …) computed from this log, through the low-pass before it was stored, if any."""
        return values if self.stored is None else self.stored.apply(values, self.rate_hz)

    def has(self, *names: str) -> bool:
        return all(name in self.channels for name in names)

    def stack(self, names: Sequence[str]) -> Array:
        """(T, len(names)) in the order asked for."""
        return np.column_stack([self.channels[name] for name in names])
