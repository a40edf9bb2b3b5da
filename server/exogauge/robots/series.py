"""Joint motion as Fourier series that begin and end at rest."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np
import scipy
from numpy.typing import NDArray

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Series:
    """Fourier series of period `duration` [s] in null-space form: any numbers keep q̇ = q̈ = 0 and q = q_0 at both ends.

    harmonics: N. Each joint has 2 N - 2 numbers: N - 1 that make a, N - 2 that make b, q_0 [rad].
    """

    duration: float
    harmonics: int

    @property
    def size(self) -> int:
        return 2 * self.harmonics - 2

    @cached_property
    def bases(self) -> tuple[Array, Array]:
        """(N, N-1) and (N, N-2): null spaces of Σ a_l, and of Σ b_l / l and Σ l b_l.

        Implements [Payload] (43).
        """
        order = np.arange(1.0, self.harmonics + 1)
        return scipy.linalg.null_space(np.ones((1, self.harmonics))), scipy.linalg.null_space(
            np.stack([1.0 / order, order])
        )

    def columns(self, time: Array) -> Array:
        """(3, T, 2N-2) of q, q̇, q̈ by the numbers of one joint.

        Implements [Payload] (41).
        """
        a, b = self.bases
        w = 2 * np.pi / self.duration * np.arange(1, self.harmonics + 1)
        sine, cosine = np.sin(np.outer(time, w)), np.cos(np.outer(time, w))
        one = np.ones((len(time), 1))
        q = np.hstack([sine / w @ a, -cosine / w @ b, one])
        return np.stack([
            q, np.hstack([cosine @ a, sine @ b, 0 * one]), np.hstack([-w * sine @ a, w * cosine @ b, 0 * one]),
        ])  # fmt: skip

    def motion(self, x: Array, time: Array) -> tuple[Array, Array, Array]:
        """q, q̇, q̈ (T, n) of the numbers x (n, 2N-2)."""
        q, dq, ddq = np.einsum("ktp,np->ktn", self.columns(time), x)
        return q, dq, ddq
