"""Sufficient statistics of linear rows: all a least-squares problem needs of any number of samples, in a few MB.

Every sample gives R rows of different kinds (six base axes, one per joint …); a row of kind r touches only the
parameters `columns[r]`. Kept per kind is either the Gram matrix of [A_r | y_r], or its triangular QR factor
(no squaring of the condition number: the accurate mode). Both add, re-weight and leave out in the same way.

The Gram matrix is summed by SciPy's own `dsyrk`, by its address, so that it leaves the interpreter to other threads.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Literal, final

import numpy as np
import scipy.linalg as sl
from numpy.typing import NDArray
from scipy.linalg import cython_blas

Array = NDArray[np.float64]
IntArray = NDArray[np.intp]
Form = Literal["gram", "factor"]


@final
@dataclass(frozen=True)
class SquareRoot:
    """‖R x - z‖² + rest = Σ w (A x - y)². R: (m, P) with m <= P. z: (m,)."""

    R: Array
    z: Array
    rest: float


@final
@dataclass
class Statistics:
    """Rows of R kinds over P parameters.

    columns: R arrays of parameter indices, (k_r,). store: R upper triangles (k_r + 1, k_r + 1), of the Gram matrix of
    [A_r | y_r] (`gram`) or its QR factor (`factor`). count: (R,) rows seen.
    """

    size: int
    columns: Sequence[IntArray]
    form: Form
    store: list[Array]
    count: IntArray

    @staticmethod
    def empty(size: int, columns: Sequence[IntArray], form: Form = "gram") -> Statistics:
        store = [np.zeros((len(c) + 1, len(c) + 1), order="F") for c in columns]
        return Statistics(size, columns, form, store, np.zeros(len(columns), dtype=np.intp))

    def add_rows(self, kind: int, block: Array) -> None:
        """Take in block: (n, k_r + 1) = [A_r | y_r]."""
        if self.form == "gram":
            add_gram(block, self.store[kind])
        else:
            stacked = np.vstack([self.store[kind], block])
            self.store[kind] = np.asfortranarray(upper_factor(stacked))
        self.count[kind] += len(block)

    def cleared(self) -> Statistics:
        """The same parameters and kinds, no rows."""
        return Statistics.empty(self.size, self.columns, self.form)

    def __add__(self, other: Statistics) -> Statistics:
        if self.form == "gram":
            store = [a + b for a, b in zip(self.store, other.store, strict=True)]
        else:
            pairs = zip(self.store, other.store, strict=True)
            store = [np.asfortranarray(upper_factor(np.vstack(pair))) for pair in pairs]
        return Statistics(self.size, self.columns, self.form, store, self.count + other.count)

    def normal(self, weights: Array) -> tuple[Array, Array, float]:
        """Σ w A^T A (P, P), Σ w A^T y (P,), Σ w y². weights: (R,) one per kind, 1/variance."""
        H = np.zeros((self.size + 1, self.size + 1))  # y stands for one more parameter
        alike: dict[bytes, list[int]] = {}  # kinds of the same columns are summed first, which is quicker
        for kind, columns in enumerate(self.columns):
            alike.setdefault(np.asarray(columns).tobytes(), []).append(kind)
        for kinds in alike.values():
            which = np.append(self.columns[kinds[0]], self.size)
            H[which[:, None], which] += sum(weights[kind] * self._upper(kind) for kind in kinds)
        diagonal = np.diag(H).copy()
        H = H + H.T
        np.fill_diagonal(H, diagonal)
        return H[:-1, :-1], H[:-1, -1], float(H[-1, -1])

    def square_root(self, weights: Array) -> SquareRoot:
        """The weighted problem with as few rows as it has directions.

        From the Gram by pivoted Cholesky, which stops at the numerical rank; from QR factors by one more QR.
        """
        if self.form == "factor":
            stacked = np.zeros((sum(len(c) + 1 for c in self.columns), self.size + 1))
            row = 0
            for kind, columns in enumerate(self.columns):
                block = np.sqrt(weights[kind]) * self.store[kind]
                stacked[row : row + len(block), np.append(columns, self.size)] = block
                row += len(block)
            factor = upper_factor(stacked)
            return SquareRoot(factor[: self.size, :-1], factor[: self.size, -1], float(factor[self.size, -1] ** 2))
        G, g, yy = self.normal(weights)
        scale = np.sqrt(np.maximum(np.diag(G), 0.0))
        scale[scale == 0.0] = 1.0
        U, pivots, rank, _ = sl.lapack.dpstrf(G / np.outer(scale, scale), tol=1e-13)
        order, upper = pivots - 1, np.triu(U[:rank])
        z = sl.solve_triangular(upper[:, :rank], (g / scale)[order[:rank]], trans="T")
        R = np.empty((rank, self.size))
        R[:, order] = upper
        return SquareRoot(R * scale, z, max(float(yy - z @ z), 0.0))

    def around(self, kind: int, x: Array) -> tuple[float, Array, Array]:
        """Of one kind's rows: Σ e² with e = y - A x, Σ A^T e (k_r,), Σ A^T A (k_r, k_r). x: (P,)."""
        upper = self._upper(kind)
        G = upper + np.triu(upper, 1).T
        v = np.append(-x[self.columns[kind]], 1.0)
        slope = G @ v
        return float(v @ slope), slope[:-1], G[:-1, :-1]

    def gram(self, kind: int) -> Array:
        """(k_r, k_r) Σ A^T A of one kind's rows."""
        upper = self._upper(kind)[:-1, :-1]
        return np.asarray(upper + np.triu(upper, 1).T)

    def residual_square_sum(self, x: Array) -> Array:
        """(R,) Σ (A_r x - y_r)² per kind. x: (P,)."""
        return np.array([self.left(kind, x) for kind in range(len(self.columns))])

    def left(self, kind: int, x: Array) -> float:
        """Of one kind."""
        v = np.append(x[self.columns[kind]], -1.0)
        product = self.store[kind] @ v
        squares = 2.0 * (v @ product) - np.diag(self.store[kind]) @ v**2 if self.form == "gram" else product @ product
        return max(float(squares), 0.0)

    def along(self, kind: int, place: int, x: Array) -> tuple[float, float]:
        """(a^T (y - A x), a^T a) of one column a of one kind's rows. place: within the row. x: (P,)."""
        upper = self._upper(kind)
        symmetric = upper[place] + upper[:, place]
        symmetric[place] -= upper[place, place]
        return float(-symmetric @ np.append(x[self.columns[kind]], -1.0)), float(upper[place, place])

    def _upper(self, kind: int) -> Array:
        """Upper triangle of the Gram matrix, zeros below."""
        stored = self.store[kind]
        return stored if self.form == "gram" else np.asarray(np.triu(stored.T @ stored))


def upper_factor(matrix: Array) -> Array:
    """R of the QR factorisation, (min(n, k), k)."""
    R: Array = np.asarray(np.linalg.qr(matrix, mode="r"))
    return R


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
