"""Changes of the number of bands: added, copied, mirrored to the other side, removed.

A via point on the other side of a robot that is built alike on both: the base link's x-z plane is the mirror.

Changes of a band's routing: via points moved, placed, added, removed. Points count from 0, as in the device file.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.changes import chosen, positive, refused, the_band, with_band_replaced, with_length
from exogauge.devices.device import Band, Device, ViaPoint
from exogauge.devices.posture import Posture
from exogauge.devices.routing import check_routing
from exogauge.effects.band_laws import check_values
from exogauge.errors import BadInput, Fault
from exogauge.robots.tree import RigidTree


@final
@dataclass(frozen=True)
class RemoveBand:
    """of: a band, a group, or `*` for all."""

    of: str

    def applied(self, device: Device, tree: RigidTree) -> Device:
        gone = {band.name for band in chosen(device, self.of)}
        left = tuple(band for band in device.bands if band.name not in gone)
        return replace(device, bands=left, tied=device.tied & {band.group for band in left})


@final
@dataclass(frozen=True)
class AddBand:
    """A new band. Without a stiffness it takes that of its group, where the group has one."""

    band: Band

    def applied(self, device: Device, tree: RigidTree) -> Device:
        check_routing(self.band, tree, "band.via_points")
        check_values(self.band.law, self.band.law_values, "band.law", "band.law_values")
        if self.band.stiffness is not None:
            positive(self.band.stiffness, "band.stiffness")
        if self.band.natural_length is not None:
            with_length(self.band, self.band.natural_length, "band.natural_length")
        return with_band(device, self.band, "band.name")


@final
@dataclass(frozen=True)
class CopyBand:
    """A second band like `band` beside it, called `name`. group: default that of the first."""

    band: str
    name: str
    group: str | None = None

    def applied(self, device: Device, tree: RigidTree) -> Device:
        original = the_band(device, self.band)
        return with_band(device, replace(original, name=self.name, group=self.group or original.group), "name")


@final
@dataclass(frozen=True)
class MirrorBand:
    """The same band on the other side of the base link's x-z plane (y left), called `name`. group: default the same.

    links: link -> its twin on the other side, where their names do not tell (`l_thigh`, `r_thigh`).
    """

    band: str
    name: str
    group: str | None = None
    links: Mapping[str, str] = field(default_factory=dict)

    def applied(self, device: Device, tree: RigidTree) -> Device:
        original = the_band(device, self.band)
        points = tuple(mirrored(tree, point, self.links) for point in original.via_points)
        twin = replace(original, name=self.name, group=self.group or original.group, via_points=points)
        check_routing(twin, tree, "band")
        return with_band(device, twin, "name")


def with_band(device: Device, band: Band, key: str) -> Device:
    """The device with one band more; a group's bands share stiffness and law."""
    most_bands = 200  # as many as a device file may have
    if any(band.name == each.name for each in device.bands):
        detail, advice = f"two bands are named {band.name!r}", "Bands may share a group, but not a name."
        raise refused(detail, "duplicate_name", advice, key, band.name)
    if len(device.bands) >= most_bands:
        raise refused(f"a device has at most {most_bands} bands", "too_many_bands", "Remove one first.", key)
    group = [each for each in device.bands if each.group == band.group]
    for first in group[:1]:
        if band.stiffness is None:
            band = replace(band, stiffness=first.stiffness)
        if (band.stiffness, band.law) != (first.stiffness, first.law):
            detail = f"band {first.name!r} of the same group {band.group!r} has {first.stiffness} N/m, law {first.law}"
            advice = "Bands of one group share it: make them equal, or give this band a group of its own."
            raise refused(detail, "group_differs", advice, key.replace("name", "group"), band.group)
    tied = {each.natural_length for each in (*group, band)} if band.group in device.tied else set()
    return replace(device, bands=(*device.bands, band), tied=device.tied - ({band.group} if len(tied) > 1 else set()))


Array = NDArray[np.float64]

WORDS = {"left": "right", "Left": "Right", "LEFT": "RIGHT", "l": "r", "L": "R"}
WORDS |= {right: left for left, right in WORDS.items()}
SIDE = re.compile(r"left|right|Left|Right|LEFT|RIGHT|(?<![A-Za-z])[lrLR](?![A-Za-z])")


