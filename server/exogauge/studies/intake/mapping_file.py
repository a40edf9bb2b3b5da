"""mapping.yaml (version 1): what the columns of foreign log files mean. docs/mapping.md shows it by example."""

from __future__ import annotations

import math
import re
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from exogauge.errors import BadInput, BadStudy, Fault
from exogauge.logs.channels import parse_channel
from exogauge.logs.mapping_rules import (
    Clock,
    FileMapping,
    LogMapping,
    Rule,
    Source,
    Values,
    Vector,
    Wrench,
    check_rotation,
)
from exogauge.logs.tables import Encoding, TextLayout
from exogauge.logs.units import find_unit
from exogauge.studies.intake.yaml_file import dotted, load_yaml, place

_ANGLE = re.compile(r"^([+-]?)(?:(\d+(?:\.\d+)?)\s*\*\s*)?pi(?:\s*/\s*(\d+(?:\.\d+)?))?$")
Matrix = tuple[tuple[float, ...], ...]


def _angle(value: Any) -> Any:
    """A number, or an angle written as `-pi/2`, `pi`, `2*pi/3`."""
    if isinstance(value, str) and (found := _ANGLE.match(value.strip())):
        sign, factor, divisor = found.groups()
        if divisor is None or float(divisor) != 0.0:
            return (-1.0 if sign == "-" else 1.0) * float(factor or 1.0) * math.pi / float(divisor or 1.0)
    if isinstance(value, str):
        raise ValueError("expected a number, or an angle such as -pi/2")
    return _number(value)


def _number(value: Any) -> Any:
    return float(value) if isinstance(value, int) and not isinstance(value, bool) else value


def _text(value: Any) -> Any:
    """Column 3 of a headerless file may be written without quotes."""
    return str(value) if isinstance(value, int) and not isinstance(value, bool) else value


def _texts(value: Any) -> Any:
    return {_text(key): entry for key, entry in value.items()} if isinstance(value, dict) else value


Word = Annotated[str, BeforeValidator(_text), Field(min_length=1, max_length=400)]
Number = Annotated[float, BeforeValidator(_number), Field(allow_inf_nan=False)]
Offset = Annotated[float, BeforeValidator(_angle), Field(allow_inf_nan=False)]
Positive = Annotated[Number, Field(gt=0.0)]
Sign = Annotated[Number, Field(ge=-1.0, le=1.0)]
UnitName = Annotated[str, Field(max_length=20)]
TimeAxis = Literal["first", "last"]
Rotation = str | list[list[Number]]


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class TimeEntry(_Part):
    """The time column and its unit; delay_s: how late its stamps are."""

    column: Word
    unit: UnitName
    delay_s: Number = 0.0


class ColumnEntry(_Part):
    channel: Word
    unit: UnitName
    sign: Literal[1, -1] = 1
    scale: Number = 1.0
    offset: Offset = 0.0
    side: Literal["joint", "motor"] = "joint"


class ArrayEntry(_Part):
    """A two-dimensional dataset: one channel per row (or column); `null` in offsets is not needed, give 0."""

    dataset: Word
    channels: Annotated[list[Word], Field(min_length=1, max_length=500)]
    unit: UnitName
    sign: Literal[1, -1] = 1
    scale: Number = 1.0
    offset: Offset = 0.0
    side: Literal["joint", "motor"] = "joint"
    time_axis: TimeAxis | None = None


class _Components(_Part):
    columns: list[Word] | None = None
    dataset: Word | None = None
    time_axis: TimeAxis | None = None
    sign: Literal[1, -1] = 1
    rotation: Rotation | None = None

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        if (self.columns is None) == (self.dataset is None):
            raise ValueError("give either `columns` or `dataset`")
        return self

    @property
    def source(self) -> Source:
        return Source(tuple(self.columns or ()), self.dataset, self.time_axis)


class VectorEntry(_Components):
    """The IMU's three components, x y z."""

    channel: Literal["acc", "gyro"]
    columns: Annotated[list[Word], Field(min_length=3, max_length=3)] | None = None
    unit: UnitName
    scale: Number = 1.0


class WrenchEntry(_Components):
    """A force/torque sensor's six components."""

    sensor: Word
    columns: Annotated[list[Word], Field(min_length=6, max_length=6)] | None = None
    order: Literal["force_first", "couple_first"]
    force_unit: UnitName
    moment_unit: UnitName


class LayoutEntry(_Part):
    """How a text file is written, where its first lines do not tell."""

    header: bool = True
    delimiter: Literal[",", ";", "\t", " "] | None = None
    decimal: Literal[".", ","] | None = None
    skip_lines: Annotated[int, Field(ge=0, le=1000)] = 0
    encoding: Encoding = "utf-8"


class FileEntry(_Part):
    file: Word
    time: TimeEntry | None = None
    rate_hz: Positive | None = None
    layout: LayoutEntry = LayoutEntry()
    columns: Annotated[dict[Word, ColumnEntry], BeforeValidator(_texts)] = {}
    arrays: list[ArrayEntry] = []
    vectors: list[VectorEntry] = []
    wrenches: list[WrenchEntry] = []
    ignore: Literal["rest"] | list[Word] = []

    @model_validator(mode="after")
    def _one_clock(self) -> Self:
        if (self.time is None) == (self.rate_hz is None):
            raise ValueError("give either `time` (column and unit) or `rate_hz`")
        if not (self.columns or self.arrays or self.vectors or self.wrenches):
            raise ValueError("say what the file holds: columns, arrays, vectors or wrenches")
        return self


