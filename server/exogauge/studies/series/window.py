"""A window of a series as CSV or Parquet: every sample, every digit, in portions."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from typing import Any, Literal

import numpy as np
import pyarrow as pa
import pyarrow.csv as pacsv
import pyarrow.parquet as pq

from exogauge.studies.csv_table import safe_cell
from exogauge.studies.series.file import TIME, SeriesFile

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
