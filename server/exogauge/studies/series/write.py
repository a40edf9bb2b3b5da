"""series/<log>.parquet: what was measured and what each model predicts, on the log's own sample times.

A log as it was read has the same form.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import final

import pyarrow as pa
import pyarrow.parquet as pq

from exogauge.identification.result import Prediction
from exogauge.logs.model import Log
from exogauge.robots.description import Robot
from exogauge.studies.series.columns import Columns
from exogauge.studies.series.motion_columns import add_motion
from exogauge.studies.series.support_series import add_bands, add_phases, add_support
from exogauge.support.result import Trial

ROW_GROUP = 12_000


@final
@dataclass(frozen=True)
class Moved:
    """The log of a series, whose robot moved, and the low-pass of the fit [Hz]."""

    robot: Robot
    log: Log
    cutoff_hz: float


def series_table(prediction: Prediction, trial: Trial | None = None, moved: Moved | None = None) -> pa.Table:
    """`t`, then `measured.`, `predicted.`, `predicted_prior.` per channel; the unit is in each field's metadata.

    trial: for a log with a device, its supporting torques, phases and bands as well. moved: for how its joints moved.
    """
    columns = Columns(prediction.time)
    parts = (
        ("measured", prediction.measured),
        ("predicted", prediction.predicted),
        ("predicted_prior", prediction.predicted_prior),
    )
    for channel in prediction.measured:
        for part, values in parts:
            if channel in values:
                columns.add(f"{part}.{channel}", values[channel], prediction.units.get(channel, ""))
    if moved is not None:
        add_motion(columns, moved.robot, moved.log, moved.cutoff_hz)
    metadata = {"log": prediction.log, "held_out": "true" if prediction.held_out else "false", "version": "1"}
    if trial is not None:
        add_support(columns, trial)
        add_phases(columns, trial)
        add_bands(columns, trial)
        metadata |= {"device": trial.device, "motion": trial.motion, "reference": trial.reference or ""}
    return columns.table(metadata)


def raw_table(log: Log, units: Mapping[str, str]) -> pa.Table:
    """`t` and every channel of a log as it was read, with its unit."""
    columns = Columns(log.time)
    for channel, values in log.channels.items():
        columns.add(channel, values, units[channel])
    return columns.table({"log": log.name, "version": "1"})


def write_series(prediction: Prediction, path: Path, trial: Trial | None = None, moved: Moved | None = None) -> None:
    write_table(series_table(prediction, trial, moved), path)


def write_table(table: pa.Table, path: Path) -> None:
    words = [field.name for field in table.schema if pa.types.is_dictionary(field.type)]
    pq.write_table(table, path, compression="zstd", use_dictionary=words, row_group_size=ROW_GROUP)
