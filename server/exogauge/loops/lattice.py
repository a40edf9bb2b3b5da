"""The steps in which a channel changes, see `logs.noise.quantisation_step`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.loops.compiled import compiled

Array = NDArray[np.float64]


@compiled("f8[::1], i8")
def spacing_of(values: Array, few_levels: int) -> float:
    """Of the lattice on which values (T,) lie, in ascending order; NaN where there is none to be seen.

    few_levels: fewer of them have to be met again and again.
    """
    count, levels, spacings = len(values), 1, 0
    largest = max(abs(values[0]), abs(values[count - 1]))
    single = True
    for n in range(count):
        if np.float64(np.float32(values[n])) != values[n]:
            single = False
            break
    least = (1e-6 if single else 1e-11) * largest
    spacing, smallest = np.empty(count), np.inf
    for n in range(1, count):
        apart = values[n] - values[n - 1]
        if apart != 0.0:
            levels += 1
        if apart > least:
            spacing[spacings] = apart
            smallest = min(smallest, apart)
            spacings += 1
    if spacings == 0 or (spacings < few_levels and count < 4 * levels):
        return np.nan
    near, small = np.empty(spacings), 0
    for n in range(spacings):
        if spacing[n] < 1.5 * smallest:
            near[small] = spacing[n]
            small += 1
    step = np.median(near[:small])
    on_lattice, looked_at = 0, 0
    for n in range(spacings):
        multiple = spacing[n] / step
        if multiple < 100.0:  # further ones sum up the rounding of the representation
            looked_at += 1
            if abs(multiple - np.round(multiple)) < 0.02 * max(1.0, multiple / 10.0):
                on_lattice += 1
    return step if on_lattice > 0.95 * looked_at else np.nan
