"""What decides when a motion is planned for a robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final


@final
@dataclass(frozen=True)
class MotionPlan:
    """nodes_per_s: of the spline; bounds on torque and centre of pressure hold at its nodes, and between 30 of them a
    second the centre of pressure was seen 42 mm from where the nodes had it. smooth_hz: what is asked is followed below
    this frequency; a trunk moves below 2 Hz. margin_m: by which the centre of pressure keeps inside the soles; 5 mm of
    it are for what lies between nodes. friction: of soles on a floor; rubber on wood has .7. least_weight: share of the
    weight that the feet carry at least; below it the centre of pressure says little. near: share of a bound from which
    on it stands in the equations. kept: share of velocity, acceleration and torque that is used, for what lies between
    nodes.
    trunk_rad, pelvis_rad, pelvis_m, limb_rad: by how much each may stray from what is asked at equal cost; the trunk is
    what is evaluated. free_rad: likewise of joints of which nothing is asked, for smoothness alone. wrench: likewise of
    the feet's loads, in weights: it decides how two feet share, not where the body goes. slack_cost: of a bound that is
    exceeded by its whole size at one node; more than any angle is worth.
    done_rad: largest step of the last round, and
    held [m or rad], floats [share of the weight]: what feet and dynamics may be off then; a tenth of what is promised.
    rounds: at most. approach_s: from home to the motion's begin, and back.
    feet_m, feet_rad: by which a standing foot may move. inside_m: margin of the centre of pressure below which a plan
    breaks its promise. beyond: share by which velocity, acceleration or torque may exceed a bound, round-off.
    judged_hz: samples per second that are judged and written."""

    nodes_per_s: float = 60.0
    smooth_hz: float = 5.0
    margin_m: float = 0.02
    friction: float = 0.5
    least_weight: float = 0.3
    near: float = 0.6
    kept: float = 0.98
    trunk_rad: float = 0.01
    pelvis_rad: float = 0.2
    pelvis_m: float = 0.1
    limb_rad: float = 0.2
    free_rad: float = 2.0
    wrench: float = 10.0
    slack_cost: float = 1e4
    done_rad: float = 1e-2
    held: float = 1e-5
    floats: float = 1e-3
    rounds: int = 30
    approach_s: float = 2.0
    feet_m: float = 1e-4
    feet_rad: float = 1.75e-4
    inside_m: float = 0.015
    beyond: float = 1e-6
    judged_hz: float = 200.0


USUAL = MotionPlan()
