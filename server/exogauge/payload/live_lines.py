"""A stream without a server: a log read as if it were live, or lines from elsewhere; what is found, as lines."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

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
    yield from stream.end()


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
    yield from stream.end()


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
