"""The one form in which logs are kept: Parquet with `t` and the channels as float64, in row groups of one chunk."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from exogauge.logs.model import Log

ROW_GROUP = 12_000


def write_log(log: Log, path: Path) -> None:
    """Write the log; the same log gives the same bytes. `reading.read_log` reads it back exactly."""
    names = ["t", *log.channels]
    schema = pa.schema([pa.field(name, pa.float64(), nullable=False) for name in names])
    with pq.ParquetWriter(
        path, schema, compression="zstd", use_dictionary=False, use_byte_stream_split=True, write_statistics=False
    ) as writer:
        for start in range(0, log.samples, ROW_GROUP):
            chunk = slice(start, start + ROW_GROUP)
            arrays = [pa.array(values[chunk]) for values in (log.time, *log.channels.values())]
            writer.write_table(pa.Table.from_arrays(arrays, schema=schema), row_group_size=ROW_GROUP)