class MappingFile(_Part):
    """mapping.yaml. constants: channel -> SI value, joint side, for what no file holds; set by the user on purpose."""

    version: Literal[1]
    name: str | None = None
    rate_hz: Positive | None = None
    rotations: dict[str, list[list[Number]]] = {}
    constants: Annotated[dict[Word, Number], Field(max_length=500)] = {}
    files: Annotated[list[FileEntry], Field(min_length=1, max_length=50)]


def parse_mapping(data: bytes, file: str) -> LogMapping:
    """The checked mapping, or BadStudy: each fault's column is the place (`files.0.columns.t.unit`), row the line."""
    content = load_yaml(data, MappingFile, file=file)
    faults = _faults(content, data, file)
    if faults:
        raise BadStudy(faults)
    files = tuple(_file(entry, content) for entry in content.files)
    return LogMapping(files, content.rate_hz, tuple(content.constants.items()))


def _faults(content: MappingFile, data: bytes, file: str) -> list[Fault]:
    """Channel names, unit names and rotations: what the keys' own types do not tell."""
    faults = list[Fault]()

    def at(pointer: tuple[str | int, ...], problem: Fault) -> None:
        faults.append(
            Fault(
                problem.detail, problem.rule, problem.advice, file, place(data, pointer), dotted(pointer), problem.value
            )
        )

    def try_channel(name: str, pointer: tuple[str | int, ...]) -> None:
        try:
            parse_channel(name)
        except BadInput as bad:
            at(pointer, bad.faults[0])

    def try_unit(name: str, pointer: tuple[str | int, ...]) -> None:
        if find_unit(name) is None:
            at(pointer, Fault(f"{name!r} is no unit known here", "unknown_unit", "docs/mapping.md lists them."))

    for name in content.constants:
        try_channel(name, ("constants", name))
    for n, entry in enumerate(content.files):
        if entry.time is not None:
            try_unit(entry.time.unit, ("files", n, "time", "unit"))
        for name, column in entry.columns.items():
            try_channel(column.channel, ("files", n, "columns", name, "channel"))
            try_unit(column.unit, ("files", n, "columns", name, "unit"))
        for k, array in enumerate(entry.arrays):
            for m, channel in enumerate(array.channels):
                try_channel(channel, ("files", n, "arrays", k, "channels", m))
            try_unit(array.unit, ("files", n, "arrays", k, "unit"))
        for part, members in (("vectors", entry.vectors), ("wrenches", entry.wrenches)):
            for k, member in enumerate(members):
                for key in ("unit", "force_unit", "moment_unit"):
                    if hasattr(member, key):
                        try_unit(getattr(member, key), ("files", n, part, k, key))
                try:
                    _rotation(member.rotation, content.rotations)
                except BadInput as bad:
                    at(("files", n, part, k, "rotation"), bad.faults[0])
    return faults


def _file(entry: FileEntry, content: MappingFile) -> FileMapping:
    clock = (
        Clock(entry.time.column, entry.time.unit, delay_s=entry.time.delay_s)
        if entry.time is not None
        else Clock(rate_hz=entry.rate_hz)
    )
    rules: list[Rule] = [
        Values(Source((name,)), (each.channel,), each.unit, each.sign, each.scale, each.offset, each.side)
        for name, each in entry.columns.items()
    ]
    rules += [
        Values(
            Source((), each.dataset, each.time_axis),
            tuple(each.channels),
            each.unit,
            each.sign,
            each.scale,
            each.offset,
            each.side,
        )
        for each in entry.arrays
    ]
    rules += [
        Vector(each.source, each.channel, each.unit, each.sign, each.scale, _rotation(each.rotation, content.rotations))
        for each in entry.vectors
    ]
    rules += [
        Wrench(
            each.source,
            each.sensor,
            each.order,
            each.force_unit,
            each.moment_unit,
            each.sign,
            _rotation(each.rotation, content.rotations),
        )
        for each in entry.wrenches
    ]
    layout = TextLayout(**dict(entry.layout))
    ignore = None if entry.ignore == "rest" else tuple(entry.ignore)
    return FileMapping(entry.file, clock, tuple(rules), ignore, layout)


def _rotation(rotation: Rotation | None, named: dict[str, list[list[float]]]) -> Matrix | None:
    """contract vector = matrix @ logged vector. By name from `rotations`, by signed axes (`y -x z`), or as a matrix."""
    if rotation is None:
        return None
    if isinstance(rotation, str):
        axes = rotation.split()
        if rotation in named:
            rows = named[rotation]
        elif len(axes) == 3 and all(re.fullmatch(r"[+-]?[xyz]", axis) for axis in axes):
            rows = [[(-1.0 if axis[0] == "-" else 1.0) * (axis[-1] == letter) for letter in "xyz"] for axis in axes]
        else:
            advice = f"Named here: {', '.join(named) or 'none'}; or write the log's axes, such as `y -x z`."
            raise BadStudy(Fault(f"no rotation is named {rotation!r}", "unknown_rotation", advice))
    else:
        rows = rotation
    return tuple(tuple(float(value) for value in row) for row in check_rotation(rows).tolist())
