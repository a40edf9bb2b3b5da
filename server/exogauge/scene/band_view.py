"""Bands on a stage: lines through their via points, coloured by tension, dashed and grey while they are slack."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.device import Band, Device
from exogauge.robots.tree import RigidTree
from exogauge.scene.colours import SLACK, UNKNOWN, VIA_POINT, round_up, tension_colour
from exogauge.scene.robot_view import RobotView
from exogauge.scene.stage import Stage

Array = NDArray[np.float64]

GROUP = "/bands"
THICKNESS, DASHES = 6.0, 6  # [px]; dashes per segment
BALL = 0.011  # [m]


def draw_bands(stage: Stage, view: RobotView, tree: RigidTree, device: Device, tension: Mapping[str, Array]) -> float:
    """Returns the tension [N] at the end of the colour scale. tension: band -> (F,) [N], where known."""
    most = round_up(max((float(values.max(initial=0.0)) for values in tension.values()), default=0.0))
    stage.scene.add_frame(GROUP, show_axes=False)
    balls = []
    for k, band in enumerate(device.bands):
        _draw(stage, f"{GROUP}/{k}", route(view, tree, band), tension.get(band.name), most)
        for n, point in enumerate(band.via_points):
            body, T = tree.frames[point.link]
            name = f"{view.nodes[body]}/via_{k}_{n}"
            place = np.asarray(T.act(np.array(point.xyz)))
            stage.scene.add_icosphere(name, BALL, color=VIA_POINT, position=tuple(place), subdivisions=2)
            balls.append(name)
    stage.layers["bands"] = [GROUP, *balls]
    return most


def route(view: RobotView, tree: RigidTree, band: Band) -> Array:
    """(F, V, 3) [m] of a band's via points in the world."""
    places = []
    for point in band.via_points:
        body, T = tree.frames[point.link]
        places.append(view.world(body, np.asarray(T.act(np.array(point.xyz)))))
    return np.stack(places, axis=1)


def segments(through: Array) -> Array:
    """(F, V-1, 2, 3) from (F, V, 3)."""
    return np.stack([through[:, :-1], through[:, 1:]], axis=2)


def _draw(stage: Stage, name: str, through: Array, tension: Array | None, most: float) -> None:
    lines = segments(through)
    stage.scene.add_line_segments(
        name, lines[0], UNKNOWN, thickness=THICKNESS, thickness_units="screen", visible=tension is None
    )
    stage.move("points", name, lines.astype(np.float32))
    if tension is None:
        return
    colours = tension_colour(np.clip(tension / most, 0.0, 1.0))
    stage.move("colors", name, np.repeat(colours[:, None], lines.shape[1] * 2, axis=1).reshape(len(lines), -1))
    slack = tension <= 0.0
    stage.move("visible", name, (~slack).astype(np.uint8))
    if slack.any():
        dashes = dashed(lines)
        other = f"{name}_slack"
        stage.scene.add_line_segments(other, dashes[0], SLACK, thickness=THICKNESS / 2, thickness_units="screen")
        stage.move("points", other, dashes.astype(np.float32))
        stage.move("visible", other, slack.astype(np.uint8))


def dashed(lines: Array) -> Array:
    """(F, S·DASHES, 2, 3) the first half of each of `DASHES` pieces of (F, S, 2, 3)."""
    start, along = lines[:, :, None, 0], lines[:, :, None, 1] - lines[:, :, None, 0]
    at = np.arange(DASHES)[:, None] / DASHES
    ends = [start + along * at, start + along * (at + 0.5 / DASHES)]
    return np.stack(ends, axis=3).reshape(len(lines), -1, 2, 3)