def mirrored(tree: RigidTree, point: ViaPoint, links: Mapping[str, str]) -> ViaPoint:
    """The point's mirror image at zero posture, on the twin of its link; a link without a side keeps it.

    links: twins by the user's word, believed. Raises BadInput where a link has a side but no twin, or where the origin
    of the twin found by name is not the mirror image of its own.
    """
    twins_apart_m = 0.005  # twin links may lie that far from each other's mirror image at zero posture
    twin, advice = links.get(point.link) or twin_of(point.link), "Name its twin in `links`."
    if twin not in tree.frames:
        raise _refused(f"link {point.link!r} has no twin on the other side", "no_twin", advice, twin)
    posture = Posture(tree)
    apart = np.linalg.norm(_reflected(posture.pose(point.link).translation) - posture.pose(twin).translation)
    if twin != point.link and point.link not in links and apart > twins_apart_m:
        detail = f"links {point.link!r} and {twin!r} do not lie opposite each other at zero posture"
        raise _refused(f"{detail} ({1e3 * apart:.0f} mm off)", "not_symmetric", advice, twin)
    x, y, z = posture.pose(twin).actInv(_reflected(posture.place(point))).tolist()
    return ViaPoint(twin, (x, y, z))


def twin_of(link: str) -> str:
    """The name with left and right exchanged: `l_thigh` to `r_thigh`; a name without a side is its own twin."""
    return SIDE.sub(lambda side: WORDS[side.group()], link)


def _reflected(place: Array) -> Array:
    x, y, z = place
    return np.array([x, -y, z])


def _refused(detail: str, rule: str, advice: str, value: str) -> BadInput:
    return BadInput(Fault(detail, rule, advice, column="band", value=value))


Vector = tuple[float, float, float]


@final
@dataclass(frozen=True)
class MovePoint:
    """Move a via point `by` [m], in the frame of its link."""

    band: str
    point: int
    by: Vector

    def applied(self, device: Device, tree: RigidTree) -> Device:
        points = the_points(device, self.band, self.point)
        old = points[self.point]
        x, y, z = (place + step for place, step in zip(old.xyz, self.by, strict=True))
        points[self.point] = replace(old, xyz=(x, y, z))
        return rerouted(device, self.band, points, tree, "by")


@final
@dataclass(frozen=True)
class PlacePoint:
    """Put a via point at `xyz` [m] of `link`; each stays as it is where None."""

    band: str
    point: int
    xyz: Vector | None = None
    link: str | None = None

    def applied(self, device: Device, tree: RigidTree) -> Device:
        points = the_points(device, self.band, self.point)
        old = points[self.point]
        points[self.point] = ViaPoint(self.link or old.link, self.xyz or old.xyz)
        return rerouted(device, self.band, points, tree, "link" if self.link is not None else "xyz")


@final
@dataclass(frozen=True)
class InsertPoint:
    """A new via point, which then is the band's point number `at`; those from there on move up by one."""

    band: str
    at: int
    link: str
    xyz: Vector

    def applied(self, device: Device, tree: RigidTree) -> Device:
        points = list(the_band(device, self.band).via_points)
        if not 0 <= self.at <= len(points):
            detail = f"a new via point of band {self.band!r} can be number 0 to {len(points)}"
            raise refused(detail, "unknown_via_point", "Points count from 0.", "at", str(self.at))
        points.insert(self.at, ViaPoint(self.link, self.xyz))
        return rerouted(device, self.band, points, tree, "link")


@final
@dataclass(frozen=True)
class RemovePoint:
    """The band runs straight from the point before to the one after."""

    band: str
    point: int

    def applied(self, device: Device, tree: RigidTree) -> Device:
        points = the_points(device, self.band, self.point)
        del points[self.point]
        return rerouted(device, self.band, points, tree, "point")


def the_points(device: Device, band: str, point: int) -> list[ViaPoint]:
    """A band's via points, among them number `point`."""
    points = list(the_band(device, band).via_points)
    if not 0 <= point < len(points):
        detail = f"band {band!r} has {len(points)} via points, 0 to {len(points) - 1}"
        raise refused(detail, "unknown_via_point", "Points count from 0.", "point", str(point))
    return points


def rerouted(device: Device, band: str, points: Sequence[ViaPoint], tree: RigidTree, key: str) -> Device:
    new = replace(the_band(device, band), via_points=tuple(points))
    check_routing(new, tree, key)
    return with_band_replaced(device, new)
