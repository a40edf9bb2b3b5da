"""MATLAB v5 to v7.2 files through scipy: declared sizes first, then only the variables asked for."""

from __future__ import annotations

import warnings
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import final

import numpy as np
import scipy.io
from scipy.io.matlab import MatReadError

from exogauge.errors import BadLog, Fault, TooLarge
from exogauge.logs.channels import shorten
from exogauge.logs.limits import check_cells
from exogauge.logs.model import Note
from exogauge.logs.tables import RawArray, broken

NUMERIC = ("double", "single", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64", "logical")
_FAILURES = (
    OSError, ValueError, TypeError, KeyError, IndexError, EOFError, OverflowError, AttributeError, RuntimeError,
    NotImplementedError, UnicodeError, zlib.error, MatReadError, Warning,
)  # fmt: skip


@final
class MatlabTable:
    part: tuple[int, int] | None = None
    notes: tuple[Note, ...] = ()

    def __init__(self, path: Path, file: str) -> None:
        self.file = file
        self._path = path
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                declared = scipy.io.whosmat(path, appendmat=False)
        except MemoryError:
            raise TooLarge(_memory(file)) from None
        except _FAILURES as problem:
            raise BadLog(broken(problem, file)) from None
        self._names = tuple(str(name) for name, _, _ in declared)
        self._declared = {str(name): (tuple(int(n) for n in shape), str(kind)) for name, shape, kind in declared}
        check_cells(1, len(self._names), file)

    @property
    def names(self) -> tuple[str, ...]:
        return self._names

    def read(self, names: Sequence[str], exact: Sequence[str] = ()) -> dict[str, RawArray]:
        cells = 0
        for name in names:
            shape, kind = self._declared[name]
            if kind not in NUMERIC or len(shape) > 2 or min(shape, default=0) < 0:
                raise BadLog(
                    Fault(
                        f"the variable is a {kind} of shape {shape}, not a table of numbers",
                        "not_a_number",
                        "Map numeric vectors and matrices.",
                        self.file,
                        column=shorten(name),
                    )
                )
            cells += int(np.prod(shape, dtype=object))
            check_cells(cells, 1, self.file, shorten(name))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                loaded = scipy.io.loadmat(self._path, appendmat=False, variable_names=list(names))
            columns = {}
            for name in names:
                values = np.asarray(loaded[name])
                if values.dtype.kind not in "fiub":
                    raise ValueError(f"{name} holds {values.dtype}")
                columns[name] = values if name in exact and values.dtype.kind in "iu" else values.astype(np.float64)
        except MemoryError:
            raise TooLarge(_memory(self.file)) from None
        except _FAILURES as problem:
            raise BadLog(broken(problem, self.file)) from None
        return columns


def _memory(file: str) -> Fault:
    return Fault("the values do not fit into memory", "memory_limit", "Split the recording.", file)
