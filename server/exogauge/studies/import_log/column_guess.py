"""What the columns of a foreign file may mean, judged by their names, their ranges, and the robot they were logged on.

A suggestion is sure where the name or the robot's limits leave one reading; every other one says what it rests on and
waits for a person. What cannot be named gets no suggestion but advice.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from exogauge.errors import BadLog
from exogauge.logs.channels import parse_channel
from exogauge.studies.import_log.body_columns import body_column
from exogauge.studies.import_log.column_facts import SI, UNKNOWN, Advice, Seen, Suggestion, Wearer
from exogauge.studies.import_log.column_words import FILLERS, KIND_OF, Words, kinds_in, tokens_of, within, words_of
from exogauge.studies.import_log.joint_columns import joint_column

JOINT_KINDS = ("q", "dq", "ddq", "i", "tau", "temp")
RATES_HZ = (5.0, 20_000.0)  # of logs
EPOCHS = ((1e17, "ns"), (1e14, "us"), (1e11, "ms"), (1e8, "s"))
SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
COMMANDED = "It looks like a commanded value, not a measured one: list it under `ignore`, or say what it measures."


def guess(columns: Sequence[Seen], wearer: Wearer, norms: Mapping[str, float]) -> dict[str, Suggestion | Advice]:
    """By column name. norms: name -> median size of the vector that the column belongs to, where it belongs to one."""
    numbered = _numbered(columns, wearer)
    found = {column.name: _one(column, wearer, numbered, norms) for column in columns}
    return _without_doubles(found)


def _one(column: Seen, wearer: Wearer, numbered: Mapping[str, str], norms: Mapping[str, float]) -> Suggestion | Advice:
    if (own := _contract(column.name, wearer)) is not None:
        return own
    words = words_of(column.name)
    if words.commanded:
        return Advice(COMMANDED)
    named = _joint_in(words, wearer)
    rest = words.tokens if named is None else named[1]
    kinds = kinds_in(rest)
    if "t" in kinds and (len(kinds) == 1 or column.step is not None):
        return _time(column, words)
    if named is not None and len(kinds) == 1 and kinds[0] in ("q", "dq", "ddq", "i", "tau", "temp"):
        return joint_column(column, kinds[0], named[0], words, wearer, f"the name says {named[0]}", sure=True)
    if named is not None and kinds == ("acc",):
        return joint_column(column, "ddq", named[0], words, wearer, f"an acceleration of {named[0]}", sure=False)
    if (body := body_column(column, words, kinds, wearer, norms)) is not None:
        return body
    if len(kinds) == 1 and kinds[0] in SI:
        if column.name in numbered:
            joint = numbered[column.name]
            why = "joints are numbered in the robot's order: check that the log has the same"
            return joint_column(column, kinds[0], joint, words, wearer, why, sure=False)
        if wearer.joints is None and (joint := _left_over(column.name, rest)):
            why = "no robot is given, so the joint is called as in the column"
            return joint_column(column, kinds[0], joint, words, wearer, why, sure=False)
        joints = ", ".join(joint.name for joint in (wearer.joints or ())[:8])
        return Advice(f"No joint of the robot is in its name ({joints}). {UNKNOWN}" if joints else UNKNOWN)
    if named is not None:
        return Advice(f"It names the joint {named[0]}, but not what of it was measured. {UNKNOWN}")
    return Advice(UNKNOWN)


def _contract(name: str, wearer: Wearer) -> Suggestion | None:
    try:
        channel = parse_channel(name)
    except BadLog:
        return None
    if channel.kind == "t":
        return None  # many a file calls milliseconds so: the steps tell
    if channel.of_joint and wearer.joints is not None and channel.subject not in [each.name for each in wearer.joints]:
        return None
    return Suggestion(name, channel.unit, sure=True, why="the contract's own name, in its own unit")


def _time(column: Seen, words: Words) -> Suggestion | Advice:
    if column.step is None:
        return Advice(
            "It is called a time but does not rise from row to row; choose another, or list it under `ignore`."
        )
    unit = words.unit if words.unit in SECONDS else None
    if unit is not None:
        return Suggestion("t", unit, sure=True, why=f"the name says time in {unit}")
    for size, epoch in EPOCHS:
        if column.low > size:
            return Suggestion("t", epoch, sure=True, why=f"stamps since 1970 in {epoch}")
    rates = {unit: 1.0 / (column.step * factor) for unit, factor in SECONDS.items()}
    fitting = [unit for unit, rate in rates.items() if RATES_HZ[0] <= rate <= RATES_HZ[1]]
    if not fitting:
        return Advice(f"It rises by {column.step:g} per row, which is no usual rate in s, ms, us or ns: give its unit.")
    best = min(fitting, key=lambda unit: abs(math.log(rates[unit] / 200.0)))
    others = " or ".join(f"{rates[unit]:.4g} Hz in {unit}" for unit in fitting)
    return Suggestion("t", best, sure=len(fitting) == 1, why=f"steps of {column.step:g} are {others}")


def _joint_in(words: Words, wearer: Wearer) -> tuple[str, tuple[str, ...]] | None:
    """The robot's joint that the name holds, the longest, and the words beside it; None where two fit as well."""
    fitting = list[tuple[int, str, tuple[str, ...]]]()
    for joint in wearer.joints or ():
        inner = tokens_of(joint.name)
        if (rest := within(inner, words.tokens)) is not None:
            fitting.append((len(inner), joint.name, rest))
    fitting.sort(key=lambda each: -each[0])
    if not fitting or (len(fitting) > 1 and fitting[0][0] == fitting[1][0]):
        return None
    return fitting[0][1], fitting[0][2]


