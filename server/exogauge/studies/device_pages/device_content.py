"""A device as the content of a device.yaml, and back: what a change made is saved, sent and read again."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, final

import yaml
from pydantic import Field

from exogauge.devices.device import Band, BenchTest, Device
from exogauge.errors import BadInput, Fault
from exogauge.studies.csv_table import csv_table
from exogauge.studies.device_pages.change_entries import Entry, NewBand
from exogauge.studies.device_pages.entry_changes import band_of
from exogauge.studies.intake.bench_table import FORCE, LENGTH
from exogauge.studies.intake.contract import Name

DIGITS = 12


@final
class DeviceEntry(Entry):
    """device.yaml without bench tests; it may have no band left."""

    version: Annotated[int, Field(ge=1, le=1)] = 1
    name: Name
    bands: Annotated[list[NewBand], Field(max_length=200)]
    tied: Annotated[list[Name], Field(max_length=200, default_factory=list)]


def device_content(device: Device) -> dict[str, Any]:
    """The keys of device.yaml, without bench tests; numbers with 12 digits."""
    content = {"version": 1, "name": device.name, "bands": [band_content(band) for band in device.bands]}
    return content | ({"tied": sorted(device.tied)} if device.tied else {})


def band_content(band: Band) -> dict[str, Any]:
    points = [{"link": point.link, "xyz": [_tidy(x) for x in point.xyz]} for point in band.via_points]
    content: dict[str, Any] = {"name": band.name, "group": band.group, "via_points": points}
    if band.stiffness is not None:
        content["stiffness_n_per_m"] = _tidy(band.stiffness)
    if band.natural_length is not None:
        content["natural_length_m"] = _tidy(band.natural_length)
    if band.ground_truth:
        content["ground_truth"] = True
    if band.law != "linear":
        content |= {"law": band.law, "law_values": {name: _tidy(value) for name, value in band.law_values.items()}}
    return content


def device_from(content: Mapping[str, Any]) -> Device:
    """What `device_content` made. Raises pydantic's ValidationError."""
    entry = DeviceEntry.model_validate(content)
    return Device(entry.name, tuple(band_of(band) for band in entry.bands), frozenset(entry.tied))


def write_device(device: Device, path: Path, root: Path | None = None) -> list[Path]:
    """Write device.yaml at `path`, and beside it a table for each bench test; the files written, device.yaml first.

    root: folder of the study that it is for; default the folder of `path`. Raises BadInput where there is no band.
    """
    if not device.bands:
        raise BadInput(Fault("the device has no band left to be saved", "no_band", "", path.name))
    inside = root is not None and path.resolve().is_relative_to(root.resolve())
    base = root.resolve() if root is not None and inside else path.resolve().parent
    content, tables = device_content(device), dict[BenchTest, Path]()
    for band, entry in zip(device.bands, content["bands"], strict=True):
        if band.bench is not None:
            plain = re.sub(r"[^A-Za-z0-9_-]", "_", band.name)
            table = tables.setdefault(band.bench, path.with_name(f"{path.stem}_{plain}_bench.csv"))
            file = table.resolve().relative_to(base).as_posix()
            entry["bench"] = {"file": file} | ({"is_truth": True} if band.bench.is_truth else {})
    for bench, table in tables.items():
        table.write_bytes(csv_table((LENGTH, FORCE), zip(bench.length, bench.force, strict=True)))
    text = yaml.safe_dump(content, sort_keys=False, allow_unicode=True, default_flow_style=None, width=120)
    path.write_text(text, encoding="utf-8")
    return [path, *tables.values()]


def _tidy(value: float) -> float:
    """Without the last digits that sums and products leave behind."""
    return float(f"{value:.{DIGITS}g}")
