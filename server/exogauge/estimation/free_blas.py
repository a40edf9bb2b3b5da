"""BLAS that leaves the interpreter to other threads while it computes: SciPy's own wrapper of `dsyrk` holds it.

The same routine of the same library, by the address that SciPy gives out for compiled code, so the same bits.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cython_blas

Array = NDArray[np.float64]


def add_gram(block: Array, gram: Array) -> None:
    """Upper triangle of gram += blockᵀ block, in place. block: (n, k) of any layout. gram: (k, k) by columns."""
    if not (gram.flags.f_contiguous and gram.flags.writeable and gram.shape == (block.shape[1],) * 2):
        raise ValueError(f"no (k, k) array by columns: {gram.shape} for rows of {block.shape[1]}")
    by_rows = block.flags.c_contiguous
    if not by_rows and not (block.strides[0] == block.itemsize and block.strides[1] >= block.strides[0] * len(block)):
        block = np.asfortranarray(block)
    apart = max(block.strides[0 if by_rows else 1] // block.itemsize, 1)
    samples, columns = (ctypes.c_int(n) for n in block.shape)
    one, by, to = ctypes.c_double(1.0), ctypes.c_int(apart), ctypes.c_int(max(len(gram), 1))
    trans = b"N" if by_rows else b"T"
    _dsyrk()(
        b"U", trans, ctypes.byref(columns), ctypes.byref(samples), ctypes.byref(one), block.ctypes.data,
        ctypes.byref(by), ctypes.byref(one), gram.ctypes.data, ctypes.byref(to),
    )  # fmt: skip


@cache
def _dsyrk() -> Callable[..., None]:
    capsule = cython_blas.__pyx_capi__["dsyrk"]
    name_of = ctypes.PYFUNCTYPE(ctypes.c_char_p, ctypes.py_object)(("PyCapsule_GetName", ctypes.pythonapi))
    address_of = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.py_object, ctypes.c_char_p)(
        ("PyCapsule_GetPointer", ctypes.pythonapi)
    )
    pointer = ctypes.c_void_p
    characters, numbers = (ctypes.c_char_p,) * 2, (pointer,) * 8
    return ctypes.CFUNCTYPE(None, *characters, *numbers)(address_of(capsule, name_of(capsule)))
