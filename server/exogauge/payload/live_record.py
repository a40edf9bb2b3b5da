"""The samples of a stream on disk as they are taken: records of one size, so that a kill leaves whole ones; and the log
that is made of them, which `payload.yaml` can name."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from pathlib import Path
from typing import final

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from exogauge.storage.blobs import disk

Array = NDArray[np.float64]


def record_type(columns: int) -> np.dtype[np.void]:
    return np.dtype([("seq", "<i8"), ("row", "<f8", (columns,))])


@final
class Record:
    """One writer. A last record that is not whole is cut off."""

    def __init__(self, path: Path, columns: int) -> None:
        self.path, self._type = path, record_type(columns)
        with disk("record the stream"):
            self._file = path.open("ab", buffering=0)
            self._file.truncate(self.size * self._type.itemsize)
        self._synced = time.monotonic()

    @property
    def size(self) -> int:
        """Whole records."""
        return self.path.stat().st_size // self._type.itemsize

    def append(self, numbers: NDArray[np.int64], rows: Array) -> None:
        sync_s = 1.0  # between two syncs: what a power cut can cost; a killed process loses nothing that was written
        record = np.empty(len(rows), self._type)
        record["seq"], record["row"] = numbers, rows
        with disk("record the stream"):
            left = memoryview(record.tobytes())
            while left:
                left = left[self._file.write(left) :]
            if time.monotonic() - self._synced > sync_s:
                os.fsync(self._file.fileno())
                self._synced = time.monotonic()

    def tail(self, count: int) -> tuple[NDArray[np.int64], Array]:
        """The last ones, at most `count`."""
        first = max(self.size - count, 0)
        found = np.fromfile(self.path, self._type, offset=first * self._type.itemsize)
        return found["seq"].copy(), found["row"].copy()

    def close(self) -> None:
        with disk("record the stream"):
            os.fsync(self._file.fileno())
            self._file.close()


def write_log(path: Path, columns: Sequence[str], out: Path) -> int:
    """The samples of a record as Parquet, with the columns of payload.yaml and `seq`; returns how many there are."""
    rows = 100_000  # of a log at once
    kind = record_type(len(columns))
    total = path.stat().st_size // kind.itemsize if path.exists() else 0
    schema = pa.schema([("seq", pa.int64()), *((name, pa.float64()) for name in columns)])
    with disk("write the stream's log"), pq.ParquetWriter(out, schema, compression="zstd") as writer:
        for first in range(0, total, rows):
            found = np.fromfile(path, kind, min(rows, total - first), offset=first * kind.itemsize)
            arrays = [pa.array(found["seq"]), *(pa.array(found["row"][:, k]) for k in range(len(columns)))]
            writer.write_table(pa.table(arrays, schema=schema))
    return total
