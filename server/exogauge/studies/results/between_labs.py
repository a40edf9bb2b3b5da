"""One device in the results of several studies: who wore which specimen on which robot, and what each found of it.

Two devices are the same where their files say the same `model` and `size` under `record`, or, where no model is
stated, bear the same name: case and spaces do not count. Of each study the numbers are those of its headline approach.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, final

if TYPE_CHECKING:
    from exogauge.estimation.between_labs import Agreement

Content = Mapping[str, Any]
Measured = Mapping[str, Any]
PRIOR = "prior"


@final
@dataclass(frozen=True)
class DeviceKey:
    """model: of its record, else its name."""

    model: str
    size: str | None

    @property
    def same(self) -> tuple[str, str]:
        return plain(self.model), plain(self.size or "")


@final
@dataclass(frozen=True)
class Band:
    """As `stiffness` of results.json has it, by the headline approach; interval: 95 %, None where it is open."""

    group: str
    band: str
    approach: str
    stiffness_n_per_m: Measured
    stiffness_interval: Sequence[float | None]
    identifiable: bool
    natural_length_m: Measured
    length_interval: Sequence[float | None]
    length_identifiable: bool


@final
@dataclass(frozen=True)
class Torque:
    """Peak and mean of one joint in one motion, by the approach that its own null test says is best."""

    motion: str
    joint: str
    unit: str
    approach: str
    peak: Measured
    mean: Measured | None


@final
@dataclass(frozen=True)
class Wearing:
    """One device in one study. specimen: its record in words."""

    key: DeviceKey
    device: str
    study: str
    robot: str
    synthetic: bool
    specimen: Mapping[str, str | None]
    bands: tuple[Band, ...]
    torques: tuple[Torque, ...]


@final
@dataclass(frozen=True)
class Compared:
    """One quantity over labs. rows: which studies count, one of each lab, the newest that decides it."""

    quantity: str
    of: str
    unit: str
    rows: tuple[int, ...]
    values: tuple[float, ...]
    found: Agreement


def wearings(content: Content) -> list[Wearing]:
    """Of one results.json; results of earlier versions, which do not say what was worn, have none."""
    scope, said = content.get("scope") or {}, (content.get("configuration") or {}).get("devices", ())
    return [
        Wearing(
            DeviceKey(each["record"].get("model") or each["device"], each["record"].get("size")),
            each["device"], content["name"], content["robot"], bool(scope.get("synthetic")), each["record"],
            tuple(bands(content, each["device"])), tuple(torques(content, each["device"])),
        )
        for each in said
        if each.get("logs")
    ]  # fmt: skip


def bands(content: Content, device: str) -> list[Band]:
    entries = [each for each in content.get("stiffness") or () if each["device"] == device]
    return [
        Band(
            each["group"] or each["band"], each["band"], each["approach"],
            each["stiffness_n_per_m"], each["interval_95"]["stiffness_n_per_m"], each["identifiable"],
            each["natural_length_m"], each["interval_95"]["natural_length_m"], each["length_identifiable"],
        )
        for each in entries
        if each.get("headline") and each["approach"] != PRIOR
    ]  # fmt: skip


def torques(content: Content, device: str) -> list[Torque]:
    return [
        Torque(
            each["motion"], each["joint"], each["unit"], each["peak"]["approach"], each["peak"],
            each["mean"] if (each.get("mean") or {}).get("approach") == each["peak"]["approach"] else None,
        )
        for each in content.get("support") or ()
        if each["device"] == device and each["main"] and each.get("peak")
    ]  # fmt: skip


def compared(rows: Sequence[Wearing], labs: Sequence[str]) -> list[Compared]:
    """labs: of each row, whose it is; rows newest first. Stiffness is one number of a group, a natural length of a
    band; torques are compared on robots of one name alone, in motions of one name."""
    from exogauge.estimation.between_labs import agreement  # SciPy, which a service can do without

    found: dict[tuple[str, str, str], dict[str, tuple[int, float, float]]] = {}
    for k, (row, lab) in enumerate(zip(rows, labs, strict=True)):
        for what, unit, measured in told(row):
            value, std = measured.get("value"), measured.get("std")
            if value is not None and std is not None and std > 0.0:
                found.setdefault((*what, unit), {}).setdefault(lab, (k, float(value), float(std)))
    made = []
    for (quantity, of, unit), by_lab in found.items():
        which, values, stds = zip(*by_lab.values(), strict=True)
        made.append(Compared(quantity, of, unit, which, values, agreement(values, stds)))
    return made


def told(row: Wearing) -> list[tuple[tuple[str, str], str, Measured]]:
    """(quantity, of what), unit, number: all that the row's data decide."""
    groups = {plain(band.group): band for band in reversed(row.bands) if band.identifiable}
    stiffness = [(("stiffness", name), "N/m", band.stiffness_n_per_m) for name, band in groups.items()]
    lengths = [
        (("natural_length", plain(band.band)), "m", band.natural_length_m)
        for band in row.bands
        if band.length_identifiable
    ]
    place = plain(row.robot)
    joints = [
        ((quantity, f"{plain(each.joint)} in {plain(each.motion)} of {place}"), each.unit, measured)
        for each in row.torques
        for quantity, measured in (("peak_torque", each.peak), ("mean_torque", each.mean))
        if measured is not None
    ]
    return [*stiffness, *lengths, *joints]


def plain(text: str) -> str:
    """As names are compared."""
    return " ".join(text.split()).casefold()
