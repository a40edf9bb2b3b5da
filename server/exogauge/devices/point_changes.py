"""Changes of a band's routing: via points moved, placed, added, removed. Points count from 0, as in the device file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

from exogauge.devices.changes import refused, the_band, with_band_replaced
from exogauge.devices.device import Device, ViaPoint
from exogauge.devices.routing_check import check_routing
from exogauge.robots.tree import RigidTree

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
