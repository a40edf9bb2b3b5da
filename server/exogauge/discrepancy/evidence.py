"""The plot and the sentence that show an effect: what is missing against the coordinate that it depends on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.discrepancy.axis_rows import AxisRows
from exogauge.discrepancy.result import Evidence
from exogauge.discrepancy.score import Score
from exogauge.identification.model import RobotModel

Array = NDArray[np.float64]

BINS = 40  # at most
FEWEST = 8  # samples in a bin
USUAL = 12  # samples in a bin of a short log
UNITS = {
    "velocity": "rad/s", "position": "rad", "load": "N·m", "time": "s", "acceleration": "rad/s²", "drive": "N·m",
    "temperature": "°C",
}  # fmt: skip


def evidence(model: RobotModel, found: Score, rows: Sequence[AxisRows]) -> Evidence:
    """Held-out rows where there are any. Signs: torque that the joint gets and the model lacks."""
    candidate, effect = found.candidate, found.candidate.effect
    own = model.equations.columns()[model.equations.first_axis + candidate.axis]
    shown = [each for each in rows if each.held_out] or list(rows)
    edge = (model.solution.solved.x - model.solution.unbounded.x)[
        own
    ]  # the model that is added to keeps to physical ranges
    at = np.concatenate([_coordinate(each, effect.coordinate) for each in shown])
    before = np.concatenate([-(each.e - each.A @ edge) for each in shown])
    after = np.concatenate(
        [-each.after(effect, candidate.shape, found.coefficients, found.step[own]) for each in shown]
    )
    torque = np.concatenate([each.torque(effect, candidate.shape) @ found.coefficients for each in shown])
    bins = int(np.clip(len(at) // USUAL, 1, BINS))
    edges = np.unique(np.quantile(at, np.linspace(0.0, 1.0, bins + 1)))
    if effect.coordinate == "velocity":  # friction turns round at zero: no bin may hold both sides
        edges = np.unique([*edges, np.clip(0.0, edges[0], edges[-1])])
    place = np.clip(np.searchsorted(edges, at, side="right") - 1, 0, max(len(edges) - 2, 0))
    count = np.bincount(place, minlength=len(edges) - 1)
    full = count >= FEWEST

    def mean(values: Array) -> Array:
        return np.asarray(np.bincount(place, values, minlength=len(count))[full] / count[full])

    spread = np.sqrt(np.maximum(mean(before**2) - mean(before) ** 2, 0.0) / count[full])
    return Evidence(
        effect.coordinate, UNITS.get(effect.coordinate, ""), mean(at), mean(before), mean(after), spread, mean(torque)
    )


def strongest(shown: Evidence) -> str:
    """Where the missing torque is largest: `+3.1 N·m at a velocity of 0.02 rad/s`."""
    if not len(shown.at):
        return ""
    k = int(np.argmax(np.abs(shown.before)))
    return f"{shown.before[k]:+.2g} N·m at a {shown.coordinate} of {shown.at[k]:.2g} {shown.unit}"


def _coordinate(rows: AxisRows, name: str) -> Array:
    values = getattr(rows.signals, name)
    return np.asarray((values if values is not None else rows.signals.time)[rows.samples])
