"""A payload on its robot at home: axes of the sensor, where they may point, planned postures, what was identified."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin
import trimesh
from numpy.typing import NDArray

from exogauge.payload.exports.body import Body
from exogauge.payload.planning.workspace import Cap
from exogauge.robots.description import Robot
from exogauge.scene.colours import MARK, SLACK, UNKNOWN, Rgb, as_hex
from exogauge.scene.poses import InBase, quaternions
from exogauge.scene.recording import aim
from exogauge.scene.robot_view import ROOT, RobotView, draw_robot
from exogauge.scene.stage import Stage
from exogauge.studies.intake.mesh_files import Opener

Array = NDArray[np.float64]

AXES: tuple[Rgb, ...] = ((204, 51, 51), (51, 153, 51), (51, 85, 204))  # x, y, z
CONTACT: Rgb = (214, 120, 0)  # unlike the axes and the centre
ARROW, DOME, BALL = 0.14, 0.24, 0.012  # of the robot's size: sensor's axes, radius of caps, centre of mass
SHOWN = 0.06  # of the robot's size, at most: three standard deviations of the centre, magnified to be seen
SIGMAS = 3.0
STEP = np.radians(7.5)  # of a cap's mesh


def draw_payload(
    robot: Robot, urdf: bytes, open_mesh: Opener, frame: str, home: Array, caps: Sequence[Cap], postures: Array | None,
    body: Body | None, contacts: Sequence[Array] = (),
) -> bytes:  # fmt: skip
    """The packed scene, of one frame at time 0. frame: of the sensor. home: (J,), postures: (K, J) [rad]. body: in the
    sensor's frame, None before anything was identified. contacts: (3,) [N] largest force on the payload of each, in
    the sensor's axes."""
    stage = Stage.empty()
    view = draw_robot(stage, robot, urdf, open_mesh, home[None], None, None)
    carrier, T = robot.tree.frames[frame]
    sensor = f"{view.nodes[carrier]}/sensor"
    stage.scene.add_frame(
        sensor, axes_length=ARROW * view.size, axes_radius=0.05 * ARROW * view.size,
        position=tuple(np.asarray(T.translation)), wxyz=tuple(quaternions(np.asarray(T.rotation))),
    )  # fmt: skip
    stage.layers["sensor"] = [sensor]
    legend, notes = (
        [_entry("sensor", f"axes of the sensor ({frame})", AXES[2], "x red, y green, z blue")],
        ["The robot stands at home."],
    )
    if caps:
        origin = view.in_base.points(carrier, np.asarray(T.translation))[0]
        stage.layers["workspace"] = [_add_cap(stage, view, cap, k, origin) for k, cap in enumerate(caps)]
        axes = ", ".join(sorted({"xyz"[cap.axis] for cap in caps}))
        legend.append(_entry("workspace", f"where {axes} may point", AXES[caps[0].axis]))
    if postures is not None and len(postures):
        _add_ghosts(stage, robot, carrier, T, postures, ARROW * view.size)
        legend.append(_entry("postures", "planned postures", SLACK, f"{len(postures)}; where z points, in their order"))
    if body is not None:
        notes += _add_body(stage, view, sensor, body, legend)
    if len(contacts):
        _add_contacts(stage, sensor, np.array(contacts), 2.0 * ARROW * view.size, legend)
    aim(stage, view)
    about = {"log": "", "start": 0.0, "end": 0.0, "fps": 1.0, "frames": 1, "legend": legend, "marked": []}
    return stage.packed({**about, "notes": notes, "points": []})


def cap_mesh(cap: Cap) -> tuple[Array, NDArray[np.uint32]]:
    """Vertices (V, 3) on the unit sphere of {B} and faces (F, 3) of where the axis may point."""
    theta = np.linspace(*cap.theta, max(int(np.ceil((cap.theta[1] - cap.theta[0]) / STEP)), 1) + 1)
    phi = np.linspace(*cap.phi, max(int(np.ceil((cap.phi[1] - cap.phi[0]) / STEP)), 1) + 1)
    t, p = np.meshgrid(theta, phi, indexing="ij")
    vertices = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1).reshape(-1, 3)
    place = np.arange(len(vertices), dtype=np.uint32).reshape(t.shape)
    a, b, c, d = place[:-1, :-1], place[1:, :-1], place[1:, 1:], place[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], axis=-1).reshape(-1, 3), np.stack([a, c, d], axis=-1).reshape(-1, 3)])
    return vertices, faces.astype(np.uint32)


def solid_ellipsoid(mass: float, inertia: Array) -> tuple[Array, Array] | None:
    """Half axes (3,) [m] and their directions (3, 3) of the homogeneous ellipsoid of this mass and inertia about its
    centre; None where no body has it. I_x = m (b² + c²)/5."""
    moments, axes = np.linalg.eigh(inertia)
    squares = 2.5 / mass * (moments.sum() - 2.0 * moments)
    if (squares <= 0.0).any():
        return None
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] *= -1.0
    return np.sqrt(squares), axes


def _add_cap(stage: Stage, view: RobotView, cap: Cap, k: int, origin: Array) -> str:
    vertices, faces = cap_mesh(cap)
    name = f"{ROOT}/workspace_{k}"
    stage.scene.add_mesh_simple(
        name, (DOME * view.size * vertices + origin).astype(np.float32), faces, color=AXES[cap.axis], opacity=0.22,
        side="double", cast_shadow=False, receive_shadow=False,
    )  # fmt: skip
    return name


