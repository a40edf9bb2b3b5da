"""Which case hides what: evenly over the sorts of effects, in random order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from exogauge.blind.generator.foot_faults import kinds_known
from exogauge.blind.generator.hidden.kinds import IN_BANDS, IN_LOGS, KINDS, ON_REQUEST
from exogauge.blind.generator.motion import PLAIN, WITH_DEVICE, LogPlan
from exogauge.blind.generator.robot_kind import ARM, TORSO, RobotKind
from exogauge.synthetic.random_streams import stream

BLOCK = 40  # cases, of which
CLEAN, PAIRS = 5, 5
CLUTTERED = 1 / 3
CURRENT = 0.7  # share of arms that log currents, the others torques
WITH_TEMPERATURE = 0.7
ROBOTS = {"arm6": (ARM,), "torso8": (TORSO,), "both": (ARM, TORSO)}
STANDING = "humanoid"  # a robot on two feet: `standing`
NOTHING = "nothing"  # asked for: a case to hide something of one's own in
TORSOS = 0.35  # share of cases with the upper body where there are both, beside those that need bands
CALIBRATED = 0.5  # share of robots whose maker has measured k_T
FAINT, VISIBLE, STRONG = 1.0, 3.0, 8.0  # times the noise floor: of the unabsorbed part of a hidden effect
_VISIBLE_SHARE = 0.6


@final
@dataclass(frozen=True)
class CasePlan:
    """kinds: what to hide, by name; ratios: how large each shall be, in noise floors. clutter: small effects on every
    joint as well. actuation: `current` or `torque`. temperature: whether it is logged. k_T: how its maker knows it, a
    key of `true_robot.K_T_STD`."""

    number: int
    kinds: tuple[str, ...]
    ratios: tuple[float, ...]
    clutter: bool
    actuation: str
    temperature: bool
    k_T: str
    robot: RobotKind

    @property
    def logs(self) -> tuple[LogPlan, ...]:
        return WITH_DEVICE if self.robot.wires else PLAIN

    @property
    def name(self) -> str:
        return case_name(self.number)


def case_name(number: int) -> str:
    return f"case_{number:04d}"


def plan_case(seed: int, number: int, robots: str = "both", effects: tuple[str, ...] = ()) -> CasePlan:
    """number counts from 1. The same arguments give the same plan, however many cases there are. robots: a key of
    `ROBOTS`. effects: to be hidden, one in each case, in turn; none: all sorts, and nothing now and then."""
    choice = ROBOTS[robots]
    block, place = divmod(number - 1, BLOCK)
    kinds = _block(seed, block, possible(robots, effects), clean=not effects)[place]
    rng = stream(seed, f"plan {number}")
    ratios = tuple(_ratio(rng, visible=len(kinds) > 1) for _ in kinds)
    clutter = bool(rng.uniform() < CLUTTERED) and bool(kinds or not effects)
    actuation = "current" if rng.uniform() < CURRENT else "torque"
    temperature = bool(rng.uniform() < WITH_TEMPERATURE) or "thermal_viscous" in kinds
    k_T = "calibrated" if rng.uniform() < CALIBRATED or "kt_gain" in kinds else "data sheet"
    torso = rng.uniform() < TORSOS or bool(IN_BANDS & set(kinds))
    return CasePlan(number, kinds, ratios, clutter, actuation, temperature, k_T, choice[-1] if torso else choice[0])


def possible(robots: str, effects: tuple[str, ...] = ()) -> tuple[str, ...]:
    """Of `effects`, or of all that take turns, what these robots can hide."""
    worn = any(robot.wires for robot in ROBOTS[robots])
    return tuple(kind for kind in effects or KINDS if worn or kind not in IN_BANDS)


def can_be_asked_for(robots: str) -> tuple[str, ...]:
    """What `effects` may name."""
    if robots == STANDING:
        return kinds_known()
    return (*possible(robots), *possible(robots, ON_REQUEST), NOTHING)


def _block(seed: int, block: int, names: tuple[str, ...], clean: bool) -> list[tuple[str, ...]]:
    """What the `BLOCK` cases of one block hide: every sort equally often, up to one. clean: some hide nothing, some
    two, in random order; otherwise each hides one, in turn, or `NOTHING`."""
    rng = stream(seed, f"block {block}")
    among = [name for name in names if name != IN_LOGS]
    single = BLOCK - CLEAN - PAIRS if clean else BLOCK
    start = block * single  # goes on where the block before ended
    turns = [names[(start + n) % len(names)] for n in range(single)]
    cases: list[tuple[str, ...]] = [() if name == NOTHING else (name,) for name in turns]
    if not clean:
        return cases
    cases += [tuple(str(name) for name in rng.choice(among, 2, replace=False)) for _ in range(PAIRS)]
    cases += [()] * CLEAN
    return [cases[n] for n in rng.permutation(BLOCK)]


def _ratio(rng: np.random.Generator, visible: bool) -> float:
    low, high = (VISIBLE, STRONG) if visible or rng.uniform() < _VISIBLE_SHARE else (FAINT, VISIBLE)
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))
