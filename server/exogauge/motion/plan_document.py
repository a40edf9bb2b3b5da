"""plan.json: what became of a plan, as data. The figures that decide are told as words too, in `told`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exogauge.motion.channels import KINDS, bound_shares
from exogauge.motion.excite.plan import ExcitationPlan
from exogauge.motion.excite.plan import summarise as tell_excitation
from exogauge.motion.plan.judge import Judged
from exogauge.motion.plan.outcome import frame_by_frame_words, summarise
from exogauge.motion.retargeting import Retargeted
from exogauge.robots.moving.robot import MotionRobot

Array = NDArray[np.float64]
VERSION = 1


def retarget_document(found: Retargeted) -> dict[str, Any]:
    """`trunk`: per joint, asked and given [rad]; `margins`; `broken`; `would_do`, null where nobody asked, or home
    lacks what it needs; `frame_by_frame`: `margins` and `broken` of that, `outside`: share of samples in which the
    centre of pressure lies outside what the feet stand on."""
    robot, judged = found.robot, found.judged
    given = found.planned.spline.at_nodes()[0]
    trunk = []
    for j in robot.torso:
        asked, had = found.asked.q[:, robot.base + j], given[:, robot.base + j]
        outside = (asked < robot.limits.lower[j]) | (asked > robot.limits.upper[j])
        off = (had - asked)[~outside] if found.planned.rounds else had[:0]  # nothing is given where nothing is planned
        trunk.append({
            "joint": robot.joints[j], "asked": span(asked), "given": span(had),
            "bound": [float(robot.limits.lower[j]), float(robot.limits.upper[j])],
            "beyond": float(outside.mean()), "rms": float(np.sqrt(np.mean(off**2))) if len(off) else None,
            "most": float(np.abs(off).max()) if len(off) else None,
        })  # fmt: skip
    told = summarise(robot, found.person, found.asked, found.missed, found.planned, judged)
    alone = None
    if found.alone is not None:
        other, seen = found.alone
        told["frame by frame"] = frame_by_frame_words(seen)
        alone = {"outside": seen.outside, "margins": margins(robot, seen, other.spline.at(seen.time)[2]),
                 "broken": list(seen.broken)}  # fmt: skip
    could = found.could
    return {
        "version": VERSION, "kind": "retarget", "robot": robot.name, "motion": found.person.name,
        "seconds": float(judged.time[-1]), "rate_hz": rate_of(judged), "rounds": found.planned.rounds, "trunk": trunk,
        "missed": {"rms": float(np.sqrt(np.mean(found.missed**2))), "most": float(found.missed.max())},
        "margins": margins(robot, judged, found.planned.spline.at(judged.time)[2]), "broken": list(judged.broken),
        "would_do": None if could is None else {"slower": could.slower, "share": could.share}, "told": told,
        "frame_by_frame": alone, "parameters": [], "counts": [],
    }  # fmt: skip


def excite_document(found: ExcitationPlan, judged: Judged, acceleration: Array) -> dict[str, Any]:
    """`parameters`: each with the standard deviation before and after; `counts`: how many of them are decided.
    acceleration: (T, n) at the judged times."""
    told: Mapping[str, Any] = tell_excitation(found)
    return {
        "version": VERSION, "kind": "excite", "robot": found.robot.name, "motion": None,
        "seconds": float(found.planned.duration), "rate_hz": rate_of(judged), "rounds": None, "trunk": [],
        "missed": None, "margins": margins(found.robot, judged, acceleration), "broken": list(told.get("broken", [])),
        "would_do": None, "told": told, "frame_by_frame": None,
        "parameters": [asdict(each) for each in found.promise.certain],
        "counts": [asdict(each) for each in found.promise.counts],
    }  # fmt: skip


def margins(robot: MotionRobot, judged: Judged, acceleration: Array) -> dict[str, Any]:
    """What is left of balance and distances; of each kind of bound the joint that comes nearest, and its share."""
    shares = bound_shares(robot, judged, acceleration)
    bounds = []
    for kind in KINDS:
        t, j = np.unravel_index(int(shares[kind].argmax()), shares[kind].shape)
        share = float(shares[kind][t, j])
        bounds.append({"kind": kind, "joint": robot.joints[j], "share": share, "time": float(judged.time[t])})
    standing = bool(robot.soles) and robot.floating
    return {
        "pressure_inside_m": judged.least_inside if standing else None,
        "weight_carried": float(judged.carried.min()) if standing else None,
        "feet_m": judged.feet_m if standing else None, "feet_rad": judged.feet_rad if standing else None,
        "apart_m": float(judged.apart.min()) if robot.shapes else None,
        "nearest": None if judged.nearest is None else {
            "links": list(judged.nearest[:2]), "time": judged.nearest[2]},
        "bounds": sorted(bounds, key=lambda each: -each["share"]),
    }  # fmt: skip


def rate_of(judged: Judged) -> float:
    """[Hz]"""
    return float((len(judged.time) - 1) / judged.time[-1])


def span(values: Array) -> list[float]:
    return [float(values.min()), float(values.max())]
