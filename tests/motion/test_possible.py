"""What would have to give is not searched for where nothing can."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from exogauge.criteria.motion_plan import USUAL
from exogauge.motion.person import Person
from exogauge.motion.plan.at_rest import at_home
from exogauge.motion.plan.possible import kept, what_would_do
from exogauge.motion.plan.retarget import ask
from exogauge.motion.retargeting import with_margin
from exogauge.robots.moving.robot import MotionRobot


def test_nothing_is_searched_for_where_home_lacks_a_little(robot: MotionRobot) -> None:
    def weak(share: float) -> MotionRobot:
        return replace(robot, limits=replace(robot.limits, torque=share * robot.limits.torque))

    need = at_home(weak(0.01), USUAL)
    lacking = weak(0.97 * 0.01 * need.needs / need.bears)
    assert at_home(lacking, USUAL).lacks
    turn = np.tile(np.eye(3), (2, 1, 1))
    still = Person("still", np.arange(2.0), np.zeros((2, 3)), turn, turn, {}, 0.8)
    tried = list[str]()
    assert what_would_do(lacking, still, tried=lambda what, *_: tried.append(what)) is None
    assert not tried
    assert not kept(
        lacking, ask(lacking, still)[0]
    )  # nor would the search have found any: even standing still lacks it


def test_a_slower_motion_is_tried_on_no_more_nodes_than_the_motion_itself(robot: MotionRobot) -> None:
    """Where nothing does, four times the time is tried: four times the nodes would be four times the cost."""
    margin = next(m for m in np.arange(0.1, 0.02, -0.002) if not at_home(robot, with_margin(m)).lacks)
    criteria = with_margin(margin)  # what home just bears, and no motion of the pelvis
    time = np.linspace(0.0, 1.0, 61)
    sways = np.column_stack([0.15 * np.sin(2.0 * np.pi * time), np.zeros((len(time), 2))])
    turn = np.tile(np.eye(3), (len(time), 1, 1))
    person = Person("sways", time, sways, turn, turn, {}, 0.8)
    tried = list[tuple[str, float, int, bool]]()
    could = what_would_do(robot, person, criteria, tried=lambda *each: tried.append(each))
    nodes = len(ask(robot, person, criteria)[0].q)
    slower = [count for what, _, count, _ in tried if what == "slower"]
    assert tried[0][:2] == ("slower", criteria.slowest)
    assert max(slower) <= nodes, f"{slower} nodes, {nodes} at the motion's own time"
    assert (could.slower is None) == (not any(holds for what, _, _, holds in tried if what == "slower"))
