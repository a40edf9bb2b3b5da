"""Tables of markers over time: whatever the header is like, the rows are read alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.motion_import import USUAL
from exogauge.motion.files.captured import Captured, fault, number

Array = NDArray[np.float64]
Rows = Sequence[tuple[int, str]]
Triple = tuple[int, int, int]
GAP = ("", "NULL", "NA")


@final
@dataclass(frozen=True)
class Table:
    """What a header says. columns: of each marker's x, y and z. wide: columns that rows have.

    rate: [Hz] if it is said; time, frame: columns, or None. stated: how many rows are announced, with the row and the
    key that say so. second: what one of the clock's units lasts [s]. head: what columns are called, where each has a
    name of its own.
    """

    format: str
    labels: tuple[str, ...]
    columns: tuple[Triple, ...]
    wide: int
    separator: str
    unit: float | None
    rate: float | None = None
    rate_at: tuple[int, str] = (1, "rate")
    time: int | None = None
    frame: int | None = None
    stated: tuple[str, int, str] | None = None
    told: Mapping[str, str] = field(default_factory=dict)
    second: float = 1.0
    head: tuple[str, ...] = ()

    def name(self, column: int | None, else_: str) -> str:
        """As the file has it."""
        return self.head[column] if self.head and column is not None else else_

    def axis(self, marker: int, axis: int) -> str:
        """The column of a marker's x, y or z, as the file has it."""
        return self.name(self.columns[marker][axis], f"{self.labels[marker]} {'xyz'[axis]}")


def from_x(column: int) -> Triple:
    """x, and y and z behind it."""
    return column, column + 1, column + 2


def points_of(path: Path, table: Table, rows: Rows) -> Captured:
    """The markers of all rows. A point that is left empty, or at 0 0 0 exactly, was not seen. Commas between other
    separators are decimal ones, where no row has a point."""
    told = dict(table.told)
    if table.separator != "," and any("," in line for _, line in rows) and not any("." in line for _, line in rows):
        rows, told["decimals"] = [(row, pointed(line)) for row, line in rows], "commas"
    if table.stated is not None and table.stated[0] != str(len(rows)):
        said, row, key = table.stated
        raise fault(path, f"{len(rows)} frames are there and {said or 'none'} announced", "frame_count",
                    "The file was cut off, or joined of two: export it again", row=row, column=key,
                    value=said or None)  # fmt: skip
    columns = [k for each in table.columns for k in each]
    position = np.empty((len(rows), len(columns)))
    clock = table.time if table.time is not None else table.frame
    time = np.arange(len(rows), dtype=np.float64)
    for t, (row, line) in enumerate(rows):
        cells = _cells(path, table, row, line, last=t + 1 == len(rows))
        if clock is not None:
            named = table.name(clock, "Time" if clock == table.time else "Frame")
            time[t] = table.second * number(path, cells[clock], row, named)
        try:
            position[t] = [float(cells[k]) if cells[k] else np.nan for k in columns]
        except ValueError:
            for j, k in enumerate(columns):
                named = table.axis(*divmod(j, 3))
                position[t, j] = np.nan if cells[k].strip() in GAP else number(path, cells[k], row, named)
    if table.frame is not None:
        _no_frame_lost(path, table, rows)
    points = position.reshape(len(rows), len(table.labels), 3)
    _whole(path, table, rows, points)
    points[(points == 0.0).all(axis=2)] = np.nan
    return Captured(table.format, _times(path, table, time), table.unit, None, table.labels, points, told=told,
                    row=rows[0][0] if rows else 1)  # fmt: skip


def pointed(text: str) -> str:
    """With decimal points in place of commas."""
    return text.replace(",", ".")


def _cells(path: Path, table: Table, row: int, line: str, last: bool) -> list[str]:
    """As many as are needed; empty ones at the end of a line are taken off by editors."""
    cells = line.split(table.separator)
    short = table.wide - len(cells)
    if short > 0 and short % 3 == 0 and not last and all(len(text.split()) < 2 for text in cells):
        cells += [""] * short
    if len(cells) < table.wide or any(text.strip() for text in cells[table.wide :]):
        advice = "Every row holds x, y, z of every marker" + (
            "; decimal commas are taken for the end of a cell" if table.separator == "," else ", between separators"
        )
        raise fault(path, f"{len(cells)} cells for {table.wide} columns", "row_length", advice, row=row)
    return cells


def _whole(path: Path, table: Table, rows: Rows, points: Array) -> None:
    """Raises BadMotion where a point is there by a part of its coordinates, or one is infinite."""
    gap = np.isnan(points)
    odd = np.isinf(points) | (gap != gap.all(axis=2, keepdims=True))
    if odd.any():
        t, m, axis = (int(each) for each in np.argwhere(odd)[0])
        value, column = points[t, m, axis], table.axis(m, axis)
        if np.isinf(value):
            number(path, f"{value:g}", rows[t][0], column)
        raise fault(path, "of this point a part of the coordinates is there", "half_a_point",
                    "Leave all three empty where it was not seen", row=rows[t][0], column=column)  # fmt: skip


def _no_frame_lost(path: Path, table: Table, rows: Rows) -> None:
    named = table.name(table.frame, "Frame")
    frames = [number(path, line.split(table.separator)[table.frame or 0], row, named) for row, line in rows]
    steps = np.diff(frames)
    if len(steps) and (steps != steps[0]).any():
        k = int(np.argmax(steps != steps[0])) + 1
        raise fault(path, f"frame {frames[k - 1] + steps[0]:g} is missing", "frame_lost", "Cut where frames are lost",
                    row=rows[k][0], column=named, value=f"{frames[k]:g}")  # fmt: skip


def _times(path: Path, table: Table, time: Array) -> Array:
    """[s]; what the header says of the rate and what the rows say agree."""
    row, key = table.rate_at
    rate = table.rate or 0.0
    if table.time is None:
        if not rate > 0.0:
            advice = "Export it with its times"
            if table.head:
                advice = "Add a column `time` in seconds, or a row above the names: # rate: 100"
            raise fault(path, "neither a rate nor times are there", "no_rate", advice, row=row, column=key,
                        value=f"{rate:g}")  # fmt: skip
        return time / rate
    runs = (len(time) - 1) / (time[-1] - time[0]) if len(time) > 1 and time[-1] > time[0] else 0.0
    if min(rate, runs) > 0.0 and abs(rate / runs - 1.0) > USUAL.same_rate:
        raise fault(path, f"{key} says {rate:g} frames a second, Time {runs:g}", "two_rates",
                    f"Time is in seconds: correct it, or {key}", row=row, column=key, value=f"{rate:g}")  # fmt: skip
    return time
