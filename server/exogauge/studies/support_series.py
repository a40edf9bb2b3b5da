"""The columns of a log with a device: supporting torques with their uncertainty, phases of the motion, bands."""

from __future__ import annotations

from exogauge.studies.series_columns import Columns
from exogauge.support.result import Array, Trial

TORQUE, LENGTH, FORCE = "N·m", "m", "N"


def add_support(columns: Columns, trial: Trial) -> None:
    """`support_a.<joint>` … with `_std`, and `_low`, `_high`: at rest the ends of the interval, else the value itself.

    support_compared, support_steady, support_rest: where A compares like with like, where the joint moves steadily,
    where it stands still.
    """
    for k, joint in enumerate(trial.joints):
        a, b = f"support_a.{joint}", f"support_b.{joint}"
        if trial.support_a is not None and trial.support_a_std is not None:
            assert trial.low_a is not None
            assert trial.high_a is not None
            columns.add(a, trial.support_a[:, k], TORQUE)
            _add_doubt(columns, a, trial.support_a_std[:, k], trial.low_a[:, k], trial.high_a[:, k])
        columns.add(b, trial.support_b[:, k], TORQUE)
        _add_doubt(columns, b, trial.support_b_std[:, k], trial.low_b[:, k], trial.high_b[:, k])
        columns.add(f"support_prior.{joint}", trial.support_prior[:, k], TORQUE)
        if trial.band_model is not None:
            columns.add(f"support_band_model.{joint}", trial.band_model[:, k], TORQUE)
        if trial.support_a is not None:
            columns.add_truth(f"support_compared.{joint}", trial.compared[:, k])
        columns.add_truth(f"support_steady.{joint}", trial.steady[:, k])
        columns.add_truth(f"support_rest.{joint}", trial.rest[:, k])


def _add_doubt(columns: Columns, name: str, std: Array, low: Array, high: Array) -> None:
    approach, joint = name.split(".", 1)
    columns.add(f"{approach}_std.{joint}", std, TORQUE)
    columns.add(f"{approach}_low.{joint}", low, TORQUE)
    columns.add(f"{approach}_high.{joint}", high, TORQUE)


def add_phases(columns: Columns, trial: Trial) -> None:
    columns.add_words("phase", trial.phase, trial.phase_names)


def add_bands(columns: Columns, trial: Trial) -> None:
    for band, length in trial.length.items():
        columns.add(f"band.{band}.length", length, LENGTH)
        if band in trial.tension:
            columns.add(f"band.{band}.tension", trial.tension[band], FORCE)
