"""A payload as plain values: JSON and CSV."""

from __future__ import annotations

import json

from exogauge.criteria.criterion import Z95
from exogauge.payload.exports.body import TENSOR, Body
from exogauge.studies.csv_table import csv_table

NAMES = ("m", "cx", "cy", "cz", *TENSOR)
HEAD = ("name", "unit", "value", "std", "low", "high", "frame")
UNITS = ("kg", *("m",) * 3, *("kg·m²",) * 6)


def rows(body: Body) -> list[tuple[str, str, float, float]]:
    """Name, unit, value, standard deviation. Inertia about the centre of mass."""
    values = [body.mass, *body.centre]
    if body.inertia is not None:
        values += [body.inertia["xyz".index(name[1]), "xyz".index(name[2])] for name in TENSOR]
    return [
        (name, unit, float(value), float(std))
        for name, unit, value, std in zip(NAMES, UNITS, values, body.std, strict=False)
    ]


def as_json(body: Body) -> str:
    """JSON: the body about its centre of mass, with standard deviations and covariance."""
    content = {
        "name": body.name,
        "frame": body.frame,
        "inertia_about": "centre of mass, axes of the frame",
        "values": [{"name": n, "unit": u, "value": v, "std": s} for n, u, v, s in rows(body)],
        "covariance": body.covariance.tolist(),
        "made_possible": body.possible,
    }
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def as_csv(body: Body) -> str:
    """CSV: one row per number, with unit, standard deviation, 95 % interval and frame."""
    frame = f"{body.frame}; inertia about the centre of mass"
    table = [
        [name, unit, value, std, value - Z95 * std, value + Z95 * std, frame] for name, unit, value, std in rows(body)
    ]
    return csv_table(HEAD, table).decode()
