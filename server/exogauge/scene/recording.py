"""A log as a recording, or a robot at rest with a device whose via points can be dragged: everything drawn, packed
into one file that the player shows at any time asked for.

Bands are lines through their via points, coloured by tension, dashed and grey while they are slack.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from exogauge.devices.device import Band, Device, ViaPoint
from exogauge.robots.description import Robot
from exogauge.robots.tree import RigidTree
from exogauge.scene.colours import (
    FORCE,
    SLACK,
    SUPPORT,
    TENSION,
    TORQUE,
    UNKNOWN,
    VIA_POINT,
    as_hex,
    round_up,
    tension_colour,
)
from exogauge.scene.effort_view import draw_forces, draw_torques, mark_joints
from exogauge.scene.poses import quaternions
from exogauge.scene.robot_view import BASE_WORDS, RobotView, draw_robot
from exogauge.scene.stage import Stage
from exogauge.scene.take import Take
from exogauge.studies.intake.mesh_files import Opener


def record(take: Take, log: str, open_mesh: Opener) -> bytes:
    """The packed scene (`Stage.packed`). log: its name."""
    stage, tree = Stage.empty(), take.robot.tree
    view = draw_robot(stage, take.robot, take.urdf, open_mesh, take.q, take.base, take.up)
    legend = list[dict[str, Any]]()
    if take.device is not None:
        most = draw_bands(stage, view, tree, take.device, take.tension)
        legend += band_legend(bool(take.tension), most, any((t <= 0.0).any() for t in take.tension.values()))
    if take.torque:
        most = draw_torques(stage, view, tree, take.torque)
        legend.append(_entry("torques", "joint torque", as_hex(TORQUE), f"¾ turn = {most:g} N·m"))
    if take.support:
        most = draw_torques(stage, view, tree, take.support, "support")
        legend.append(_entry("support", "supporting torque", as_hex(SUPPORT), f"¾ turn = {most:g} N·m"))
    if take.force:
        most = draw_forces(stage, view, take.robot, take.force)
        legend.append(_entry("forces", "contact force", as_hex(FORCE), f"longest = {most:g} N"))
    if take.marked:
        mark_joints(stage, view, tree, take.marked)
    aim(stage, view)
    frames = take.frames
    about = {
        "log": log,
        "start": frames.start,
        "end": frames.end,
        "fps": frames.fps,
        "frames": frames.count,
        "legend": legend,
        "marked": [{"joint": joint, "effect": effect} for joint, effect in take.marked.items()],
        "notes": [BASE_WORDS[view.known], f"{frames.said}.".capitalize()],
    }
    return stage.packed(about)


def band_legend(known: bool, most: float, slack: bool) -> list[dict[str, Any]]:
    """The scale of tensions, or that none is known."""
    if not known:
        return [_entry("bands", "band, tension unknown", as_hex(UNKNOWN), "")]
    stops = [as_hex(colour.astype(np.uint8)) for colour in TENSION]
    scale = {"scale": stops, "low": 0.0, "high": most, "unit": "N"}
    entries = [_entry("bands", "band tension", stops[-1], "") | scale]
    return [*entries, _entry("bands", "slack band", as_hex(SLACK), "dashed")] if slack else entries


def aim(stage: Stage, view: RobotView, toward: Sequence[float] = (-1.2, -1.5, 0.45)) -> None:
    """The camera looks at the robot from behind and its right, a little from above: suits pull over the back."""
    centre = (view.low + view.high) / 2
    away = np.array(toward) / np.linalg.norm(toward)
    stage.look(centre + away * view.size * 0.95, centre)


def _entry(layer: str, label: str, colour: str, size: str) -> dict[str, Any]:
    return {"layer": layer, "label": label, "color": colour, "size": size}


BALL, HANDLE = 0.009, 0.09  # of the robot's size: a via point, the arrows to drag it by


def draw_still(robot: Robot, urdf: bytes, device: Device | None, open_mesh: Opener) -> bytes:
    """The packed scene, all joints at zero, of one frame at time 0."""
    stage, q = Stage.empty(), np.zeros((1, len(robot.tree.joints)))
    view = draw_robot(stage, robot, urdf, open_mesh, q, None, np.array([[0.0, 0.0, 1.0]]))
    points = [] if device is None else _draw_bands(stage, view, robot.tree, device)
    aim(stage, view)
    notes = [BASE_WORDS["fixed"]] if view.known == "fixed" else []
    legend = [{"layer": "bands", "label": "band", "color": as_hex(UNKNOWN), "size": ""}] if points else []
    about = {"log": "", "start": 0.0, "end": 0.0, "fps": 1.0, "frames": 1, "legend": legend, "marked": []}
    return stage.packed({**about, "notes": ["All joints are at zero.", *notes], "points": points})


def _draw_bands(stage: Stage, view: RobotView, tree: RigidTree, device: Device) -> list[dict[str, Any]]:
    """What the player needs of each via point, in the order of the bands."""
    stage.scene.add_frame(GROUP, show_axes=False)
    points = []
    for k, band in enumerate(device.bands):
        line = f"{GROUP}/{k}"
        lines = segments(route(view, tree, band))[0]
        stage.scene.add_line_segments(line, lines, UNKNOWN, thickness=THICKNESS, thickness_units="screen")
        points += [_add_point(stage, view, tree, point, f"{k}_{n}") for n, point in enumerate(band.via_points)]
        for point in points[-len(band.via_points) :]:
            point |= {"band": band.name, "line": line}
    stage.layers["bands"] = [GROUP, *(point["ball"] for point in points)]
    return points


def _add_point(stage: Stage, view: RobotView, tree: RigidTree, point: ViaPoint, key: str) -> dict[str, Any]:
    """A ball to choose it by, and arrows along its link's axes that are hidden until it is chosen."""
    body, T = tree.frames[point.link]
    link = f"{view.nodes[body]}/link_{key}"
    stage.scene.add_frame(
        link,
        show_axes=False,
        position=tuple(np.asarray(T.translation)),
        wxyz=tuple(quaternions(np.asarray(T.rotation))),
    )
    ball = stage.scene.add_icosphere(f"{link}/ball", BALL * view.size, color=VIA_POINT, position=point.xyz)
    ball.on_click(lambda event: None)  # the client says so; the player hears it
    stage.scene.add_transform_controls(
        f"{link}/point",
        scale=HANDLE * view.size,
        disable_rotations=True,
        depth_test=False,
        position=point.xyz,
        visible=False,
    )
    world = pin.SE3(view.R[0], view.p[0])
    if body >= 0:
        world = world * pin.SE3(view.in_base.R[0, body], view.in_base.p[0, body])
    world = world * T
    return {
        "name": f"{link}/point",
        "ball": ball.name,
        "link": point.link,
        "position": list(point.xyz),
        "rotation": np.asarray(world.rotation).tolist(),
        "origin": np.asarray(world.translation).tolist(),
    }


Array = NDArray[np.float64]

GROUP = "/bands"
THICKNESS, DASHES = 6.0, 6  # [px]; dashes per segment
VIA_BALL = 0.011  # [m]


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
            stage.scene.add_icosphere(name, VIA_BALL, color=VIA_POINT, position=tuple(place), subdivisions=2)
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
