"""The child process that reads one log of a stored study as it is, and leaves it as a series file.

Asked by `raw_series` in a temporary folder of its own.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from exogauge.sandbox.answering import Tasks

RAW = "raw.parquet"


def raw(folder: str, log: str) -> dict[str, Any]:
    """folder: the study's files. log: its name in study.yaml."""
    import pyarrow as pa

    from exogauge.studies.intake.bundle import Bundle
    from exogauge.studies.series.recorded_motion import read_raw
    from exogauge.studies.series.write import raw_table, write_table

    pa.set_cpu_count(1)
    write_table(raw_table(*read_raw(Bundle(Path(folder), "study.yaml"), log)), Path(RAW))
    return {}


TASKS: Tasks = {"raw": raw}
LOADED = ("exogauge.studies.series.recorded_motion", "exogauge.studies.series.write")
