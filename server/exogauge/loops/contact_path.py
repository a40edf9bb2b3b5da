"""What wrenches at a contact sensor do to the joints between it and the base, and to the base."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from exogauge.loops.compiled import fused

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


@fused(
    "f8[:,::1], f8[:,:,:,::1], f8[:,::1], f8[:,::1], f8[:,::1], b1[::1], i8[::1], f8[:,::1], f8[:,:,::1], b1, "
    "f8[:,:,::1]"
)
def carry_inward(
    to_body: Array, turns: Array, axis: Array, before: Array, offset: Array, slides: Bools, dof: Ints,
    q: Array, wrenches: Array, floating: bool, out: Array,
) -> None:  # fmt: skip
    """n bodies from that of the sensor inward. Adds to out (T, W, rows), base first where it floats, then joints.

    to_body: (6, 6) from the sensor's frame to the first body's. turns: (n, 3, 3, 3) of the body in its parent:
    constant, times cos q, times sin q. axis, before: (n, 3) in the parent; offset: (n, 3) from joint to body, in this.
    q: (T, J). wrenches: (T, W, 6) force and moment in the sensor's frame.
    """
    n, first = len(dof), 6 if floating else 0
    R, w, r = np.empty((3, 3)), np.empty(6), np.empty(3)
    cosines, sines = np.empty(n), np.empty(n)
    for t in range(len(q)):
        for k in range(n):
            cosines[k], sines[k] = math.cos(q[t, dof[k]]), math.sin(q[t, dof[k]])
        for each in range(wrenches.shape[1]):
            for i in range(6):
                w[i] = 0.0
                for j in range(6):
                    w[i] += to_body[i, j] * wrenches[t, each, j]
            for k in range(n):
                o, c, s = offset[k], cosines[k], sines[k]
                w[3] += o[1] * w[2] - o[2] * w[1]
                w[4] += o[2] * w[0] - o[0] * w[2]
                w[5] += o[0] * w[1] - o[1] * w[0]
                for i in range(3):
                    for j in range(3):
                        R[i, j] = turns[k, 0, i, j] + c * turns[k, 1, i, j] + s * turns[k, 2, i, j]
                f_0, f_1, f_2, m_0, m_1, m_2 = w[0], w[1], w[2], w[3], w[4], w[5]
                for i in range(3):
                    w[i] = R[i, 0] * f_0 + R[i, 1] * f_1 + R[i, 2] * f_2
                    w[3 + i] = R[i, 0] * m_0 + R[i, 1] * m_1 + R[i, 2] * m_2
                    r[i] = before[k, i]
                    if slides[k]:
                        r[i] += axis[k, i] * q[t, dof[k]]
                along = 0 if slides[k] else 3
                out[t, each, first + dof[k]] += (
                    axis[k, 0] * w[along] + axis[k, 1] * w[along + 1] + axis[k, 2] * w[along + 2]
                )
                w[3] += r[1] * w[2] - r[2] * w[1]
                w[4] += r[2] * w[0] - r[0] * w[2]
                w[5] += r[0] * w[1] - r[1] * w[0]
            if floating:
                for i in range(6):
                    out[t, each, i] += w[i]
