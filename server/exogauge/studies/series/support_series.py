"""The columns of a log with a device: supporting torques with their uncertainty, phases of the motion, bands."""

from __future__ import annotations

import numpy as np

from exogauge.studies.series.columns import Columns
from exogauge.support.result import Array, Trial

TORQUE, LENGTH, FORCE = "N·m", "m", "N"


def add_support(columns: Columns, trial: Trial) -> None:
    """`support_a.<joint>` … with `_std`, and `_low`, `_high`, the ends of the interval where friction leaves only one.

    support_compared, support_steady, support_rest: where A compares like with like, where the joint moves steadily,
    where it stands still.
    """
    by_approach = {
        "a": (trial.support_a, trial.support_a_std, *interval(trial.low_a, trial.high_a)),
        "b": (trial.support_b, trial.support_b_std, *interval(trial.low_b, trial.high_b)),
        "prior": (trial.support_prior, None, None, None),
        "band_model": (trial.band_model, None, None, None),
    }
    for k, joint in enumerate(trial.joints):
        for approach, parts in by_approach.items():
            for part, values in zip(("", "_std", "_low", "_high"), parts, strict=True):
                if values is not None:
                    columns.add(f"support_{approach}{part}.{joint}", values[:, k], TORQUE)
        if trial.support_a is not None:
            columns.add_truth(f"support_compared.{joint}", trial.compared[:, k])
        columns.add_truth(f"support_steady.{joint}", trial.steady[:, k])
        columns.add_truth(f"support_rest.{joint}", trial.rest[:, k])


def interval(low: Array | None, high: Array | None) -> tuple[Array | None, Array | None]:
    """Its ends, NaN where both are one number."""
    if low is None or high is None:
        return None, None
    wide = high > low
    return np.where(wide, low, np.nan), np.where(wide, high, np.nan)


def add_phases(columns: Columns, trial: Trial) -> None:
    columns.add_words("phase", trial.phase, trial.phase_names)


def add_bands(columns: Columns, trial: Trial) -> None:
    for band, length in trial.length.items():
        columns.add(f"band.{band}.length", length, LENGTH)
        if band in trial.tension:
            columns.add(f"band.{band}.tension", trial.tension[band], FORCE)
