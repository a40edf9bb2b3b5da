"""The plot that shows an effect of a band: torque that the wear's model lacks, over what the effect depends on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.detect.device.baseline import Ground
from exogauge.findings.result import Evidence
from exogauge.support.band_rows import Wire

Array = NDArray[np.float64]

BINS = 40  # at most
USUAL, FEWEST = 12, 6  # samples in a bin
UNITS = {"stretch": "m", "rate": "m/s", "clock": "s"}
NAMES = {"stretch": "band length", "rate": "rate of the band", "clock": "time"}


def band_evidence(ground: Ground, wire: Wire, coordinate: str, joint: int, before: Array, after: Array) -> Evidence:
    """before, after: (N, D) [N·m] residuals, NaN where they do not count; their difference is what the effect adds."""
    used = np.isfinite(before[:, joint]) & np.isfinite(after[:, joint])
    values = {"stretch": wire.length, "rate": wire.rate, "clock": ground.setting.logs.clock}[coordinate]
    at, was, now = values[used], before[used, joint], after[used, joint]
    bins = int(np.clip(len(at) // USUAL, 1, BINS))
    edges = np.unique(np.quantile(at, np.linspace(0.0, 1.0, bins + 1))) if len(at) else np.zeros(1)
    if coordinate == "rate" and len(at):  # what depends on the rate turns round at zero: no bin may hold both sides
        edges = np.unique([*edges, np.clip(0.0, edges[0], edges[-1])])
    place = np.clip(np.searchsorted(edges, at, side="right") - 1, 0, max(len(edges) - 2, 0))
    count = np.bincount(place, minlength=max(len(edges) - 1, 1))
    full = count >= min(FEWEST, max(len(at), 1))

    def mean(of: Array) -> Array:
        return np.asarray(np.bincount(place, of, minlength=len(count))[full] / count[full])

    spread = np.sqrt(np.maximum(mean(was**2) - mean(was) ** 2, 0.0) / count[full])
    unit = UNITS[coordinate] if wire.course.routing is not None else UNITS[coordinate].replace("m", "rad")
    return Evidence(NAMES[coordinate], unit, mean(at), mean(was), mean(now), spread, mean(was - now))
