"""Which estimate a headline number comes from: the one that finds least where the truth is zero, beyond what is known
to be in doubt of it, with that doubt."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np

from exogauge.criteria.supporting import Supporting
from exogauge.support.repeatability import Null
from exogauge.support.result import Best

Regime = Literal["whole", "steady", "other"]
LEAST = 1e-9  # [N·m] of a null test that finds nothing at all, and nothing in doubt


def best(
    nulls: Mapping[str, Null], std: Mapping[str, float], joint: int, regime: Regime, criteria: Supporting
) -> Best | None:
    """std: approach -> doubt of its number; only approaches in it can be chosen. Without a null test of what compares
    runs (one log without the device) the paired estimate is taken, or B where there is none; None without any number.

    An RMS over n independent errors is known to 1/√(2 n); n is the time of the regime over the memory of an error.
    """
    if not std:
        return None
    judged = {name: nulls[name] for name in std if name in nulls}
    if len(judged) < len(std):
        first = next(name for name in ("paired", "a", "b") if name in std)
        return Best(first, (first,))
    size = {name: max(float(np.hypot(each.beyond[regime][joint], std[name])), LEAST) for name, each in judged.items()}
    share = {
        name: criteria.memory_s / (2.0 * max(float(each.lasting[regime][joint]), criteria.memory_s))
        for name, each in judged.items()
    }
    least = min(size, key=lambda name: size[name])
    as_good = tuple(
        name
        for name in size
        if name == least or np.log(size[name] / size[least]) < criteria.equal * np.sqrt(share[name] + share[least])
    )
    return Best(min(as_good, key=lambda name: std[name]), as_good)
