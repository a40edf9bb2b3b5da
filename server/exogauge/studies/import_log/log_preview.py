"""A first look at a foreign log, before a mapping says what it holds: columns, ranges, first rows, what each may be.

With a mapping that is complete, also what the doctor says of the log that it makes.

A mapping.yaml drafted by looking at the files: what is suggested, and as comments what a person has to see to.
"""

from __future__ import annotations

import math
import re
from collections.abc import Container, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

import numpy as np
import yaml
from numpy.typing import NDArray

from exogauge.criteria.logs import LOGS
from exogauge.errors import BadInput, BadLog, Fault
from exogauge.logs.channels import parse_channel, shorten
from exogauge.logs.mapping import LogMapping, read_mapped
from exogauge.logs.model import Array, Log
from exogauge.logs.open_table import open_table
from exogauge.logs.tables import Encoding, RawArray, Table, TextLayout, read_names
from exogauge.logs.whole_turns import continued, in_one_course
from exogauge.robots.description import Robot
from exogauge.studies.import_log.column_guess import COMMANDED, OF_A_MODEL, guess
from exogauge.studies.import_log.column_words import (
    Advice,
    JointFacts,
    Seen,
    Suggestion,
    Wearer,
    axes_by_number,
    axis_in,
    kinds_in,
    known_unit,
    words_of,
)

if TYPE_CHECKING:
    from exogauge.logs.findings import Expectation
    from exogauge.robots.description import Robot
from exogauge.logs.channels import WRENCH_AXES

XYZ = "xyz"
FIRST_ROWS = 20
AROUND = 200  # samples to each side of a finding
MOST_TEXT_COLUMNS = 40
TEXT = ("not_a_number",)
NO_LOG: dict[str, Any] = {"faults": [], "findings": [], "channels": [], "clock": None}


def preview(path: Path, file: str, worn: Wearer, layout: TextLayout | None = None) -> dict[str, Any]:
    """{file, rows, header, columns, mapping, proposal}; mapping: of what is sure, proposal: of all suggestions.

    A column has name, dtype, shape, min, max, missing, samples (its first rows), suggestion and advice. Raises BadLog.
    """
    table, layout = _opened(path, file, layout)
    names = read_names(table)
    values, texts = _values(table, names)
    flat = {name: each for name, each in values.items() if np.squeeze(each).ndim <= 1}
    samples, widths = _samples(values), {len(XYZ), len(worn.joints or ())}
    parts = {name: _parts(name, each, samples, widths) for name, each in values.items() if name not in flat}
    single = flat | {part: each for whole in parts.values() for part, each in whole.items()}
    seen = [_seen(name, np.atleast_1d(np.squeeze(each))) for name, each in single.items()]
    found = guess(seen, worn, _norms(single))
    columns = [
        _text_column(texts[name]) | {"name": name} if name in texts else _column(name, values[name], found.get(name))
        for name in names
    ]
    wholes = {name: alike for name, whole in parts.items() if (alike := _alike([found[part] for part in whole]))}
    for column in columns:
        if (name := column["name"]) in wholes:
            column["advice"] = _of_whole(wholes[name])
        elif said := _advice_of_all([found[part] for part in parts.get(name, ())]):
            column["advice"] = said
    every = {name: each for name, each in found.items() if name in flat and isinstance(each, Suggestion)}
    sure = {name: each for name, each in every.items() if each.sure}
    return {
        "file": file,
        "rows": max((each.shape[0] for each in flat.values()), default=samples),
        "header": layout.header,
        "columns": columns,
        "mapping": proposal(file, sure, layout),
        "proposal": proposal(file, every, layout, wholes),
    }


