"""The supporting torque that a sample's suit really gave, as MuJoCo says in `truth/`, and how far estimates are off."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

Array = NDArray[np.float64]

PEAK_S = 0.2  # a peak is a mean over
APPROACHES = {"A": "a", "B": "b", "paired": "paired"}  # as in results.json, as in the series files


def true_torque(study: Path, series: Path, motions: dict[str, str]) -> dict[str, Any]:
    """motions: log -> its motion.

    `true`: motion -> joint -> peak and mean [N·m], each the mean over the logs, the peak of the side that is larger (a
    twist goes both ways). `rmse`: motion -> joint -> approach -> [N·m] against the truth, all samples, and `A steady` …
    of both runs' steady motion.
    """
    peaks, means = dict[tuple[str, str], list[tuple[float, float]]](), dict[tuple[str, str], list[float]]()
    errors: dict[tuple[str, str, str], list[Array]] = {}
    for log, motion in motions.items():
        truth, told = pq.read_table(study / "truth" / f"{log}.parquet"), pq.read_table(series / f"{log}.parquet")
        time = truth["t"].to_numpy()
        for joint in truth.column_names[1:]:
            line = truth[joint].to_numpy().astype(np.float64)
            peaks.setdefault((motion, joint), []).append(peaks_both_ways(line, time))
            means.setdefault((motion, joint), []).append(float(line.mean()))
            for approach, letter in APPROACHES.items():
                name = f"support_{letter}.{joint}"
                if name not in told.column_names:
                    continue
                off = told[name].to_numpy().astype(np.float64) - line
                steady = told[f"support_steady.{joint}"].to_numpy() & told[f"support_compared.{joint}"].to_numpy()
                errors.setdefault((motion, joint, approach), []).append(off)
                errors.setdefault((motion, joint, f"{approach} steady"), []).append(off[steady])
    found: dict[str, Any] = {"true": {}, "rmse": {}}
    for (motion, joint), values in peaks.items():
        both = np.mean(values, axis=0)
        numbers = {"peak": float(both[np.argmax(np.abs(both))]), "mean": float(np.mean(means[motion, joint]))}
        found["true"].setdefault(motion, {})[joint] = numbers
    for (motion, joint, approach), parts in errors.items():
        square = np.concatenate(parts) ** 2
        rmse = float(np.sqrt(np.mean(square[np.isfinite(square)]))) if np.isfinite(square).any() else None
        found["rmse"].setdefault(motion, {}).setdefault(joint, {})[approach] = rmse
    return found


def peaks_both_ways(line: Array, time: Array) -> tuple[float, float]:
    """[N·m] the lowest and the highest mean over `PEAK_S`."""
    width = max(1, round(PEAK_S * (len(time) - 1) / float(time[-1] - time[0])))
    smooth = uniform_filter1d(line, width, mode="nearest")
    return float(smooth.min()), float(smooth.max())
