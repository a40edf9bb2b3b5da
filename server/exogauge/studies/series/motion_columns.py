"""How the joints moved, for plots: positions and currents as logged, and what the fit took of them."""

from __future__ import annotations

from collections.abc import Set

from exogauge.logs.channels import Channel, parse_channel
from exogauge.logs.derivatives import differentiate, differentiate_twice
from exogauge.logs.filtering import LowPass
from exogauge.logs.model import Log
from exogauge.robots.description import Robot
from exogauge.robots.parameters import of_slide
from exogauge.studies.series.columns import Columns


def add_motion(columns: Columns, robot: Robot, log: Log, cutoff_hz: float) -> None:
    """`measured.q.<joint>`, `measured.i.<joint>`, then `filtered.` q, dq, ddq and i: low-passed at the cut-off of the
    fit, and differentiated after, as `identification.preparation` does."""
    names = [joint.name for joint in robot.joints]
    driven = [joint.name for joint in robot.joints if joint.actuation == "current"]
    low_pass = LowPass(cutoff_hz, log.rate_hz)
    raw = {"q": log.stack([f"q.{name}" for name in names])}
    q = low_pass.apply(raw["q"])
    filtered = {"q": q, "dq": differentiate(q, log.rate_hz), "ddq": differentiate_twice(q, log.rate_hz)}
    if driven:
        raw["i"] = log.stack([f"i.{name}" for name in driven])
        filtered["i"] = low_pass.apply(raw["i"])
    for part, found in (("measured", raw), ("filtered", filtered)):
        for kind, values in found.items():
            for k, name in enumerate(driven if kind == "i" else names):
                unit = unit_of(parse_channel(f"{kind}.{name}"), robot.tree.sliding)
                columns.add(f"{part}.{kind}.{name}", values[:, k], unit, short=part == "filtered")


def unit_of(channel: Channel, sliding: Set[str]) -> str:
    """sliding: prismatic joints, whose positions are lengths and whose efforts are forces."""
    if not channel.of_joint or channel.subject not in sliding:
        return channel.unit
    return of_slide(channel.unit)
