"""What a stream says, as plain values: the same on a websocket and in a terminal; and how the
service and the process of a stream pass it on: length, kind, content.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, final

import numpy as np
from numpy.typing import NDArray

from exogauge.errors import BadInput, ExogaugeError, Fault

if TYPE_CHECKING:  # a server, which passes messages on, loads no numerics
    from exogauge.payload.live import Known, Sensed
    from exogauge.payload.live_input import Counts

Array = NDArray[np.float64]


def wrench_message(sensed: Sensed, numbers: Sequence[int]) -> dict[str, Any]:
    """numbers: of the samples. Wrench and std in N, N·m."""
    digits = 6  # of a number that is told: a hundredth of its standard deviation needs no more
    return {
        "type": "wrench",
        "seq": list(numbers),
        "t": sensed.time.tolist(),
        "wrench": sensed.wrench.round(digits).tolist(),
        "std": sensed.std.round(digits).tolist(),
        "alarm": sensed.alarm.tolist(),
        "settled": sensed.settled.tolist(),
        "zero": sensed.zero,
    }


def payload_message(known: Known, counts: Counts, rate_hz: float) -> dict[str, Any]:
    """Ten times a second."""
    from exogauge.payload.dynamics import NAMES, ZERO_NAMES

    found, names = known.estimate, (*NAMES, *ZERO_NAMES)
    return {
        "type": "payload",
        "t": known.time,
        "state": found.state,
        "value": dict(zip(names, found.value.tolist(), strict=True)),
        "std": dict(zip(names, found.std.tolist(), strict=True)),
        "decided": [name for name, sure in zip(names, found.decided.tolist(), strict=True) if sure],
        "mu": found.mu,
        "mu_std": found.mu_std,
        "threshold_n": known.threshold,
        "late_ms": None if known.late is None else 1e3 * known.late[0],
        "late_std_ms": None if known.late is None else 1e3 * known.late[1],
        "in_doubt": list(known.in_doubt),
        "calibration": known.calibration,
        "used_s": found.used / rate_hz,
        "left_out_s": known.left_out / rate_hz,
        "counts": dict(counts.plain()),
    }


def error_message(error: ExogaugeError | Fault) -> dict[str, Any]:
    """The first fault, and how many there are."""
    faults: tuple[Fault, ...] = (error,) if isinstance(error, Fault) else ()
    if isinstance(error, BadInput):
        faults = error.faults
    first: Mapping[str, Any] = asdict(faults[0]) if faults else {"detail": str(error), "rule": type(error).__name__}
    told = {key: value for key, value in first.items() if value not in (None, "")}
    return {"type": "error", **told, "faults": max(len(faults), 1)}


HEAD = struct.Struct("<IB")
CLIENT_TEXT, CLIENT_BYTES, CONTROL = range(3)
"""Kinds: to or from the client; between service and process."""


def framed(kind: int, content: bytes) -> bytes:
    return HEAD.pack(len(content), kind) + content


@final
class Frames:
    """Whole frames of bytes as they come."""

    def __init__(self) -> None:
        self._left = bytearray()

    def of(self, data: bytes) -> Iterator[tuple[int, bytes]]:
        self._left += data
        at = 0
        while len(self._left) - at >= HEAD.size:
            length, kind = HEAD.unpack_from(self._left, at)
            if len(self._left) - at - HEAD.size < length:
                break
            at += HEAD.size
            yield kind, bytes(self._left[at : at + length])
            at += length
        del self._left[:at]
