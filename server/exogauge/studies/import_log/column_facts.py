"""What is known of a foreign column and of its robot, and what is said of the column: a suggestion or advice."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, final

UNKNOWN = "Say what it measures (channel and unit), or list it under `ignore`."
SI = {"q": "rad", "dq": "rad/s", "ddq": "rad/s^2", "i": "A", "tau": "Nm", "acc": "m/s^2", "gyro": "rad/s",
      "temp": "degC", "f": "N", "m": "Nm"}  # fmt: skip
OTHER = {"q": "deg", "dq": "deg/s", "i": "mA", "tau": "mNm", "gyro": "deg/s", "m": "mNm"}  # what it may be as well
LARGE = {"q": 7.0, "dq": 40.0, "i": 200.0, "tau": 2000.0, "gyro": 35.0, "m": 2000.0}  # beyond what SI units give


@final
@dataclass(frozen=True)
class Seen:
    """One column. low, high: of its finite values. step: median difference, where it rises throughout, else None."""

    name: str
    low: float
    high: float
    step: float | None = None

    @property
    def size(self) -> float:
        return max(abs(self.low), abs(self.high))


@final
@dataclass(frozen=True)
class JointFacts:
    """lower, upper: [rad or m]; velocity: [rad/s or m/s]; infinite where unknown."""

    name: str
    lower: float = -math.inf
    upper: float = math.inf
    velocity: float = math.inf


@final
@dataclass(frozen=True)
class Wearer:
    """What is known of the robot; joints None where no robot is named."""

    joints: tuple[JointFacts, ...] | None = None
    sensors: tuple[str, ...] = ()


@final
@dataclass(frozen=True)
class Suggestion:
    """channel: contract name, `t` for the time. why: what it rests on, in a sentence; sure: nothing else fits."""

    channel: str
    unit: str
    sign: Literal[1, -1] = 1
    side: Literal["joint", "motor"] = "joint"
    sure: bool = False
    why: str = ""


@final
@dataclass(frozen=True)
class Advice:
    """Why there is no suggestion, and what to do."""

    text: str


def too_large(column: Seen, kind: str) -> bool:
    """For the SI unit, by what joints and sensors do."""
    return column.size > LARGE.get(kind, math.inf)
