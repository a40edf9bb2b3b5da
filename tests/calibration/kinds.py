"""Which numbers of a result have a truth to be held against, by kind."""

from __future__ import annotations

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
        return abs(self.value - self.truth) <= float(norm.ppf(0.5 + 0.5 * level)) * self.std


def told(results: dict[str, Any], truth: dict[str, Any]) -> Iterator[Told]:
    """Parameters that the data decide, and bands by every approach that looks at the logs."""
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
                kind, name = f"{what}, {each['approach']}", f"{what}[{each['band']}]"
                low, high = interval
                yield Told(kind, name, number["value"], number["std"], own[key], each[decided], (low, high))
