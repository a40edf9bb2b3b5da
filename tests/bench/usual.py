"""The usual way: pinocchio's regressor sample by sample, stacked, solved.

Both recipes are given the base-parameter columns beforehand, which usual code must find by another decomposition.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import scipy.linalg as sl
from numpy.typing import NDArray
from tests.bench.problems import Problem, parts

Array = NDArray[np.float64]

CHUNK = 200  # samples per Gram update of the best recipe; 100 to 500 were alike


def regressor_loop(problem: Problem) -> None:
    """The regressors alone, thrown away."""
    model, data = problem.model, problem.model.createData()
    for q, v, a in zip(*problem.pinocchio(), strict=True):
        pin.computeJointTorqueRegressor(model, data, q, v, a)


def stack_and_lstsq(problem: Problem) -> Array:
    """(B,) from one tall matrix and `numpy.linalg.lstsq`."""
    model, data = problem.model, problem.model.createData()
    columns, rows = problem.columns, problem.model.nv
    A = np.empty((problem.samples * rows, len(columns)))
    whole = np.empty((CHUNK * rows, 10 * (model.njoints - 1)))
    q, v, a = problem.pinocchio()
    for part in parts(problem.samples, CHUNK):
        stacked = _stack(model, data, q[part], v[part], a[part], whole)
        np.take(stacked, columns, axis=1, out=A[part.start * rows : part.stop * rows], mode="clip")
    return np.asarray(np.linalg.lstsq(A, problem.forces.ravel(), rcond=None)[0])


def normal_equations(problem: Problem) -> Array:
    """(B,) the best recipe around pinocchio's loop: stack a chunk, add its Gram matrix by `dsyrk`, solve at the end."""
    model, data = problem.model, problem.model.createData()
    columns, rows, size = problem.columns, problem.model.nv, len(problem.base.columns) + 1
    A = np.empty((CHUNK * rows, size))
    whole = np.empty((CHUNK * rows, 10 * (model.njoints - 1)))
    gram = np.zeros((size, size), order="F")
    q, v, a = problem.pinocchio()
    for part in parts(problem.samples, CHUNK):
        stacked = _stack(model, data, q[part], v[part], a[part], whole)
        A[: len(stacked), :-1] = stacked[:, columns]
        A[: len(stacked), -1] = problem.forces[part].ravel()
        gram = sl.blas.dsyrk(1.0, A[: len(stacked)].T, beta=1.0, c=gram, trans=0, overwrite_c=1)
    upper = np.triu(gram)
    G, g = upper[:-1, :-1] + np.triu(upper[:-1, :-1], 1).T, upper[:-1, -1]
    scale = np.sqrt(np.diag(G))
    return np.asarray(sl.cho_solve(sl.cho_factor(G / np.outer(scale, scale)), g / scale) / scale)


def _stack(model: pin.Model, data: pin.Data, q: Array, v: Array, a: Array, out: Array) -> Array:
    """(T · nv, 10 N) the loop; out: room for it. Base columns are taken for many samples at once, which is quicker."""
    rows = model.nv
    for k in range(len(q)):
        out[k * rows : (k + 1) * rows] = pin.computeJointTorqueRegressor(model, data, q[k], v[k], a[k])
    return out[: len(q) * rows]
