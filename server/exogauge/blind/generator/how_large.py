"""How large a hidden effect shows on the channel that shows it best."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from exogauge.blind.generator.cut import AXES
from exogauge.blind.generator.hidden.effect import HiddenEffect
from exogauge.blind.generator.hidden.log_filter import BandLimitedLog
from exogauge.blind.generator.hidden.whole import Change
from exogauge.blind.generator.scene import Scene

STATED = {"kt_gain": 0.02}  # effects on joints that are errors of a stated number: the least standard deviation of it


@final
@dataclass(frozen=True)
class HowLarge:
    """ratio: excess over floor; of a wrong number not more than its error over its stated standard deviation.

    excess, floor: [N·m or N] on `channel`, as logs name it, `tau` where currents are logged too.
    """

    ratio: float
    excess: float
    floor: float
    channel: str

    def times(self, size: float) -> HowLarge:
        return HowLarge(self.ratio * size, self.excess * size, self.floor, self.channel)


def trace_on_joint(scene: Scene, effect: HiddenEffect, joint: int, size: float) -> HowLarge:
    torque, floor = effect.torque(scene.runs[joint], size), scene.floors[joint]
    stated = STATED.get(effect.name)
    excess = scene.baselines[joint].excess(torque) if stated is None else scene.baselines[joint].held(torque)
    ratio = excess / floor if stated is None else min(excess / floor, size / stated)
    return HowLarge(ratio, excess, floor, f"tau.{scene.joints[joint]}")


def largest_trace(scene: Scene, change: Change, believed: float | None, size: float) -> HowLarge:
    """believed: std of a stated number whose error is `size`; then bodies and bands count as known, and the ratio is at
    most size / believed."""
    every = list[HowLarge]()
    if change.torque is not None:
        for j, (baseline, floor) in enumerate(zip(scene.baselines, scene.floors, strict=True)):
            look = baseline.excess if believed is None else baseline.held
            excess = look(change.torque[:, :, j], change.on)
            every.append(HowLarge(excess / floor, excess, floor, f"tau.{scene.joints[j]}"))
    if change.wrench is not None:
        look_there = scene.cut_baseline.excess if believed is None else scene.cut_baseline.held
        for axis, ratio, std in zip(AXES, look_there(change.wrench, change.on), scene.cut_baseline.std, strict=True):
            every.append(HowLarge(float(ratio), float(ratio * std), float(std), f"ft.{scene.kind.sensor.name}.{axis}"))
    best = max(every, key=lambda each: each.ratio)
    if believed is None:
        return best
    return HowLarge(min(best.ratio, size / believed), best.excess, best.floor, best.channel)


def trace_in_log(scene: Scene, effect: BandLimitedLog, size: float) -> HowLarge:
    excess, ratio = effect.excess(scene, size)
    joint = int(np.argmax(ratio))
    return HowLarge(float(ratio[joint]), float(excess[joint]), scene.floors[joint], f"tau.{scene.joints[joint]}")
