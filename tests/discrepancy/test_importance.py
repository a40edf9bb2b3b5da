"""What closes the widest gap is told first."""

import numpy as np

from exogauge.devices.result import Estimate
from exogauge.findings.as_told import by_importance
from exogauge.findings.basis import BesideStated
from exogauge.findings.result import Evidence, Finding, HeldOut, Place

NOTHING = Evidence("", "", *([np.zeros(0)] * 5))


def finding(rank, effect, before, after, **parameters):
    known = {name: Estimate(value, 0.0, "1") for name, value in parameters.items()}
    held_out = HeldOut("tau.j1", "N·m", before, after, 0.1)
    return Finding(rank, effect, Place("joint", "j1"), known, held_out, 0.5, BesideStated(0.1), (), (), NOTHING)


def test_effects_stand_by_the_gap_they_close_behind_what_was_done_about_the_logs():
    told = by_importance([
        finding(1, "kt_gain", 9.0, 0.1), finding(2, "joint_spring", 0.13, 0.11), finding(3, "band_viscous", 0.3, 0.1),
        finding(4, "contact", 1.0, 1.0), finding(5, "payload", 5.0, 0.1), finding(6, "payload", 0.5, 0.1, since=2.0),
        finding(7, "stribeck", float("nan"), float("nan")),
    ])  # fmt: skip
    assert [each.effect for each in told] == [
        "contact", "kt_gain", "payload", "payload", "band_viscous", "joint_spring", "stribeck",
    ]  # fmt: skip
    assert [each.held_out.rmse_before for each in told[2:4]] == [5.0, 0.5]
    assert [each.rank for each in told] == list(range(1, 8))
