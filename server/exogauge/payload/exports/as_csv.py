"""CSV: one row per number, with unit, standard deviation, 95 % interval and frame."""

from __future__ import annotations

from exogauge.criteria.criterion import Z95
from exogauge.payload.exports.as_json import rows
from exogauge.payload.exports.body import Body
from exogauge.studies.csv_table import csv_table

HEAD = ("name", "unit", "value", "std", "low", "high", "frame")


def write(body: Body) -> str:
    frame = f"{body.frame}; inertia about the centre of mass"
    table = [
        [name, unit, value, std, value - Z95 * std, value + Z95 * std, frame] for name, unit, value, std in rows(body)
    ]
    return csv_table(HEAD, table).decode()
