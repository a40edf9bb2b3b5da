"""The names of a log's channels: `q.<joint>`, `acc.x`, `ft.<sensor>.fz` … and what each one measures."""

from __future__ import annotations

import difflib
from dataclasses import dataclass
from typing import Literal, final

from exogauge.errors import BadLog, Fault

Kind = Literal["t", "q", "dq", "ddq", "i", "tau", "acc", "gyro", "ft", "temp", "base"]

JOINT_UNITS: dict[Kind, str] = {"q": "rad", "dq": "rad/s", "ddq": "rad/s²", "i": "A", "tau": "N·m", "temp": "°C"}
VECTOR_UNITS: dict[Kind, str] = {"acc": "m/s²", "gyro": "rad/s"}
WRENCH_AXES = ("fx", "fy", "fz", "mx", "my", "mz")
BASE_UNITS = {"x": "m", "y": "m", "z": "m", "qx": "1", "qy": "1", "qz": "1", "qw": "1"}
FORMS = (
    "t",
    *(f"{kind}.<joint>" for kind in JOINT_UNITS),
    *(f"{kind}.x|y|z" for kind in VECTOR_UNITS),
    "ft.<sensor>.fx|fy|fz|mx|my|mz",
    "base.x|y|z|qx|qy|qz|qw",
)


@final
@dataclass(frozen=True)
class Channel:
    """One parsed channel name.

    subject: joint or sensor name, empty for `t`, IMU and base channels. axis: `x` …, `fx` …, `qw`, empty for joints.
    unit: the SI unit of its values; of a prismatic joint rad reads m and N·m reads N.
    """

    name: str
    kind: Kind
    subject: str
    axis: str
    unit: str

    @property
    def of_joint(self) -> bool:
        return self.kind in JOINT_UNITS


def parse_channel(name: str, file: str | None = None) -> Channel:
    """The channel a column name stands for; a name outside the contract is a BadLog with a suggestion."""
    channel = _parse(name)
    if channel is None:
        raise BadLog(
            Fault(
                f"{shorten(name)!r} is not a channel name",
                "unknown_channel",
                suggestion(name),
                file=file,
                column=shorten(name),
            )
        )
    return channel


def _parse(name: str) -> Channel | None:
    name_length = 200
    if len(name) > name_length or not name.isprintable():
        return None
    if name == "t":
        return Channel(name, "t", "", "", "s")
    kind, _, rest = name.partition(".")
    subject, _, axis = rest.rpartition(".")
    for joint_kind, unit in JOINT_UNITS.items():
        if kind == joint_kind and rest.strip() == rest != "":
            return Channel(name, joint_kind, rest, "", unit)
    for vector_kind, unit in VECTOR_UNITS.items():
        if kind == vector_kind and rest in ("x", "y", "z"):
            return Channel(name, vector_kind, "", rest, unit)
    if kind == "base" and rest in BASE_UNITS:
        return Channel(name, "base", "", rest, BASE_UNITS[rest])
    if kind == "ft" and axis in WRENCH_AXES and subject.strip() == subject != "":
        return Channel(name, "ft", subject, axis, "N" if axis[0] == "f" else "N·m")
    return None


def suggestion(name: str) -> str:
    """What the user may have meant, else the list of forms and the way in for other names."""
    kind, dot, rest = name.strip().partition(".")
    kinds = ["t", *JOINT_UNITS, *VECTOR_UNITS, "ft", "base"]
    aliases = {
        "time": "t", "timestamp": "t", "pos": "q", "position": "q", "vel": "dq", "qd": "dq", "velocity": "dq",
        "qdd": "ddq", "current": "i", "cur": "i", "torque": "tau", "effort": "tau", "imu": "acc", "accel": "acc",
        "omega": "gyro", "force": "ft", "wrench": "ft", "temperature": "temp",
    }  # fmt: skip
    near = aliases.get(kind.lower()) or next(iter(difflib.get_close_matches(kind.lower(), kinds, 1, 0.6)), None)
    if near:
        if near == "t":
            return "Did you mean 't'?"
        axes = {"ft": WRENCH_AXES, "base": tuple(BASE_UNITS), "acc": ("x", "y", "z"), "gyro": ("x", "y", "z")}.get(near)
        form = f"{near}.{rest}" if dot and not axes else next(f for f in FORMS if f.startswith(f"{near}."))
        return f"Did you mean {shorten(form)!r}? Columns with names of their own come in through a mapping."
    return f"Channels are {', '.join(FORMS)}. Columns with names of their own come in through a mapping."


def shorten(text: str, length: int = 80) -> str:
    """Text of a user made fit for a message: printable and short."""
    shown = "".join(sign if sign.isprintable() else "\N{REPLACEMENT CHARACTER}" for sign in text[: length + 1])
    return shown if len(shown) <= length else shown[: length - 1] + "…"
