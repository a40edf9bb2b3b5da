"""series/<log>.parquet: what was measured and what each model predicts, on the log's own sample times."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from exogauge.identification.result import Prediction

ROW_GROUP = 12_000


def series_table(prediction: Prediction) -> pa.Table:
    """`t`, then `measured.`, `predicted.`, `predicted_prior.` per channel; the unit is in each field's metadata."""
    fields, arrays = [pa.field("t", pa.float64(), False, {"unit": "s"})], [pa.array(prediction.time)]
    parts = (
        ("measured", prediction.measured),
        ("predicted", prediction.predicted),
        ("predicted_prior", prediction.predicted_prior),
    )
    for channel in prediction.measured:
        for part, values in parts:
            if channel in values:
                unit = {"unit": prediction.units.get(channel, "")}
                fields.append(pa.field(f"{part}.{channel}", pa.float64(), True, unit))
                column = np.asarray(values[channel], dtype=np.float64)
                arrays.append(pa.array(column, mask=~np.isfinite(column)))
    metadata = {"log": prediction.log, "held_out": "true" if prediction.held_out else "false", "version": "1"}
    return pa.table(arrays, schema=pa.schema(fields, metadata))


def write_series(prediction: Prediction, path: Path) -> None:
    pq.write_table(series_table(prediction), path, compression="zstd", row_group_size=ROW_GROUP)
