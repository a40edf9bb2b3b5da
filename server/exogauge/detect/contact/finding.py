"""A contact as a finding: which log, when, how hard, where."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from exogauge.detect.contact.fit import Push
from exogauge.devices.result import Estimate
from exogauge.findings.basis import Touch, Touched
from exogauge.findings.objection import Objection, Why
from exogauge.findings.result import Alternative, Evidence, Finding, HeldOut, Place
from exogauge.identification.preparation import channel_of_row
from exogauge.identification.result import Identification
from exogauge.identification.validate import unit_of
from exogauge.robots.description import Robot
from exogauge.robots.rows import RowType
from exogauge.search.locate import pooled

CONTACT = "contact"
SHOWN_S = 0.7  # before and after the push


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
        evidence=_evidence(robot, push),
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


def _evidence(robot: Robot, push: Push) -> Evidence:
    """Residuals of the channel that shows it best over the log's own time: torque that the joint gets and the model
    lacks, what a sensor reads too much."""
    row = robot.rows.told.rows[push.kind]
    sign = -robot.cuts[row.place].sign if row.type == RowType.SENSOR else -1.0
    near = (push.time > push.start - SHOWN_S) & (push.time < push.stop + SHOWN_S) & (push.weight[:, push.kind] > 0.0)
    before, added = (sign * each[near, push.kind] for each in (push.before, push.added))
    spread = 1.0 / np.sqrt(push.weight[near, push.kind])
    return Evidence("time", "s", push.time[near], before, before - added, spread, added)
