"""A robot at rest, with a device whose via points can be dragged where one is given."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from exogauge.devices.device import Device, ViaPoint
from exogauge.robots.description import Robot
from exogauge.robots.tree import RigidTree
from exogauge.scene.band_view import GROUP, THICKNESS, route, segments
from exogauge.scene.colours import UNKNOWN, VIA_POINT, as_hex
from exogauge.scene.poses import quaternions
from exogauge.scene.recording import aim
from exogauge.scene.robot_view import BASE_WORDS, RobotView, draw_robot
from exogauge.scene.stage import Stage
from exogauge.studies.intake.mesh_files import Opener

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
