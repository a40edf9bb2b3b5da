"""Words in the name of a foreign column: its quantity, unit, axis, and what is left to name a joint or a sensor.

What is known of a foreign column and of its robot, and what is said of the column: a suggestion or advice.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, final

from exogauge.logs.units import find_unit
from exogauge.studies.import_log.other_languages import in_english, spaced

QUANTITIES: dict[str, tuple[str, ...]] = {
    "t": ("t", "time", "timestamp", "timestamps", "stamp", "clock", "clk"),
    "q": ("q", "qpos", "pos", "position", "positions", "angle", "angles", "theta", "enc", "encoder"),
    "dq": ("dq", "qd", "qdot", "dtheta", "thetadot", "qvel", "vel", "velocity", "velocities", "speed", "speeds"),
    "ddq": ("ddq", "qdd", "qddot", "qacc"),
    "i": ("i", "iq", "cur", "curr", "current", "currents", "amps"),
    "tau": ("tau", "torque", "torques", "trq", "effort", "efforts"),
    "acc": ("acc", "accel", "acceleration", "accelerometer"),
    "gyro": ("gyro", "gyr", "gyroscope", "omega", "angvel"),
    "temp": ("temp", "temperature", "temperatures"),
}  # fmt: skip
KIND_OF = {word: kind for kind, words in QUANTITIES.items() for word in words}
COMMANDED = {
    "cmd",
    "command",
    "commanded",
    "des",
    "desired",
    "ref",
    "reference",
    "target",
    "goal",
    "setpoint",
    "planned",
    "cmptd",
    "computed",
    "requested",
    "action",
}
OF_A_MODEL = {  # no whole torque
    "ext", "external", "ff", "feedforward", "gravity", "grav", "coriolis", "residual", "friction", "fric", "model",
    "modelled", "modeled", "predicted", "disturbance", "dist",
}  # fmt: skip
BESIDE_IT = {  # no value of the quantity itself
    "error", "errors", "err", "limit", "limits", "min", "max", "std", "stddev", "variance", "var", "covariance", "bias",
    "offset", "init", "initial", "gradient", "gain", "tolerance", "threshold", "counts", "count", "ticks", "adc", "pct",
    "percent", "bus", "supply", "battery",
}  # fmt: skip
OF_TOOL = {"tcp", "tool", "ee", "eef", "cartesian", "pose"}  # six numbers of it are no joints'
FILLERS = {
    "axis", "axes", "ax", "joint", "joints", "jnt", "j",
    "state", "states", "measured", "meas", "actual", "act", "fb", "feedback", "data",
    "robot", "raw", "value", "values", "sensor", "sensors", "imu", "motor", "motors", "rotor", "read", "header", "link",
    "linear", "angular", "ft", "wrench", "force", "forces", "log", "recv", "sec", "secs", "of", "the",
}  # fmt: skip
MOTOR = {"motor", "motors", "rotor"}
SPELLED = {
    "degree": "deg", "degrees": "deg", "radian": "rad", "radians": "rad", "seconds": "s", "sec": "s", "secs": "s",
    "msec": "ms", "millis": "ms", "milliseconds": "ms", "usec": "us", "micros": "us", "microseconds": "us",
    "nsec": "ns", "nsecs": "ns", "nanos": "ns", "nanoseconds": "ns", "celsius": "degC", "degc": "degC", "kelvin": "K",
    "grad": "deg", "grad/s": "deg/s", "u/min": "rpm", "1/min": "rpm", "sek": "s",
    "nm": "Nm", "mnm": "mNm", "ma": "mA", "ampere": "A", "amperes": "A", "newton": "N", "rads": "rad/s",
    "degs": "deg/s", "dps": "deg/s", "ms2": "m/s^2",
    **{f"{unit}{per}{after}": f"{unit}/{second}" for unit in ("deg", "rad", "mrad", "rev", "m", "mm")
       for per in ("p", "per") for after, second in (("s", "s"), ("sec", "s"), ("s2", "s^2"), ("sec2", "s^2"))},
}  # fmt: skip
TRAILING = {"deg", "rad", "mrad", "rpm", "ms", "us", "ns", "mm", "cm"}  # units that are told without brackets
KNOWN = frozenset((*KIND_OF, *COMMANDED, *FILLERS))
AXIS = re.compile(r"^(?:(?P<kind>acc|accel|a|gyro|gyr|g|w|omega|force|f|torque|moment|m|t|n|c)_?)?(?P<axis>[xyz])$")
AXIS_KIND = {
    "acc": "acc", "accel": "acc", "a": "acc", "gyro": "gyro", "gyr": "gyro", "g": "gyro", "w": "gyro",
    "omega": "gyro", "force": "f", "f": "f", "torque": "m", "moment": "m", "m": "m", "t": "m", "n": "m",
    "c": "couple",  # of a sensor that is named, or it is a centre
}  # fmt: skip


@final
@dataclass(frozen=True)
class Words:
    """tokens: what the name says beside the unit. unit: as it is written there, None where it is not."""

    tokens: tuple[str, ...]
    unit: str | None

    @property
    def commanded(self) -> bool:
        """By a word; or by a `d` behind the quantity: `tau_J_d`, `q_d[3]`."""
        bare = [token for token in self.tokens if not token.isdecimal()]
        desired = bare[-1:] == ["d"] and any(token in KIND_OF for token in bare[:-1])
        return desired or bool(COMMANDED & set(bare))

    @property
    def of_a_model(self) -> bool:
        return bool(OF_A_MODEL & set(self.tokens))

    @property
    def motor_side(self) -> bool:
        return bool(MOTOR & set(self.tokens))


def words_of(name: str) -> Words:
    """Of `torso_pitch_vel [deg/s]`: torso, pitch, vel; deg/s."""
    bare, unit = name, None
    bracket = re.search(r"[\[(]([^\])]+)[\])]\s*$", name)
    if bracket and not bracket.group(1).isdecimal() and (found := known_unit(bracket.group(1))):
        bare, unit = name[: bracket.start()], found
    tail = re.search(r"[_\s]([A-Za-z]{2,}|N)$", bare)
    if unit is None and tail and find_unit(tail.group(1)) is not None:  # `_mA`, which small letters would not tell
        bare, unit = bare[: tail.start()], tail.group(1)
    squared = re.search(r"[_\s]([A-Za-z]+2)$", bare)
    if unit is None and squared and (found := known_unit(squared.group(1))):  # `_mps2`, no word and a number
        bare, unit = bare[: squared.start()], found
    tokens = (*tokens_of(bare), *(("percent",) if "%" in bare else ()))
    alone = SPELLED.get(tokens[0], tokens[0] if tokens[0] != "s" else "") if len(tokens) == 1 else ""
    if unit is None and alone in ("s", "ms", "us", "ns"):  # `sec`; a letter alone may be anything
        return Words(("time",), known_unit(tokens[0]))
    if unit is None and len(tokens) > 2 and tokens[-2:] in (("deg", "s"), ("rad", "s"), ("m", "s")):
        tokens, unit = tokens[:-2], known_unit("/".join(tokens[-2:]))
    elif unit is None and len(tokens) > 1 and (tokens[-1] in TRAILING or tokens[-1] in SPELLED):
        tokens, unit = tokens[:-1], known_unit(tokens[-1])
    return Words(tokens, unit)


def tokens_of(name: str) -> tuple[str, ...]:
    """English words in small letters: split at signs, before capitals, and between letters and digits."""
    apart = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", spaced(name))
    tokens = re.findall(r"[^\W\d_]+|\d+", apart.lower())
    if tokens == ["temps"]:  # time in French; beside other words temperatures
        return ("time",)
    return tuple(word for token in tokens for word in in_english(token, KNOWN))


def known_unit(text: str) -> str | None:
    plain = SPELLED.get(text.strip().lower(), text.strip())
    return plain if find_unit(plain) is not None else None


def kinds_in(tokens: Sequence[str]) -> tuple[str, ...]:
    """Quantities that the words name, each once."""
    found = tuple(dict.fromkeys(KIND_OF[token] for token in tokens if token in KIND_OF))
    if set(found) == {"i", "q"} and "q" in tokens:  # `current_q`, which gives the torque, beside `current_d`
        return ("i",)
    if found == ("q",) and {"dot", "ddot"}.intersection(tokens):
        return ("dq",) if "dot" in tokens else ("ddq",)
    if "angular" in tokens and "dq" in found:
        return ("gyro",)
    if "linear" in tokens and "acc" in found:
        return ("acc",)
    if not found and {"axis", "act"} <= set(tokens):  # KUKA's `$AXIS_ACT`
        return ("q",)
    if not found and {"qfrc", "actuator"} <= set(tokens):  # MuJoCo's, at the joint; `actuator_force` is before a gear
        return ("tau",)
    return found


def axis_in(tokens: Sequence[str]) -> tuple[str, str] | None:
    """(acc, gyro, f, m or nothing; x, y or z) where a word names an axis: `accx`, `fz`, `z`."""
    for token in reversed(tokens):
        if found := AXIS.match(token):
            return AXIS_KIND.get(found["kind"] or "", ""), found["axis"]
    return None


def numbered(names: Iterable[str]) -> Iterator[tuple[tuple[str, ...], dict[int, str]]]:
    """(words with `#` for a number, number -> name) of the names that are alike but for it. Of several numbers in a
    name each may be the one that counts: `ROB_1 axis 3`."""
    series: dict[tuple[str, ...], dict[int, str]] = {}
    for name in names:
        tokens = words_of(name).tokens
        for k, token in enumerate(tokens):
            if token.isdecimal():
                series.setdefault((*tokens[:k], "#", *tokens[k + 1 :]), {})[int(token)] = name
    yield from series.items()


def counts(places: Iterable[int], many: int) -> bool:
    """Whether they go from 0 or from 1 on, one after the other."""
    return sorted(places) in (list(range(many)), list(range(1, many + 1)))


def axes_by_number(names: Iterable[str]) -> dict[str, tuple[str, str]]:
    """Name -> (acc or gyro; x, y or z), of three that are numbered: `imu.gyroscope[2]`."""
    found = dict[str, tuple[str, str]]()
    for tokens, members in numbered(names):
        kinds = kinds_in(tokens)
        if kinds in (("acc",), ("gyro",)) and counts(members, 3):
            found |= {members[place]: (kinds[0], axis) for place, axis in zip(sorted(members), "xyz", strict=True)}
    return found


SIDES = {"l": "left", "r": "right"}


def within(inner: Sequence[str], outer: Sequence[str]) -> tuple[str, ...] | None:
    """What is left of `outer` when `inner` is taken out of it in one piece; None where it is not there. A side may be
    written as one letter."""
    width, own = len(inner), [SIDES.get(token, token) for token in inner]
    for start in range(len(outer) - width + 1):
        if [SIDES.get(token, token) for token in outer[start : start + width]] == own:
            return (*outer[:start], *outer[start + width :])
    return None


UNKNOWN = "Say what it measures (channel and unit), or ignore it (`ignore`)."
SI = {"q": "rad", "dq": "rad/s", "ddq": "rad/s^2", "i": "A", "tau": "Nm", "acc": "m/s^2", "gyro": "rad/s",
      "temp": "degC", "f": "N", "m": "Nm"}  # fmt: skip
OTHER = {"q": "deg", "dq": "deg/s", "i": "mA", "tau": "mNm", "gyro": "deg/s", "m": "mNm"}  # what it may be as well
SLIDING = {"q": ("m", "mm"), "dq": ("m/s", "mm/s"), "ddq": ("m/s^2",), "tau": ("N", "mN")}
LARGE = {"q": 7.0, "dq": 40.0, "i": 200.0, "tau": 2000.0, "gyro": 35.0, "m": 2000.0}  # beyond what SI units give


@final
@dataclass(frozen=True)
class Seen:
    """One column. low, high: of its finite values. step: median difference, where it rises throughout, else None."""

    name: str
    low: float
    high: float
    step: float | None = None

    @property
    def size(self) -> float:
        return max(abs(self.low), abs(self.high))


@final
@dataclass(frozen=True)
class JointFacts:
    """lower, upper: [rad or m]; velocity: [rad/s or m/s]; infinite where unknown. sliding: it does not turn."""

    name: str
    lower: float = -math.inf
    upper: float = math.inf
    velocity: float = math.inf
    sliding: bool = False

    def units(self, kind: str) -> tuple[str, ...]:
        """In which a quantity of it is usually written: SI, then what it may be as well."""
        turning = tuple(unit for unit in (SI[kind], OTHER.get(kind)) if unit)
        return SLIDING.get(kind, turning) if self.sliding else turning


@final
@dataclass(frozen=True)
class Wearer:
    """What is known of the robot; joints None where no robot is named. sole: the sensor of every wrench, if it is known
    that there is no other."""

    joints: tuple[JointFacts, ...] | None = None
    sensors: tuple[str, ...] = ()
    sole: str | None = None


@final
@dataclass(frozen=True)
class Suggestion:
    """channel: contract name, `t` for the time. why: what it rests on, in a sentence; sure: nothing else fits."""

    channel: str
    unit: str
    sign: Literal[1, -1] = 1
    side: Literal["joint", "motor"] = "joint"
    sure: bool = False
    why: str = ""


@final
@dataclass(frozen=True)
class Advice:
    """Why there is no suggestion, and what to do."""

    text: str


def too_large(column: Seen, kind: str) -> bool:
    """For the SI unit, by what joints and sensors do."""
    return column.size > LARGE.get(kind, math.inf)
