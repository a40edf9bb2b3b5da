"""Columns of a series file as they are gathered: names, units and values on one set of sample times."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, final

import numpy as np
import pyarrow as pa
from numpy.typing import ArrayLike


@final
class Columns:
    """`t` [s] and what is added to it; NaN and infinity become null."""

    def __init__(self, time: ArrayLike) -> None:
        self._fields: list[Any] = [pa.field("t", pa.float64(), False, {"unit": "s"})]
        self._arrays: list[Any] = [pa.array(np.asarray(time, dtype=np.float64))]

    def add(self, name: str, values: ArrayLike, unit: str, short: bool = False) -> None:
        """short: in seven digits, more than any sensor has; half as large."""
        column = np.asarray(values, dtype=np.float32 if short else np.float64)
        self._fields.append(pa.field(name, pa.float32() if short else pa.float64(), True, {"unit": unit}))
        self._arrays.append(pa.array(column, mask=~np.isfinite(column)))

    def add_truth(self, name: str, values: ArrayLike) -> None:
        self._fields.append(pa.field(name, pa.bool_(), False))
        self._arrays.append(pa.array(np.asarray(values, dtype=np.bool_)))

    def add_words(self, name: str, index: ArrayLike, words: tuple[str, ...]) -> None:
        """Sample by sample one of a few words."""
        column = pa.DictionaryArray.from_arrays(pa.array(np.asarray(index, dtype=np.int32)), pa.array(words))
        self._fields.append(pa.field(name, column.type, False))
        self._arrays.append(column)

    def table(self, metadata: Mapping[str, str]) -> pa.Table:
        return pa.table(self._arrays, schema=pa.schema(self._fields, dict(metadata)))
