"""Suggestions for columns put together as the content of a mapping.yaml."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from exogauge.logs.channels import WRENCH_AXES, parse_channel
from exogauge.studies.import_log.column_words import Suggestion


def proposal(file: str, found: Mapping[str, Suggestion], header: bool = True) -> dict[str, Any]:
    """The mapping of these columns and no others: what it leaves open, its reader refuses.

    The three of an IMU and the six of a sensor become one entry, which may be turned; fewer stay columns. Topics of a
    bag have a clock each, and so a part of the mapping each.
    """
    stamps = [name.removesuffix("stamp") for name, each in found.items() if each.channel == "t"]
    if len(stamps) > 1:
        topics = [{name: each for name, each in found.items() if name.startswith(stamp)} for stamp in stamps]
        return {"version": 1, "files": [_entry_of(file, topic, header) for topic in topics if len(topic) > 1]}
    return {"version": 1, "files": [_entry_of(file, found, header)]}


def _entry_of(file: str, found: Mapping[str, Suggestion], header: bool) -> dict[str, Any]:
    entry: dict[str, Any] = {"file": file}
    if not header:
        entry["layout"] = {"header": False}
    left = dict(found)
    time = next((name for name, each in found.items() if each.channel == "t"), None)
    if time is not None:
        entry["time"] = {"column": time, "unit": left.pop(time).unit}
    vectors = [made for kind in ("acc", "gyro") if (made := _vector(kind, left))]
    wrenches = [made for sensor in _sensors(left) if (made := _wrench(sensor, left))]
    if left:
        entry["columns"] = {name: _entry(each) for name, each in left.items()}
    entry |= {key: made for key, made in (("vectors", vectors), ("wrenches", wrenches)) if made}
    return entry


def _entry(each: Suggestion) -> dict[str, Any]:
    said: dict[str, Any] = {"channel": each.channel, "unit": each.unit}
    if each.sign != 1:
        said["sign"] = each.sign
    return said | ({"side": each.side} if each.side != "joint" else {})


def _vector(kind: str, left: dict[str, Suggestion]) -> dict[str, Any] | None:
    by_channel = {each.channel: name for name, each in left.items()}
    names = [by_channel.get(f"{kind}.{axis}") for axis in "xyz"]
    columns = [name for name in names if name is not None]
    units = {left[name].unit for name in columns}
    if len(columns) != 3 or len(units) != 1:
        return None
    for name in columns:
        del left[name]
    return {"channel": kind, "columns": columns, "unit": units.pop()}


def _sensors(left: Mapping[str, Suggestion]) -> list[str]:
    channels = (parse_channel(each.channel) for each in left.values())
    return list(dict.fromkeys(channel.subject for channel in channels if channel.kind == "ft"))


def _wrench(sensor: str, left: dict[str, Suggestion]) -> dict[str, Any] | None:
    by_channel = {each.channel: name for name, each in left.items()}
    names = [by_channel.get(f"ft.{sensor}.{axis}") for axis in WRENCH_AXES]
    columns = [name for name in names if name is not None]
    forces, moments = {left[name].unit for name in columns[:3]}, {left[name].unit for name in columns[3:]}
    if len(columns) != 6 or len(forces) != 1 or len(moments) != 1:
        return None
    for name in columns:
        del left[name]
    units = {"force_unit": forces.pop(), "moment_unit": moments.pop()}
    return {"sensor": sensor, "columns": columns, "order": "force_first", **units}
