"""Foreign files to a Log, by a mapping that says what every column means. Nothing is guessed."""

from __future__ import annotations

import fnmatch
from collections.abc import Mapping, Sequence, Set
from pathlib import Path

import numpy as np

from exogauge.errors import BadLog, Fault
from exogauge.logs.bursts import evened
from exogauge.logs.channels import WRENCH_AXES, Channel, parse_channel, shorten
from exogauge.logs.gear import joint_side
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
from exogauge.logs.model import Array, Log, Note
from exogauge.logs.open_table import open_table
from exogauge.logs.reading import cut, refuse, time_faults, value_faults
from exogauge.logs.tables import RawArray, Table, as_vector, read_names
from exogauge.logs.units import Unit, dimensions_of, find_unit, units_of

__all__ = ["LogMapping", "read_mapped"]

Raw = Mapping[str, RawArray]


def read_mapped(
    paths: Mapping[str, Path],
    mapping: LogMapping,
    *,
    joints: Sequence[str],
    motor_from_joint: Array | None,
    name: str,
    rows: tuple[int, int] | None = None,
    allow_gaps: bool = False,
) -> Log:
    """The log that `mapping` makes of the files; contract channels, SI units, joint side.

    paths: handed-in file name -> where it lies. joints: the robot's, in order. motor_from_joint: (J, J), motor angle
    = matrix @ joint angle; needed where the mapping says `side: motor`. rows: (start, stop) of the resulting log; where
    that has the rows of one file, what is wrong with its other rows does not matter.
    Time starts at 0 with the first sample of the earliest file (of its rows, where only they count); files with a rate
    instead of a time column start together. allow_gaps: keep NaN (one clock only). Raises BadLog with every fault,
    TooLarge.
    """
    matched = _match(paths, mapping)
    targets = _targets(mapping, joints)
    alone = len(matched) == 1 and mapping.rate_hz is None
    used = {file: {name for each, (f, _) in zip(mapping.files, matched, strict=True) if f == file for name in each.used}
            for file, _ in matched}  # fmt: skip
    parts = [
        _read_file(file, path, each, targets[index], allow_gaps, rows if alone else None, used[file])
        for index, (each, (file, path)) in enumerate(zip(mapping.files, matched, strict=True))
    ]
    rows = None if alone else rows
    times = _common_origin([time for time, _, _ in parts], mapping, [file for file, _ in matched])
    logs = [Log(file, time, channels) for (file, _), time, (_, channels, _) in zip(matched, times, parts, strict=True)]
    log = _join(logs, mapping.rate_hz, name, allow_gaps)
    notes = tuple(note for _, _, told in parts for note in told)
    channels = dict(joint_side(log.channels, _motor_offsets(mapping), joints, motor_from_joint))
    channels |= {channel: np.full(log.samples, value) for channel, value in mapping.constants}
    label = ", ".join(file for file, _ in matched)
    if rows is None:
        cut(log.time, None, label)
        return Log(name, log.time, channels, notes=notes)
    kept = {each: cut(values, rows, label) for each, values in channels.items()}
    return Log(name, cut(log.time, rows, label), kept, notes=notes)


def _match(paths: Mapping[str, Path], mapping: LogMapping) -> list[tuple[str, Path]]:
    """The handed-in file of each part of the mapping; none left over, and used twice only under its own name: what a
    bag holds of several topics has several clocks."""
    matched, faults, left = list[tuple[str, Path]](), list[Fault](), dict(paths)
    for each in mapping.files:
        found = [name for name in paths if name == each.file] or [
            name for name in left if fnmatch.fnmatchcase(name.rpartition("/")[2], each.file)
        ]
        if len(found) == 1:
            matched.append((found[0], paths[found[0]]))
            left.pop(found[0], None)
            continue
        detail = "no handed-in file has this name" if not found else f"{len(found)} files match: {', '.join(found[:5])}"
        advice = f'Handed in: {", ".join(paths)}. For logs with names of their own write a pattern: `file: "*.csv"`.'
        faults.append(Fault(detail, "file_not_matched", advice, each.file))
    if not faults:
        advice = "Add it to the mapping's files, or leave it out."
        faults = [Fault("the mapping does not say what this file holds", "file_not_mapped", advice, f) for f in left]
    refuse(faults)
    return matched


