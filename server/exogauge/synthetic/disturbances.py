"""What a laboratory does to a recording, each a switch with a size of its own: the catalogue, and the words to ask."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

from exogauge.errors import BadInput, Fault

Disturbances = Mapping[str, float]  # size by name, SI units; what is not in it does not happen

_UNITS: Mapping[str, Mapping[str, float]] = {  # what may stand behind a number, by the SI unit that it is worth
    "1": {"%": 0.01},
    "rad": {"rad": 1.0, "mrad": 1e-3, "urad": 1e-6, "deg": math.pi / 180.0},
    "m": {"m": 1.0, "mm": 1e-3},
    "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6},
    "N": {"N": 1.0},
}
_SI = {unit: si for si, units in _UNITS.items() for unit in units}


@final
@dataclass(frozen=True)
class Disturbance:
    """value, unit: its size in the laboratory sample, and where it is asked for without one. meaning: of that size."""

    name: str
    value: float
    unit: str
    meaning: str
    in_lab: bool = True

    @property
    def si(self) -> str:
        """The unit of `size`."""
        return _SI[self.unit]

    @property
    def size(self) -> float:
        return self.value * _UNITS[self.si][self.unit]


CATALOGUE = (
    Disturbance("runs_differ", 3, "mrad", "rms by which two runs of a motion differ at every joint, smoothly"),
    Disturbance("runs_amplitude", 1, "%", "std of a run's amplitude"),
    Disturbance("runs_timing", 5, "ms", "rms by which a run is ahead of or behind the plan, smoothly"),
    Disturbance("runs_offset", 3, "mrad", "rms by which two runs differ at every joint, by a constant", in_lab=False),
    Disturbance("encoder_steps", 3.8, "urad", "one count of every encoder, for the controller and in the log"),
    Disturbance("encoder_zeros", 2, "mrad", "std of each encoder's zero, in the log"),
    Disturbance("kt_warming", 2, "%", "k_T falls by 0.5 to 1.5 times this over the session, each joint's own"),
    Disturbance("friction_warming", 10, "%", "the same of k_d; Coulomb friction falls by half as much"),
    Disturbance(
        "load_friction",
        5,
        "%",
        "Coulomb friction grows by 0.6 to 1.4 times this of the torque passed on",
        in_lab=False,
    ),
    Disturbance("feet_gain", 3, "%", "both feet read so much more", in_lab=False),
    Disturbance("foot_gains", 2, "%", "std of a foot sensor's gain; 0.8 of it common to both, 0.6 its own"),
    Disturbance("feet_drift", 5, "N", "zeros drift by 0.5 to 1 times this over the session; moments by 0.2 m of it"),
    Disturbance("feet_tilt", 0.2, "deg", "std of a foot sensor's tilt about each axis"),
    Disturbance("feet_place", 1, "mm", "std of where a foot's sensor measures, along each axis, beside its frame"),
    Disturbance("imu_mounting", 0.5, "deg", "tilt of the IMU, to a random side, from where the URDF has it"),
    Disturbance("via_points", 5, "mm", "std of each coordinate of the via points as the device file states them"),
    Disturbance("donning", 3, "mm", "std of the bands' ends, each time the suit is put on; natural length 2/3 of it"),
    Disturbance("streams_late", 1, "ms", "std by which each foot's sensor, and the IMU, is told later than all else"),
    Disturbance("clock_jitter", 50, "us", "std of a time stamp about the even clock of the samples"),
)
BY_NAME = {each.name: each for each in CATALOGUE}

_OF_THE_ROBOT = ("kt_warming", "feet_gain", "feet_drift", "via_points", "load_friction")
TOGETHER = {  # several under one name
    "all_smooth": ("runs_differ", *_OF_THE_ROBOT),
    "all_offset": ("runs_offset", *_OF_THE_ROBOT),
}

IDEAL: Disturbances = {}
LAB: Disturbances = {each.name: each.size for each in CATALOGUE if each.in_lab}
REALISM: Mapping[str, Disturbances] = {"lab": LAB, "ideal": IDEAL}
DEFAULT = "lab"


def chosen(realism: str = DEFAULT, added: Sequence[str] = (), left_out: Sequence[str] = ()) -> Disturbances:
    """What happens: that of `realism`, with `NAME` or `NAME=SIZE` added or resized, and without the names left out.

    SIZE is a number in SI units or with a unit: 0.03, 3%, 3mrad, 0.5deg, 5mm, 5N, 50us. BadInput names what is known.
    """
    if realism not in REALISM:
        raise _refusal(f"no sample is made as {realism!r}", "unknown_realism", "realism", realism, REALISM)
    sizes = dict(REALISM[realism])
    for word in added:
        name, given, size = word.partition("=")
        for one in _names(name, "with"):
            sizes[one] = _size(BY_NAME[one], size, word) if given else BY_NAME[one].size
    for word in left_out:
        for one in _names(word, "without"):
            sizes.pop(one, None)
    return {name: sizes[name] for name in BY_NAME if sizes.get(name)}


def table() -> str:
    """The catalogue as text, one line each, for a terminal."""
    lines = [f"  {d.name:17}{f'{d.value:g} {d.unit}':12}{'lab' if d.in_lab else '':5}{d.meaning}" for d in CATALOGUE]
    return "\n".join([*lines, *(f"  {name:17}{', '.join(parts)}" for name, parts in TOGETHER.items())])


def _names(name: str, option: str) -> tuple[str, ...]:
    name = name.strip()
    if name in TOGETHER:
        return TOGETHER[name]
    if name not in BY_NAME:
        detail = f"no disturbance is called {name!r}"
        raise _refusal(detail, "unknown_disturbance", option, name, [*BY_NAME, *TOGETHER])
    return (name,)


def _size(of: Disturbance, text: str, word: str) -> float:
    match = re.fullmatch(r"\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*([a-zA-Z%]*)\s*", text)
    units = {"": 1.0, **_UNITS[of.si]}
    if match is None or match[2] not in units:
        detail = f"{text!r} is no size of {of.name}"
        raise _refusal(detail, "disturbance_size", "with", word, [unit for unit in units if unit])
    try:
        size = float(match[1]) * units[match[2]]
    except ValueError:
        raise _refusal(f"{match[1]!r} is no number", "disturbance_size", "with", word, []) from None
    if size < 0.0 and of.name != "feet_gain":
        raise _refusal(f"the size of {of.name} is a magnitude, 0 or more", "disturbance_size", "with", word, [])
    return size


def _refusal(detail: str, rule: str, column: str, value: str, known: Sequence[str] | Mapping[str, object]) -> BadInput:
    advice = f"Known: {', '.join(known)}" if known else ""
    return BadInput(Fault(detail, rule, advice, column=column, value=value))
