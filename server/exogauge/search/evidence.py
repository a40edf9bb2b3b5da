"""The plot that shows an effect: what is missing against the coordinate that it depends on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.flags import along_motion
from exogauge.findings.basis import Continued
from exogauge.findings.result import Evidence
from exogauge.identification.equations import Equations
from exogauge.identification.model import RobotModel
from exogauge.robots.rows import RowType
from exogauge.search.score import Score
from exogauge.search.site_rows import SiteRows

Array = NDArray[np.float64]

BINS = 40  # at most
FEWEST = 8  # samples in a bin
USUAL = 12  # samples in a bin of a short log
UNITS = {
    "velocity": "rad/s", "position": "rad", "load": "N·m", "time": "s", "acceleration": "rad/s²", "drive": "N·m",
    "temperature": "°C", "motor_velocity": "rad/s",
}  # fmt: skip
COVERED = ("temperature", "load", "position")  # coordinates in which held-out logs may go beyond
VELOCITIES = ("velocity", "motor_velocity")


def evidence(model: RobotModel, found: Score, kind: int, rows: Sequence[SiteRows]) -> Evidence:
    """Rows of one kind, held-out ones where there are any. Signs: torque that the joint gets and the model lacks, or
    gets along the motion where the effect says so; what a sensor reads too much."""
    candidate, effect = found.candidate, found.candidate.effect
    own, sign = model.equations.columns(), _sign(model.equations, kind)
    known = [each for each in rows if kind in each.rows]
    shown = [each for each in known if each.held_out] or known
    edge = model.solution.solved.x - model.solution.unbounded.x  # the model that is added to keeps to physical ranges
    name = _logged(effect.coordinate, known)
    over = [each.seen.coordinate(name, candidate.shape) for each in shown]
    at = np.concatenate([values[each.rows[kind].samples] for values, each in zip(over, shown, strict=True)])
    before = sign * np.concatenate([each.rows[kind].e - each.rows[kind].A @ edge[own[kind]] for each in shown])
    after = sign * np.concatenate(
        [each.after(effect, candidate.shape, found.coefficients, found.step, own)[kind] for each in shown]
    )
    columns = [each.columns(effect, candidate.shape)[kind] for each in shown]
    torque = -sign * np.concatenate(columns) @ found.coefficients
    if along_motion(effect):
        way = np.concatenate([np.sign(each.seen.signals.velocity[each.rows[kind].samples]) for each in shown])
        before, after, torque = way * before, way * after, way * torque
    bins = int(np.clip(len(at) // USUAL, 1, BINS))
    edges = np.unique(np.quantile(at, np.linspace(0.0, 1.0, bins + 1)))
    if name in VELOCITIES:  # friction turns round at zero: no bin may hold both sides
        edges = np.unique([*edges, np.clip(0.0, edges[0], edges[-1])])
    place = np.clip(np.searchsorted(edges, at, side="right") - 1, 0, max(len(edges) - 2, 0))
    count = np.bincount(place, minlength=len(edges) - 1)
    full = count >= FEWEST

    def mean(values: Array) -> Array:
        return np.asarray(np.bincount(place, values, minlength=len(count))[full] / count[full])

    spread = np.sqrt(np.maximum(mean(before**2) - mean(before) ** 2, 0.0) / count[full])
    unit = UNITS.get(name) or candidate.site.in_si(model, name, candidate.shape)[1]
    binned = (mean(at), mean(before), mean(after), spread, mean(torque))
    return Evidence(name, unit, *binned, along_motion=along_motion(effect))


def continued(model: RobotModel, found: Score, kind: int, rows: Sequence[SiteRows]) -> Continued | None:
    """Where held-out logs go well beyond all that was fitted, in the coordinate that the effect depends on."""
    criteria = model.criteria.search
    candidate, name = found.candidate, _logged(found.candidate.effect.coordinate, rows)
    if name not in COVERED:
        return None
    seen: dict[bool, list[Array]] = {False: [], True: []}
    for each in (each for each in rows if kind in each.rows):
        values = each.seen.coordinate(name, candidate.shape)[each.rows[kind].samples]
        ends = np.quantile(values, [1.0 - criteria.covered, criteria.covered]) if len(values) else np.zeros(0)
        seen[each.held_out].append(ends)
    if not all(any(len(ends) for ends in each) for each in seen.values()):
        return None
    (low, high), (least, most) = (
        (min(ends[0] for ends in each if len(ends)), max(ends[1] for ends in each if len(ends)))
        for each in (seen[False], seen[True])
    )
    beyond = [(low - least, least, low), (most - high, most, high)]
    further, reached, fitted = max(beyond)
    return Continued(name, UNITS[name], reached, fitted) if further > criteria.beyond * (high - low) else None


def _logged(coordinate: str, rows: Sequence[SiteRows]) -> str:
    """The coordinate, or time where a log does not hold it."""
    return "time" if any(getattr(each.seen.signals, coordinate, None) is None for each in rows) else coordinate


def _sign(equations: Equations, kind: int) -> float:
    """Of what is shown against what a row holds: torque beyond the motor's; a reading, with the log's sign."""
    row = equations.layout.rows[kind]
    return -equations.robot.cuts[row.place].sign if row.type == RowType.SENSOR else -1.0
