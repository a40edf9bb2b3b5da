"""What a named effect does to supporting torque and stiffness: the same logs with the model before and after."""

from __future__ import annotations

from collections.abc import Sequence

from exogauge.devices.result import Estimate, StiffnessResult
from exogauge.findings.result import Consequence
from exogauge.support.result import JointSupport, SupportResult

Estimated = tuple[SupportResult, Sequence[StiffnessResult]]
TOLD = 2  # joints of a device and motion: those that the bands load most
AT_REST = 0.9  # of the samples: from here on there is an interval of the torque, and hardly a torque


def before_after(before: Estimated, after: Estimated) -> tuple[Consequence, ...]:
    """RMSE of B against the band model at the most loaded joints, and the stiffness of each group by each approach."""
    result: list[Consequence] = []
    pairs = list(zip(before[0].joints, after[0].joints, strict=True))
    for device, motion in dict.fromkeys((one.device, one.motion) for one, _ in pairs):
        here = [pair for pair in pairs if (pair[0].device, pair[0].motion) == (device, motion)]
        for one, other in sorted(here, key=lambda pair: -_load(pair[0]))[:TOLD]:
            if "b" in one.rmse and "b" in other.rmse and one.rest_share < AT_REST:
                errors = (Estimate(each.rmse["b"], 0.0, each.unit) for each in (one, other))
                result.append(Consequence("rmse", (device, motion, one.joint), *errors))
    for was, now in zip(before[1], after[1], strict=True):
        groups = {band.group: (band, later) for band, later in zip(was.bands, now.bands, strict=True)}
        for group, (band, later) in groups.items():
            if was.approach != "prior":
                of = (group, was.approach, was.device)
                result.append(Consequence("group_stiffness", of, band.stiffness, later.stiffness))
    return tuple(result)


def _load(joint: JointSupport) -> float:
    effort = joint.by.get("band_model")
    return abs(effort.peak.value) if effort else 0.0
