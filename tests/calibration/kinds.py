"""Which numbers of a result have a truth to be held against, by kind."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, final

from scipy.stats import norm

LINK, JOINT = "link parameters", "joint parameters"
LEVELS = (0.5, 0.8, 0.95)


@final
@dataclass(frozen=True)
class Told:
    """A number of which something is claimed. kind: of which it is one; std: one standard deviation; low, high: its
    95 % interval where one is told; told: whether the result calls it identifiable."""

    kind: str
    name: str
    value: float
    std: float
    truth: float
    told: bool
    interval: tuple[float, float] | None = None

    def inside(self, level: float) -> bool:
        if level == LEVELS[-1] and self.interval is not None:
            return self.interval[0] <= self.truth <= self.interval[1]
        return self.inside_of_normal(level)

    def inside_of_normal(self, level: float) -> bool:
        return abs(self.value - self.truth) <= float(norm.ppf(0.5 + 0.5 * level)) * self.std


def told(results: dict[str, Any], truth: dict[str, Any]) -> Iterator[Told]:
    """Parameters that the data decide; bands, and peak and mean of the supporting torque, by every approach that looks
    at the logs and by the one that the headline is of. truth: `truth.json`, with `torque` of `true_torque`."""
    joints = {f"{name}[{joint}]": value for joint, own in truth["joints"].items() for name, value in own.items()}
    for each in results["identification"]["parameters"]:
        name = each["name"]
        true = truth["parameters"].get(name, joints.get(name))
        if true is None or not each["std"] or each["value"] is None:
            continue
        kind = "k_T" if name.startswith("k_T[") else JOINT if name in joints else LINK
        yield Told(kind, name, each["value"], each["std"], true, each["identifiable"])
    for each in results["stiffness"]:
        if each["approach"] == "prior":
            continue
        own = truth["devices"][each["device"]][each["band"]]
        pairs = (
            ("stiffness", "stiffness_n_per_m", "identifiable"),
            ("length", "natural_length_m", "length_identifiable"),
        )
        for what, key, decided in pairs:
            number, interval = each[key], each["interval_95"][key]
            if number["value"] is not None and number["std"] and None not in interval:
                name, (low, high) = f"{what}[{each['band']}]", interval
                for by in (each["approach"], *(["headline"] if each["headline"] else [])):
                    yield Told(
                        f"{what}, {by}", name, number["value"], number["std"], own[key], each[decided], (low, high)
                    )
    yield from _torques(results, truth["torque"]["true"])


def _torques(results: dict[str, Any], truth: dict[str, Any]) -> Iterator[Told]:
    for each in results["support"]:
        true = truth.get(each["motion"], {}).get(each["joint"])
        if true is None:
            continue
        for quantity in ("peak", "mean"):
            numbers = {by: each["approaches"][by][quantity] for by in ("A", "B", "paired") if by in each["approaches"]}
            for by, number in {**numbers, "headline": each[quantity]}.items():
                if number and number["value"] is not None and number["std"]:
                    name, value = f"{quantity}[{each['motion']}, {each['joint']}]", number["value"]
                    size = true[quantity]  # of a peak whichever side it is told of: both are claimed to be no larger
                    size = math.copysign(size, value) if quantity == "peak" else size
                    yield Told(f"{quantity}, {by}", name, value, number["std"], size, True)
