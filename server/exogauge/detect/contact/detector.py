"""Something that touched the robot once: found, named, and its time left out of the fit, before any effect is sought.

A push in a fitted log bends everything that is identified from it. No held-out log can tell of it, because it happens
once. So all logs are looked at, with a higher bar: it must stand far above all other moments of these logs, and one
force at one link has to explain it in all that was measured.

A contact as a finding: which log, when, how hard, where.

What happened once, such as a push, is left out before effects that are always there are sought.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.detecting import Touching
from exogauge.detect.contact.fit import Push, explain
from exogauge.detect.contact.rows import LogRows, force_columns, log_rows, reaches
from exogauge.detect.contact.scan import bursts, gains, level
from exogauge.detect.so_far import SoFar
from exogauge.devices.result import Estimate
from exogauge.findings.as_told import OF_THE_LOGS
from exogauge.findings.basis import Touch, Touched
from exogauge.findings.result import Alternative, Evidence, Finding, HeldOut, Place
from exogauge.findings.verdict import Objection, Why
from exogauge.identification.model import RobotModel
from exogauge.identification.preparation import channel_of_row
from exogauge.identification.result import Identification
from exogauge.identification.settings import Recording
from exogauge.identification.validate import unit_of
from exogauge.progress import Doing, Progress, still, unwatched
from exogauge.robots.description import Robot
from exogauge.robots.rows import RowType
from exogauge.search.judge import refused
from exogauge.search.locate import pooled
from exogauge.side_by_side import each as side_by_side

Array = NDArray[np.float64]


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
    progress: Progress = unwatched,
) -> Contacts | None:
    """None where nothing happened. found: identification of `recordings`. identify_anew: the same with other ones."""
    progress(0.0, Doing.LOOKING_FOR_CONTACT)
    pushed = pushes(found.model, recordings)
    again, spared, criteria = found, tuple(recordings), found.model.criteria.contact
    for _ in range(criteria.rounds):
        if not pushed:
            return None
        spared, before = _spared(recordings, pushed, criteria), pushed
        progress(0.5, Doing.IDENTIFYING_WITHOUT_CONTACT)
        again = identify_anew(spared)
        pushed = pushes(again.model, recordings, pushed)
        if _same(before, pushed, criteria):
            break
    else:
        return None  # each model sees other moments: none of them is sure
    grouped = by_link(again.model, pushed)
    findings = tuple(name_contact(k, each, found, again) for k, each in enumerate(grouped, 1))
    return Contacts(grouped, findings, spared, again)


def pushes(model: RobotModel, recordings: Sequence[Recording], known: Sequence[Push] = ()) -> list[Push]:
    """Largest first, [] where none is sure. known: those that were sure with a model that was bent by them; they have
    to be there still."""
    criteria, block_s = model.criteria.contact, model.criteria.judging.block_s
    logs = log_rows(model, recordings)
    scanned = list(side_by_side(lambda rows: gains(rows, force_columns(model, rows), criteria), logs))
    bar = level([rows.time for rows in logs], [gain for gain, _ in scanned], block_s, criteria)
    moments, next_gain = bursts(logs, scanned, bar, criteria)
    reach = reaches(model.robot.tree, model.criteria.contact)
    explained = []
    for moment in moments:
        rows = logs[moment.log]
        columns = force_columns(model, rows)
        explained.append(explain(rows, columns, reach, moment.middle, moment.duration, criteria))
    plausible = [
        each
        for each in explained
        if _one_force(each, criteria) and (_again(each, known, criteria) or not _own_jolt(model, each, logs, next_gain))
    ]
    sure = [
        each
        for each in plausible
        if _again(each, known, criteria)
        or each.alone < criteria.one_axis
        or np.sqrt(each.best.gain) > criteria.far_above * bar
    ]
    return [each for each in plausible if any(each is other or _common(model, each, other) for other in sure)]


def _one_force(push: Push, criteria: Touching) -> bool:
    known = push.force > criteria.force_known * push.force_std
    small, long = push.force < criteria.largest_n, push.duration > criteria.briefest_s
    return push.share > criteria.explained and small and long and known and _begins_and_ends(push)


def _begins_and_ends(push: Push) -> bool:
    """Within its log: what was there from its first sample on, or to its last, may be a drive that settles."""
    first, last = push.rows.time[[0, -1]]
    stop_std = np.hypot(push.start_std, push.duration_std)
    return bool(first < push.start - push.start_std and push.stop + stop_std < last)


def _own_jolt(model: RobotModel, push: Push, logs: Sequence[LogRows], next_gain: float) -> bool:
    """Whether one joint alone may have given itself the jolt.

    A gear that swings or a bristle that bends does, as the joint starts or turns; no hand picks that. And friction
    does, at a speed that is rare: so at other moments of such speed there has to be nothing like it. next_gain: of the
    next moment that is no burst.
    """
    criteria, row = model.criteria.contact, model.equations.layout.told.rows[push.kind]
    if push.alone < criteria.one_axis or row.type != RowType.AXIS:
        return False
    rises = np.sqrt(push.best.gain) >= criteria.alone_above * np.sqrt(next_gain)
    if push.seen[push.kind] < criteria.wholly_seen and not rises:
        return True
    during, others = list[Array](), list[Array]()  # (2, n) speed and what is unexplained
    for rows in logs:
        speed = np.abs(rows.prepared.axis_velocity[rows.prepared.kept, row.place])
        both = np.stack([speed, np.abs(rows.e[:, push.kind])])
        seen, here = rows.weight[:, push.kind] > 0.0, rows is push.rows
        during.append(both[:, seen & here & (rows.time > push.start) & (rows.time < push.stop)])
        near = np.abs(rows.time - push.start) < push.duration + criteria.apart_s
        others.append(both[:, seen & ~(here & near)])
    (speed, size), (speeds, sizes) = (np.concatenate(each, axis=1) for each in (during, others))
    slower = np.sum(speeds < criteria.alike * speed.min())
    usual = sizes[(speeds > speed.min() / criteria.alike) & (speeds < speed.max() * criteria.alike)]
    return bool(slower < criteria.fewest or size.max() < criteria.larger * np.quantile(usual, 0.95))


def _again(push: Push, known: Sequence[Push], criteria: Touching) -> bool:
    same_s = criteria.same_s
    return any(push.rows.name == each.rows.name and abs(push.start - each.start) < same_s for each in known)


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
    reach = reaches(model.robot.tree, model.criteria.contact)
    again = tuple(push if push.best.body == best else _explained_by(model, push, best, reach) for push in group)
    return Contact(best, again, alike, tuple(lacks[len(alike) : len(alike) + 3]))


def _explained_by(model: RobotModel, push: Push, body: int, reach: Array) -> Push:
    columns, middle = force_columns(model, push.rows), push.start + 0.5 * push.duration
    return explain(push.rows, columns, reach, middle, push.duration, model.criteria.contact, body)


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
    criteria = model.criteria.contact
    return criteria.tell_apart + criteria.scale**2 * max(on_axes, 0.0)


def _evidence(push: Push) -> dict[int, float]:
    return {each.body: each.evidence for each in push.links}


def _spared(recordings: Sequence[Recording], found: Sequence[Push], criteria: Touching) -> tuple[Recording, ...]:
    spared = []
    for each in recordings:
        spans = [_span(push, criteria) for push in found if push.rows.name == each.log.name]
        log = replace(each.log, left_out=(*each.log.left_out, *sorted(spans)))
        spared.append(replace(each, log=log) if spans else each)
    return tuple(spared)


def _span(push: Push, criteria: Touching) -> tuple[float, float]:
    margin = float(np.clip(2.0 * push.start_std, *criteria.margin_s))
    return push.start - margin, push.stop + margin


def _same(one: Sequence[Push], other: Sequence[Push], criteria: Touching) -> bool:
    return len(one) == len(other) and all(_again(each, other, criteria) for each in one)


CONTACT = "contact"


@final
@dataclass(frozen=True)
class Contact:
    """Pushes at one link. body: the one that is likeliest for all of them. alike: (body, evidence that it lacks) of
    those that nearly are. others: the same of the next ones."""

    body: int
    pushes: tuple[Push, ...]
    alike: tuple[tuple[int, float], ...]
    others: tuple[tuple[int, float], ...]


def name_contact(rank: int, contact: Contact, before: Identification, after: Identification) -> Finding:
    """before, after: identified with and without the time in which it happened."""
    robot, bodies = after.model.robot, after.model.robot.tree.bodies
    push = contact.pushes[0]
    held_out = _held_out(channels(robot)[push.kind], before, after, contact)

    def other(body: int, why: Why) -> Alternative:
        gain = next(each.gain for each in push.links if each.body == body)
        score = push.share * float(np.clip(gain / max(push.best.gain, 1e-300), 0.0, 1.0))
        return Alternative(CONTACT, Place("link", bodies[body]), score, Objection(why))

    alike = tuple(other(body, Why.ALIKE) for body, _ in contact.alike)
    return Finding(
        rank=rank,
        effect=CONTACT,
        place=Place("link", bodies[contact.body]),
        parameters=_parameters(contact),
        held_out=held_out,
        score=push.share,
        basis=_touched(contact),
        alternatives=(*alike, *(other(body, Why.LESS) for body, _ in contact.others)),
        also_possible=alike,
        evidence=_evidence_of(robot, push),
    )


def channels(robot: Robot) -> list[str]:
    """Of the kinds of `LogRows`."""
    return [channel_of_row(robot, kind) for kind in robot.rows.numbers(RowType.BASE, RowType.AXIS, RowType.SENSOR)]


def _parameters(contact: Contact) -> dict[str, Estimate]:
    """`force[id_1]`, `start[id_1]`, `duration[id_1]`: by the log's name, `id_1, 2` for its second push."""
    found: dict[str, Estimate] = {}
    for push in contact.pushes:
        name, number = push.rows.name, 2
        while f"force[{name}]" in found:
            name, number = f"{push.rows.name}, {number}", number + 1
        found[f"force[{name}]"] = Estimate(push.force, push.force_std, "N")
        found[f"start[{name}]"] = Estimate(push.start, push.start_std, "s")
        found[f"duration[{name}]"] = Estimate(push.duration, push.duration_std, "s")
    return found


