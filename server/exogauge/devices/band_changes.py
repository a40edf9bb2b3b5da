"""Changes of the number of bands: added, copied, mirrored to the other side, removed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import final

from exogauge.devices.changes import chosen, positive, refused, the_band, with_length
from exogauge.devices.device import Band, Device
from exogauge.devices.mirror import mirrored
from exogauge.devices.routing_check import check_routing
from exogauge.effects.band_laws import check_values
from exogauge.robots.tree import RigidTree

MOST_BANDS = 200  # as many as a device file may have


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
    if any(band.name == each.name for each in device.bands):
        detail, advice = f"two bands are named {band.name!r}", "Bands may share a group, but not a name."
        raise refused(detail, "duplicate_name", advice, key, band.name)
    if len(device.bands) >= MOST_BANDS:
        raise refused(f"a device has at most {MOST_BANDS} bands", "too_many_bands", "Remove one first.", key)
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
