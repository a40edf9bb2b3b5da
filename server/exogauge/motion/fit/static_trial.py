"""What is given as a static trial: the same markers on a person who stands straight, or nothing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.motion_fit import MotionFit
from exogauge.errors import BadMotion, Fault
from exogauge.motion.human import HumanMotion, Markers

Array = NDArray[np.float64]


def refuse_no_static(motion: HumanMotion, static: HumanMotion, criteria: MotionFit) -> None:
    """Raises BadMotion where pelvis and thorax have other markers there, or where the person does not stand: from the
    feet to the thorax it is less far then than in the motion, as of who sits, bends or is another one."""
    own, there = motion.markers, static.markers
    if own is None or there is None:
        return
    both = [label for label in own.labels if label in there.labels and label in own.segment]
    for part in ("pelvis", "thorax"):
        on = [label for label in both if own.segment[label] == part]
        if len(on) < criteria.fewest:
            detail = f"{len(on)} of the markers of its {part} are those of the motion, {criteria.fewest} are needed"
            advice = "Give a static trial of the same person with the same markers, or leave it out"
            raise BadMotion(Fault(detail, "other_markers", advice, static.name, column=part))
    apart = [_up_to_thorax(each, both) for each in (own, there)]
    if any(not np.isfinite(each).any() for each in apart):
        return
    moves, stands = np.nanpercentile(apart[0], 95.0), np.nanpercentile(apart[1], 5.0)
    if stands < moves - criteria.shorter_m:
        frame = int(np.nanargmin(apart[1]))
        there_s = f"feet to thorax are {apart[1][frame]:.2f} m at {static.time[frame]:.2f} s"
        detail = f"nobody stands straight in it: {there_s}, and {moves:.2f} m in the motion"
        advice = "Cut it to where the person stands, or leave it out: its trunk is the zero of all angles"
        raise BadMotion(Fault(detail, "not_standing", advice, static.name, row=frame + 1, column="thorax"))


def _up_to_thorax(markers: Markers, labels: list[str]) -> Array:
    """(T,) [m] from the middle of the markers on feet and shanks to that of the thorax; NaN where one is not seen."""
    middle = []
    for ends in (("foot", "shank"), ("thorax",)):
        on = [markers.labels.index(label) for label in labels if markers.segment.get(label, "").endswith(ends)]
        middle.append(markers.position[:, on].mean(axis=1) if on else np.full((len(markers.position), 3), np.nan))
    return np.asarray(np.linalg.norm(middle[1] - middle[0], axis=1))
