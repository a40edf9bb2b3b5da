"""A series file opened for reading: what it holds, and its columns as numbers, by row groups.

A window of a series as CSV or Parquet: every sample, every digit, in portions.
"""

from __future__ import annotations

import difflib
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Literal, final

import numpy as np
import pyarrow as pa
import pyarrow.csv as pacsv
import pyarrow.parquet as pq
from numpy.typing import NDArray

from exogauge.errors import BadInput, Fault
from exogauge.studies.csv_table import safe_cell

Array = NDArray[np.float64]
Kind = Literal["number", "truth", "words"]
TIME = "t"


@final
@dataclass(frozen=True)
class SeriesChannel:
    """kind: number; truth, 0 or 1; words, the place of a sample's word in `words`."""

    name: str
    unit: str
    kind: Kind
    words: tuple[str, ...] = ()


@final
class SeriesFile:
    """Columns of `series/<log>.parquet`. samples: rows. groups: (G+1,) first row of each row group, and the end."""

    def __init__(self, source: Path | BinaryIO) -> None:
        self._file = pq.ParquetFile(source)
        self._schema = self._file.schema_arrow
        meta = self._file.metadata
        self.samples: int = meta.num_rows
        self.groups = np.cumsum([0, *(meta.row_group(k).num_rows for k in range(meta.num_row_groups))])
        self.log = (self._schema.metadata or {}).get(b"log", b"").decode("utf-8", "replace")

    @property
    def names(self) -> tuple[str, ...]:
        """All channels, without the time."""
        return tuple(name for name in self._schema.names if name != TIME)

    def channels(self) -> tuple[SeriesChannel, ...]:
        return tuple(self.channel(name) for name in self.names)

    def channel(self, name: str) -> SeriesChannel:
        field = self._schema.field(name)
        kind: Kind = "number"
        if pa.types.is_dictionary(field.type):
            kind = "words"
        elif pa.types.is_boolean(field.type):
            kind = "truth"
        unit = (field.metadata or {}).get(b"unit", b"").decode("utf-8", "replace")
        return SeriesChannel(name, unit, kind, self._words(name) if kind == "words" else ())

    def checked(self, names: Sequence[str]) -> tuple[str, ...]:
        """Each name once. An unknown one is a BadInput that says which channels there are."""
        known = self.names
        faults = [
            Fault("the series has no such channel", "unknown_channel", advice(name, known), column="channels",
                  value=name[:200])
            for name in names
            if name not in known
        ]  # fmt: skip
        if faults:
            raise BadInput(faults)
        return tuple(dict.fromkeys(names))

    def span(self) -> tuple[float, float]:
        """First and last time [s]; (0, 0) of an empty series."""
        if self.samples == 0:
            return 0.0, 0.0
        first, last = self.read(TIME, 0, 1), self.read(TIME, len(self.groups) - 2, len(self.groups) - 1)
        return float(first[0]), float(last[-1])

    def read(self, name: str, first: int, stop: int) -> Array:
        """(T,) values of row groups first … stop-1; NaN where there is none."""
        return self.read_all([name], first, stop)[name]

    def read_all(self, names: Sequence[str], first: int, stop: int) -> dict[str, Array]:
        table = self.table(names, first, stop)
        return {name: self._numbers(name, table.column(name)) for name in names}

    def table(self, names: Sequence[str], first: int, stop: int) -> Any:
        """The columns of these row groups as a pyarrow table."""
        return self._file.read_row_groups(list(range(first, stop)), columns=list(names))

    def _numbers(self, name: str, column: Any) -> Array:
        if pa.types.is_dictionary(column.type):
            place = {word: k for k, word in enumerate(self._words(name))}
            parts = [
                np.array([place[word] for word in chunk.dictionary.to_pylist()], np.float64)[chunk.indices.to_numpy()]
                for chunk in column.chunks
            ]
            return np.concatenate(parts) if parts else np.empty(0)
        return np.asarray(column.to_numpy(), dtype=np.float64)

    def _words(self, name: str) -> tuple[str, ...]:
        """In the order in which the file names them; each row group may keep a dictionary of its own."""
        column = self._file.read(columns=[name]).column(name)
        return tuple(dict.fromkeys(str(word) for chunk in column.chunks for word in chunk.dictionary.to_pylist()))


def advice(name: str, known: Sequence[str]) -> str:
    """What may have been meant, and what there is."""
    listed = ", ".join(known[:60]) + (f" and {len(known) - 60} more" if len(known) > 60 else "")
    near = next((f"Did you mean {each!r}? " for each in difflib.get_close_matches(name, known, n=1)), "")
    return f"{near}There are: {listed or 'none'}."


Format = Literal["csv", "parquet"]
GROUPS_AT_ONCE = 4


def window(series: SeriesFile, channels: Sequence[str], start: float, end: float, form: Format) -> Iterator[bytes]:
    """The rows with start <= t <= end [s], `t` first. A missing value is an empty cell, or null."""
    return (_csv if form == "csv" else _parquet)(_tables(series, [TIME, *channels], start, end))


def _tables(series: SeriesFile, names: Sequence[str], start: float, end: float) -> Iterator[Any]:
    """At least one, which may hold no row: it tells the columns."""
    for first in range(0, len(series.groups) - 1, GROUPS_AT_ONCE) or (0,):
        stop = min(first + GROUPS_AT_ONCE, len(series.groups) - 1)
        time = series.read(TIME, first, stop)
        row, stop_row = int(np.searchsorted(time, start, "left")), int(np.searchsorted(time, end, "right"))
        if row < stop_row or first == 0:
            yield series.table(names, first, stop).slice(row, max(stop_row - row, 0))
        if time.size and time[-1] > end:
            return


def _csv(tables: Iterator[Any]) -> Iterator[bytes]:
    for k, table in enumerate(tables):
        sink = io.BytesIO()
        pacsv.write_csv(_plain(table), sink, pacsv.WriteOptions(include_header=k == 0))
        yield sink.getvalue()


def _plain(table: Any) -> Any:
    """Words as text that a spreadsheet takes for text; numbers as they are."""
    for k, field in enumerate(table.schema):
        if pa.types.is_dictionary(field.type):
            words = pa.array([safe_cell(word) for word in table.column(k).to_pylist()], pa.string())
            table = table.set_column(k, field.name, words)
    return table


def _parquet(tables: Iterator[Any]) -> Iterator[bytes]:
    """Units and the series' own facts stay in the schema."""
    sink, writer = _Sink(), None
    for table in tables:
        if writer is None:
            words = [field.name for field in table.schema if pa.types.is_dictionary(field.type)]
            writer = pq.ParquetWriter(sink, table.schema, compression="zstd", use_dictionary=words)
        writer.write_table(table)
        yield sink.taken()
    if writer is not None:
        writer.close()
    yield sink.taken()


class _Sink(io.RawIOBase):
    """Keeps what is written until it is taken."""

    def __init__(self) -> None:
        self._kept, self._written = bytearray(), 0

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int:
        self._kept += data
        self._written += len(data)
        return len(data)

    def tell(self) -> int:
        return self._written

    def taken(self) -> bytes:
        taken = bytes(self._kept)
        self._kept.clear()
        return taken
