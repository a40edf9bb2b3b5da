"""Effects put somewhere, as large as planned where that is believable.

How large a hidden effect shows on the channel that shows it best.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, cast, final

import numpy as np
from numpy.typing import NDArray

from exogauge.blind.generator.axis_run import AxisRun
from exogauge.blind.generator.cut import AXES
from exogauge.blind.generator.hidden.band import OnASpring, together
from exogauge.blind.generator.hidden.effect import Change, HiddenEffect, WholeEffect
from exogauge.blind.generator.hidden.kinds import CLUTTER, ELSEWHERE, IN_LOGS, ON_ENCODERS, ON_JOINTS, OUTSIDE, SMALLEST
from exogauge.blind.generator.hidden.log_filter import BandLimitedLog
from exogauge.blind.generator.hidden.outside import EncoderEccentricity
from exogauge.blind.generator.plan import FAINT, VISIBLE, CasePlan
from exogauge.blind.generator.scene import Scene

Array = NDArray[np.float64]

Anything = HiddenEffect | WholeEffect | BandLimitedLog | EncoderEccentricity

ALL = "all"
_ALL_JOINTS = 0.25  # share of delays that every joint has
_CLUTTER_RATIO = (0.08, 0.25)  # of each of two small effects per joint, in noise floors
_CLUTTER_HELD = 0.5  # noise floors: no more is left beside bodies that are known, which hide less than free ones
_CLOSE = 0.03  # relative, of a ratio that is searched for
_SEARCHES = 4
_MOST_PLACES = 6


@final
@dataclass(frozen=True)
class Placed:
    """joint: index where the effect is a joint's, None for every joint. where: as results.json says it."""

    effect: Anything
    joint: int | None
    where: Mapping[str, str | bool]
    size: float
    found: HowLarge

    def record(self) -> dict[str, Any]:
        """For the answers."""
        shape: Mapping[str, Any] = asdict(cast(Any, self.effect))
        return {
            "effect": self.effect.name,
            "where": dict(self.where),
            "parameters": {"size": self.size, **shape},
            "ratio": self.found.ratio,
            "excess": self.found.excess,
            "noise_floor": self.found.floor,
            "channel": self.found.channel,
            "visible": self.found.ratio >= VISIBLE,
        } | ({"outside": True} if self.effect.name in OUTSIDE else {})


@final
@dataclass(frozen=True)
class _Candidate:
    """An effect at a place, of whatever size. trace: how large a size shows."""

    effect: Anything
    joint: int | None
    where: Mapping[str, str | bool]
    limits: tuple[float, float]
    linear: bool
    trace: Callable[[float], HowLarge]


def hide(rng: np.random.Generator, plan: CasePlan, scene: Scene) -> list[Placed]:
    """One for each of the plan's kinds, at places in random order: the first at which it can be large enough."""
    return [_placed(rng, kind, ratio, scene) for kind, ratio in zip(plan.kinds, plan.ratios, strict=True)]


def clutter(rng: np.random.Generator, scene: Scene, hidden: Sequence[Placed] = ()) -> list[Placed]:
    """Two small effects on every joint. In a log that was low-passed the noise is smaller, and so are they."""
    found = list[Placed]()
    left = min(
        (one.effect.noise_left(one.size) for one in hidden if isinstance(one.effect, BandLimitedLog)), default=1.0
    )
    for joint, run in enumerate(scene.runs):
        for kind in rng.choice(CLUTTER, 2, replace=False):
            effect = ON_JOINTS[str(kind)].draw(rng, run)
            held = scene.baselines[joint].held(effect.torque(run, 1.0)) / scene.floors[joint]
            one = _on_joint(effect, joint, scene)
            one = replace(one, limits=(one.limits[0], min(one.limits[1], left * _CLUTTER_HELD / max(held, 1e-12))))
            found.append(_sized(one, left * float(rng.uniform(*_CLUTTER_RATIO))))
    return found


def motor_torque(run: AxisRun, effects: Sequence[Placed], joint: int) -> Array:
    """(L, T) [N·m] k_T i as the log reports it, with all effects of this joint."""
    motor = run.motor.copy()
    here = [each for each in effects if each.effect.name in ON_JOINTS and each.joint in (None, joint)]
    for each in sorted(here, key=lambda one: _joint_effect(one).reported):
        seen = replace(run, motor=motor) if _joint_effect(each).reported else run
        motor = motor + _joint_effect(each).torque(seen, each.size)
    return motor


def pull(scene: Scene, effects: Sequence[Placed]) -> Array | None:
    """(L, T, J) [N·m] that joints must give beside bodies and bands; None where nothing asks them."""
    elsewhere = [each for each in effects if each.effect.name in ELSEWHERE]
    changes, here = list[Change](), scene
    for each in sorted(elsewhere, key=lambda one: not isinstance(one.effect, OnASpring)):
        changes.append(_whole_effect(each).change(here, each.size))
        if isinstance(each.effect, OnASpring):  # what a band does beside its spring it does with that spring
            here = each.effect.changed(here, each.size)
    torques = [each.torque for each in changes if each.torque is not None and each.pull is None]
    pulls = [each.pull for each in changes if each.pull is not None]
    torques += [together(scene, pulls)] if pulls else []
    return np.asarray(sum(torques)) if torques else None


