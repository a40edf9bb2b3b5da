"""A column of a joint: the unit that its name says or the joint's limits allow, its sign, its side of the gear."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

from exogauge.logs.channels import parse_channel
from exogauge.logs.units import dimensions_of, find_unit
from exogauge.studies.import_log.column_facts import (
    OTHER,
    SI,
    UNKNOWN,
    Advice,
    JointFacts,
    Seen,
    Suggestion,
    Wearer,
    too_large,
)
from exogauge.studies.import_log.column_words import Words

ROOM = 0.05  # [rad or m], and as a share of the limit: a joint may be seen a little beyond its limits
WORTH = 0.05  # [rad or m] of motion that makes a log worth recording


def joint_column(
    column: Seen, kind: str, joint: str, words: Words, wearer: Wearer, why: str, *, sure: bool
) -> Suggestion | Advice:
    """A quantity of a joint: its unit as named, or the one that the joint's limits allow."""
    channel = parse_channel(f"{kind}.{joint}")
    side: Literal["joint", "motor"] = "motor" if words.motor_side and kind != "temp" else "joint"
    if side == "motor":
        sure, why = False, f"{why}; the motor's side of the gear, by its name"
    if words.unit is not None:
        named = find_unit(words.unit)
        if named is None or named.dimension not in dimensions_of(channel):
            return Advice(f"Its name says {words.unit}, which is no unit of {channel.kind}. {UNKNOWN}")
        sign = _sign(column, kind, words.unit, _facts(joint, wearer)) if side == "joint" else 1
        return _signed(Suggestion(channel.name, words.unit, sign, side, sure, why))
    facts = _facts(joint, wearer) if side == "joint" else None
    if kind == "temp":
        return Suggestion(channel.name, "degC", sure=sure and 0.0 < column.size < 150.0, why=why)
    units = [unit for unit in (SI[kind], OTHER.get(kind)) if unit]
    upright = [unit for unit in units if _fits(column, kind, unit, 1, facts)]
    moving = [unit for unit in upright if _moves(column, kind, unit)]
    turned = [unit for unit in units if _fits(column, kind, unit, -1, facts) and _moves(column, kind, unit)]
    if turned and not moving:
        rests = f"{turned[0]} with the sign reversed stays within the joint's limits, nothing else does"
        return Suggestion(channel.name, turned[0], -1, side, False, f"{why}; {rests}")
    if upright:
        likely = moving or upright
        unit = likely[-1] if too_large(column, kind) else likely[0]
        only = len(upright) == 1 and unit in moving and facts is not None and math.isfinite(_limit(facts, kind))
        rests = f"only {unit} stays within the joint's limits" if only else f"the unit is not named: {unit} is usual"
        return Suggestion(channel.name, unit, 1, side, sure and only, f"{why}; {rests}")
    return Advice(
        f"{why}, but {column.low:.4g} … {column.high:.4g} is beyond its limits in any unit. Check its zero (`offset`), "
        "its side of the gear, and the joint."
    )


def _facts(joint: str, wearer: Wearer) -> JointFacts | None:
    return next((each for each in wearer.joints or () if each.name == joint), None)


def _limit(facts: JointFacts, kind: str) -> float:
    return facts.velocity if kind == "dq" else facts.upper - facts.lower if kind == "q" else math.inf


def _fits(column: Seen, kind: str, unit: str, sign: int, facts: JointFacts | None) -> bool:
    found = find_unit(unit)
    if facts is None or found is None or kind not in ("q", "dq"):
        return sign == 1
    low, high = sorted((sign * column.low * found.factor, sign * column.high * found.factor))
    if kind == "dq":
        return max(abs(low), abs(high)) <= facts.velocity * (1.0 + ROOM) and sign == 1
    return low >= facts.lower - ROOM * (1.0 + abs(facts.lower)) and high <= facts.upper + ROOM * (
        1.0 + abs(facts.upper)
    )


def _moves(column: Seen, kind: str, unit: str) -> bool:
    """Whether a position, read in this unit, moves enough to have been worth a log."""
    found = find_unit(unit)
    return kind != "q" or found is None or (column.high - column.low) * found.factor >= WORTH


def _sign(column: Seen, kind: str, unit: str, facts: JointFacts | None) -> Literal[1, -1]:
    reversed_only = not _fits(column, kind, unit, 1, facts) and _fits(column, kind, unit, -1, facts)
    return -1 if kind == "q" and reversed_only else 1


def _signed(found: Suggestion) -> Suggestion:
    if found.sign == 1:
        return found
    return replace(
        found, sure=False, why=f"{found.why}; only with the sign reversed it stays within the joint's limits"
    )
