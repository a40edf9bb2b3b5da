"""Something that touched the robot once: found, named, and its time left out of the fit, before any effect is sought.

A push in a fitted log bends everything that is identified from it. No held-out log can tell of it, because it happens
once. So all logs are looked at, with a higher bar: it must stand far above all other moments of these logs, and one
force at one link has to explain it in all that was measured.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.detect.contact.finding import Contact, name_contact
from exogauge.detect.contact.fit import Push, explain
from exogauge.detect.contact.rows import LogRows, force_columns, log_rows, reaches
from exogauge.detect.contact.scan import APART_S, bursts, gains, level
from exogauge.findings.result import Finding
from exogauge.identification.model import RobotModel
from exogauge.identification.result import Identification
from exogauge.identification.settings import Progress, Recording
from exogauge.robots.rows import RowType

Array = NDArray[np.float64]

EXPLAINED = 0.8  # of a burst, by one force
LARGEST_N = 200.0
BRIEFEST_S = 0.11  # gears jolt for as long as they swing; a hand, a cable or a table takes longer
FORCE_KNOWN = 0.7  # standard deviations: part of a force may be felt by no joint, however clear the push is
ONE_AXIS = 0.95  # of the gain: seen by one joint alone, where friction and gears make bursts too
WHOLLY_SEEN = 0.8  # of the burst's time: these come where the joint starts, stops or turns
ALONE_ABOVE = 5.0  # times the next moment, in the square root of the gain: what starts and turns do, they do again
FAR_ABOVE = 1.5  # times the level
ALIKE = 1.25  # ratio of speeds
FEWEST = 20  # samples as slow, elsewhere
LARGER = 3.0  # than 95 % of what is unexplained at such speeds
TELL_APART = 15.0  # of evidence (twice the log likelihood), between links
SCALE = 0.03  # to which the torque of a joint is known: what it takes of the gain tells no links apart
MARGIN_S = 0.05, 0.3  # at least and at most, for the doubt of when it began and ended
ROUNDS = 3
SAME_S = 0.5  # between the begins of a push that was found twice


@final
@dataclass(frozen=True)
class Contacts:
    """recordings: the same, with the spans that are left out. identification: from the rest."""

    contacts: tuple[Contact, ...]
    findings: tuple[Finding, ...]
    recordings: tuple[Recording, ...]
    identification: Identification


def contacts(
    found: Identification,
    recordings: Sequence[Recording],
    identify_anew: Callable[[Sequence[Recording]], Identification],
    progress: Progress = lambda _fraction, _phrase: None,
) -> Contacts | None:
    """None where nothing happened. found: identification of `recordings`. identify_anew: the same with other ones."""
    progress(0.0, "looking for moments at which something touched the robot")
    pushed = pushes(found.model, recordings)
    again, spared = found, tuple(recordings)
    for _ in range(ROUNDS):
        if not pushed:
            return None
        spared, before = _spared(recordings, pushed), pushed
        progress(0.5, "identifying without the moments at which something touched the robot")
        again = identify_anew(spared)
        pushed = pushes(again.model, recordings, pushed)
        if _same(before, pushed):
            break
    else:
        return None  # each model sees other moments: none of them is sure
    grouped = by_link(again.model, pushed)
    findings = tuple(name_contact(k, each, found, again) for k, each in enumerate(grouped, 1))
    return Contacts(grouped, findings, spared, again)


def pushes(model: RobotModel, recordings: Sequence[Recording], known: Sequence[Push] = ()) -> list[Push]:
    """Largest first, [] where none is sure. known: those that were sure with a model that was bent by them; they have
    to be there still."""
    logs = log_rows(model, recordings)
    scanned = [gains(rows, force_columns(model, rows)) for rows in logs]
    moments, next_gain = bursts(logs, scanned)
    bar = level([rows.time for rows in logs], [gain for gain, _ in scanned])
    reach = reaches(model.robot.tree)
    explained = []
    for moment in moments:
        rows = logs[moment.log]
        explained.append(explain(rows, force_columns(model, rows), reach, moment.middle, moment.duration))
    plausible = [
        each
        for each in explained
        if _one_force(each) and (_again(each, known) or not _own_jolt(model, each, logs, next_gain))
    ]
    sure = [
        each
        for each in plausible
        if _again(each, known) or each.alone < ONE_AXIS or np.sqrt(each.best.gain) > FAR_ABOVE * bar
    ]
    return [each for each in plausible if any(each is other or _common(model, each, other) for other in sure)]


def _one_force(push: Push) -> bool:
    known = push.force > FORCE_KNOWN * push.force_std
    return push.share > EXPLAINED and push.force < LARGEST_N and push.duration > BRIEFEST_S and known


def _own_jolt(model: RobotModel, push: Push, logs: Sequence[LogRows], next_gain: float) -> bool:
    """Whether one joint alone may have given itself the jolt.

    A gear that swings or a bristle that bends does, as the joint starts or turns; no hand picks that. And friction
    does, at a speed that is rare: so at other moments of such speed there has to be nothing like it. next_gain: of the
    next moment that is no burst.
    """
    row = model.equations.layout.told.rows[push.kind]
    if push.alone < ONE_AXIS or row.type != RowType.AXIS:
        return False
    if push.seen[push.kind] < WHOLLY_SEEN and np.sqrt(push.best.gain) < ALONE_ABOVE * np.sqrt(next_gain):
        return True
    during, others = list[Array](), list[Array]()  # (2, n) speed and what is unexplained
    for rows in logs:
        speed = np.abs(rows.prepared.axis_velocity[rows.prepared.kept, row.place])
        both = np.stack([speed, np.abs(rows.e[:, push.kind])])
        seen, here = rows.weight[:, push.kind] > 0.0, rows is push.rows
        during.append(both[:, seen & here & (rows.time > push.start) & (rows.time < push.stop)])
        others.append(both[:, seen & ~(here & (np.abs(rows.time - push.start) < push.duration + APART_S))])
    (speed, size), (speeds, sizes) = (np.concatenate(each, axis=1) for each in (during, others))
    slower = np.sum(speeds < ALIKE * speed.min())
    usual = sizes[(speeds > speed.min() / ALIKE) & (speeds < speed.max() * ALIKE)]
    return bool(slower < FEWEST or size.max() < LARGER * np.quantile(usual, 0.95))


def _again(push: Push, known: Sequence[Push]) -> bool:
    return any(push.rows.name == each.rows.name and abs(push.start - each.start) < SAME_S for each in known)


def by_link(model: RobotModel, found: Sequence[Push]) -> tuple[Contact, ...]:
    """Pushes that one link explains are one contact."""
    groups: list[list[Push]] = []
    for push in sorted(found, key=lambda each: -each.best.gain):
        fitting = next((group for group in groups if _common(model, push, *group)), None)
        if fitting is None:
            groups.append([push])
        else:
            fitting.append(push)
    return tuple(_contact(model, group) for group in groups)


def _contact(model: RobotModel, group: Sequence[Push]) -> Contact:
    bodies = [each.body for each in group[0].links]
    total = {body: sum(_evidence(push)[body] for push in group) for body in bodies}
    best = max(_common(model, *group), key=lambda body: total[body])
    lacks = sorted(((body, total[best] - total[body]) for body in bodies if body != best), key=lambda each: each[1])
    alike = tuple(each for each in lacks if each[1] < _told_from(model, *group))
    reach = reaches(model.robot.tree)
    again = [
        push
        if push.best.body == best
        else explain(
            push.rows, force_columns(model, push.rows), reach, push.start + 0.5 * push.duration, push.duration, best
        )
        for push in group
    ]
    return Contact(best, tuple(again), alike, tuple(lacks[len(alike) : len(alike) + 3]))


def _common(model: RobotModel, *found: Push) -> list[int]:
    """Bodies that explain each of them nearly as well as its best."""
    sets = []
    for push in found:
        least = push.links[0].evidence - _told_from(model, push)
        sets.append({body for body, value in _evidence(push).items() if value > least})
    return sorted(set.intersection(*sets))


def _told_from(model: RobotModel, *found: Push) -> float:
    """Evidence by which one link has to explain them better than another one."""
    on_axes = sum(float(each.by_kind[model.equations.layout.told.axes].sum()) for each in found)
    return TELL_APART + SCALE**2 * max(on_axes, 0.0)


def _evidence(push: Push) -> dict[int, float]:
    return {each.body: each.evidence for each in push.links}


def _spared(recordings: Sequence[Recording], found: Sequence[Push]) -> tuple[Recording, ...]:
    spared = []
    for each in recordings:
        spans = [_span(push) for push in found if push.rows.name == each.log.name]
        log = replace(each.log, left_out=(*each.log.left_out, *sorted(spans)))
        spared.append(replace(each, log=log) if spans else each)
    return tuple(spared)


def _span(push: Push) -> tuple[float, float]:
    margin = float(np.clip(2.0 * push.start_std, *MARGIN_S))
    return push.start - margin, push.stop + margin


def _same(one: Sequence[Push], other: Sequence[Push]) -> bool:
    return len(one) == len(other) and all(_again(each, other) for each in one)