def _left_over(name: str, tokens: Sequence[str]) -> str:
    """A joint's name out of what else the column's name says."""
    return "_".join(token for token in tokens if token not in KIND_OF and token not in FILLERS)


def _numbered(columns: Sequence[Seen], wearer: Wearer) -> dict[str, str]:
    """Column -> joint, where the columns of one quantity are numbered 0 … J-1 or 1 … J and otherwise called alike."""
    series: dict[tuple[str, ...], dict[int, str]] = {}
    for column in columns:
        tokens = words_of(column.name).tokens
        numbers = [token for token in tokens if token.isdecimal()]
        if len(numbers) == 1:
            stem = tuple(token for token in tokens if not token.isdecimal())
            series.setdefault(stem, {})[int(numbers[0])] = column.name
    joints = wearer.joints or ()
    found: dict[str, str] = {}
    for members in series.values():
        places = sorted(members)
        if (
            joints
            and len(places) == len(joints)
            and places in (list(range(len(joints))), list(range(1, len(joints) + 1)))
        ):
            found |= {members[place]: joint.name for place, joint in zip(places, joints, strict=True)}
    return found


def _without_doubles(found: Mapping[str, Suggestion | Advice]) -> dict[str, Suggestion | Advice]:
    """Two columns that would fill one channel fill none: which of them counts is not ours to say."""
    claims: dict[str, list[str]] = {}
    for name, each in found.items():
        if isinstance(each, Suggestion):
            topic = name.removesuffix("stamp")  # of a bag, where each has a clock of its own
            own_clock = each.channel == "t" and topic != name and sum(other.startswith(topic) for other in found) > 1
            claims.setdefault(name if own_clock else each.channel, []).append(name)
    doubled = {name: names for names in claims.values() if len(names) > 1 for name in names}

    def refusal(names: Sequence[str]) -> Advice:
        listed = ", ".join(repr(name) for name in names)
        return Advice(f"{listed} may all be this; keep one and list the others under `ignore`.")

    return {name: refusal(doubled[name]) if name in doubled else each for name, each in found.items()}
