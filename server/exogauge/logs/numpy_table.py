"""NPZ and NPY: each member's own header is read and checked before its values; objects (pickles) are refused."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import IO, final

import numpy as np
from numpy.lib import format as npy_format

from exogauge.errors import BadInput, BadLog, Fault, TooLarge
from exogauge.logs.channels import shorten
from exogauge.logs.limits import check_bytes, check_cells
from exogauge.logs.model import Note
from exogauge.logs.tables import RawArray, broken

LONE_ARRAY = "array"
_FAILURES = (
    OSError, ValueError, TypeError, KeyError, IndexError, EOFError, OverflowError, SyntaxError, RuntimeError,
    NotImplementedError, RecursionError, UnicodeError, zipfile.BadZipFile, zlib.error,
)  # fmt: skip


@final
class NumpyTable:
    """`names`: the arrays of the archive; the one array of an NPY file is called `array`.

    What is no table of numbers, as joints' names or a lone value, is refused once it is asked for, and never unpacked.
    """

    part: tuple[int, int] | None = None
    notes: tuple[Note, ...] = ()

    def __init__(self, path: Path, file: str) -> None:
        self.file = file
        self._path = path
        self._shapes: dict[str, tuple[int, ...]] = {}
        self._members: dict[str, str] = {}
        self._unfit: dict[str, Fault] = {}
        try:
            if not zipfile.is_zipfile(path):
                with path.open("rb") as stream:
                    self._declare(LONE_ARRAY, stream)
                return
            with zipfile.ZipFile(path) as archive:
                check_cells(1, len(archive.infolist()), file)
                check_bytes(sum(member.file_size for member in archive.infolist()), file)
                for member in archive.infolist():
                    if not member.filename.endswith(".npy"):
                        raise ValueError(f"{shorten(member.filename)} is no array (a zip of other files?)")
                    name = member.filename.removesuffix(".npy")
                    self._members[name] = member.filename
                    with archive.open(member) as packed:
                        self._declare(name, packed)
        except BadInput:
            raise
        except _FAILURES as problem:
            raise BadLog(broken(problem, file)) from None

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self._shapes)

    def read(self, names: Sequence[str], exact: Sequence[str] = ()) -> dict[str, RawArray]:
        if unfit := [self._unfit[name] for name in names if name in self._unfit]:
            raise BadLog(unfit)
        check_cells(sum(int(np.prod(self._shapes[name], dtype=object)) for name in names), 1, self.file)
        columns: dict[str, RawArray] = {}
        try:
            for name in names:
                if not self._members:
                    values = np.load(self._path, allow_pickle=False)
                else:
                    with zipfile.ZipFile(self._path) as archive, archive.open(self._members[name]) as packed:
                        values = npy_format.read_array(packed, allow_pickle=False)
                columns[name] = values if name in exact and values.dtype.kind in "iu" else values.astype(np.float64)
        except MemoryError:
            raise TooLarge(
                Fault("the values do not fit into memory", "memory_limit", "Split the recording.", self.file)
            ) from None
        except _FAILURES as problem:
            raise BadLog(broken(problem, self.file)) from None
        return columns

    def _declare(self, name: str, stream: IO[bytes]) -> None:
        version = npy_format.read_magic(stream)
        read_header = npy_format.read_array_header_1_0 if version == (1, 0) else npy_format.read_array_header_2_0
        shape, _, kind = read_header(stream)
        if kind.kind not in "fiub" or kind.itemsize > 8 or len(shape) not in (1, 2) or min(shape) < 0:
            self._unfit[name] = Fault(
                f"the array holds {shorten(str(kind))} of shape {shape}, not a table of numbers",
                "not_a_number",
                "Save vectors and matrices of plain numbers (no objects).",
                self.file,
                column=shorten(name),
            )
            self._shapes[name] = ()
            return
        check_cells(int(np.prod(shape, dtype=object)), 1, self.file, shorten(name))
        self._shapes[name] = tuple(int(size) for size in shape)