def _targets(mapping: LogMapping, joints: Sequence[str]) -> list[list[list[Channel]]]:
    """Per file and rule the channels it fills; unknown names, joints, units and doubles are refused together."""
    faults, seen = list[Fault](), set[str]()
    targets = list[list[list[Channel]]]()
    for each in mapping.files:
        rules = list[list[Channel]]()
        for rule in each.rules:
            channels = list[Channel]()
            for name, unit in _named(rule):
                try:
                    channel = parse_channel(name, each.file)
                except BadLog as bad:
                    faults += bad.faults
                    continue
                faults += _target_faults(channel, unit, each.file, joints, seen, rule)
                seen.add(name)
                channels.append(channel)
            rules.append(channels)
        targets.append(rules)
        clock_unit = find_unit(each.clock.unit)
        if clock_unit is None or clock_unit.dimension != "time":
            faults.append(_unit_fault(each.clock.unit, ("time",), each.file, "t"))
    if not seen and not faults:
        faults.append(Fault("the mapping fills no channel", "no_channels", "", mapping.files[0].file))
    faults += _constant_faults(mapping, joints, seen)
    refuse(faults)
    return targets


def _constant_faults(mapping: LogMapping, joints: Sequence[str], seen: set[str]) -> list[Fault]:
    faults = list[Fault]()
    for name, value in mapping.constants:
        try:
            channel = parse_channel(name)
        except BadLog as bad:
            faults += bad.faults
            continue
        if name in seen or channel.kind == "t":
            detail, advice = "a constant cannot stand for what a column fills", "Keep the column or the constant."
            faults.append(Fault(detail, "constant_and_column", advice, column=name))
        if channel.of_joint and channel.subject not in joints:
            advice = f"Joints: {_some(joints)}."
            faults.append(Fault("the robot has no such joint", "unknown_joint", advice, column=name))
        if not np.isfinite(value):
            faults.append(Fault("a constant must be a finite number", "not_finite", column=name, value=str(value)))
    return faults


def _target_faults(
    channel: Channel, unit: str, file: str, joints: Sequence[str], seen: set[str], rule: Rule
) -> list[Fault]:
    faults = list[Fault]()
    name = channel.name
    if name in seen:
        advice = "Keep one. Of files that follow each other, list each as a log of its own."
        faults.append(Fault("two columns fill this channel", "duplicate_channel", advice, file, column=name))
    if channel.of_joint and channel.subject not in joints:
        advice = f"Joints: {_some(joints)}."
        faults.append(Fault("the robot has no such joint", "unknown_joint", advice, file, column=name))
    if channel.kind == "t":
        faults.append(Fault("time is given under `time`", "time_as_channel", "", file, column=name))
    found = find_unit(unit)
    if found is None or found.dimension not in dimensions_of(channel):
        faults.append(_unit_fault(unit, dimensions_of(channel), file, name))
    if isinstance(rule, Values) and rule.side == "motor" and channel.kind not in ("q", "dq", "ddq", "tau", "i"):
        faults.append(Fault("only joint quantities have a motor side", "no_motor_side", "", file, column=name))
    return faults


def _unit_fault(unit: str, dimensions: tuple[str, ...], file: str, column: str) -> Fault:
    detail = f"{shorten(unit)!r} is no unit of {' or '.join(dimensions)}"
    return Fault(detail, "unknown_unit", f"Known: {', '.join(units_of(dimensions))}.", file, column=column)


def _named(rule: Rule) -> list[tuple[str, str]]:
    """Channel name and unit of each component of a rule."""
    if isinstance(rule, Values):
        return [(name, rule.unit) for name in rule.channels]
    if isinstance(rule, Vector):
        return [(f"{rule.channel}.{axis}", rule.unit) for axis in "xyz"]
    return [
        (f"ft.{rule.sensor}.{axis}", rule.force_unit if axis[0] == "f" else rule.moment_unit) for axis in WRENCH_AXES
    ]