def judged(
    path: Path, file: str, rules: LogMapping, joints: Sequence[str], gears: Array, expected: Expectation
) -> dict[str, Any]:
    """{faults, findings, channels, clock}: what keeps the mapping from making a log, else what the doctor finds in it.

    clock: {samples, duration_s, rate_hz} wherever there is one, so that a wrong unit of time is seen.
    """
    from exogauge.studies.intake.admit import impossible_rate

    try:
        log = read_mapped({file: path}, rules, joints=joints, motor_from_joint=gears, name=file, allow_gaps=True)
    except BadInput as bad:
        return NO_LOG | {"faults": [asdict(fault) for fault in bad.faults]}
    clock = {"samples": log.samples, "duration_s": float(log.time[-1] - log.time[0]), "rate_hz": log.rate_hz}
    if wrong := impossible_rate(log):
        return NO_LOG | {"faults": [asdict(fault) for fault in wrong], "clock": clock}
    (log,) = in_one_course([log], expected.joints)
    return {"faults": [], "findings": findings(log, expected), "channels": list(log.channels), "clock": clock}


def findings(log: Log, expected: Expectation) -> list[dict[str, Any]]:
    """As results.json has them, with the sample's index from 0 and its time [s] where one is meant, and the samples
    around it."""
    from exogauge.logs.doctor import examine
    from exogauge.studies.results.plain_values import finite

    return [
        finite(
            asdict(each)
            | {
                "index": None if each.row is None else each.row - 1,
                "t": None if each.row is None else float(log.time[each.row - 1]),
                "around": None if each.row is None else _around(log, each.channel, each.row - 1),
            }
        )
        for each in examine(log, expected)
    ]


def _around(log: Log, channel: str, index: int) -> dict[str, Any] | None:
    """What to draw of a channel: `AROUND` samples to each side, exactly as they are; None of the clock."""
    values = log.channels.get(channel)
    if values is None:
        return None
    part = slice(max(index - AROUND, 0), index + AROUND + 1)
    return {"unit": parse_channel(channel).unit, "t": log.time[part].tolist(), "values": values[part].tolist()}


def wearer(robot: Robot | None) -> Wearer:
    if robot is None:
        return Wearer()
    tree = robot.tree
    limits = zip(tree.joints, tree.lower.tolist(), tree.upper.tolist(), tree.velocity_limit.tolist(), strict=True)
    facts = {each[0]: JointFacts(*each, sliding=each[0] in tree.sliding) for each in limits}
    joints = tuple(facts.get(joint.name, JointFacts(joint.name)) for joint in robot.joints)
    return Wearer(joints, tuple(sensor.name for sensor in robot.sensors))


def _opened(path: Path, file: str, layout: TextLayout | None) -> tuple[Table, TextLayout]:
    """The table, and how it lies in the file: a table of bare numbers has its columns counted, what stands before the
    names is skipped, and of another encoding is the one in which most of its names say something."""
    layout = layout or TextLayout()
    try:
        return open_table(path, file, layout), layout
    except BadLog as bad:
        (fault, *others) = bad.faults
        if fault.rule == "not_utf8" and layout.encoding == TextLayout().encoding:
            opened = [each for each in _in_other_encodings(path, file, layout) if _understood(each[0])]
            best = max(opened, key=lambda each: _understood(each[0]), default=None)
            if best and (
                not fault.row or "".join(best[0].names).isascii()
            ):  # or its names were right: one byte is wrong
                return best
        if others or not layout.from_the_head or fault.value is None or fault.rule not in ("no_header", "lines_before"):
            raise
        before = fault.rule == "lines_before"
        layout = replace(layout, skip_lines=int(fault.value)) if before else replace(layout, header=False)
        return open_table(path, file, layout), layout


def _in_other_encodings(path: Path, file: str, layout: TextLayout) -> Iterator[tuple[Table, TextLayout]]:
    for encoding in get_args(Encoding):
        if encoding != layout.encoding:
            with suppress(BadLog):
                yield _opened(path, file, replace(layout, encoding=encoding))


