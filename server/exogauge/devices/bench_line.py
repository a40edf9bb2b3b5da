"""A force-length test of the bare band as a straight line: stiffness, natural length and how well they are known."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from exogauge.devices.device import BenchTest

TAUT = 0.02  # of the largest force: below, the band counts as slack
LEAST_SHARE = 0.01  # of the value: no test bench is taken to be better than that


@final
@dataclass(frozen=True)
class BenchLine:
    """force = stiffness (length - natural_length) where taut [N/m, m]; std of both."""

    stiffness: float
    natural_length: float
    stiffness_std: float
    natural_length_std: float


def bench_line(test: BenchTest) -> BenchLine:
    """Least squares over the taut part.

    Implements the fit behind [Evaluator] Figure 5. Raises ValueError with fewer than two taut points.
    """
    length, force = np.array(test.length), np.array(test.force)
    taut = force > TAUT * force.max(initial=0.0)
    if taut.sum() < 2 or np.ptp(length[taut]) <= 0.0:
        raise ValueError("a bench test needs two or more lengths at which the band pulls")
    A = np.column_stack([length[taut], -np.ones(int(taut.sum()))])
    (k, c), *_ = np.linalg.lstsq(A, force[taut], rcond=None)
    spare = max(1, len(A) - 2)
    noise = float(np.sum((force[taut] - A @ [k, c]) ** 2)) / spare
    covariance = noise * np.linalg.inv(A.T @ A)
    slope = np.array([-c / k**2, 1.0 / k])  # of l0 = c / k
    return BenchLine(
        float(k),
        float(c / k),
        float(max(np.sqrt(covariance[0, 0]), LEAST_SHARE * k)),
        float(max(np.sqrt(slope @ covariance @ slope), LEAST_SHARE * np.ptp(length))),
    )