def _touched(contact: Contact) -> Touched:
    push = contact.pushes[0]
    inside = (push.time > push.start) & (push.time < push.stop) & (push.weight[:, push.kind] > 0.0)
    lacks = float(np.max(np.abs(push.before[inside, push.kind]), initial=0.0))
    return Touched(
        tuple(
            Touch(each.rows.name, each.start, each.duration, Estimate(each.force, each.force_std, "N"))
            for each in contact.pushes
        ),
        lacks,
    )


def _held_out(channel: str, before: Identification, after: Identification, contact: Contact) -> HeldOut:
    """Of held-out logs; where these say nothing of it, of the logs in which it happened."""
    touched = list(dict.fromkeys(push.rows.name for push in contact.pushes))
    for log in ("", ", ".join(touched)):
        values = []
        for each in (before, after):
            fits = [fit for fit in each.validation if fit.channel == channel]
            values.append(pooled([fit for fit in fits if (fit.log in touched if log else fit.held_out)]))
        held = HeldOut(channel, unit_of(channel, before.model.robot), values[0][0], values[1][0], values[1][1], log)
        if held.falls(after.model.criteria.judging):
            break
    return held


def _evidence_of(robot: Robot, push: Push) -> Evidence:
    """Residuals of the channel that shows it best over the log's own time: torque that the joint gets and the model
    lacks, what a sensor reads too much."""
    shown_s = 0.7  # before and after the push
    row = robot.rows.told.rows[push.kind]
    sign = -robot.cuts[row.place].sign if row.type == RowType.SENSOR else -1.0
    near = (push.time > push.start - shown_s) & (push.time < push.stop + shown_s) & (push.weight[:, push.kind] > 0.0)
    before, added = (sign * each[near, push.kind] for each in (push.before, push.added))
    spread = 1.0 / np.sqrt(push.weight[near, push.kind])
    return Evidence("time", "s", push.time[near], before, before - added, spread, added)


def contact(so_far: SoFar) -> SoFar:
    """Without the time in which something touched the robot."""
    if not so_far.question.touched:
        return so_far
    touched = contacts(so_far.current, so_far.recordings, so_far.identified, so_far.question.progress)
    if touched is None or any(refused(each, so_far.criteria.judging) for each in touched.findings):
        return so_far
    models = (*so_far.models, *([touched.identification] * len(touched.findings)))
    return replace(so_far, recordings=touched.recordings, models=models).having(touched.findings)


def contact_again(so_far: SoFar) -> SoFar:
    """Where effects were named since that explain what looked like a push, all is sought anew without one."""
    looked_like_one = any(each.effect == CONTACT for each in so_far.findings)
    named_since = any(each.effect not in OF_THE_LOGS for each in so_far.findings)
    if not looked_like_one or not named_since or pushes(so_far.current.model, so_far.whole):
        return so_far
    question = so_far.question
    return replace(so_far, anew=replace(question, touched=False, progress=still(question.progress)))