def _understood(table: Table) -> int:
    """Quantities and units that the names of the columns say."""
    said = [words_of(name) for name in table.names]
    return sum(bool(kinds_in(words.tokens)) + (words.unit is not None) for words in said)


def _values(table: Table, names: Sequence[str]) -> tuple[dict[str, RawArray], dict[str, Fault]]:
    """Columns of numbers, and the first cell that is none of the others."""
    texts = dict[str, Fault]()
    by_label = {shorten(name): name for name in names}
    while True:
        left = [name for name in names if name not in texts]
        try:
            return table.read(left) if left else {}, texts
        except BadLog as bad:
            new = {by_label.get(fault.column or "", ""): fault for fault in reversed(bad.faults) if fault.rule in TEXT}
            if not new or "" in new or len(texts) > min(MOST_TEXT_COLUMNS, LOGS.most_columns):
                raise
            texts |= new


def _seen(name: str, values: RawArray) -> Seen:
    finite = values[np.isfinite(values)] if values.dtype.kind == "f" else values
    if not finite.size:
        return Seen(name, 0.0, 0.0)
    if finite.size == values.size and values.dtype.kind == "f":
        for turn in (math.tau, 360.0):  # an angle that begins anew after each is read as one course
            course, row = continued(np.asarray(values, np.float64) * math.tau / turn)
            finite = finite if row is None else course * turn / math.tau
    step = None
    if finite.size == values.size > 1 and values.dtype.kind in "fiu":
        steps = np.diff(values.astype(np.float64) if values.dtype.kind == "f" else values.astype(np.int64))
        step = float(np.median(steps)) if (steps > 0).all() else None
    return Seen(name, float(finite.min()), float(finite.max()), step)


def _column(name: str, values: RawArray, found: Suggestion | Advice | None) -> dict[str, Any]:
    numbers = np.asarray(values, np.float64)
    finite = numbers[np.isfinite(numbers)]
    first = numbers.reshape(-1)[:FIRST_ROWS] if numbers.ndim <= 1 else np.empty(0)
    whole = bool(finite.size) and bool((finite == np.floor(finite)).all())
    many = "Name its components under `arrays`, `vectors` or `wrenches` of the mapping."
    advice = many if numbers.ndim > 1 and found is None else None
    return {
        "name": name,
        "dtype": "array" if numbers.ndim > 1 else "whole" if whole else "number",
        "shape": list(numbers.shape),
        "min": float(finite.min()) if finite.size else None,
        "max": float(finite.max()) if finite.size else None,
        "missing": int(numbers.size - finite.size),
        "samples": [float(value) if np.isfinite(value) else None for value in first],
        "suggestion": asdict(found) if isinstance(found, Suggestion) else None,
        "advice": found.text if isinstance(found, Advice) else advice,
    }


def _samples(values: Mapping[str, RawArray]) -> int:
    return max((size for each in values.values() for size in each.shape), default=0)


def _parts(name: str, values: RawArray, samples: int, widths: Container[int]) -> dict[str, RawArray]:
    """What it holds of each sample, as columns that are called `name[0]`. Nothing where it has no axis of samples, or
    as many values beside it as there are neither joints nor axes."""
    if values.ndim != 2 or samples not in values.shape:
        return {}
    across = values.T if values.shape[0] == samples else values
    return {f"{name}[{k}]": each for k, each in enumerate(across)} if len(across) in widths else {}


def _alike(found: Sequence[Suggestion | Advice]) -> tuple[Suggestion, ...]:
    """Of one array, if they differ in nothing but their joint or axis, as one entry of a mapping has to; else none."""
    each = [one for one in found if isinstance(one, Suggestion)]
    kinds = {(parse_channel(one.channel).kind, one.unit, one.sign, one.side) for one in each}
    fits = len(each) == len(found) and len(kinds) == 1 and all(one.channel != "t" for one in each)
    return tuple(each) if fits else ()


