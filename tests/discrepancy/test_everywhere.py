"""What all joints, or all axes of a sensor, have in common is told once."""

import numpy as np

from exogauge.criteria.planning import Telling
from exogauge.effects.ft_drift import EFFECT
from exogauge.findings.as_told import merged
from exogauge.findings.basis import OfRobot
from exogauge.findings.result import Evidence, Finding, HeldOut, Place
from exogauge.studies.words.finding_sentences import finding_sentence

NOTHING = Evidence("", "", *([np.zeros(0)] * 5))


def finding(rank, effect, place):
    return Finding(rank, effect, place, {}, HeldOut("", "N", 2.0, 1.0, 1.0), 0.5, OfRobot(EFFECT), (), (), NOTHING)


def test_a_zero_that_moves_on_most_axes_of_one_sensor_is_one_finding():
    axes = ("fx", "fy", "mx", "mz")
    found = [finding(k, "ft_drift", Place("sensor", "wrist", axis)) for k, axis in enumerate(axes, 1)]
    other = [finding(5, "ft_drift", Place("sensor", "foot", "fx")), finding(6, "stribeck", Place("joint", "j1"))]
    first, second, third = merged([*found, *other], 6, Telling())
    assert (first.place, first.rank) == (Place("sensor", "wrist", "all"), 1)
    assert [each.part for each in first.alike] == list(axes)
    assert finding_sentence(first).startswith("All axes alike (fx, fy, mx, mz): wrist.fx: ")
    assert [second.place.name, third.effect, third.rank] == ["foot", "stribeck", 3]


def test_a_gain_that_is_wrong_on_four_axes_stays_four_findings():
    found = [
        finding(k, "ft_gain", Place("sensor", "wrist", axis)) for k, axis in enumerate(("fx", "fy", "fz", "mx"), 1)
    ]
    assert [each.place.part for each in merged(found, 6, Telling())] == ["fx", "fy", "fz", "mx"]


def test_a_delay_of_half_of_the_joints_is_one_of_all():
    found = [finding(k, "torque_delay", Place("joint", f"j{k}")) for k in (1, 2, 3)]
    (told,) = merged(found, 6, Telling())
    assert told.place == Place("joint", "all")
    assert [each.name for each in told.alike] == ["j1", "j2", "j3"]
    assert finding_sentence(told).startswith("All joints alike (j1, j2, j3): j1: ")
    assert len(merged(found[:2], 6, Telling())) == 2
