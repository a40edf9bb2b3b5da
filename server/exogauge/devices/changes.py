"""Changes of a device, one after another: what is asked when other values or another routing are tried out.

A change names bands by `of`: a band, a group, or `*` for all. A changed value is no longer a true one, and a bench test
belongs to the band it was made with: both go where the band itself changes, and stay where only its routing does.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from typing import Protocol, final

from exogauge.devices.device import Band, Device
from exogauge.devices.posture import Posture
from exogauge.effects.band_laws import check_values
from exogauge.errors import BadInput, Fault
from exogauge.robots.tree import RigidTree

ALL = "*"


class Change(Protocol):
    """One change. `applied` raises BadInput whose faults name the key of the change in `column`."""

    def applied(self, device: Device, tree: RigidTree) -> Device: ...


def apply(device: Device, changes: Sequence[Change], tree: RigidTree, place: str = "changes") -> Device:
    """The device after all changes, in their order; a later one sees what an earlier one did.

    The first fault ends it, with the column `changes.<number>.<key>`. place: another word for `changes`.
    """
    for k, change in enumerate(changes):
        try:
            device = change.applied(device, tree)
        except BadInput as bad:
            raise type(bad)([replace(each, column=f"{place}.{k}.{each.column}") for each in bad.faults]) from None
    return device


@final
@dataclass(frozen=True)
class Stiffness:
    """Set `to` [N/m], or `times` the present one. A band that leaves its group's stiffness is a group of its own."""

    of: str
    to: float | None = None
    times: float | None = None

    def applied(self, device: Device, tree: RigidTree) -> Device:
        key = "to" if self.to is not None else "times"

        def change(band: Band) -> Band:
            known = band.stiffness if self.to is None else 1.0
            if known is None:
                detail = f"the stiffness of band {band.name!r} is not known and cannot be scaled"
                raise refused(detail, "unknown_stiffness", "Set it `to` a value first.", key)
            value = self.to if self.to is not None else known * positive(self.times, "times")
            return replace(band, stiffness=positive(value, key), ground_truth=False, bench=None)

        return changed(leaving_group(device, self.of), self.of, change)


@final
@dataclass(frozen=True)
class NaturalLength:
    """Set `to` [m], make it longer `by` [m] (shorter where negative), or `times` the present one."""

    of: str
    to: float | None = None
    by: float | None = None
    times: float | None = None

    def applied(self, device: Device, tree: RigidTree) -> Device:
        key = "to" if self.to is not None else "by" if self.by is not None else "times"

        def change(band: Band) -> Band:
            known = band.natural_length
            if self.to is not None:
                return with_length(band, self.to, key)
            if known is None:
                detail = f"the natural length of band {band.name!r} is not known and cannot be changed by an amount"
                raise refused(detail, "unknown_natural_length", "Set it `to` a value first.", key)
            return with_length(band, known + self.by if self.by is not None else known * positive(self.times, key), key)

        return changed(untied(device, self.of), self.of, change)


@final
@dataclass(frozen=True)
class Pretension:
    """Set the natural length so that the band is stretched by `to` [m] at zero posture (slack where negative)."""

    of: str
    to: float

    def applied(self, device: Device, tree: RigidTree) -> Device:
        posture = Posture(tree)

        def change(band: Band) -> Band:
            return with_length(band, posture.length(band) - self.to, "to")

        return changed(untied(device, self.of), self.of, change)


@final
@dataclass(frozen=True)
class Law:
    """Another force law, or other values of it; stiffness and natural length stay."""

    of: str
    law: str
    values: Mapping[str, float] = field(default_factory=dict)

    def applied(self, device: Device, tree: RigidTree) -> Device:
        def change(band: Band) -> Band:
            return replace(band, law=self.law, law_values=dict(self.values), ground_truth=False, bench=None)

        check_values(self.law, self.values, "law", "values")
        return changed(leaving_group(device, self.of), self.of, change)


def changed(device: Device, of: str, change: Callable[[Band], Band]) -> Device:
    """The device with every band that `of` names changed."""
    names = {band.name for band in chosen(device, of)}
    return replace(device, bands=tuple(change(band) if band.name in names else band for band in device.bands))


def with_band_replaced(device: Device, new: Band) -> Device:
    """The band of this name is another one."""
    return replace(device, bands=tuple(new if band.name == new.name else band for band in device.bands))


def chosen(device: Device, of: str, key: str = "of") -> tuple[Band, ...]:
    """The bands that `of` names: all, a group's, or one."""
    if of == ALL:
        return device.bands
    named = tuple(band for band in device.bands if band.name == of)
    group = tuple(band for band in device.bands if band.group == of)
    if named and group and named != group:
        detail = f"{of!r} is the name of a band and of a group"
        raise refused(detail, "ambiguous_name", "Rename one of them in the device file.", key, of)
    if not (named or group):
        known = [*dict.fromkeys([*device.groups, *(band.name for band in device.bands)])]
        raise refused(f"the device has no band or group {of!r}", "unknown_band", near(of, known), key, of)
    return named or group


def the_band(device: Device, name: str, key: str = "band") -> Band:
    for band in device.bands:
        if band.name == name:
            return band
    known = [band.name for band in device.bands]
    raise refused(f"the device has no band {name!r}", "unknown_band", near(name, known), key, name)


def leaving_group(device: Device, of: str) -> Device:
    """A band that is one of several in its group becomes a group of its own, for a group shares its stiffness."""
    bands = chosen(device, of)
    others = [band for band in device.bands if band not in bands and band.group == bands[0].group] if bands else []
    return changed(device, of, lambda band: replace(band, group=band.name)) if others else device


def untied(device: Device, of: str) -> Device:
    """The device without the tie of natural lengths of a group of which `of` names a part."""
    bands = chosen(device, of)
    partly = {band.group for band in device.bands if band not in bands} & {band.group for band in bands}
    return replace(device, tied=device.tied - partly)


def with_length(band: Band, value: float, key: str) -> Band:
    longest_m = 100.0
    if not 0.0 < value <= longest_m:
        detail = f"the natural length of band {band.name!r} would be {value:.4g} m"
        advice = f"It is above 0 and at most {longest_m:g} m."
        raise refused(detail, "natural_length_impossible", advice, key, f"{value:.4g}")
    return replace(band, natural_length=value, ground_truth=False, bench=None)


def positive(value: float | None, key: str) -> float:
    largest = 1e9  # stiffness [N/m], or factor: beyond what any band can be, and far from where numbers end
    if value is None or not 0.0 < value <= largest:
        advice = f"It is above 0 and at most {largest:g}."
        raise refused(
            "the number is out of range", "out_of_range", advice, key, None if value is None else f"{value:g}"
        )
    return value


def near(word: str, known: Sequence[str]) -> str:
    """Advice: the nearest known name, or what there is."""
    found = get_close_matches(word, known, n=1, cutoff=0.6)
    if found:
        return f"Did you mean {found[0]!r}?"
    return f"Known here: {', '.join(known[:12])}{', …' if len(known) > 12 else ''}." if known else ""


def refused(detail: str, rule: str, advice: str, key: str, value: str | None = None) -> BadInput:
    return BadInput(Fault(detail, rule, advice, column=key, value=value))