def _advice_of_all(found: Sequence[Suggestion | Advice]) -> str | None:
    """That no column of an array was measured; None where some may have been."""
    said = {each.text for each in found if isinstance(each, Advice)}
    return said.pop() if len(said) == 1 and said <= {COMMANDED, OF_A_MODEL} else None


def _of_whole(found: Sequence[Suggestion]) -> str:
    channels = ", ".join(each.channel for each in found[:NAMED]) + (" …" if len(found) > NAMED else "")
    return f"Drafted as {channels} [{found[0].unit}]: {found[0].why}."


def _text_column(fault: Fault) -> dict[str, Any]:
    advice = f"{fault.detail[:1].upper()}{fault.detail[1:]}: ignore it (`ignore`)."
    if fault.row is not None:
        cell = str(fault.value or "")
        advice = f"It holds text (row {fault.row}: {cell}), which no channel is made of: {_of_text(cell)}."
    empty: dict[str, Any] = {"shape": [], "min": None, "max": None, "missing": 0, "samples": [], "suggestion": None}
    return {"name": "", "dtype": "text", "advice": advice, **empty}


def _of_text(cell: str) -> str:
    """What to do about a cell that is no number, by what it looks like."""
    bare = cell.strip().strip("[]() ")
    if re.search(r"^\s*(array)?[(\[].*\d.*,", cell):
        return "write each value of the list into a column of its own"
    if known_unit(bare) is not None:
        return "take the line of units out, and write them behind the names, such as `q1 [rad]`"
    if re.match(r"\d+[-/:]\d+[-/:]\d", bare):
        return "write a date or time of day in seconds, or ignore it (`ignore`) and give `rate_hz`"
    return "ignore it (`ignore`), or correct the cell"


def _norms(values: Mapping[str, RawArray]) -> dict[str, float]:
    """Median size of each accelerometer's vector, by each of its columns."""
    triples: dict[tuple[str, ...], dict[str, str]] = {}
    by_number = axes_by_number(values)
    for name in values:
        tokens = words_of(name).tokens
        axis = by_number.get(name) or axis_in(tokens)
        if axis is not None and (axis[0] == "acc" or "acc" in kinds_in(tokens)):
            stem = tuple(
                token for token in tokens if axis_in((token,)) is None and not (token.isdecimal() and name in by_number)
            )
            triples.setdefault(stem, {})[axis[1]] = name
    found: dict[str, float] = {}
    for members in triples.values():
        if len(members) == 3:
            vectors: NDArray[np.float64] = np.stack([np.asarray(values[name], np.float64) for name in members.values()])
            found |= dict.fromkeys(members.values(), float(np.nanmedian(np.linalg.norm(vectors, axis=0))))
    return found


NAMED = 6  # of columns that are open for one reason, so that a robot of thirty joints stays one line
HEAD = "# Drafted from names, ranges and the robot. Check what is marked ?; name or ignore what is marked !."


def draft(paths: Sequence[Path], robot: Robot | None) -> str:
    """The mapping of all files together, those of a file one after the other. Raises BadLog."""
    looks = [preview(path, path.name, wearer(robot)) for path in paths]
    lines = [HEAD, *(line for look in looks for line in _open(look))]
    parts = [part for look in looks for part in look["proposal"]["files"]]
    if len(parts) == 1:  # of one file, whatever it is called: the next logs of the robot are others
        endings = paths[0].suffixes[-2:] if paths[0].suffix == ".gz" else paths[0].suffixes[-1:]
        parts[0]["file"] = f"*{''.join(endings)}"
    content = {"version": 1, "files": parts}
    comments = [" ".join(line.split()) for line in lines]
    return "\n".join([*comments, yaml.safe_dump(content, allow_unicode=True, sort_keys=False, width=120)])


