"""A person as points and lines over time, to be drawn."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.motion.fit.result import HumanFit
from exogauge.motion.human import HumanMotion
from exogauge.robots.moving.segments import Segment

Array = NDArray[np.float64]
DRAWN_HZ = 60.0  # twice what is drawn, so that a motion made slower stays smooth
LIMBS: tuple[tuple[Segment, Segment], ...] = (
    ("pelvis", "thorax"), ("thorax", "head"), ("head", "l_upper_arm"), ("head", "r_upper_arm"),
    ("l_upper_arm", "l_forearm"), ("l_forearm", "l_hand"), ("r_upper_arm", "r_forearm"), ("r_forearm", "r_hand"),
    ("pelvis", "l_thigh"), ("l_thigh", "l_shank"), ("l_shank", "l_foot"),
    ("pelvis", "r_thigh"), ("r_thigh", "r_shank"), ("r_shank", "r_foot"),
)  # fmt: skip


@final
@dataclass(frozen=True)
class Figure:
    """time: (T,) [s] of the capture. points: (T, M, 3) [m] of markers, NaN in gaps. lines: (T, L, 2, 3) [m] of bones.
    World, z up."""

    time: Array
    points: Array
    lines: Array


def figure_of(motion: HumanMotion, fit: HumanFit | None = None) -> Figure:
    """fit: of the same motion, whose segments are drawn."""
    every = max(1, round(motion.rate / DRAWN_HZ))
    kept = slice(None, None, every)
    none = np.zeros((len(motion.time[kept]), 0, 3))
    points = none if motion.markers is None else motion.markers.position[kept]
    lines = none[:, :, None, :].repeat(2, axis=2)
    if fit is not None:
        ways = [(fit.position[a], fit.position[b]) for a, b in LIMBS]
        ways += [(fit.position[part], end) for part, end in fit.end.items()]
        lines = np.stack([np.stack(way, axis=1) for way in ways], axis=1)[kept]
    elif motion.tree is not None:
        place, above = motion.tree.position, motion.tree.parent.tolist()
        ways = [(place[:, up], place[:, k]) for k, up in enumerate(above) if up >= 0]
        ways += [(place[:, k], motion.tree.end[:, k]) for k in range(len(above)) if k not in above]
        lines = np.stack([np.stack(way, axis=1) for way in ways], axis=1)[kept]
    return Figure(motion.time[kept], points, lines)


def write_figure(figure: Figure, path: Path) -> None:
    np.savez_compressed(path, time=figure.time, points=figure.points.astype(np.float32),
                        lines=figure.lines.astype(np.float32))  # fmt: skip


def read_figure(path: Path) -> Figure:
    """What `write_figure` wrote."""
    with np.load(path) as file:
        return Figure(*(file[name].astype(np.float64) for name in ("time", "points", "lines")))
