"""series/<log>.parquet: what was measured and what each model predicts, on the log's own sample times."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from exogauge.identification.result import Prediction
from exogauge.studies.series_columns import Columns
from exogauge.studies.support_series import add_bands, add_phases, add_support
from exogauge.support.result import Trial

ROW_GROUP = 12_000


def series_table(prediction: Prediction, trial: Trial | None = None) -> pa.Table:
    """`t`, then `measured.`, `predicted.`, `predicted_prior.` per channel; the unit is in each field's metadata.

    trial: for a log with a device, its supporting torques, phases and bands as well.
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
    metadata = {"log": prediction.log, "held_out": "true" if prediction.held_out else "false", "version": "1"}
    if trial is not None:
        add_support(columns, trial)
        add_phases(columns, trial)
        add_bands(columns, trial)
        metadata |= {"device": trial.device, "motion": trial.motion, "reference": trial.reference or ""}
    return columns.table(metadata)


def write_series(prediction: Prediction, path: Path, trial: Trial | None = None) -> None:
    table = series_table(prediction, trial)
    words = [field.name for field in table.schema if pa.types.is_dictionary(field.type)]
    pq.write_table(table, path, compression="zstd", use_dictionary=words, row_group_size=ROW_GROUP)
