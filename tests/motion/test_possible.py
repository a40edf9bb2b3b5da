"""What would have to give is not searched for where nothing can."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from exogauge.criteria.motion_plan import USUAL
from exogauge.motion.person import Person
from exogauge.motion.plan.at_rest import at_home
from exogauge.motion.plan.possible import can, what_would_do
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
    assert not can(lacking, still)  # nor would the search have found any: even standing still lacks it