def _read_file(
    file: str,
    path: Path,
    each: FileMapping,
    targets: Sequence[Sequence[Channel]],
    allow_gaps: bool,
    rows: tuple[int, int] | None,
    used: Set[str],
) -> tuple[RawArray, dict[str, Array], tuple[Note, ...]]:
    """(T,) time in the clock's own unit (integers stay integers), the SI channels, still on their own side, and what
    was done to them. rows: the only ones that count; a clock without a column counts from the file's first all the
    same. used: columns that any part of the mapping reads of the file."""
    table = open_table(path, file, each.layout, rows)
    _check_columns(table, each, used)
    first, left, notes = (rows[0] if rows else 0), (None if table.part else rows), table.notes
    raw = table.read(each.used, exact=(each.clock.column,) if each.clock.column else ())
    channels, faults = dict[str, Array](), list[Fault]()
    time = None if each.clock.column is None else as_vector(raw[each.clock.column], file, each.clock.column)
    for rule, filled in zip(each.rules, targets, strict=True):
        components = _components(rule.source, len(filled), raw, file)
        for label, values in components:
            if time is not None and values.size != time.size:
                detail = f"{values.size} values, but {time.size} times"
                raise BadLog(Fault(detail, "length_differs", "", file, column=shorten(label)))
            time = np.arange(values.size, dtype=np.int64) + (first if table.part else 0) if time is None else time
        kept = [cut(values, left, file) for _, values in components] if rows else [values for _, values in components]
        for (label, _), values in zip(components, kept, strict=True):
            faults += value_faults(values, file, label, allow_gaps=allow_gaps, first=first)
        channels |= _convert(rule, filled, kept, file)
    if time is None:
        raise BadLog(Fault("no rule reads this file", "file_not_used", "", file))
    time = cut(time, left, file)
    if each.clock.column is not None:
        if np.isfinite(time).all():
            time, note = evened(time, _unit(each.clock.unit).factor)
            notes = (*notes, *([note] if note else []))
        faults = time_faults(time, file, each.clock.column, first) + faults
    refuse(faults)
    return time, channels, notes


def _check_columns(table: Table, each: FileMapping, used_anywhere: Set[str]) -> None:
    """Every named column is there, and every column there is named."""
    names = read_names(table)
    faults = [
        Fault("the file has no such column", "missing_column", f"It has: {_some(names)}.", table.file, 0, shorten(used))
        for used in [*each.used, *(each.ignore or ())]
        if used not in names
    ]
    if each.ignore is not None:
        known = {*used_anywhere, *each.ignore}
        advice = "Say what it is, or ignore it (`ignore`) (`ignore: rest` leaves out all others)."
        faults += [
            Fault(
                "the mapping does not say what this column is", "unmapped_column", advice, table.file, 0, shorten(name)
            )
            for name in names
            if name not in known
        ]
    refuse(faults)


def _some(names: Sequence[str]) -> str:
    return ", ".join(shorten(name, 40) for name in names[:12]) + (", …" if len(names) > 12 else "")


def _components(source: Source, count: int, raw: Raw, file: str) -> list[tuple[str, Array]]:
    """Label and (T,) values of each component of a rule."""
    if source.dataset is None:
        return [(name, np.asarray(as_vector(raw[name], file, name), np.float64)) for name in source.columns]
    values = np.asarray(raw[source.dataset], np.float64)
    if values.ndim == 1:
        values = values[:, None] if source.time_axis != "last" else values[None, :]
    axis = {"first": 1, "last": 0, None: None}[source.time_axis]
    fitting = [k for k in (0, 1) if values.shape[k] == count and axis in (None, k)]
    if len(fitting) != 1:
        detail = f"{count} components are named, the array has shape {values.shape}"
        advice = "Give `time_axis: first` or `last`." if len(fitting) == 2 else "Name one channel per row or column."
        raise BadLog(Fault(detail, "shape_differs", advice, file, column=shorten(source.dataset)))
    across = values if fitting[0] == 0 else values.T
    return [(f"{source.dataset}[{k + 1}]", np.ascontiguousarray(across[k])) for k in range(count)]


