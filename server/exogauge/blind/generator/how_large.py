"""How large a hidden effect shows on the channel that shows it best."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from exogauge.blind.generator.cut import AXES
from exogauge.blind.generator.hidden.effect import HiddenEffect
from exogauge.blind.generator.hidden.log_filter import BandLimitedLog
from exogauge.blind.generator.hidden.whole import WholeEffect
from exogauge.blind.generator.scene import Scene

STATED = {"kt_gain": 0.02}  # effects on joints that are errors of a stated number: the least standard deviation of it


@final
@dataclass(frozen=True)
class HowLarge:
    """ratio: excess over floor; of a wrong number not more than the standard deviations, of it and of all others that
    are stated, by which the logs contradict it.

    excess, floor: [N·m or N] on `channel`, as logs name it, `tau` where currents are logged too.
    """

    ratio: float
    excess: float
    floor: float
    channel: str

    def times(self, size: float) -> HowLarge:
        return HowLarge(self.ratio * size, self.excess * size, self.floor, self.channel)


def trace_on_joint(scene: Scene, effect: HiddenEffect, joint: int, size: float) -> HowLarge:
    torque, floor, channel = effect.torque(scene.runs[joint], size), scene.floors[joint], f"tau.{scene.joints[joint]}"
    stated = STATED.get(effect.name)
    if stated is None:
        excess = scene.baselines[joint].excess(torque)
        return HowLarge(excess / floor, excess, floor, channel)
    excess = scene.baselines[joint].held(torque)
    every = np.zeros(scene.motion.q.shape)
    every[:, :, joint] = torque
    return HowLarge(min(excess / floor, size / stated, scene.stated.contradicted(every, None)), excess, floor, channel)


def largest_trace(scene: Scene, effect: WholeEffect, size: float) -> HowLarge:
    """Of a stated number that is wrong bodies and bands count as known, and the ratio is no more than by how many
    standard deviations the logs contradict what is stated."""
    change, believed = effect.change(scene, size), effect.believed(scene)
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
    ratio = min(best.ratio, size / believed, _contradicted(scene, effect, size))
    return HowLarge(ratio, best.excess, best.floor, best.channel)


def _contradicted(scene: Scene, effect: WholeEffect, size: float) -> float:
    """Against the robot and the bands as they would be with what is stated."""
    wrong, right = effect.change(scene, size), effect.change(scene, 0.0)
    torque, wrench = (
        None if new is None or old is None else new - old
        for new, old in ((wrong.torque, right.torque), (wrong.wrench, right.wrench))
    )
    stated = scene.stated if wrong.on is None else scene.stated_with_wear
    return stated.contradicted(torque, wrench)


def trace_in_log(scene: Scene, effect: BandLimitedLog, size: float) -> HowLarge:
    excess, ratio = effect.excess(scene, size)
    joint = int(np.argmax(ratio))
    return HowLarge(float(ratio[joint]), float(excess[joint]), scene.floors[joint], f"tau.{scene.joints[joint]}")
