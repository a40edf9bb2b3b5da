"""A device file looked at on its robot: how long its bands are, which joints they pull, and which way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.device import Device
from exogauge.devices.routing import Routing
from exogauge.devices.torque import band_torque
from exogauge.errors import BadLog, Fault
from exogauge.logs.model import Log
from exogauge.robots.description import Robot
from exogauge.studies.intake.yaml_file import suggestion
from exogauge.studies.words.pull_words import Ways

Array = NDArray[np.float64]

NO_ARM_M = 5e-4  # a smaller moment arm counts as none
TURNED_M = 5e-3  # a moment arm beyond this on both sides changes its sign


@final
@dataclass(frozen=True)
class ArmCheck:
    """What a band does to a joint. arm: ∂l/∂q with all joints at zero [m/rad, or 1]; lowest, highest: over the log.

    sign: of the joint's position that the band pulls towards; way: in words, where that moves what the joint carries.
    """

    joint: str
    arm: float
    lowest: float | None
    highest: float | None
    sign: float
    way: str

    @property
    def changes_sides(self) -> bool:
        """The band pulls one way in some postures of the log, and the other way in others."""
        return (
            self.lowest is not None and self.highest is not None and self.lowest < -TURNED_M < TURNED_M < self.highest
        )


@final
@dataclass(frozen=True)
class BandCheck:
    """length, stretch, tension: with all joints at zero [m, m, N]; shortest, longest [m]: over the log.

    None: not known without a log, a natural length or a stiffness. arms: the largest first.
    """

    name: str
    group: str
    points: int
    length: float
    shortest: float | None
    longest: float | None
    natural_length: float | None
    stretch: float | None
    tension: float | None
    arms: tuple[ArmCheck, ...]


@final
@dataclass(frozen=True)
class DeviceCheck:
    """torque: joint -> [N·m] of all bands with all joints at zero; empty where values are missing.

    doubts: what looks like a slip. notes: what to know when reading the figures.
    """

    device: Device
    robot: Robot
    bands: tuple[BandCheck, ...]
    torque: dict[str, float]
    doubts: tuple[Fault, ...]
    notes: tuple[str, ...]


def check_device(robot: Robot, device: Device, log: Log | None = None, doubts: Sequence[Fault] = ()) -> DeviceCheck:
    """log: holds `q.<joint>` of every joint that a band passes."""
    routing = Routing(robot.tree, device.bands)
    zero = np.zeros((1, len(robot.tree.joints)))
    at_zero = routing.geometry(zero)
    moved = None if log is None else routing.geometry(_positions(robot, routing, log))
    known = all(band.stiffness is not None and band.natural_length is not None for band in device.bands)
    pulled = band_torque(routing, device.bands, zero, np.zeros(1)) if known else None
    ways, bands = Ways(robot.tree), []
    for w, band in enumerate(device.bands):
        length = float(at_zero.length[0, w])
        over_log = None if moved is None else moved.jacobian[:, w]
        arms = _arms(routing, ways, at_zero.jacobian[0, w], over_log)
        bands.append(
            BandCheck(
                name=band.name,
                group=band.group,
                points=len(band.via_points),
                length=length,
                shortest=None if moved is None else float(moved.length[:, w].min()),
                longest=None if moved is None else float(moved.length[:, w].max()),
                natural_length=band.natural_length,
                stretch=None if band.natural_length is None else length - band.natural_length,
                tension=None if pulled is None else float(pulled.tension[0, w]),
                arms=arms,
            )
        )
    torque = {} if pulled is None else dict(zip(routing.joints, pulled.torque[0].tolist(), strict=True))
    return DeviceCheck(device, robot, tuple(bands), torque, tuple(doubts), tuple(_notes(robot, routing)))


def _arms(routing: Routing, ways: Ways, at_zero: Array, over_log: Array | None) -> tuple[ArmCheck, ...]:
    """at_zero: (D,) ∂l/∂q; over_log: (T, D)."""
    arms = []
    for d, joint in enumerate(routing.joints):
        seen = [float(at_zero[d])]
        if over_log is not None:
            seen += [float(over_log[:, d].min()), float(over_log[:, d].max())]
        most = max(seen, key=abs)
        if abs(most) < NO_ARM_M:
            continue
        sign = -float(np.sign(seen[0] if abs(seen[0]) >= NO_ARM_M else most))
        lowest, highest = (None, None) if over_log is None else seen[1:]
        arms.append(ArmCheck(joint, seen[0], lowest, highest, sign, ways.words(joint, sign)))
    return tuple(sorted(arms, key=lambda arm: -max(abs(arm.arm), abs(arm.lowest or 0.0), abs(arm.highest or 0.0))))


def _notes(robot: Robot, routing: Routing) -> list[str]:
    tree = robot.tree
    outside = [
        name
        for column, name in zip(routing.columns, routing.joints, strict=True)
        if not tree.lower[column] <= 0.0 <= tree.upper[column]
    ]
    notes = []
    if outside:
        notes.append(
            f"Zero lies outside the limits of {', '.join(outside)}: figures at zero are not of a real posture."
        )
    return notes


def _positions(robot: Robot, routing: Routing, log: Log) -> Array:
    """(T, J) [rad or m]; joints that no band passes stay at zero."""
    q = np.zeros((log.samples, len(robot.tree.joints)))
    lacking = [joint for joint in routing.joints if not log.has(f"q.{joint}")]
    if lacking:
        held = [name for name in log.channels if name.startswith("q.")]
        raise BadLog(
            [
                Fault(
                    "a band passes this joint",
                    "missing_column",
                    suggestion(f"q.{joint}", held),
                    log.name,
                    None,
                    f"q.{joint}",
                )
                for joint in lacking
            ]
        )
    for column, joint in zip(routing.columns, routing.joints, strict=True):
        q[:, column] = log.channels[f"q.{joint}"]
    return q
