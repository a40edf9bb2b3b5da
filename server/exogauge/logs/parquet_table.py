"""Parquet through pyarrow: read, after what the footer declares was checked, and written in the one form in which
logs are kept: `t` and the channels as float64, in row groups of one chunk.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, final

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from exogauge.errors import BadLog, Fault, TooLarge
from exogauge.logs.channels import shorten
from exogauge.logs.limits import check_cells
from exogauge.logs.model import Log, Note
from exogauge.logs.tables import RawArray, broken

_FAILURES = (pa.ArrowException, OSError, ValueError, OverflowError, KeyError, IndexError)


@final
class ParquetTable:
    """A column of lists, all of one length n, is an array (T, n)."""

    part: tuple[int, int] | None = None
    notes: tuple[Note, ...] = ()

    def __init__(self, path: Path, file: str) -> None:
        self.file = file
        try:
            self._source = pq.ParquetFile(
                path, thrift_string_size_limit=64_000_000, thrift_container_size_limit=1_000_000, memory_map=False
            )
            self._schema = self._source.schema_arrow
            self._rows = int(self._source.metadata.num_rows)
            declared = sum(
                self._source.metadata.row_group(k).num_rows for k in range(self._source.metadata.num_row_groups)
            )
        except _FAILURES as problem:
            raise BadLog(broken(problem, file)) from None
        if declared != self._rows or self._rows < 0:
            raise BadLog(broken(ValueError(f"{self._rows} rows declared, {declared} in its row groups"), file))
        check_cells(self._rows, len(self._schema.names), file)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(str(name) for name in self._schema.names)

    def read(self, names: Sequence[str], exact: Sequence[str] = ()) -> dict[str, RawArray]:
        batch_rows = 1 << 16
        faults = [self._type_fault(name) for name in names if not _is_numeric(self._schema.field(name).type)]
        if faults:
            raise BadLog(faults)
        lists = {name: list[RawArray]() for name in names if _in_lists(self._schema.field(name).type)}
        kinds = {name: _target(self._schema.field(name), name in exact) for name in names if name not in lists}
        columns: dict[str, RawArray] = {name: np.empty(self._rows, kind) for name, kind in kinds.items()}
        for name in lists:
            check_cells(self._declared(name), 1, self.file, shorten(name))
        row = 0
        try:
            for batch in self._source.iter_batches(batch_rows, columns=list(names), use_threads=False):
                if row + batch.num_rows > self._rows:
                    raise ValueError("more rows than declared")
                for name in names:
                    column = batch.column(batch.schema.get_field_index(name))
                    if name in lists:
                        lists[name].append(self._rows_of(column, name, row, lists[name]))
                        continue
                    columns[name][row : row + batch.num_rows] = _values(column, kinds[name], name, row, self.file)
                row += batch.num_rows
        except _FAILURES as problem:
            raise BadLog(broken(problem, self.file)) from None
        except MemoryError:
            raise TooLarge(
                Fault("the values do not fit into memory", "memory_limit", "Split the recording.", self.file)
            ) from None
        if row != self._rows:
            raise BadLog(broken(ValueError(f"{self._rows} rows declared, {row} found"), self.file))
        return columns | {name: np.concatenate(parts) for name, parts in lists.items() if parts}

    def _declared(self, name: str) -> int:
        """Values in a column of lists, by the footer."""
        groups = [self._source.metadata.row_group(k) for k in range(self._source.metadata.num_row_groups)]
        parts = [group.column(k) for group in groups for k in range(group.num_columns)]
        return sum(part.num_values for part in parts if part.path_in_schema.startswith(f"{name}."))

    def _rows_of(self, column: Any, name: str, row: int, before: Sequence[RawArray]) -> RawArray:
        """(rows, n) of one batch of lists, as long as those before."""
        lengths = pc.fill_null(pc.list_value_length(column), 0).to_numpy(zero_copy_only=False)
        width = before[0].shape[1] if before else int(lengths[0]) if len(lengths) else 0
        if (other := np.flatnonzero(lengths != width)).size:
            detail = f"a list of {int(lengths[other[0]])} values, where the first row has {width}"
            advice = "Write lists of one length, or each value into a column of its own."
            raise BadLog(
                Fault(detail, "shape_differs", advice, self.file, row + int(other[0]) + 1, column=shorten(name))
            )
        check_cells(self._rows, max(width, 1), self.file, shorten(name))
        values = pc.cast(column.flatten(), pa.float64(), safe=False).to_numpy(zero_copy_only=False)
        return np.asarray(values, np.float64).reshape(len(lengths), width)

    def _type_fault(self, name: str) -> Fault:
        return Fault(
            f"the column holds {shorten(str(self._schema.field(name).type))}, not numbers",
            "not_a_number",
            "Write it as double.",
            self.file,
            column=shorten(name),
        )


def _in_lists(kind: Any) -> bool:
    return bool(pa.types.is_list(kind) or pa.types.is_large_list(kind) or pa.types.is_fixed_size_list(kind))


def _is_numeric(kind: Any) -> bool:
    if _in_lists(kind):
        return not _in_lists(kind.value_type) and _is_numeric(kind.value_type)
    return bool(
        pa.types.is_integer(kind)
        or pa.types.is_floating(kind)
        or pa.types.is_boolean(kind)
        or pa.types.is_decimal(kind)
        or pa.types.is_timestamp(kind)
        or pa.types.is_null(kind)
    )


def _target(field: Any, exact: bool) -> Any:
    whole = pa.types.is_integer(field.type) or pa.types.is_timestamp(field.type)
    return np.int64 if exact and whole else np.float64


def _values(column: Any, kind: Any, name: str, row: int, file: str) -> RawArray:
    """One batch as numbers; a timestamp counts nanoseconds."""
    if pa.types.is_timestamp(column.type):
        column = pc.cast(pc.cast(column, pa.timestamp("ns", tz=column.type.tz)), pa.int64())
    if kind is np.int64:
        if column.null_count:
            first = int(np.flatnonzero(column.is_null().to_numpy(zero_copy_only=False))[0])
            raise BadLog(Fault("a time stamp is missing", "missing_value", "", file, row + first + 1, shorten(name)))
        return np.asarray(pc.cast(column, pa.int64()).to_numpy(zero_copy_only=False))
    return np.asarray(pc.cast(column, pa.float64(), safe=False).to_numpy(zero_copy_only=False), np.float64)


def write_log(log: Log, path: Path) -> None:
    """Write the log; the same log gives the same bytes. `reading.read_log` reads it back exactly."""
    row_group = 12_000
    names = ["t", *log.channels]
    schema = pa.schema([pa.field(name, pa.float64(), nullable=False) for name in names])
    with pq.ParquetWriter(
        path, schema, compression="zstd", use_dictionary=False, use_byte_stream_split=True, write_statistics=False
    ) as writer:
        for start in range(0, log.samples, row_group):
            chunk = slice(start, start + row_group)
            arrays = [pa.array(values[chunk]) for values in (log.time, *log.channels.values())]
            writer.write_table(pa.Table.from_arrays(arrays, schema=schema), row_group_size=row_group)
