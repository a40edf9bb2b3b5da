"""A stream without a server: a log read as if it were live, or lines from elsewhere; what is found, as lines,
for programs and for a person.
"""

from __future__ import annotations

import csv
import json
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import IO, Any, final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.payload_dynamic import USUAL, Moving
from exogauge.errors import BadStudy, Fault
from exogauge.logs.channels import shorten
from exogauge.logs.open_table import open_table
from exogauge.logs.tables import as_vector, read_names
from exogauge.payload.contract import PayloadFile
from exogauge.payload.live import Known, Live, Sensed, Start
from exogauge.payload.live_input import Arrivals, Columns
from exogauge.payload.live_messages import error_message, payload_message, wrench_message
from exogauge.studies.intake.yaml_file import suggestion

Array = NDArray[np.float64]

AT_ONCE = 250  # samples of a log


@final
class Stream:
    """Rows in, messages out: what a websocket sends, and what a terminal prints."""

    def __init__(self, file: PayloadFile, start: Start, rate_hz: float, arrivals: Arrivals | None = None) -> None:
        self.columns = Columns(file, start.pose.chain)
        self.live, self.arrivals = Live(start, rate_hz), arrivals or Arrivals()
        self._inside = deque[int]()  # numbers of samples that have not come out
        self.kept: Callable[[NDArray[np.int64], Array], None] = lambda numbers, rows: None
        """Called with the samples that are taken, as they came, before anything is made of them."""

    def take(self, numbers: NDArray[np.int64], rows: Array, clock: float | None = None) -> Iterator[Mapping[str, Any]]:
        """rows: (n, columns) as payload.yaml names them. Raises BadStudy where they have another width."""
        counts = self.arrivals.counts
        counts.received += len(rows)
        good, read, faults = self.columns.read_some(rows)
        if faults:
            counts.refused += int(np.sum(~good))
            row = faults[0].row
            yield error_message(faults[0] if row is None else replace(faults[0], row=int(numbers[row - 1])))
        if read is None:
            return
        time, pose, wrench = read
        keep = self.arrivals.admit(numbers[good], time, clock)
        self._inside.extend(numbers[good][keep].tolist())
        if keep.any():
            self.kept(numbers[good][keep], rows[good][keep])
            yield from self._told(self.live.push(time[keep], pose[keep], wrench[keep]))

    def end(self) -> Iterator[Mapping[str, Any]]:
        """What is left."""
        yield from self._told(self.live.flush())

    def _told(self, said: Iterable[Sensed | Known]) -> Iterator[Mapping[str, Any]]:
        for each in said:
            if isinstance(each, Known):
                yield payload_message(each, self.arrivals.counts, self.live.rate_hz)
            else:
                yield wrench_message(each, [self._inside.popleft() for _ in each.time])


def from_log(path: Path, stream: Stream) -> Iterator[Mapping[str, Any]]:
    """The rows of a log, in any format that is read."""
    table = open_table(path, path.name)
    names = read_names(table)
    for name in stream.columns.names:
        if name not in names:
            advice = suggestion(name, list(names))
            fault = Fault("the file has no such column", "missing_column", advice, path.name, 0, shorten(name))
            raise BadStudy(fault)
    raw = table.read(list(stream.columns.names), exact=stream.columns.names)
    rows = np.column_stack([np.asarray(as_vector(raw[c], path.name, c), np.float64) for c in stream.columns.names])
    for first in range(0, len(rows), AT_ONCE):
        part = rows[first : first + AT_ONCE]
        yield from stream.take(np.arange(first, first + len(part)), part)
    yield from _ended(stream)


def from_lines(lines: Iterable[str], stream: Stream) -> Iterator[Mapping[str, Any]]:
    """One sample per line: a JSON object by column, a JSON array, or comma-separated numbers, whose first line may name
    the columns. A line that cannot be read is told and counted."""
    order: Sequence[str] = stream.columns.names
    for number, line in enumerate(lines):
        text = line.strip()
        if not text:
            continue
        if number == 0 and not text.startswith(("{", "[")) and any(c.isalpha() and c not in "eE" for c in text):
            order = [name.strip() for name in text.split(",")]
            continue
        try:
            row = parsed(text, order, stream.columns.names, number + 1)
        except BadStudy as error:
            stream.arrivals.counts.received += 1
            stream.arrivals.counts.refused += 1
            yield error_message(error)
            continue
        yield from stream.take(np.array([number + 1]), row[None])
    yield from _ended(stream)


