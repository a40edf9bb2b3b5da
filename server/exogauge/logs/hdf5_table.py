"""HDF5 and MATLAB v7.3. The tree is walked first: whatever could fetch another file's content is refused.

External links, external storage and virtual datasets make the library open other files by name; soft links are
refused with them, and so are filters other than the built-in lossless ones.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, final

import h5py
import numpy as np

from exogauge.criteria.logs import LOGS
from exogauge.errors import BadInput, BadLog, Fault, TooLarge
from exogauge.logs.channels import shorten
from exogauge.logs.limits import check_cells
from exogauge.logs.model import Note
from exogauge.logs.tables import RawArray, broken

BUILT_IN_FILTERS = {
    h5py.h5z.FILTER_DEFLATE,
    h5py.h5z.FILTER_SHUFFLE,
    h5py.h5z.FILTER_FLETCHER32,
    h5py.h5z.FILTER_LZF,
}
_MATLAB_OWN = ("#refs#", "#subsystem#")
_FAILURES = (OSError, RuntimeError, ValueError, KeyError, TypeError, OverflowError, AttributeError, UnicodeError)


@final
class Hdf5Table:
    """`names` are the paths of all datasets (`group/name`, of MATLAB structs `struct.field`); what holds no numbers is
    told when read."""

    part: tuple[int, int] | None = None
    notes: tuple[Note, ...] = ()

    def __init__(self, path: Path, file: str) -> None:
        self.file = file
        self._path = path
        self._separator = "/"
        self._shapes: dict[str, tuple[int, ...]] = {}
        self._numeric: dict[str, bool] = {}
        self._paths: dict[str, str] = {}
        try:
            with path.open("rb") as stream:
                if stream.read(10) == b"MATLAB 7.3":
                    self._separator = "."
            with h5py.File(path, "r", locking=False) as source:
                for name, dataset in self._walk(source, "", 0, set()):
                    self._numeric[name] = dataset.dtype.kind in "fiu" and dataset.dtype.itemsize <= 8
                    self._shapes[name] = tuple(dataset.shape or ())
                    self._paths[name] = dataset.name
                    if len(self._shapes) > LOGS.most_columns:
                        check_cells(1, len(self._shapes), file)
        except BadInput:
            raise
        except _FAILURES as problem:
            raise BadLog(broken(problem, file)) from None

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self._shapes)

    def read(self, names: Sequence[str], exact: Sequence[str] = ()) -> dict[str, RawArray]:
        cells = 0
        for name in names:
            shape = self._shapes[name]
            if not self._numeric[name] or len(shape) not in (1, 2):
                raise BadLog(
                    Fault(
                        f"the dataset holds no table of numbers (shape {shape})",
                        "not_a_number",
                        "Map datasets of one or two dimensions.",
                        self.file,
                        column=shorten(name),
                    )
                )
            cells += int(np.prod([int(size) for size in shape], dtype=object))
            check_cells(cells, 1, self.file, shorten(name))
        columns = {}
        try:
            with h5py.File(self._path, "r", locking=False) as source:
                for name in names:
                    values = np.asarray(source[self._paths[name]][()])
                    columns[name] = values if name in exact and values.dtype.kind in "iu" else values.astype(np.float64)
        except _FAILURES as problem:
            raise BadLog(broken(problem, self.file, name)) from None
        except MemoryError:
            raise TooLarge(
                Fault("the values do not fit into memory", "memory_limit", "Split the recording.", self.file)
            ) from None
        return columns

    def _walk(self, group: Any, prefix: str, depth: int, seen: set[Any]) -> Iterator[tuple[str, Any]]:
        max_depth = 16
        if depth > max_depth:
            raise TooLarge(Fault(f"groups are nested deeper than {max_depth}", "too_deep", "", self.file))
        for key in group:
            name = f"{prefix}{key}"
            link = group.get(key, getlink=True)
            if not isinstance(link, h5py.HardLink):
                kind = "another file" if isinstance(link, h5py.ExternalLink) else "another place"
                raise self._refusal(f"the entry is a link to {kind}", "hdf5_link", name)
            if not prefix and key in _MATLAB_OWN:
                continue
            item = group[key]
            if isinstance(item, h5py.Group):
                address = h5py.h5o.get_info(item.id).addr
                if address not in seen:
                    seen.add(address)
                    yield from self._walk(item, f"{name}{self._separator}", depth + 1, seen)
            elif isinstance(item, h5py.Dataset):
                self._check_storage(item, name)
                yield name, item

    def _check_storage(self, dataset: Any, name: str) -> None:
        if dataset.external:
            raise self._refusal("the dataset's values lie in another file", "hdf5_external", name)
        if dataset.is_virtual:
            raise self._refusal("the dataset is virtual: a view of other files", "hdf5_virtual", name)
        settings = dataset.id.get_create_plist()
        for k in range(settings.get_nfilters()):
            if settings.get_filter(k)[0] not in BUILT_IN_FILTERS:
                raise self._refusal("the dataset uses a filter that is not read here", "hdf5_filter", name)

    def _refusal(self, detail: str, rule: str, name: str) -> BadLog:
        advice = "Save the values themselves into this file, uncompressed or with gzip."
        return BadLog(Fault(detail, rule, advice, self.file, column=shorten(name)))