def _convert(rule: Rule, filled: Sequence[Channel], values: Sequence[Array], file: str) -> dict[str, Array]:
    """SI values per channel, in the contract's frame and order."""
    if isinstance(rule, Wrench):
        if rule.order == "couple_first":
            values = [*values[3:], *values[:3]]
        force, moment = _unit(rule.force_unit), _unit(rule.moment_unit)
        stacked = np.stack(values)
        stacked[:3] *= rule.sign * force.factor
        stacked[3:] *= rule.sign * moment.factor
        if rule.rotation is not None:
            R = check_rotation(rule.rotation, file)
            stacked[:3], stacked[3:] = R @ stacked[:3], R @ stacked[3:]
    else:
        unit = _unit(rule.unit)
        stacked = rule.sign * (rule.scale * np.stack(values) * unit.factor + unit.offset)
        if isinstance(rule, Vector) and rule.rotation is not None:
            stacked = check_rotation(rule.rotation, file) @ stacked
        if isinstance(rule, Values) and rule.side == "joint":
            stacked = stacked + rule.offset
    return {channel.name: stacked[k] for k, channel in enumerate(filled)}


def _unit(name: str) -> Unit:
    unit = find_unit(name)
    if unit is None:
        raise ValueError(f"unit {name!r} passed the check of targets")
    return unit


def _common_origin(times: Sequence[RawArray], mapping: LogMapping, files: Sequence[str]) -> list[Array]:
    """(T,) [s] per file, 0 at the earliest sample of all; integer stamps are subtracted before they become floats."""
    clocks = [each.clock for each in mapping.files]
    if len({clock.column is None for clock in clocks}) > 1:
        without = next(file for file, clock in zip(files, clocks, strict=True) if clock.column is None)
        advice = "Give the file a time column on the clock of the others."
        detail = "this file has a rate, others have time stamps: where it starts is not known"
        raise BadLog(Fault(detail, "clocks_differ", advice, without))
    if clocks[0].rate_hz is not None:
        return [_late(time / _rate(clock), clock) for time, clock in zip(times, clocks, strict=True)]
    units = [_unit(clock.unit).factor for clock in clocks]
    if len(set(units)) == 1:
        first = min(time[0] for time in times)
        seconds = [_late((time - first) * units[0], clock) for time, clock in zip(times, clocks, strict=True)]
    else:
        seconds = [_late(time * unit, clock) for time, unit, clock in zip(times, units, clocks, strict=True)]
    origin = min(time[0] for time in seconds)
    return [time - origin for time in seconds]


def _late(time: RawArray, clock: Clock) -> Array:
    return np.asarray(time, np.float64) - clock.delay_s


def _rate(clock: Clock) -> float:
    if clock.rate_hz is None:
        raise ValueError("a clock without column has a rate")
    return clock.rate_hz


def _join(logs: Sequence[Log], rate_hz: float | None, name: str, allow_gaps: bool) -> Log:
    """One log on one clock: side by side where the times are the same, otherwise resampled."""
    same = all(np.array_equal(log.time, logs[0].time) for log in logs)
    if same and rate_hz is None:
        return Log(name, logs[0].time, {key: values for log in logs for key, values in log.channels.items()})
    from exogauge.logs.resampling import to_common_clock  # half a second of imports that one clock does not need

    for log in logs:
        cut(log.time, None, log.name)
        if allow_gaps:
            refuse([f for key, v in log.channels.items() for f in value_faults(v, log.name, key, allow_gaps=False)])
    return to_common_clock(logs, rate_hz, name)


def _motor_offsets(mapping: LogMapping) -> dict[str, float]:
    """Motor-side channels and the offset to add once they are joint-side."""
    return {
        channel: rule.offset
        for each in mapping.files
        for rule in each.rules
        if isinstance(rule, Values) and rule.side == "motor"
        for channel in rule.channels
    }
