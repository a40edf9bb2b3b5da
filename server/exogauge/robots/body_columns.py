"""What each parameter of a body adds to the wrench that moves it, in NumPy: for the few bodies beyond a sensor."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.robots.kinematics import Sweep
from exogauge.robots.tree import IntArray

Array = NDArray[np.float64]


def mass_columns(chosen: IntArray, sweep: Sweep) -> Array:
    """(6, K_1, T) force and moment about the base origin, base frame, per mass [kg] or first moment [kg·m].

    chosen: (K_1,) body · 4 + 0..3."""
    n, samples = sweep.p.shape[0], sweep.p.shape[2]
    b, p, R, B = sweep.b, sweep.p, sweep.R, sweep.B
    columns = np.empty((6, n, 4, samples))
    for x in range(3):
        columns[x, :, 0] = b[:, x]
        np.einsum("njt,njkt->nkt", B[:, x], R, out=columns[x, :, 1:])
    for x, y, z in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):  # p x f, and for first moments h x b
        moment = columns[3 + x]
        np.multiply(p[:, y, None], columns[z], out=moment)
        moment -= p[:, z, None] * columns[y]
        moment[:, 1:] += R[:, y] * b[:, z, None]
        moment[:, 1:] -= R[:, z] * b[:, y, None]
    return np.take(columns.reshape(6, 4 * n, samples), chosen, axis=1)


def inertia_columns(chosen: IntArray, sweep: Sweep) -> Array:
    """(3, K_2, T) moment, base frame, per entry of the inertia about the body's origin [kg·m²].

    chosen: (K_2,) body · 6 + 0..5.
    With r_k the axes of the body: entry (k, l) moves as r_k α_l + (ω x r_k) ω_l, plus the same with k and l exchanged.
    """
    n, samples = sweep.p.shape[0], sweep.p.shape[2]
    R, w = sweep.R, sweep.omega
    rates = np.empty((n, 2, 3, samples))  # in the body frame
    np.einsum("njkt,njt->nkt", R, sweep.alpha, out=rates[:, 0])
    np.einsum("njkt,njt->nkt", R, w, out=rates[:, 1])
    axes = np.empty((n, 2, 3, samples))
    columns = np.empty((3, n, 6, samples))
    outer = np.empty((n, 3, 3, samples))
    for x, y, z in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        axes[:, 0] = R[:, x]
        np.multiply(w[:, y, None], R[:, z], out=axes[:, 1])
        axes[:, 1] -= w[:, z, None] * R[:, y]
        np.einsum("nskt,nslt->nklt", axes, rates, out=outer)
        for place, k in ((0, 0), (2, 1), (5, 2)):
            columns[x, :, place] = outer[:, k, k]
        for place, k, l in ((1, 0, 1), (3, 0, 2), (4, 1, 2)):  # noqa: E741 (entry k, l)
            np.add(outer[:, k, l], outer[:, l, k], out=columns[x, :, place])
    return np.take(columns.reshape(3, 6 * n, samples), chosen, axis=1)
