"""What decides when a motion is planned for a robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

HALF_FOOT_M = 0.1  # what distances and moments are counted in, so that excesses are shares
APART_M = 0.1  # at home: shapes that far apart are not near each other


@final
@dataclass(frozen=True)
class MotionPlan:
    """nodes_per_s: of the spline; bounds on torque and centre of pressure hold at its nodes, and between 30 of them a
    second the centre of pressure was seen 42 mm from where the nodes had it. smooth_hz: what is asked is followed below
    this frequency; a trunk moves below 2 Hz. margin_m: by which the centre of pressure keeps inside the soles; 5 mm of
    it are for what lies between nodes. friction: of soles on a floor; rubber on wood has .7. least_weight: share of the
    weight that the feet carry at least; below it the centre of pressure says little. near: share of a bound from which
    on it stands in the equations; beside: nodes to either side at which a torque does so too. kept: share of velocity,
    acceleration and torque that is used, for what lies between nodes.
    apart_m: by which what must not touch is kept apart at the nodes; clearance_m: at least, between them too; 5 mm are
    for edges that pass each other between nodes (4 mm were seen). look_m: nearer pairs stand in the equations. out_m:
    by which what is inside each other is taken apart in one round; it is not further that slopes hold.
    slides: steps at each node until limbs stand still that are asked through what is in their way; slide_rad: one of
    them at most, so that nothing is jumped over; slid_rad: below which they stand still.
    again: times that a plan is made anew where it, or its table, breaks a bound that the nodes keep. More nodes come
    after tighter bounds, as they cost more: JVRC-1's centre of pressure came to 8 mm of the edge with 67 nodes a second
    while it raised a knee, to 14.9 mm with 100, of 20 kept. more_kept: share of such a bound that is kept beside,
    and of half a foot of margin, as a plan that was changed swings elsewhere; Talos' arms bind at 98 % and swung to
    101.
    trunk_rad, pelvis_rad, pelvis_m, limb_rad: by how much each may stray from what is asked at equal cost; the trunk is
    what is evaluated. free_rad: likewise of joints of which nothing is asked, for smoothness alone. wrench: likewise of
    the feet's loads, in weights: it pulls at the body, and is loose. uneven: likewise by how much two feet share it
    other than as evenly as they can, which pulls at nothing: a table of joints says no more. Talos' knees took 120 % of
    their torque where its feet shared evenly and the plan's did not, 107 at .1, and none at .01.
    slack_cost: of a bound that is exceeded by its whole size at one node; more than any angle is worth.
    done_rad: largest step of the last round, and held [m or rad], floats [share of the weight]: what feet and dynamics
    may be off then; half of what is promised. over: share of a bound by which it may then be exceeded more than was
    planned; half of what is kept. loosely: times as much where a plan is begun.
    far_off: times as far astray as the round before, from which on that one is taken up again, nearer to what was:
    slopes promised what is not there. stillest: times the pelvis' own weight; steps are then a hundredth of what the
    equations say.
    rounds: at most; patience: in which neither the step nor what is wrong falls below `nearer` times its least so
    far, until a stretch is given up; two knee raises of CMU 13_29 took 7 of them, and then came to their end.
    aside: [rad or m] by which a joint may begin or end beside home; a plan is there to round-off where one was found.
    lift_s: in which a foot that lifts is eased into its way, and out of it; a foot that is up for less than twice that
    stays down. approach_s: from home to the motion's begin, and back.
    feet_m, feet_rad: by which a standing foot may move. inside_m: margin of the centre of pressure below which a plan
    breaks its promise. beyond: share by which velocity, acceleration or torque may exceed a bound, round-off;
    beyond_rad [or m]: likewise of a position, by which a cubic through a table's samples swings beyond it.
    stretch_s: that are planned at once, ahead_s: and looked ahead; a body's sway, sqrt(height / g), is .3 s, and what
    is planned at once decides how much memory it takes. coarse: every so many nodes a plan is begun.
    slowest: times the time that are tried where a motion cannot be had; within: to which the least of it, and the
    largest share of the trunk's angle, are found; each halving is a plan.
    judged_hz: samples per second that are judged and written. told_deg: by which a joint of the trunk is off before it
    is told what is at its bound there.
    no_bound_rad: so far beyond its range no joint of a table is by rounding, or by a bound a little broken: two such
    make degrees likely. round_rad: by which angles may exceed their range once read as degrees, a degree."""

    nodes_per_s: float = 60.0
    smooth_hz: float = 5.0
    margin_m: float = 0.02
    friction: float = 0.5
    least_weight: float = 0.3
    near: float = 0.6
    beside: int = 2
    kept: float = 0.98
    apart_m: float = 0.015
    clearance_m: float = 0.01
    look_m: float = 0.03
    out_m: float = 0.02
    more_kept: float = 0.03
    again: int = 3
    slides: int = 10
    slide_rad: float = 0.1
    slid_rad: float = 1e-3
    trunk_rad: float = 0.01
    pelvis_rad: float = 0.2
    pelvis_m: float = 0.1
    limb_rad: float = 0.2
    free_rad: float = 2.0
    wrench: float = 10.0
    uneven: float = 0.01
    slack_cost: float = 1e4
    done_rad: float = 2e-2
    loosely: float = 10.0
    held: float = 5e-5
    floats: float = 1e-3
    over: float = 0.01
    far_off: float = 4.0
    stillest: float = 64.0
    rounds: int = 30
    patience: int = 12
    nearer: float = 0.8
    aside: float = 1e-3
    lift_s: float = 0.15
    approach_s: float = 2.0
    feet_m: float = 1e-4
    feet_rad: float = 1.75e-4
    inside_m: float = 0.015
    beyond: float = 1e-6
    beyond_rad: float = 1e-5
    stretch_s: float = 7.0
    ahead_s: float = 1.0
    coarse: int = 4
    slowest: float = 4.0
    within: float = 0.1
    judged_hz: float = 200.0
    told_deg: float = 1.0  # judgement: what is less is no reason to look for one
    no_bound_rad: float = 1.0
    round_rad: float = 0.02


USUAL = MotionPlan()
