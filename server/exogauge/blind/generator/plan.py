"""Which case hides what: evenly over the sorts of effects, in random order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from exogauge.blind.generator.arm import ARM
from exogauge.blind.generator.hidden.kinds import KINDS
from exogauge.blind.generator.robot_kind import RobotKind
from exogauge.blind.generator.torso import TORSO
from exogauge.synthetic.random_streams import stream

BLOCK = 40  # cases, of which
CLEAN, PAIRS = 8, 4
CLUTTERED = 1 / 3
CURRENT = 0.7  # share of arms that log currents, the others torques
WITH_TEMPERATURE = 0.7
ROBOTS = {"arm6": (ARM,), "torso8": (TORSO,), "both": (ARM, TORSO)}
TORSOS = 0.3  # share of cases with the upper body where there are both
FAINT, VISIBLE, STRONG = 1.0, 3.0, 8.0  # times the noise floor: of the unabsorbed part of a hidden effect
_VISIBLE_SHARE = 0.6


@final
@dataclass(frozen=True)
class CasePlan:
    """kinds: what to hide, by name; ratios: how large each shall be, in noise floors. clutter: small effects on every
    joint as well. actuation: `current` or `torque`. temperature: whether it is logged."""

    number: int
    kinds: tuple[str, ...]
    ratios: tuple[float, ...]
    clutter: bool
    actuation: str
    temperature: bool
    robot: RobotKind

    @property
    def name(self) -> str:
        return f"case_{self.number:04d}"


def plan_case(seed: int, number: int, robots: str = "both") -> CasePlan:
    """number counts from 1. The same seed and number give the same plan, however many cases there are. robots: a key
    of `ROBOTS`; another choice changes nothing but the robot."""
    block, place = divmod(number - 1, BLOCK)
    kinds = _block(seed, block)[place]
    rng = stream(seed, f"plan {number}")
    ratios = tuple(_ratio(rng, visible=len(kinds) > 1) for _ in kinds)
    clutter = bool(rng.uniform() < CLUTTERED)
    actuation = "current" if rng.uniform() < CURRENT else "torque"
    temperature = bool(rng.uniform() < WITH_TEMPERATURE) or "thermal_viscous" in kinds
    choice = ROBOTS[robots]
    robot = choice[-1] if rng.uniform() < TORSOS else choice[0]
    return CasePlan(number, kinds, ratios, clutter, actuation, temperature, robot)


def _block(seed: int, block: int) -> list[tuple[str, ...]]:
    """What the `BLOCK` cases of one block hide: every sort equally often, up to one."""
    rng, names = stream(seed, f"block {block}"), list(KINDS)
    single = BLOCK - CLEAN - PAIRS
    start = block * single  # goes on where the block before ended
    cases: list[tuple[str, ...]] = [(names[(start + n) % len(names)],) for n in range(single)]
    cases += [tuple(str(name) for name in rng.choice(names, 2, replace=False)) for _ in range(PAIRS)]
    cases += [()] * CLEAN
    return [cases[n] for n in rng.permutation(BLOCK)]


def _ratio(rng: np.random.Generator, visible: bool) -> float:
    low, high = (VISIBLE, STRONG) if visible or rng.uniform() < _VISIBLE_SHARE else (FAINT, VISIBLE)
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))
