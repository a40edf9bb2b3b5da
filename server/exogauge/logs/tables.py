"""A file as named raw columns, whatever its format."""

from __future__ import annotations

import gzip
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, Protocol, final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.logs import LOGS
from exogauge.errors import BadLog, Fault
from exogauge.logs.channels import shorten
from exogauge.logs.model import Note

RawArray = NDArray[Any]
Encoding = Literal["utf-8", "cp1252", "cp932", "gb18030", "big5", "cp949"]
UNNAMED = "Name it in the header, or leave it out: no sign at the end of lines, no index (pandas: `index=False`)."


@final
@dataclass(frozen=True)
class TextLayout:
    """How a text table is written. None: told from the first lines, refused where they allow two readings.

    header: the first line after `skip_lines` names the columns; otherwise they are called "1", "2", … from the left.
    encoding: UTF-8, or UTF-16 where the file says so, if none is given; numbers are the same in all of them.
    """

    header: bool = True
    delimiter: str | None = None
    decimal: Literal[".", ","] | None = None
    skip_lines: int = 0
    encoding: Encoding = "utf-8"

    @property
    def from_the_head(self) -> bool:
        """Nothing is said of where the table begins and how it is written."""
        return replace(self, encoding=TextLayout.encoding) == TextLayout()


class Table(Protocol):
    """Columns by name; nothing but names and declared sizes is read before `read`.

    part: the rows (start, stop) that it holds, where it holds no others; None for all. notes: what was left out.
    """

    file: str
    part: tuple[int, int] | None
    notes: tuple[Note, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """In file order, as written; duplicates kept."""
        ...

    def read(self, names: Sequence[str], exact: Sequence[str] = ()) -> dict[str, RawArray]:
        """(T,) float64 per text or Parquet column, (T, n) of Parquet's lists, any one- or two-dimensional numbers from
        MAT, HDF5 and NPZ.

        exact: columns kept as 64-bit integers where they hold integers (time stamps since an epoch).
        Missing values are NaN.
        """
        ...


def read_names(table: Table) -> tuple[str, ...]:
    """The column names, after checking that there are some and that each is there once."""
    names = table.names
    faults = [
        Fault("the column has no name", "unnamed_column", UNNAMED, table.file, 0, str(index + 1))
        for index, name in enumerate(names)
        if not name
    ]
    faults += [
        Fault(
            f"the column is there {names.count(name)} times",
            "duplicate_column",
            "Keep one or rename it.",
            table.file,
            0,
            shorten(name),
        )
        for name in dict.fromkeys(names)
        if name and names.count(name) > 1
    ]
    if not names:
        faults = [Fault("the file holds no columns of numbers", "no_columns", "", table.file)]
    if faults:
        raise BadLog(faults[: LOGS.most_faults])
    return names


def as_vector(values: RawArray, file: str, column: str) -> RawArray:
    """(T,) from (T,), (1, T) or (T, 1)."""
    flat = np.atleast_1d(np.squeeze(values))
    if flat.ndim == 1:
        return flat
    raise BadLog(
        Fault(
            f"one value per sample is expected, the array has shape {values.shape}",
            "not_a_vector",
            "Name its components in the mapping under `arrays`, `vectors` or `wrenches`.",
            file=file,
            column=shorten(column),
        )
    )


def unpacked_head(path: Path, file: str, size: int) -> tuple[bytes, bool]:
    """The first bytes of a text file, unpacked where it is gzip-compressed; and whether it is."""
    with path.open("rb") as raw:
        if raw.read(2) != b"\x1f\x8b":
            raw.seek(0)
            return raw.read(size), False
    try:
        with gzip.open(path, "rb") as packed:
            return packed.read(size), True
    except (OSError, EOFError, zlib.error) as problem:
        raise BadLog(broken(problem, file)) from None


def broken(problem: Exception, file: str, column: str | None = None) -> Fault:
    """A file that its own format's library cannot read. MemoryError where that is why: it need not be damaged."""
    if isinstance(problem, MemoryError):  # Arrow's is one of its other errors, too
        raise problem
    return Fault(
        f"the file cannot be read: {shorten(str(problem) or type(problem).__name__, 160)}",
        "unreadable_file",
        "It may be cut off or damaged; export it again.",
        file=file,
        column=None if column is None else shorten(column),
    )
