"""MATLAB v5 to v7.2 files through scipy: declared sizes first, then only the variables asked for.

Fields of a struct are columns called `struct.field`, nested ones too; the elements of a struct array are
`struct(2).field`, counted as MATLAB does. What they are called is only known once they are loaded, so structs are
loaded at once.
"""

from __future__ import annotations

import warnings
import zlib
from collections.abc import Iterator, Sequence
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
_KINDS = {
    "f8": "double", "f4": "single", "b1": "logical", **{f"{sign}{size}": f"{word}{8 * size}"
    for sign, word in (("i", "int"), ("u", "uint")) for size in (1, 2, 4, 8)},
}  # fmt: skip
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
        self._declared: dict[str, tuple[tuple[int, ...], str]] = {}
        self._fields: dict[str, RawArray] = {}
        check_cells(1, len(declared), file)
        structs = self._load([str(name) for name, _, kind in declared if str(kind) == "struct"])
        for name, shape, kind in declared:
            own = {str(name): structs[str(name)]} if str(name) in structs else {}
            fields = dict(_flat(str(name), own[str(name)], 0)) if own else {}
            self._fields |= fields
            for field, values in fields.items():
                self._declared[field] = (values.shape, _KINDS.get(values.dtype.str[1:], str(values.dtype)))
            if not fields:
                self._declared[str(name)] = (tuple(int(n) for n in shape), str(kind))
        self._names = tuple(self._declared)
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
        loaded = self._fields | self._load([name for name in names if name not in self._fields])
        columns = {}
        for name in names:
            values = np.asarray(loaded[name])
            if values.dtype.kind not in "fiub":
                raise BadLog(broken(ValueError(f"{name} holds {values.dtype}"), self.file))
            columns[name] = values if name in exact and values.dtype.kind in "iu" else values.astype(np.float64)
        return columns

    def _load(self, names: Sequence[str]) -> dict[str, RawArray]:
        if not names:
            return {}
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                loaded = scipy.io.loadmat(self._path, appendmat=False, variable_names=list(names))
                return {name: np.asarray(loaded[name]) for name in names}
        except MemoryError:
            raise TooLarge(_memory(self.file)) from None
        except _FAILURES as problem:
            raise BadLog(broken(problem, self.file)) from None


def _flat(name: str, value: RawArray, depth: int) -> Iterator[tuple[str, RawArray]]:
    """The fields of a struct, and of those in it, that are no structs."""
    most_elements = 100  # of a struct array; a log kept as one struct per sample is no table
    max_depth = 16
    if value.dtype.names is None or depth > max_depth or value.size > most_elements:
        yield name, value
        return
    for number, element in enumerate(value.ravel()):
        own = name if value.size == 1 else f"{name}({number + 1})"
        for field in value.dtype.names:
            yield from _flat(f"{own}.{field}", np.asarray(element[field]), depth + 1)


def _memory(file: str) -> Fault:
    return Fault("the values do not fit into memory", "memory_limit", "Split the recording.", file)
