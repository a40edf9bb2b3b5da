"""What goes into an estimate of the supporting torque, and the choices a user may make about it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final

from exogauge.devices.device import Device
from exogauge.logs.model import Log


@final
@dataclass(frozen=True)
class PlainLog:
    """A log without the device. motion: what the robot did, None where it has no name. held_out: not fitted."""

    log: Log
    motion: str | None
    held_out: bool


@final
@dataclass(frozen=True)
class WornLog:
    """A log with the device."""

    log: Log
    motion: str
    device: Device


@final
@dataclass(frozen=True)
class SupportSettings:
    """When two runs hold the same motion: rms of the velocity difference over the rms velocity, joint by joint.

    Above `doubtful` there is a warning, above `different` approach A is refused.
    started: recording -> [s] when it began, on one clock; empty where that is not said of every log.
    """

    doubtful: float = 0.15
    different: float = 0.5
    started: Mapping[str, float] = field(default_factory=dict)
