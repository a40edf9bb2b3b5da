"""What can be hidden in a payload recording: one `EFFECT@PLACE` per effect, its size drawn from the seed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from exogauge.errors import BadInput, Fault

Array = NDArray[np.float64]

CHANNELS = ("fx", "fy", "fz", "mx", "my", "mz")
LOGS = ("excitation", "fast", "slow")
PAIRS = tuple(f"{read}_{of}" for read in CHANNELS for of in CHANNELS if read != of)
PLACES: Mapping[str, tuple[str, ...]] = {
    "zero_step": LOGS,  # the zero jumps in the middle of this log
    "zero_of_log": LOGS,  # the zero is another one throughout this log
    "zero_drift": ("sensor",),  # it moves on through every log, as a sensor that warms up does
    "crosstalk": PAIRS,  # mx_fy: mx reads a share of what fy reads
    "gain": CHANNELS,
    "delay": ("sensor",),  # the wrench is late
    "spring": ("suckers",),  # the whole payload gives way along x and y of the sensor
    "second_body": ("payload",),  # a part of it hangs on springs
    "hose": ("payload",),  # a spring to a point of the cell; it stands in no list of what may be missing
}


@final
@dataclass(frozen=True)
class Hidden:
    """effect, place: as asked for; values: the drawn size, SI units."""

    effect: str
    place: str
    values: Mapping[str, float | list[float]]


def parse_hidden(specs: Sequence[str], rng: np.random.Generator) -> list[Hidden]:
    """Effects with sizes drawn by rng; BadInput for an unknown effect or place, naming the known ones."""
    out = []
    for spec in specs:
        effect, _, place = spec.partition("@")
        known = PLACES.get(effect)
        if known is None:
            raise _refusal(f"{effect!r} cannot be hidden in a payload recording", spec, tuple(PLACES))
        place = place or known[0]
        if place not in known:
            raise _refusal(f"{effect} does not happen at {place!r}", spec, known)
        out.append(Hidden(effect, place, _drawn(effect, place, rng)))
    return out


def _drawn(effect: str, place: str, rng: np.random.Generator) -> dict[str, float | list[float]]:
    def sized(force: float, moment: float) -> list[float]:
        size = rng.uniform(0.5, 1.5, 6) * rng.choice([-1.0, 1.0], 6)
        return list(size * np.repeat([force, moment], 3))

    sign = float(rng.choice([-1.0, 1.0]))
    if effect in ("zero_step", "zero_of_log"):
        return {"wrench": sized(2.0, 0.2)}
    if effect == "zero_drift":
        return {"rate": sized(0.3, 0.03)}
    if effect == "crosstalk":
        read, of = place.split("_")
        scale = {"ff": 0.02, "mm": 0.05, "fm": 0.2, "mf": 0.005}[read[0] + of[0]]
        return {"share": sign * scale * rng.uniform(0.7, 1.5)}
    if effect == "gain":
        return {"share": sign * rng.uniform(0.015, 0.04)}
    if effect == "delay":
        return {"seconds": rng.uniform(0.004, 0.012)}
    if effect == "spring":
        return {"stiffness": rng.uniform(4e4, 9e4), "damping_ratio": rng.uniform(0.5, 0.8)}
    if effect == "second_body":
        point = rng.uniform([-0.4, -0.4, 0.05], [0.4, 0.4, 0.3])
        return {"mass": rng.uniform(2.0, 4.0), "point": list(point), "frequency_hz": rng.uniform(2.5, 4.0),
                "damping_ratio": rng.uniform(0.1, 0.3)}  # fmt: skip
    return {"stiffness": rng.uniform(20.0, 40.0), "point": [0.3, 0.2, 0.1]}


def of(hidden: Sequence[Hidden], effect: str) -> Hidden | None:
    return next((each for each in hidden if each.effect == effect), None)


def as_read(wrench: Array, time: Array, log: str, hidden: Sequence[Hidden]) -> Array:
    """(T, 6) what the sensor makes of it: late, with shares of other channels, with another zero."""
    out = wrench.copy()
    late = of(hidden, "delay")
    if late is not None:
        seconds = float(late.values["seconds"])  # type: ignore[arg-type]
        out = np.asarray(CubicSpline(time, out)(np.maximum(time - seconds, time[0])))
    matrix = np.eye(6)
    for each in hidden:
        if each.effect == "crosstalk":
            read, of_ = (CHANNELS.index(name) for name in each.place.split("_"))
            matrix[read, of_] += float(each.values["share"])  # type: ignore[arg-type]
        elif each.effect == "gain":
            k = CHANNELS.index(each.place)
            matrix[k, k] += float(each.values["share"])  # type: ignore[arg-type]
    out = out @ matrix.T
    for each in hidden:
        if each.effect == "zero_step" and each.place == log:
            out[time >= time.mean()] += np.array(each.values["wrench"])
        elif each.effect == "zero_of_log" and each.place == log:
            out += np.array(each.values["wrench"])
        elif each.effect == "zero_drift" and log != "postures":
            out += np.outer(time, np.array(each.values["rate"]))
    return out


def _refusal(detail: str, value: str, known: Sequence[str]) -> BadInput:
    return BadInput(Fault(detail, "unknown_effect", f"It must be one of {', '.join(known)}.", value=value))
