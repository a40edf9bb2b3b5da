"""What the columns of foreign files mean: quantity, unit, sign, frame, order, side of the gear, and clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, final

import numpy as np

from exogauge.criteria.logs import LOGS
from exogauge.errors import BadLog, Fault
from exogauge.logs.model import Array
from exogauge.logs.tables import TextLayout

Side = Literal["joint", "motor"]
Order = Literal["force_first", "couple_first"]


@final
@dataclass(frozen=True)
class Source:
    """Where the components of a rule lie: either named columns, or one two-dimensional dataset.

    time_axis: which axis of the dataset counts samples; None where the number of components tells.
    """

    columns: tuple[str, ...] = ()
    dataset: str | None = None
    time_axis: Literal["first", "last"] | None = None

    def __post_init__(self) -> None:
        if bool(self.columns) == (self.dataset is not None):
            raise ValueError("give either columns or a dataset")

    @property
    def names(self) -> tuple[str, ...]:
        return self.columns if self.dataset is None else (self.dataset,)


@final
@dataclass(frozen=True)
class Values:
    """Components that become one contract channel each: si = sign · scale · unit(value), then gear, then + offset.

    offset: [SI unit of the channel], joint-side. side: motor = the robot's motor_from_joint matrix lies between.
    """

    source: Source
    channels: tuple[str, ...]
    unit: str
    sign: float = 1.0
    scale: float = 1.0
    offset: float = 0.0
    side: Side = "joint"


@final
@dataclass(frozen=True)
class Vector:
    """Three components of `acc` or `gyro`. rotation: 3 x 3, rows; contract vector = rotation @ logged vector."""

    source: Source
    channel: Literal["acc", "gyro"]
    unit: str
    sign: float = 1.0
    scale: float = 1.0
    rotation: tuple[tuple[float, ...], ...] | None = None


@final
@dataclass(frozen=True)
class Wrench:
    """Six components of one force/torque sensor, force and moment both about the sensor frame's origin."""

    source: Source
    sensor: str
    order: Order
    force_unit: str = "N"
    moment_unit: str = "Nm"
    sign: float = 1.0
    rotation: tuple[tuple[float, ...], ...] | None = None


Rule = Values | Vector | Wrench


@final
@dataclass(frozen=True)
class Clock:
    """Either a time column with its unit, or a constant rate from the first row on.

    delay_s: by how much the stamps are late [s]; subtracted.
    """

    column: str | None = None
    unit: str = "s"
    rate_hz: float | None = None
    delay_s: float = 0.0

    def __post_init__(self) -> None:
        if (self.column is None) == (self.rate_hz is None):
            raise ValueError("give either a time column or rate_hz")


@final
@dataclass(frozen=True)
class FileMapping:
    """One file. file: name, or pattern with * and ?, that exactly one handed-in file matches.

    ignore: columns left out on purpose; None = all that no rule names.
    """

    file: str
    clock: Clock
    rules: tuple[Rule, ...]
    ignore: tuple[str, ...] | None = ()
    layout: TextLayout = field(default_factory=TextLayout)

    @property
    def used(self) -> tuple[str, ...]:
        """Names of the columns that rules or the clock read, in order, each once."""
        names = [name for rule in self.rules for name in rule.source.names]
        return tuple(dict.fromkeys([*names, *([self.clock.column] if self.clock.column else [])]))


@final
@dataclass(frozen=True)
class LogMapping:
    """One log out of one or several files. rate_hz: of the common clock, where the files' clocks differ.

    constants: (channel, value [its SI unit, joint side]) of what no file holds and the user sets on purpose.
    """

    files: tuple[FileMapping, ...]
    rate_hz: float | None = None
    constants: tuple[tuple[str, float], ...] = ()

    @staticmethod
    def from_plain(plain: Mapping[str, Any]) -> LogMapping:
        """From what `dataclasses.asdict` and JSON make of a mapping; the inverse of `to_plain`."""
        constants = tuple((str(name), float(value)) for name, value in plain.get("constants", ()))
        return LogMapping(tuple(_file(each) for each in plain["files"]), plain["rate_hz"], constants)

    def to_plain(self) -> dict[str, Any]:
        return {
            "rate_hz": self.rate_hz,
            "constants": self.constants,
            "files": [
                {
                    "file": each.file,
                    "clock": vars(each.clock),
                    "ignore": each.ignore,
                    "layout": vars(each.layout),
                    "rules": [
                        {"kind": type(rule).__name__, **vars(rule), "source": vars(rule.source)} for rule in each.rules
                    ],
                }
                for each in self.files
            ],
        }


def check_rotation(rows: Sequence[Sequence[float]], file: str | None = None, column: str | None = None) -> Array:
    """(3, 3) proper rotation; anything else (a mirror, a scaled matrix) is a BadLog."""
    try:
        R = np.array(rows, dtype=np.float64)
    except (ValueError, TypeError):
        R = np.empty(0)
    if R.shape == (3, 3) and np.isfinite(R).all() and np.allclose(R @ R.T, np.eye(3), atol=LOGS.rotation):
        if np.linalg.det(R) > 0.0:
            return R
        detail = "the matrix mirrors (determinant -1) instead of rotating"
    else:
        detail = "the matrix is no 3 x 3 rotation"
    advice = "Row i holds the contract frame's axis i in the log's frame; check signs and order."
    raise BadLog(Fault(detail, "not_a_rotation", advice, file, column=column))


def _file(plain: Mapping[str, Any]) -> FileMapping:
    return FileMapping(
        plain["file"],
        Clock(**plain["clock"]),
        tuple(_rule(dict(rule)) for rule in plain["rules"]),
        None if plain["ignore"] is None else tuple(plain["ignore"]),
        TextLayout(**plain["layout"]),
    )


def _rule(plain: dict[str, Any]) -> Rule:
    kind = {"Values": Values, "Vector": Vector, "Wrench": Wrench}[plain.pop("kind")]
    source = dict(plain["source"])
    plain["source"] = Source(**{**source, "columns": tuple(source["columns"])})
    if plain.get("rotation") is not None:
        plain["rotation"] = tuple(tuple(row) for row in plain["rotation"])
    if "channels" in plain:
        plain["channels"] = tuple(plain["channels"])
    rule: Rule = kind(**plain)
    return rule
