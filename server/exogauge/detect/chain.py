"""The chain of gaps from the first model to the noise floor, and the models' lineage."""

from __future__ import annotations

from collections.abc import Sequence, Set

import numpy as np

from exogauge.findings.result import ChainStep, Lineage, Link
from exogauge.identification.result import Identification
from exogauge.identification.validate import unit_of
from exogauge.search.locate import pooled

FLOORS = "floors"


def link(found: Identification, step: ChainStep, channels: Sequence[str], logs: Set[str]) -> Link:
    """step: what was added last. channels: those in question, none for all joint torques. logs: that errors are told
    of."""
    robot = found.model.robot
    joints = [f"tau.{joint.name}" for joint in robot.joints]
    asked = list(dict.fromkeys(channels)) or joints
    each = {name: pooled([fit for fit in found.validation if fit.log in logs and fit.channel == name])
            for name in dict.fromkeys([*asked, *joints])}  # fmt: skip
    known = {name: values for name, values in each.items() if np.isfinite(values[0]) and values[1] > 0.0}
    worst = max(known, key=lambda name: known[name][0] / known[name][1], default="")
    worst_rmse, worst_floor = known.get(worst, (float("nan"), float("nan")))
    worst_unit = unit_of(worst, robot) if worst else ""
    sorts = {(unit_of(name, robot), name.partition(".")[0]) for name in asked}
    if len(sorts) == 1:  # a sensor's moments would drown among joint torques
        rmse, floor = pooled([fit for fit in found.validation if fit.log in logs and fit.channel in asked])
        return Link(step, rmse, floor, worst, worst_rmse, worst_floor, unit_of(asked[0], robot), worst_unit)
    ratios = [known[name][0] / known[name][1] for name in asked if name in known]
    rmse = float(np.sqrt(np.mean(np.square(ratios)))) if ratios else float("nan")
    return Link(step, rmse, 1.0, worst, worst_rmse, worst_floor, FLOORS, worst_unit)


def lineage(additions: Sequence[ChainStep]) -> tuple[Lineage, ...]:
    lines = [Lineage("identified", None, None)]
    for step in additions:
        lines.append(descendant(lines[-1], step))
    return tuple(lines)


def descendant(parent: Lineage, step: ChainStep) -> Lineage:
    return Lineage(f"{parent.version}+{step.identifier}", parent.version, step)
