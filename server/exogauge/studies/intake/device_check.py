"""A device file looked at on its robot: how long its bands are, which joints they pull, and which way.

What is allowed in a device.yaml and yet looks like a slip: each doubt with its line, none of them an error.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.supporting import DEVICES
from exogauge.devices.bench import bench_line
from exogauge.devices.device import Band, Device
from exogauge.devices.routing import Routing
from exogauge.devices.torque import band_torque
from exogauge.errors import BadLog, Fault
from exogauge.logs.model import Log
from exogauge.robots.description import Robot
from exogauge.studies.intake.bundle import Bundle
from exogauge.studies.intake.device_file import drawn_postures
from exogauge.studies.intake.yaml_file import MAX_BYTES, Pointer, YamlPage, suggestion
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

    law: how it pulls. None: not known without a log, a natural length or a stiffness. arms: the largest first.
    """

    name: str
    group: str
    points: int
    length: float
    shortest: float | None
    longest: float | None
    law: str
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
                law=band.law,
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


FAR_M = 2.0  # of a via point from its link's origin: more is millimetres
LENGTH_RATIO = 1.5  # natural length against the length at zero posture, either way
BENCH_SHARE, BENCH_LENGTH_SHARE = 0.2, 0.1  # stiffness and natural length against the line of the bench test
UNEVEN_SHARE = 0.02  # lengths at zero posture within a group, which is usually a mirrored pair


def device_doubts(bundle: Bundle, file: str, robot: Robot, device: Device) -> tuple[Fault, ...]:
    """device: as read from `file` for this robot, without a fault."""
    page = YamlPage(file, bundle.read(file, limit=MAX_BYTES))
    postures = drawn_postures(robot.tree)
    zero: dict[str, float] = {}
    found = list[Fault]()
    for k, band in enumerate(device.bands):
        segments = Routing(robot.tree, [band]).segments(postures, 0).length
        length = segments.sum(axis=1)
        zero[band.name] = float(length[0])
        found += _point_doubts(band, segments[0], page, ("bands", k))
        found += _length_doubts(band, length, page, ("bands", k))
        found += _value_doubts(band, page, ("bands", k))
    found += _uneven_groups(device, zero, page)
    return tuple(sorted(found, key=lambda fault: fault.row or 0))


def _point_doubts(band: Band, segments: Array, page: YamlPage, at: Pointer) -> Iterator[Fault]:
    """segments: (S,) [m] their lengths at zero posture."""
    for j, point in enumerate(band.via_points):
        away = float(np.linalg.norm(point.xyz))
        if away > FAR_M:
            detail = f"the via point is {away:.4g} m away from the origin of {point.link!r}"
            yield page.fault(detail, "far_away", (*at, "via_points", j, "xyz"), "xyz is in metres.")
    for s in np.flatnonzero(segments < DEVICES.same_place_m):
        detail = "with all joints at zero this via point is at the same place as the one before it"
        advice = "The band has no direction there, and no moment arm."
        yield page.fault(detail, "no_segment_at_zero", (*at, "via_points", int(s) + 1), advice)


def _length_doubts(band: Band, length: Array, page: YamlPage, at: Pointer) -> Iterator[Fault]:
    """length: (T,) [m], the first at zero posture."""
    l_0, zero, longest = band.natural_length, float(length[0]), float(length.max())
    if l_0 is None:
        return
    pointer = (*at, "natural_length_m")
    if l_0 >= longest:
        detail = f"the band is never taut: over all postures it gets {longest:.4g} m long at most"
        yield page.fault(detail, "never_taut", pointer, "Check via points and units [m].", f"{l_0:g}")
    elif not zero / LENGTH_RATIO <= l_0 <= zero * LENGTH_RATIO:
        detail = f"far from the {zero:.4g} m that the band is long with all joints at zero"
        yield page.fault(detail, "far_from_zero", pointer, "Check via points and units [m].", f"{l_0:g}")


def _value_doubts(band: Band, page: YamlPage, at: Pointer) -> Iterator[Fault]:
    if band.bench is not None and band.law == "linear":
        line, advice = bench_line(band.bench), "Check which of them belongs to this band."
        k, l_0 = band.stiffness, band.natural_length
        if k is not None and abs(line.stiffness - k) > BENCH_SHARE * k:
            detail = f"the bench test rises with {line.stiffness:.4g} N/m"
            yield page.fault(detail, "bench_disagrees", (*at, "stiffness_n_per_m"), advice, f"{k:g}")
        if l_0 is not None and abs(line.natural_length - l_0) > BENCH_LENGTH_SHARE * l_0:
            detail = f"the bench test begins to pull at {line.natural_length:.4g} m"
            yield page.fault(detail, "bench_disagrees", (*at, "natural_length_m"), advice, f"{l_0:g}")
    if band.ground_truth and band.stiffness is None:
        detail = "ground_truth says that the values are true, and no stiffness is given"
        yield page.fault(detail, "no_truth", (*at, "ground_truth"), "Give stiffness_n_per_m, or leave it out.")


def _uneven_groups(device: Device, zero: Mapping[str, float], page: YamlPage) -> Iterator[Fault]:
    """zero: band -> length at zero posture [m]."""
    first: dict[str, Band] = {}
    for k, band in enumerate(device.bands):
        other = first.setdefault(band.group, band)
        one, two = zero[band.name], zero[other.name]
        if abs(one - two) > UNEVEN_SHARE * two:
            detail = f"with all joints at zero {band.name!r} is {one:.4g} m long and {other.name!r} {two:.4g} m"
            advice = "Bands of one group are usually mirror images: check the sign of y and the links' names."
            yield page.fault(detail, "uneven_group", ("bands", k, "via_points"), advice)