def _open(look: Mapping[str, Any]) -> list[str]:
    """What a person has to look at: one line for all columns of which the same is said."""
    drafted = {each["dataset"] for part in look["proposal"]["files"] for each in _of_arrays(part)}
    alike: dict[tuple[str, str, str], list[tuple[str, str]]] = {}
    for column in look["columns"]:
        found = column["suggestion"]
        if found is not None and not found["sure"]:
            alike.setdefault(("?", found["why"], f" [{found['unit']}]"), []).append((column["name"], found["channel"]))
        elif column["advice"]:
            mark = "?" if column["name"] in drafted else "!"
            alike.setdefault((mark, column["advice"], ""), []).append((column["name"], ""))
    lines = list[str]()
    for (mark, said, unit), columns in alike.items():
        names = ", ".join(f"{name} as {channel}{unit}" if channel else name for name, channel in columns[:NAMED])
        more = f" and {len(columns) - NAMED} more" if len(columns) > NAMED else ""
        lines.append(f"# {mark} {look['file']}: {names}{more}: {said}")
    return lines


def _of_arrays(part: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return [each for key in ("arrays", "vectors") for each in part.get(key, ()) if "dataset" in each]


def proposal(
    file: str,
    found: Mapping[str, Suggestion],
    layout: TextLayout | None = None,
    wholes: Mapping[str, Sequence[Suggestion]] | None = None,
) -> dict[str, Any]:
    """The mapping of these columns and no others: what it leaves open, its reader refuses. wholes: of an array each.

    The three of an IMU and the six of a sensor become one entry, which may be turned; fewer stay columns. Topics of a
    bag have a clock each, and so a part of the mapping each.
    """
    layout = layout or TextLayout()
    stamps = [name.removesuffix("stamp") for name, each in found.items() if each.channel == "t"]
    if len(stamps) > 1:
        topics = [{name: each for name, each in found.items() if name.startswith(stamp)} for stamp in stamps]
        return {"version": 1, "files": [_entry_of(file, topic, layout) for topic in topics if len(topic) > 1]}
    return {"version": 1, "files": [_entry_of(file, found, layout, wholes)]}


def _entry_of(
    file: str,
    found: Mapping[str, Suggestion],
    layout: TextLayout,
    wholes: Mapping[str, Sequence[Suggestion]] | None = None,
) -> dict[str, Any]:
    entry: dict[str, Any] = {"file": file}
    if layout != TextLayout():
        usual = vars(TextLayout())
        entry["layout"] = {key: value for key, value in vars(layout).items() if value != usual[key]}
    left = dict(found)
    time = next((name for name, each in found.items() if each.channel == "t"), None)
    if time is not None:
        entry["time"] = {"column": time, "unit": left.pop(time).unit}
    vectors = [made for kind in ("acc", "gyro") if (made := _vector(kind, left))]
    wrenches = [made for sensor in _sensors(left) if (made := _wrench(sensor, left))]
    if left:
        entry["columns"] = {name: _entry(each) for name, each in left.items()}
    arrays = list[dict[str, Any]]()
    for name, whole in (wholes or {}).items():
        kind = parse_channel(whole[0].channel).kind
        if kind in ("acc", "gyro"):
            vectors.append({"channel": kind, "dataset": name, "unit": whole[0].unit})
        else:
            joints = {"dataset": name, "channels": [each.channel for each in whole]}
            arrays.append(joints | {key: said for key, said in _entry(whole[0]).items() if key != "channel"})
    entry |= {key: made for key, made in (("arrays", arrays), ("vectors", vectors), ("wrenches", wrenches)) if made}
    return entry


def _entry(each: Suggestion) -> dict[str, Any]:
    said: dict[str, Any] = {"channel": each.channel, "unit": each.unit}
    if each.sign != 1:
        said["sign"] = each.sign
    return said | ({"side": each.side} if each.side != "joint" else {})


def _vector(kind: str, left: dict[str, Suggestion]) -> dict[str, Any] | None:
    by_channel = {each.channel: name for name, each in left.items()}
    names = [by_channel.get(f"{kind}.{axis}") for axis in XYZ]
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
