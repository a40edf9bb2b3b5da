"""Logs of contact: a zero of their own, and what touches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import Criteria
from exogauge.payload.contact import Compensation, false_alarm_limit
from exogauge.payload.intake import Payload
from exogauge.payload.prepare import Moved

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Touch:
    """A contact: span [s], largest force of the environment on the payload (3,) [N] in {S}."""

    start: float
    end: float
    force: Array


def zeroed(
    payload: Payload, compensation: Compensation, contact: Sequence[Moved], moving: bool, criteria: Criteria
) -> tuple[list[Moved], list[str]]:
    """Logs of contact with a zero of their own taken off, where one constant is what alarms through most of a log, and
    other logs show that the zero moves; and what is said of it. moving: whether they do."""
    out, said, most = list[Moved](), list[str](), criteria.payload.touched
    limit = false_alarm_limit(criteria.payload_dynamic.zero_alarms)
    for recording, each in zip(payload.of("contact"), contact, strict=True):
        found = compensation.touched(each.motion, each.wrench, limit)
        constant = np.median(found.external, axis=0)
        without = replace(each, wrench=each.wrench - constant)
        share = float(np.mean(compensation.touched(each.motion, without.wrench, limit).alarm))
        if np.mean(found.alarm) < most or share > most * float(np.mean(found.alarm)):
            out.append(each)
            continue
        force = float(np.linalg.norm(constant[:3]))
        told = f"{recording.name}: {force:.3g} N stand there in {100 * np.mean(found.alarm):.0f} % of the time. "
        taken = "Other logs show a zero that moves: taken for that, and off."
        said.append(told + (taken if moving else "A zero that has moved looks like that, and so does a lasting touch."))
        out.append(without if moving else each)
    return out, said


def found_touches(
    payload: Payload, compensation: Compensation, contact: Sequence[Moved], sign: int, criteria: Criteria
) -> tuple[dict[str, tuple[Touch, ...]], dict[str, float]]:
    """Contacts by log, and the force [N] that counts as one."""
    touches: dict[str, tuple[Touch, ...]] = {}
    thresholds: dict[str, float] = {}
    for recording, touched in zip(payload.of("contact"), contact, strict=True):
        rate = payload.file.settings.false_alarms_per_hour
        external = compensation.external(touched.motion, touched.wrench)
        touches[recording.name] = tuple(
            _touch(span, touched.motion.time, -sign * external)
            for span in compensation.contacts(touched.motion, touched.wrench, rate, criteria.payload_dynamic)
        )
        period = float(np.median(np.diff(touched.motion.time)))
        limit = compensation.force_threshold(touched.motion, rate * period / 3600.0)
        thresholds[recording.name] = float(limit.max())
    return touches, thresholds


def _touch(span: tuple[float, float], time: Array, on_payload: Array) -> Touch:
    inside = on_payload[(time >= span[0]) & (time <= span[1]), :3]
    return Touch(span[0], span[1], inside[int(np.argmax(np.linalg.norm(inside, axis=1)))])