def _add_ghosts(stage: Stage, robot: Robot, carrier: int, T: pin.SE3, postures: Array, reach: float) -> None:
    """Each posture as lines from the base through the joints to the sensor and along its z, whose ends are joined in
    the order of the postures. A wrist alone turns in most plans: only z tells its postures apart."""
    in_base, chain, body = InBase.of(robot.tree, postures), list[int](), carrier
    while body >= 0:
        chain.insert(0, body)
        body = int(robot.tree.parent[body])
    stops = [np.zeros((len(postures), 3)), *(in_base.points(each, np.zeros(3)) for each in chain)]
    stops.append(in_base.points(carrier, np.asarray(T.translation)))
    way = np.stack(stops, axis=1)
    lines = np.stack([way[:, :-1], way[:, 1:]], axis=2).reshape(-1, 2, 3)
    name = f"{ROOT}/postures"
    stage.scene.add_line_segments(name, lines.astype(np.float32), SLACK, thickness=1.5, thickness_units="screen")
    tips = in_base.points(carrier, np.asarray(T.act(np.array([0.0, 0.0, reach]))))
    pointing, order = f"{ROOT}/postures/z", f"{ROOT}/postures/order"
    rays = np.stack([way[:, -1], tips], axis=1).astype(np.float32)
    stage.scene.add_line_segments(pointing, rays, AXES[2], thickness=3.0, thickness_units="screen")
    stage.layers["postures"] = [name, pointing]
    if len(tips) > 1:
        joined = np.stack([tips[:-1], tips[1:]], axis=1).astype(np.float32)
        stage.scene.add_line_segments(order, joined, SLACK, thickness=1.5, thickness_units="screen")
        stage.layers["postures"].append(order)


def _add_body(stage: Stage, view: RobotView, sensor: str, body: Body, legend: list[dict[str, Any]]) -> list[str]:
    """Centre of mass, its doubt magnified, and the ellipsoid of the same inertia; what is to be said of them."""
    centre, ball = tuple(body.centre), f"{sensor}/centre"
    stage.scene.add_icosphere(ball, BALL * view.size, color=MARK, position=centre)
    moments, axes = np.linalg.eigh(body.covariance[1:4, 1:4])
    reach = SIGMAS * np.sqrt(np.maximum(moments, 0.0))
    times = 10.0 ** np.floor(np.log10(SHOWN * view.size / reach.max())) if reach.max() > 0.0 else 1.0
    doubt = f"{sensor}/doubt"
    _add_ellipsoid(stage, doubt, times * reach, axes, centre, MARK, 0.35)
    stage.layers["centre"] = [ball, doubt]
    legend.append(_entry("centre", f"centre of mass, {SIGMAS:g} std", MARK, f"doubt {times:g} times as large"))
    if body.inertia is None:
        return ["The data decide no inertia."]
    found = solid_ellipsoid(body.mass, body.inertia)
    if found is None:
        return ["No body has this inertia: its ellipsoid is not drawn."]
    name = f"{sensor}/inertia"
    _add_ellipsoid(stage, name, *found, centre, UNKNOWN, 0.25)
    stage.layers["inertia"] = [name]
    size = " × ".join(f"{2e3 * half:.0f}" for half in sorted(found[0], reverse=True))
    legend.append(_entry("inertia", "solid ellipsoid of the same inertia", UNKNOWN, f"{size} mm"))
    return []


def _add_contacts(stage: Stage, sensor: str, forces: Array, reach: float, legend: list[dict[str, Any]]) -> None:
    """Arrows that end at the sensor's origin, whence the force pushes; the largest is `reach` [m] long."""
    most = float(np.linalg.norm(forces, axis=1).max())
    tails = -reach * forces / most
    tips = np.zeros_like(tails)
    back = 0.15 * tails
    across = np.cross(tails, [0.0, 0.0, 1.0])
    level = np.linalg.norm(across, axis=1) < 0.1 * np.linalg.norm(tails, axis=1)
    across[level] = np.cross(tails[level], [1.0, 0.0, 0.0])
    across *= 0.06 * np.linalg.norm(tails, axis=1, keepdims=True) / np.linalg.norm(across, axis=1, keepdims=True)
    lines = np.concatenate(
        [np.stack([tails, tips], axis=1), *(np.stack([back + s * across, tips], 1) for s in (-1, 1))]
    )
    name = f"{sensor}/contacts"
    stage.scene.add_line_segments(name, lines.astype(np.float32), CONTACT, thickness=4.0, thickness_units="screen")
    stage.layers["contacts"] = [name]
    legend.append(_entry("contacts", "largest force of each contact", CONTACT, f"the longest {most:.3g} N"))


def _add_ellipsoid(
    stage: Stage, name: str, half: Array, axes: Array, centre: tuple[float, ...], colour: Rgb, opacity: float
) -> None:
    sphere = trimesh.creation.icosphere(3, 1.0)
    vertices = np.asarray(sphere.vertices) * np.maximum(half, 1e-6) @ axes.T + centre
    stage.scene.add_mesh_simple(
        name, vertices.astype(np.float32), np.asarray(sphere.faces, np.uint32), color=colour, opacity=opacity,
        side="double", cast_shadow=False, receive_shadow=False,
    )  # fmt: skip


def _entry(layer: str, label: str, colour: Rgb, size: str = "") -> dict[str, Any]:
    return {"layer": layer, "label": label, "color": as_hex(colour), "size": size}