def sensed(scene: Scene, effects: Sequence[Placed]) -> Array:
    """(L, T, 6) what the sensor says: what it feels, then its own faults."""
    wrench = scene.wrench
    elsewhere = [each for each in effects if each.effect.name in ELSEWHERE]
    for each in sorted(elsewhere, key=lambda one: _whole_effect(one).reported):
        reported = _whole_effect(each).reported
        change = _whole_effect(each).change(replace(scene, wrench=wrench) if reported else scene, each.size).wrench
        if change is not None:
            wrench = wrench + change
    return wrench


def _placed(rng: np.random.Generator, kind: str, ratio: float, scene: Scene) -> Placed:
    """A believable size may fall short of the ratio: half of it is enough if it is visible where it should be."""
    tried: list[Placed] = []
    enough = 0.95 * min(ratio, max(0.5 * ratio, VISIBLE if ratio >= VISIBLE else FAINT))
    for candidate in _candidates(rng, kind, scene):
        tried.append(_sized(candidate, ratio))
        if tried[-1].found.ratio >= enough or len(tried) == _MOST_PLACES:
            break
    return max(tried, key=lambda each: min(each.found.ratio, ratio))


def _candidates(rng: np.random.Generator, kind: str, scene: Scene) -> Iterator[_Candidate]:
    """The same kind at one place after the other, in random order."""
    if kind in ON_JOINTS:
        everywhere = kind == "torque_delay" and rng.uniform() < _ALL_JOINTS
        for joint in rng.permutation(len(scene.runs)):
            effect = ON_JOINTS[kind].draw(rng, scene.runs[joint])
            yield _on_all_joints(effect, scene) if everywhere else _on_joint(effect, int(joint), scene)
            if everywhere:
                return
    elif kind == ON_ENCODERS:
        for joint in rng.permutation(len(scene.runs)):
            yield _on_encoder(EncoderEccentricity.draw(rng), int(joint), scene)
    elif kind == IN_LOGS:
        yield _in_log(BandLimitedLog.draw(rng, scene), scene)
    else:
        places = ELSEWHERE[kind].places(scene)
        for n in rng.permutation(len(places)):
            yield _elsewhere(ELSEWHERE[kind].draw(rng, scene, places[n]), places[n], scene)


def _on_joint(effect: HiddenEffect, joint: int, scene: Scene) -> _Candidate:
    limits = SMALLEST.get(effect.name, 0.0), effect.largest(scene.runs[joint])
    where = {"joint": scene.joints[joint]}
    return _Candidate(
        effect, joint, where, limits, effect.linear, lambda size: trace_on_joint(scene, effect, joint, size)
    )


def _on_all_joints(effect: HiddenEffect, scene: Scene) -> _Candidate:
    """The same size on every joint: as large as it is where it is largest."""

    def trace(size: float) -> HowLarge:
        every = (trace_on_joint(scene, effect, joint, size) for joint in range(len(scene.runs)))
        return max(every, key=lambda each: each.ratio)

    limits = 0.0, min(effect.largest(run) for run in scene.runs)
    return _Candidate(effect, None, {"joint": ALL}, limits, effect.linear, trace)


def _elsewhere(effect: WholeEffect, where: Mapping[str, str | bool], scene: Scene) -> _Candidate:
    unit = largest_trace(scene, effect, 1.0) if effect.linear else None

    def trace(size: float) -> HowLarge:
        return largest_trace(scene, effect, size) if unit is None else unit.times(size)

    return _Candidate(effect, None, where, effect.limits(scene), effect.linear, trace)


def _on_encoder(effect: EncoderEccentricity, joint: int, scene: Scene) -> _Candidate:
    def trace(size: float) -> HowLarge:
        excess, ratio = effect.excess(scene, joint, size)
        seen = int(np.argmax(ratio))
        return HowLarge(float(ratio[seen]), float(excess[seen]), scene.floors[seen], f"tau.{scene.joints[seen]}")

    return _Candidate(effect, joint, {"joint": scene.joints[joint]}, effect.limits(), False, trace)


def _in_log(effect: BandLimitedLog, scene: Scene) -> _Candidate:
    where = {"log": ALL if effect.log is None else scene.logs[effect.log].name}
    return _Candidate(effect, None, where, effect.limits(), False, lambda size: trace_in_log(scene, effect, size))


def _sized(one: _Candidate, ratio: float) -> Placed:
    """As large as asked for, but never larger than anyone would believe, nor smaller than makes sense."""
    smallest, largest = one.limits
    if one.linear:
        unit = one.trace(1.0)
        size = float(np.clip(ratio / max(unit.ratio, 1e-12), smallest, largest))
        return Placed(one.effect, one.joint, one.where, size, unit.times(size))
    size, found = largest, one.trace(largest)
    slope = 1.0
    for _ in range(_SEARCHES):
        reached = abs(found.ratio / ratio - 1.0) <= _CLOSE
        stuck = (size == largest and found.ratio < ratio) or (size == smallest and found.ratio > ratio)
        if reached or stuck or found.ratio == 0.0:
            break
        next_size = float(np.clip(size * (ratio / found.ratio) ** (1.0 / slope), smallest, largest))
        next_found = one.trace(next_size)
        change = np.log(next_size / size)
        if abs(change) > 1e-6 and next_found.ratio not in (0.0, found.ratio):
            slope = float(np.clip(np.log(next_found.ratio / found.ratio) / change, 0.3, 3.0))
        size, found = next_size, next_found
    return Placed(one.effect, one.joint, one.where, size, found)


def _joint_effect(placed: Placed) -> HiddenEffect:
    return placed.effect  # type: ignore[return-value]


def _whole_effect(placed: Placed) -> WholeEffect:
    return placed.effect  # type: ignore[return-value]


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
