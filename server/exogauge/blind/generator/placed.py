"""Effects put onto joints, as large as planned where that is believable."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from exogauge.blind.generator.axis_run import AxisRun
from exogauge.blind.generator.excess import Baseline
from exogauge.blind.generator.hidden.effect import HiddenEffect
from exogauge.blind.generator.hidden.kinds import CLUTTER, KINDS
from exogauge.blind.generator.plan import FAINT, VISIBLE, CasePlan

Array = NDArray[np.float64]

ALL = "all"
_ALL_JOINTS = 0.25  # share of delays that every joint has
_CLUTTER_RATIO = (0.08, 0.25)  # of each of two small effects per joint, in noise floors
_CLOSE = 0.03  # relative, of a ratio that is searched for
_SEARCHES = 4


@final
@dataclass(frozen=True)
class Placed:
    """joint: index, or None for every joint. ratio: excess over floor, where it is largest; both [N·m]."""

    effect: HiddenEffect
    joint: int | None
    size: float
    ratio: float
    excess: float
    floor: float

    def on(self, joint: int) -> bool:
        return self.joint is None or self.joint == joint

    def record(self, joints: Sequence[str]) -> dict[str, Any]:
        """For the answers."""
        shape: Mapping[str, Any] = asdict(self.effect)  # type: ignore[call-overload]
        return {
            "effect": self.effect.name,
            "where": {"joint": ALL if self.joint is None else joints[self.joint]},
            "parameters": {"size": self.size, **shape},
            "ratio": self.ratio,
            "excess": self.excess,
            "noise_floor": self.floor,
            "visible": self.ratio >= VISIBLE,
        }


@final
@dataclass(frozen=True)
class Bench:
    """What effects are sized on: every joint without any, what a baseline absorbs there, its noise [N·m]."""

    runs: Sequence[AxisRun]
    baselines: Sequence[Baseline]
    floors: Sequence[float]


def hide(rng: np.random.Generator, plan: CasePlan, bench: Bench) -> list[Placed]:
    """One for each of the plan's kinds, on joints in random order: the first on which it can be large enough."""
    return [_placed(rng, KINDS[kind], ratio, bench) for kind, ratio in zip(plan.kinds, plan.ratios, strict=True)]


def clutter(rng: np.random.Generator, bench: Bench) -> list[Placed]:
    """Two small effects on every joint."""
    return [
        _sized(KINDS[str(kind)].draw(rng, bench.runs[joint]), joint, float(rng.uniform(*_CLUTTER_RATIO)), bench)
        for joint in range(len(bench.runs))
        for kind in rng.choice(CLUTTER, 2, replace=False)
    ]


def motor_torque(run: AxisRun, effects: Sequence[Placed], joint: int) -> Array:
    """(L, T) [N·m] k_T i as the log reports it, with all effects of this joint."""
    motor = run.motor.copy()
    here = [each for each in effects if each.on(joint)]
    for each in sorted(here, key=lambda one: one.effect.reported):
        seen = replace(run, motor=motor) if each.effect.reported else run
        motor = motor + each.effect.torque(seen, each.size)
    return motor


def _placed(rng: np.random.Generator, kind: type[HiddenEffect], ratio: float, bench: Bench) -> Placed:
    """A believable size may fall short of the ratio: half of it is enough if it is visible where it should be."""
    tried: list[Placed] = []
    enough = 0.95 * min(ratio, max(0.5 * ratio, VISIBLE if ratio >= VISIBLE else FAINT))
    everywhere = kind.name == "torque_delay" and rng.uniform() < _ALL_JOINTS
    for joint in rng.permutation(len(bench.runs)):
        effect = kind.draw(rng, bench.runs[joint])
        tried.append(
            _sized_everywhere(effect, ratio, bench) if everywhere else _sized(effect, int(joint), ratio, bench)
        )
        if tried[-1].ratio >= enough or everywhere:
            break
    return max(tried, key=lambda each: each.ratio)


def _sized_everywhere(effect: HiddenEffect, ratio: float, bench: Bench) -> Placed:
    """The same size on every joint, so that the ratio is reached on one."""
    every = [_sized(effect, joint, ratio, bench) for joint in range(len(bench.runs))]
    return replace(min(every, key=lambda each: each.size), joint=None)


def _sized(effect: HiddenEffect, joint: int, ratio: float, bench: Bench) -> Placed:
    """As large as asked for, but never larger than anyone would believe."""
    run, floor = bench.runs[joint], bench.floors[joint]

    def excess(size: float) -> float:
        return bench.baselines[joint].excess(effect.torque(run, size))

    largest = effect.largest(run)
    if effect.linear:
        unit = excess(1.0)
        size = min(ratio * floor / unit, largest)
        return Placed(effect, joint, size, size * unit / floor, size * unit, floor)
    size, found = largest, excess(largest)
    slope = 1.0
    for _ in range(_SEARCHES):
        if found <= ratio * floor * (1.0 + _CLOSE) and (size == largest or found >= ratio * floor * (1.0 - _CLOSE)):
            break
        next_size = min(size * (ratio * floor / found) ** (1.0 / slope), largest)
        next_found = excess(next_size)
        change = np.log(next_size / size)
        if abs(change) > 1e-6 and next_found != found:
            slope = float(np.clip(np.log(next_found / found) / change, 0.3, 3.0))
        size, found = next_size, next_found
    return Placed(effect, joint, size, found / floor, found, floor)
