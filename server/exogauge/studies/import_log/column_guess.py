"""What the columns of a foreign file may mean, judged by their names, their ranges, and the robot they were logged on.

A suggestion is sure where the name or the robot's limits leave one reading; every other one says what it rests on and
waits for a person. What cannot be named gets no suggestion but advice.

A column of a joint: the unit that its name says or the joint's limits allow, its sign, its side of the gear.

Columns of the IMU and of force/torque sensors: a component, told by the axis in its name, and its unit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

from exogauge.errors import BadLog
from exogauge.logs.channels import parse_channel
from exogauge.logs.units import STANDARD_GRAVITY, dimensions_of, find_unit
from exogauge.studies.import_log.column_words import (
    BESIDE_IT,
    FILLERS,
    KIND_OF,
    OF_TOOL,
    OTHER,
    SI,
    UNKNOWN,
    Advice,
    JointFacts,
    Seen,
    Suggestion,
    Wearer,
    Words,
    axes_by_number,
    axis_in,
    counts,
    kinds_in,
    numbered,
    tokens_of,
    too_large,
    within,
    words_of,
)

RATES_HZ = (5.0, 20_000.0)  # of logs
EPOCHS = ((1e17, "ns"), (1e14, "us"), (1e11, "ms"), (1e8, "s"))
SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
OF_JOINTS = ("q", "dq", "ddq", "i", "tau", "temp")
NO_RISE = (
    "It is called a time but does not rise in every row, as a coarse, missing or wrapped stamp does: choose another, "
    "or ignore it (`ignore`) and give `rate_hz`."
)
OWN_NAME = "the contract's own name, in its own unit"
IN_TWO = " Of seconds and nanoseconds in two columns write the sum into one."
OF_A_MODEL = (
    "It looks like a part of the torque that a model tells, not the whole that was measured: ignore it (`ignore`)."
)
BESIDE = (
    "It looks like an error, a limit, a spread, an offset, a count or a share of it, not what was measured: ignore it "
    "(`ignore`), or say what it measures."
)
COMMANDED = "It looks like a commanded value, not a measured one: ignore it (`ignore`), or say what it measures."


def guess(columns: Sequence[Seen], wearer: Wearer, norms: Mapping[str, float]) -> dict[str, Suggestion | Advice]:
    """By column name. norms: name -> median size of the vector that the column belongs to, where it belongs to one."""
    joints, axes, sent = _numbered(columns, wearer), axes_by_number([each.name for each in columns]), _sent(columns)
    found = dict[str, Suggestion | Advice]()
    for column in columns:
        if column.name in sent:
            found[column.name] = Advice(COMMANDED)
        elif column.name in axes:
            found[column.name] = _of_three(column, *axes[column.name], norms)
        else:
            found[column.name] = _one(column, wearer, joints, norms)
    return _without_doubles(_of_one_unit(columns, found, wearer))


def _of_one_unit(
    columns: Sequence[Seen], found: Mapping[str, Suggestion | Advice], wearer: Wearer
) -> dict[str, Suggestion | Advice]:
    """A file writes one quantity of its joints in one unit: what the largest needs holds for all that name none."""
    needed = dict[tuple[str, ...], str]()
    guessed = dict[str, tuple[Seen, str, JointFacts]]()
    for column in columns:
        each = found[column.name]
        if isinstance(each, Suggestion) and words_of(column.name).unit is None and each.why != OWN_NAME:
            channel = parse_channel(each.channel)
            if channel.of_joint and channel.kind != "temp":
                joint = _facts(channel.subject, wearer) or JointFacts(channel.subject)
                guessed[column.name] = column, channel.kind, joint
                if each.unit != joint.units(channel.kind)[0]:
                    needed[joint.units(channel.kind)] = each.unit
    changed = dict(found)
    for name, (column, kind, joint) in guessed.items():
        each, unit = found[name], needed.get(joint.units(kind))
        assert isinstance(each, Suggestion)
        facts = joint if each.side == "joint" else None
        if unit is not None and each.unit != unit and _fits(column, kind, unit, each.sign, facts):
            why = f"{each.why.partition(';')[0]}; {unit} as others of these columns"
            changed[name] = replace(each, unit=unit, sure=False, why=why)
    return changed


def _one(column: Seen, wearer: Wearer, by_number: Mapping[str, str], norms: Mapping[str, float]) -> Suggestion | Advice:
    if (own := _contract(column.name, wearer)) is not None:
        return own
    words = words_of(column.name)
    if words.commanded:
        return Advice(COMMANDED)
    named = _joint_in(words, wearer)
    rest = words.tokens if named is None else named[1]
    kinds = kinds_in(rest)
    if "tau" in kinds and words.of_a_model:
        return Advice(OF_A_MODEL)
    if BESIDE_IT.intersection(rest) and (named or column.name in by_number or axis_in(rest)):
        return Advice(BESIDE)
    if "t" in kinds and (len(kinds) == 1 or column.step is not None):
        return _time(column, words)
    if named is not None and len(kinds) == 1 and kinds[0] in OF_JOINTS:
        return joint_column(column, kinds[0], named[0], words, wearer, "the name says which joint", sure=True)
    if named is not None and kinds == ("acc",):
        return joint_column(column, "ddq", named[0], words, wearer, "an acceleration of the joint", sure=False)
    if named is not None and kinds == ("gyro",) and axis_in(rest) is None:
        return joint_column(column, "dq", named[0], words, wearer, "a rate of the joint", sure=False)
    kind = kinds[0] if len(kinds) == 1 else _by_unit(words, [token for token in rest if not token.isdecimal()])
    if (
        column.name in by_number and kind in OF_JOINTS and not OF_TOOL.intersection(rest)
    ):  # before `ax1`, of axis 1, is taken for an accelerometer's x
        why = "joints are numbered in the robot's order: check that the log has the same"
        return joint_column(column, kind, by_number[column.name], words, wearer, why, sure=False)
    if (body := body_column(column, words, kinds, wearer, norms)) is not None:
        return body
    if not kinds and words.unit in SECONDS and column.step is not None:
        return Suggestion("t", words.unit, why=f"it is in {words.unit} and rises from row to row")
    if len(kinds) == 1 and kinds[0] in SI:
        if wearer.joints is None and (joint := _left_over(column.name, rest)):
            why = "no robot is given, so the joint is called as in the column"
            return joint_column(column, kinds[0], joint, words, wearer, why, sure=False)
        joints = ", ".join(joint.name for joint in (wearer.joints or ())[:8])
        return Advice(f"No joint of the robot is in its name ({joints}). {UNKNOWN}" if joints else UNKNOWN)
    if named is not None and (kind := _by_unit(words, rest)):
        return joint_column(column, kind, named[0], words, wearer, "the name says which joint, and its unit", sure=True)
    if named is not None:
        return Advice(f"It names a joint, but not what of it was measured. {UNKNOWN}")
    return Advice(UNKNOWN)


def _sent(columns: Sequence[Seen]) -> set[str]:
    """Columns of what went out to the robot, beside the same of what came in: `qOut_3`, `qIn_3`."""
    tokens = {column.name: words_of(column.name).tokens for column in columns}
    came = {tuple("out" if token == "in" else token for token in each) for each in tokens.values() if "in" in each}
    return {name for name, each in tokens.items() if "out" in each and each in came}


def _by_unit(words: Words, rest: Sequence[str]) -> str | None:
    """The quantity of a joint that alone has the unit: an angle is a position. None where the name says more."""
    unit = find_unit(words.unit or "")
    if unit is None or not FILLERS.issuperset(rest):
        return None
    return next((kind for kind in OF_JOINTS if unit.dimension in dimensions_of(parse_channel(f"{kind}.joint"))), None)


def _contract(name: str, wearer: Wearer) -> Suggestion | None:
    try:
        channel = parse_channel(name)
    except BadLog:
        return None
    if channel.kind == "t":
        return None  # many a file calls milliseconds so: the steps tell
    if channel.of_joint and wearer.joints is not None and channel.subject not in [each.name for each in wearer.joints]:
        return None
    return Suggestion(name, channel.unit, sure=True, why=OWN_NAME)


def _time(column: Seen, words: Words) -> Suggestion | Advice:
    if column.step is None:
        return Advice(NO_RISE + (IN_TWO if words.unit in ("s", "ns") else ""))
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
    joints = wearer.joints or ()
    found: dict[str, list[str]] = {}
    for _, members in numbered([column.name for column in columns]):
        if joints and counts(members, len(joints)):
            for place, joint in zip(sorted(members), joints, strict=True):
                found.setdefault(members[place], []).append(joint.name)
    return {name: joint for name, (joint, *others) in found.items() if not others}


def _without_doubles(found: Mapping[str, Suggestion | Advice]) -> dict[str, Suggestion | Advice]:
    """Two columns that would fill one channel fill none: which of them counts is not ours to say."""
    claims: dict[str, list[str]] = {}
    for name, each in found.items():
        if isinstance(each, Suggestion):
            topic = name.removesuffix("stamp")  # of a bag, where each has a clock of its own
            own_clock = (
                each.channel == "t"
                and topic != name
                and any(
                    other.startswith(topic) and isinstance(what, Suggestion) and what.channel != "t"
                    for other, what in found.items()
                )
            )
            claims.setdefault(name if own_clock else each.channel, []).append(name)
    doubled = {name: names for names in claims.values() if len(names) > 1 for name in names}

    def refusal(names: Sequence[str]) -> Advice:
        listed = ", ".join(repr(name) for name in names)
        return Advice(f"{listed} may all be this; keep one and ignore the others (`ignore`).")

    return {name: refusal(doubled[name]) if name in doubled else each for name, each in found.items()}


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
    units = (_facts(joint, wearer) or JointFacts(joint)).units(kind)
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
    if kind == "q" and facts is not None and not facts.sliding and column.low >= 0.0:
        for unit, turn in (("rad", 2.0 * math.pi), ("deg", 360.0)):
            beyond = replace(column, low=column.low - turn, high=column.high - turn)
            if _fits(beyond, kind, unit, 1, facts) and _moves(column, kind, unit):
                rests = f"a whole turn less in {unit} stays within the joint's limits, and is taken off"
                return Suggestion(channel.name, unit, 1, side, False, f"{why}; {rests}")
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


GRAVITY = {"m/s^2": STANDARD_GRAVITY, "g": 1.0, "mg": 1000.0, "mm/s^2": 1000.0 * STANDARD_GRAVITY}  # in each unit
NEAR = 0.1  # relative


def body_column(
    column: Seen, words: Words, kinds: tuple[str, ...], wearer: Wearer, norms: Mapping[str, float]
) -> Suggestion | Advice | None:
    """IMU and force/torque sensors: a component told by its axis. None where the name has no axis."""
    axis = axis_in(words.tokens)
    if axis is None:
        return None
    kind = axis[0]
    if not kind:
        forces = {"force": "f", "forces": "f", "torque": "m", "torques": "m", "moment": "m"}
        kind = next((forces[token] for token in words.tokens if token in forces), "")
        kind = kind or next((each for each in kinds if each in ("acc", "gyro")), "")
    if kind in ("acc", "gyro"):
        return _imu(column, kind, axis[1], words, norms)
    named = _sensor_in(words, wearer)
    if kind == "couple" and (named or {"force", "wrench"}.intersection(words.tokens)):
        kind = "m"
    if kind not in ("f", "m"):
        return None
    sensor = named or (wearer.sensors[0] if len(wearer.sensors) == 1 else None)
    if sensor is None:
        known = ", ".join(wearer.sensors) or "the robot has none, or no robot is given"
        return Advice(f"A component of a wrench, but of which sensor? ({known}) {UNKNOWN}")
    unit = words.unit or (OTHER[kind] if kind in OTHER and too_large(column, kind) else SI[kind])
    channel = parse_channel(f"ft.{sensor}.{kind}{axis[1]}")
    found = find_unit(unit)
    if found is None or found.dimension not in dimensions_of(channel):
        return Advice(f"Its name says {unit}, which is no unit of a {'force' if kind == 'f' else 'moment'}. {UNKNOWN}")
    rests = "" if words.unit else f"; the unit is not named: {unit} is usual"
    which = "the name says which sensor and axis" if named else "the robot has one sensor"
    return Suggestion(channel.name, unit, sure=bool(named and words.unit), why=f"{which}{rests}")


def _imu(column: Seen, kind: str, axis: str, words: Words, norms: Mapping[str, float]) -> Suggestion | Advice:
    channel = parse_channel(f"{kind}.{axis}")
    if words.unit is not None:
        unit = find_unit(words.unit)
        if unit is None or unit.dimension not in dimensions_of(channel):
            return Advice(f"Its name says {words.unit}, which is no unit of {channel.kind}. {UNKNOWN}")
        return Suggestion(channel.name, words.unit, sure=True, why=f"the name says {kind} along {axis}")
    size = norms.get(column.name)
    if kind == "acc" and size is not None:
        for unit_name, gravity in GRAVITY.items():
            if abs(size / gravity - 1.0) < NEAR:
                return Suggestion(
                    channel.name, unit_name, sure=True, why=f"its usual size is {size:.4g}: gravity in {unit_name}"
                )
        return Advice(
            f"Its usual size, {size:.4g}, is gravity in no unit. Give its unit, and check that gravity is in it."
        )
    unit_name = OTHER[kind] if kind in OTHER and too_large(column, kind) else SI[kind]
    return Suggestion(channel.name, unit_name, why=f"the unit is not named: {unit_name} is usual")


def _of_three(column: Seen, kind: str, axis: str, norms: Mapping[str, float]) -> Suggestion | Advice:
    found = _imu(column, kind, axis, words_of(column.name), norms)
    why = "three are numbered: taken for x, y and z"
    return replace(found, sure=False, why=f"{why}; {found.why}") if isinstance(found, Suggestion) else found


def _sensor_in(words: Words, wearer: Wearer) -> str | None:
    if wearer.sole is not None:
        return wearer.sole
    for sensor in sorted(wearer.sensors, key=len, reverse=True):
        if within(tokens_of(sensor), words.tokens) is not None:
            return sensor
    if wearer.joints is not None:
        return None
    rest = [token for token in words.tokens if token not in FILLERS | set(KIND_OF) and axis_in((token,)) is None]
    return "_".join(rest) or None
