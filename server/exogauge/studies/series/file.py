"""A series file opened for reading: what it holds, and its columns as numbers, by row groups."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Literal, final

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from exogauge.errors import BadInput, Fault

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
