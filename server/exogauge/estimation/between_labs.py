"""Whether one quantity, measured by several labs, is one number: weighted mean, Cochran's Q, Birge ratio, I², and how
far labs are apart beyond what they state.

With x_k ± s_k of lab k and w_k = 1/s_k²:

    mean = Σ w x / Σ w        Q = Σ w (x - mean)²        Birge ratio = √(Q / (n - 1))        I² = 1 - (n - 1) / Q

Q follows chi² of n - 1 degrees of freedom where the labs differ by what they state alone (Cochran 1954; Birge 1932;
Higgins and Thompson 2002). The standard deviation between labs, tau, is that for which Q of the weights
1/(s_k² + tau²) is n - 1 (Paule and Mandel 1982); its interval holds the tau for which Q is no unusual value of chi²
(Viechtbauer 2007).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, chdtri

from exogauge.criteria.between_labs import USUAL, BetweenLabs

Array = NDArray[np.float64]
Agreeing = Literal["agree", "differ", "undecided"]


@final
@dataclass(frozen=True)
class Agreement:
    """All in the quantity's unit but Q, its probability by chance, I² (0…1) and the Birge ratio.

    mean, std: weighted; std is larger by the Birge ratio where that is above 1. tau, tau_interval: standard deviation
    between labs. verdict `agree`: they differ by no more than chance, given what they state; how much could be hidden
    tells the upper end of tau_interval. None: of fewer labs than it takes; tau_interval also where labs agree better
    than chance has it, which no spread explains.
    """

    labs: int
    verdict: Agreeing
    provisional: bool
    mean: float | None = None
    std: float | None = None
    q: float | None = None
    probability: float | None = None
    i_squared: float | None = None
    birge_ratio: float | None = None
    tau: float | None = None
    tau_interval: tuple[float, float] | None = None


def agreement(values: Sequence[float], stds: Sequence[float], criteria: BetweenLabs = USUAL) -> Agreement:
    """values, stds: one of each lab, with its standard deviation, > 0."""
    x, s = np.asarray(values, dtype=float), np.asarray(stds, dtype=float)
    n = len(x)
    if x.shape != s.shape or not (np.isfinite(x).all() and np.isfinite(s).all() and (s > 0.0).all()):
        raise ValueError("a finite value with a standard deviation above 0 of each lab")
    if n < criteria.fewest:
        return Agreement(n, "undecided", provisional=True)
    mean, std, q = weighted(x, s, 0.0)
    probability, birge = float(chdtrc(n - 1, q)), float(np.sqrt(q / (n - 1)))
    tail = (1.0 - criteria.interval) / 2.0
    unlikely, likely = float(chdtri(n - 1, 1.0 - tail)), float(chdtri(n - 1, tail))
    return Agreement(
        labs=n,
        verdict="differ" if probability < criteria.by_chance else "agree",
        provisional=n < criteria.settled,
        mean=mean,
        std=std * max(1.0, birge),
        q=q,
        probability=probability,
        i_squared=max(0.0, 1.0 - (n - 1) / q) if q > 0.0 else 0.0,
        birge_ratio=birge,
        tau=between(x, s, n - 1.0),
        tau_interval=(between(x, s, likely), between(x, s, unlikely)) if q > unlikely else None,
    )


def weighted(x: Array, s: Array, tau: float) -> tuple[float, float, float]:
    """Mean, its standard deviation, Q."""
    w = 1.0 / (s**2 + tau**2)
    mean = float(w @ x / w.sum())
    return mean, float(1.0 / np.sqrt(w.sum())), float(w @ (x - mean) ** 2)


def between(x: Array, s: Array, wanted: float) -> float:
    """The tau >= 0 for which Q is `wanted`; 0 where Q is smaller without any. Q falls as tau grows."""
    from scipy.optimize import brentq  # a fifth of what every server loads, for what few ask

    if weighted(x, s, 0.0)[2] <= wanted:
        return 0.0
    high = float(s.max())
    while weighted(x, s, high)[2] > wanted:
        high *= 2.0
    return float(brentq(lambda tau: weighted(x, s, tau)[2] - wanted, 0.0, high))
