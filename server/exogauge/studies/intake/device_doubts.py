"""What is allowed in a device.yaml and yet looks like a slip: each doubt with its line, none of them an error."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.bench_line import bench_line
from exogauge.devices.device import Band, Device
from exogauge.devices.routing import Routing
from exogauge.errors import Fault
from exogauge.robots.description import Robot
from exogauge.studies.intake.bundle import Bundle
from exogauge.studies.intake.device_file import SAME_PLACE_M, DevicePage
from exogauge.studies.intake.postures import drawn_postures
from exogauge.studies.intake.yaml_file import MAX_BYTES, Pointer

Array = NDArray[np.float64]

FAR_M = 2.0  # of a via point from its link's origin: more is millimetres
LENGTH_RATIO = 1.5  # natural length against the length at zero posture, either way
BENCH_SHARE, BENCH_LENGTH_SHARE = 0.2, 0.1  # stiffness and natural length against the line of the bench test
UNEVEN_SHARE = 0.02  # lengths at zero posture within a group, which is usually a mirrored pair


def device_doubts(bundle: Bundle, file: str, robot: Robot, device: Device) -> tuple[Fault, ...]:
    """device: as read from `file` for this robot, without a fault."""
    page = DevicePage(file, bundle.read(file, limit=MAX_BYTES))
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


def _point_doubts(band: Band, segments: Array, page: DevicePage, at: Pointer) -> Iterator[Fault]:
    """segments: (S,) [m] their lengths at zero posture."""
    for j, point in enumerate(band.via_points):
        away = float(np.linalg.norm(point.xyz))
        if away > FAR_M:
            detail = f"the via point is {away:.4g} m away from the origin of {point.link!r}"
            yield page.fault(detail, "far_away", (*at, "via_points", j, "xyz"), "xyz is in metres.")
    for s in np.flatnonzero(segments < SAME_PLACE_M):
        detail = "with all joints at zero this via point is at the same place as the one before it"
        advice = "The band has no direction there, and no moment arm."
        yield page.fault(detail, "no_segment_at_zero", (*at, "via_points", int(s) + 1), advice)


def _length_doubts(band: Band, length: Array, page: DevicePage, at: Pointer) -> Iterator[Fault]:
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


def _value_doubts(band: Band, page: DevicePage, at: Pointer) -> Iterator[Fault]:
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


def _uneven_groups(device: Device, zero: Mapping[str, float], page: DevicePage) -> Iterator[Fault]:
    """zero: band -> length at zero posture [m]."""
    first: dict[str, Band] = {}
    for k, band in enumerate(device.bands):
        other = first.setdefault(band.group, band)
        one, two = zero[band.name], zero[other.name]
        if abs(one - two) > UNEVEN_SHARE * two:
            detail = f"with all joints at zero {band.name!r} is {one:.4g} m long and {other.name!r} {two:.4g} m"
            advice = "Bands of one group are usually mirror images: check the sign of y and the links' names."
            yield page.fault(detail, "uneven_group", ("bands", k, "via_points"), advice)
