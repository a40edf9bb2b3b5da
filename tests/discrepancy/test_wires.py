"""Where a band that nobody declared is looked for."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from exogauge.criteria.criteria import Criteria
from exogauge.detect.device.extra_band import _between_links
from exogauge.devices.routing import Routing


def test_a_wire_may_begin_at_what_a_fixed_robot_stands_on(robot):
    """As far from the first joint as the link that it carries is large."""
    ground = SimpleNamespace(model=SimpleNamespace(robot=robot, criteria=Criteria()))
    wires = [each for each in _between_links(ground, [0]) if each.name.startswith("base - ")]
    assert {each.name.partition(" - ")[2] for each in wires} == set(robot.tree.bodies)
    turned = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]])
    lengths = [Routing(robot.tree, wire.routing.bands).geometry(turned).length for wire in wires]
    assert max(float(np.ptp(each)) for each in lengths) > 0.01