def _ended(stream: Stream) -> Iterator[Mapping[str, Any]]:
    yield from stream.end()
    counts = stream.arrivals.counts
    if not stream.live.told:
        detail = f"of {counts.received} samples {counts.taken} count, too few to tell anything"
        advice = (
            "Every sample needs a later time than the one before, and there must be some tenths of a second of them."
        )
        yield error_message(Fault(detail, "too_few_samples", advice, "stream"))


def parsed(text: str, order: Sequence[str], names: Sequence[str], line: int) -> Array:
    """(columns,) numbers in the order of `names`. Raises BadStudy."""
    try:
        said = json.loads(text) if text[0] in "{[" else [float(cell) for cell in text.split(",")]
        if isinstance(said, list):
            said = dict(zip(order, said, strict=True))
        return np.array([float(said[name]) for name in names])
    except KeyError as error:
        detail, advice = "the sample lacks a column", f"It needs {', '.join(names)}."
        raise BadStudy(Fault(detail, "missing_column", advice, "stream", line, shorten(str(error.args[0])))) from error
    except (ValueError, TypeError) as error:
        advice = f"Send {', '.join(names)} as a JSON object, a JSON array or comma-separated numbers."
        raise BadStudy(Fault("the line is no sample", "no_sample", advice, "stream", line, value=text[:60])) from error


@final
class Contact:
    """One that may not have ended."""

    def __init__(self, time: float, wrench: list[float]) -> None:
        self.start = self.last = time
        self.most = wrench[:3]

    def goes_on(self, time: float, wrench: list[float]) -> None:
        self.last = time
        if np.linalg.norm(wrench[:3]) > np.linalg.norm(self.most):
            self.most = wrench[:3]

    @property
    def line(self) -> str:
        force = ", ".join(f"{x:.3g}" for x in self.most)
        return f"contact {self.start:.3f} to {self.last:.3f} s, force on the payload up to ({force}) N"


def lines(messages: Iterable[Mapping[str, Any]], criteria: Moving = USUAL) -> Iterator[str]:
    every = 10  # estimates for one line
    contact: Contact | None = None
    told, state, counts = 0, "", dict[str, int]()
    for each in messages:
        if each["type"] == "wrench":
            for time, wrench, alarm in zip(each["t"], each["wrench"], each["alarm"], strict=True):
                if contact is not None and time - contact.last > criteria.bridged_s:
                    yield contact.line
                    contact = None
                if alarm and contact is None:
                    contact = Contact(time, wrench)
                elif alarm and contact is not None:
                    contact.goes_on(time, wrench)
        elif each["type"] == "payload":
            counts = each["counts"]
            if told % every == 0 or each["state"] != state:
                yield known_line(each)
            told, state = told + 1, each["state"]
        elif each["type"] == "error":
            place = f"sample {each['row']}: " if "row" in each else ""
            yield f"{place}{each['detail']}. {each.get('advice', '')}".strip()
    if contact is not None:
        yield contact.line
    if counts:
        yield ", ".join(f"{name.replace('_', ' ')} {number}" for name, number in counts.items() if number)


def known_line(message: Mapping[str, Any]) -> str:
    value, std, mu = message["value"], message["std"], message["mu"]
    parts = [f"{message['t']:9.2f} s", f"{message['state']:10s}", f"m {value['m']:.4g} ± {std['m']:.1g} kg"]
    parts += [f"{name} {value[name]:.3g} ± {std[name]:.1g}" for name in ("mx", "my", "mz", "Ixx", "Iyy", "Izz")]
    parts.append(f"contact from {message['threshold_n']:.2g} N")
    if message["late_ms"] is not None:
        parts.append(f"wrench {message['late_ms']:.2f} ± {message['late_std_ms']:.1g} ms late")
    if mu is not None:
        parts.append(f"μ {mu:.2f} ± {message['mu_std']:.2f}")
    if message["in_doubt"]:
        parts.append(f"not to be believed: {' '.join(message['in_doubt'])}")
    return "  ".join(parts)


AXES = ("fx", "fy", "fz", "mx", "my", "mz")


def written(messages: Iterable[Mapping[str, Any]], out: IO[str]) -> Iterator[Mapping[str, Any]]:
    """The messages, each sample's wrench also as a row of CSV."""
    rows = csv.writer(out, lineterminator="\n")
    rows.writerow(["seq", "t", *AXES, *(f"std_{axis}" for axis in AXES), "alarm", "settled"])
    for each in messages:
        if each["type"] == "wrench":
            for seq, t, wrench, std, alarm, settled in zip(
                each["seq"], each["t"], each["wrench"], each["std"], each["alarm"], each["settled"], strict=True
            ):
                rows.writerow([seq, repr(t), *wrench, *std, int(alarm), int(settled)])
        yield each
