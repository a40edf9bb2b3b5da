"""A candidate that may be claimed, as a finding: its numbers, its evidence, what it beat.

The plot that shows an effect: what is missing against the coordinate that it depends on.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.judging import Judging
from exogauge.devices.result import Estimate
from exogauge.effects.shaped import along_motion
from exogauge.findings.basis import Continued, OfRobot
from exogauge.findings.binned import binned
from exogauge.findings.result import Alternative, Evidence, Finding, HeldOut, Place
from exogauge.findings.verdict import Objection, Why
from exogauge.identification.equations import Equations
from exogauge.identification.model import RobotModel, Site
from exogauge.identification.preparation import channel_of_row
from exogauge.identification.result import Identification
from exogauge.identification.validate import unit_of
from exogauge.robots.parameters import unit_at
from exogauge.robots.rows import RowType
from exogauge.search.ambiguity import Undecided, undecided
from exogauge.search.baseline import Ground
from exogauge.search.candidates import Candidate
from exogauge.search.doubt import parameters
from exogauge.search.judge import Judgement, apart, refused
from exogauge.search.locate import pooled
from exogauge.search.score import Score
from exogauge.search.site_rows import SiteRows


def place_of(model: RobotModel, candidate: Candidate) -> Place:
    return Place(*candidate.site.label(model.equations))


def rejection(model: RobotModel, judged: Judgement, objection: Objection) -> Alternative:
    candidate = judged.score.candidate
    return Alternative(candidate.effect.name, place_of(model, candidate), max(judged.explained, 0.0), objection)


@final
@dataclass(frozen=True)
class Told:
    """What is told of a candidate before the robot is identified with it; rows are not needed after.

    rivals: others that act on the same rows. alike: those of them that are as good. undecided: what planning a motion
    needs that tells it from these.
    """

    parameters: Mapping[str, Estimate]
    continued: Continued | None
    evidence: Evidence
    rivals: Sequence[Judgement]
    alike: Sequence[Judgement]
    undecided: Undecided | None


def tell(
    model: RobotModel, winner: Judgement, judged: Sequence[Judgement], rows_of: Mapping[Site, Sequence[SiteRows]]
) -> Told:
    site = winner.score.candidate.site
    rows, kinds = rows_of[site], set(site.kinds(model.equations))
    rivals = [each for each in judged if each is not winner
              and kinds & set(each.score.candidate.site.kinds(model.equations))]  # fmt: skip
    alike = [each for each in rivals if _as_good(winner, each, model.criteria.judging)]
    return Told(
        parameters=parameters(model, winner.score, rows),
        continued=continued(model, winner.score, winner.kind, rows),
        evidence=evidence(model, winner.score, winner.kind, rows),
        rivals=rivals,
        alike=alike,
        undecided=_doubt(model, [winner, *alike], rows_of) if alike else None,
    )


def name_effect(
    rank: int,
    model: RobotModel,
    winner: Judgement,
    told: Told,
    before: Identification,
    after: Identification,
    kind: int,
) -> Finding:
    """kind: of the rows whose error is told."""
    candidate, alike = winner.score.candidate, told.alike
    held_out = _held_out(channel_of(model.equations, kind), before, after, winner)
    others = [rejection(model, each, each.objection or Objection(Why.ALIKE if each in alike else Why.LESS))
              for each in told.rivals]  # fmt: skip
    return Finding(
        rank=rank,
        effect=candidate.effect.name,
        place=place_of(model, candidate),
        parameters=told.parameters,
        held_out=held_out,
        score=held_out.explained,
        basis=OfRobot(candidate.effect, told.continued),
        alternatives=tuple(others),
        also_possible=tuple(each for each, rival in zip(others, told.rivals, strict=True) if rival in alike),
        evidence=told.evidence,
    )


def _as_good(winner: Judgement, rival: Judgement, judging: Judging) -> bool:
    """Whether the held-out blocks, or the fitted logs, leave it open which of the two it is."""
    if rival.objection or rival.kind != winner.kind:
        return False
    return abs(apart(winner, rival)) < judging.tell_apart or winner.score.evidence - rival.score.evidence < judging.open


def _doubt(model: RobotModel, judged: Sequence[Judgement], rows_of: Mapping[Site, Sequence[SiteRows]]) -> Undecided:
    """judged: the winner, then what is as good."""
    return undecided(model, [each.score for each in judged], judged[0].kind, judged[0].after, rows_of)


def channel_of(equations: Equations, kind: int) -> str:
    """Of a kind of rows."""
    return channel_of_row(equations.robot, kind)


def objection(finding: Finding, without: float, with_it: float, judging: Judging) -> Objection | None:
    """Why an effect is dropped again once the robot has been identified with it. without, with_it: `low_passed`.

    The error has to fall as it is told as well, in steady motion and from above the noise, and the size of the effect
    to be known.
    """
    if finding.held_out.rmse_before <= finding.held_out.noise_floor:
        return Objection(Why.AT_FLOOR)
    if with_it > judging.falls * without:
        return Objection(Why.NOT_FALLING_AGAIN, without, with_it, finding.held_out.unit)
    return refused(finding, judging)


def low_passed(ground: Ground, kind: int, logs: Sequence[str]) -> float:
    """RMSE of one kind of rows in these logs. A jolt that the model meets a moment late makes the unfiltered error
    larger."""
    left = [each.residual[kind] for each in ground.residuals if each.log in logs and kind in each.residual]
    return float(np.sqrt(np.nanmean(np.concatenate(left) ** 2)))


def _held_out(channel: str, before: Identification, after: Identification, judged: Judgement) -> HeldOut:
    fits = [[fit for fit in each.validation if fit.log in judged.logs and fit.channel == channel]
            for each in (before, after)]  # fmt: skip
    (rmse_before, floor), (rmse_after, _) = (pooled(each) for each in fits)
    log = ", ".join(judged.logs) if judged.once else ""
    return HeldOut(channel, unit_of(channel, before.model.robot), rmse_before, rmse_after, floor, log)


Array = NDArray[np.float64]

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
    columns = [each.columns(effect, candidate.shape) for each in shown]
    left = [
        each.after(own_columns, found.coefficients, found.step, own)
        for each, own_columns in zip(shown, columns, strict=True)
    ]
    after = sign * np.concatenate([each[kind] for each in left])
    torque = -sign * np.concatenate([each[kind] for each in columns]) @ found.coefficients
    if along_motion(effect):
        way = np.concatenate([np.sign(each.seen.signals.velocity[each.rows[kind].samples]) for each in shown])
        before, after, torque = way * before, way * after, way * torque
    unit = _unit(model, candidate, name)
    means = binned(at, before, after, torque, name in VELOCITIES)  # friction turns round at zero
    return Evidence(name, unit, *means, along_motion=along_motion(effect))


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
    return (
        Continued(name, _unit(model, candidate, name), reached, fitted)
        if further > criteria.beyond * (high - low)
        else None
    )


def _unit(model: RobotModel, candidate: Candidate, coordinate: str) -> str:
    """Of a coordinate, which of a joint that slides is a length, its rate, or a force."""
    place, name, _ = candidate.site.label(model.equations)
    unit = UNITS.get(coordinate) or candidate.site.in_si(model, coordinate, candidate.shape)[1]
    return unit_at(model.robot.tree, name, unit) if place == "joint" else unit


def _logged(coordinate: str, rows: Sequence[SiteRows]) -> str:
    """The coordinate, or time where a log does not hold it."""
    return "time" if any(getattr(each.seen.signals, coordinate, None) is None for each in rows) else coordinate


def _sign(equations: Equations, kind: int) -> float:
    """Of what is shown against what a row holds: torque beyond the motor's; a reading, with the log's sign."""
    row = equations.layout.rows[kind]
    return -equations.robot.cuts[row.place].sign if row.type == RowType.SENSOR else -1.0
