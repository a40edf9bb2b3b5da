"""The chain of gaps from the first model to the noise floor, and the models' lineage."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exogauge.discrepancy.locate import pooled
from exogauge.discrepancy.result import Finding, Lineage, Link
from exogauge.identification.result import Identification


def link(found: Identification, so_far: Sequence[Finding], channels: Sequence[str]) -> Link:
    step = f"+ {so_far[-1].effect} at {so_far[-1].place.name}" if so_far else "identified model"
    joints = [f"tau.{joint.name}" for joint in found.model.robot.joints]
    fits = [fit for fit in found.validation if fit.held_out and fit.channel in (channels or joints)]
    rmse, floor = pooled(fits)
    each = {name: pooled([fit for fit in found.validation if fit.held_out and fit.channel == name]) for name in joints}
    known = {name: values for name, values in each.items() if np.isfinite(values[0]) and values[1] > 0.0}
    worst = max(known, key=lambda name: known[name][0] / known[name][1], default="")
    worst_rmse, worst_floor = known.get(worst, (float("nan"), float("nan")))
    return Link(step, rmse, floor, worst, worst_rmse, worst_floor)


def lineage(findings: Sequence[Finding]) -> tuple[Lineage, ...]:
    names = ["identified"]
    lines = [Lineage(names[0], None, "")]
    for each in findings:
        names.append(f"{names[-1]}+{each.effect}@{each.place.name}")
        lines.append(Lineage(names[-1], names[-2], f"{each.effect}@{each.place.name}"))
    return tuple(lines)
