"""A person beside the robot that does what the person did, on one clock: bones, markers, the centre of pressure on the
floor with what the feet stand on, the nearest pair, joints at a bound."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from exogauge.motion.figure import Figure
from exogauge.motion.played import Played
from exogauge.robots.description import Robot
from exogauge.scene.colours import GHOST, MARK, Rgb, as_hex
from exogauge.scene.effort_view import BALL
from exogauge.scene.frames import Frames
from exogauge.scene.recording import aim
from exogauge.scene.robot_view import RobotView, draw_ghost, draw_robot
from exogauge.scene.stage import Stage
from exogauge.studies.intake.mesh_files import Opener

Array = NDArray[np.float64]

BONE: Rgb = (70, 96, 140)
MARKER: Rgb = (32, 128, 96)
STANDS: Rgb = (120, 126, 138)
INNER: Rgb = (46, 125, 50)
PRESSURE: Rgb = (198, 40, 40)
PAIR: Rgb = (214, 120, 0)
HIDDEN = -100.0  # [m] below the floor: where a point that was not seen is put
ABOVE = 0.004  # [m] of what is drawn on the floor over it
BESIDE = 0.35  # [m] between the person and the robot
TOWARD = (2.6, 0.5, 0.6)  # where the camera stands: in front of both


def draw_played(
    robot: Robot, urdf: bytes, open_mesh: Opener, played: Played, joints: Sequence[str], figure: Figure | None
) -> bytes:
    """The packed scene. joints: those of `played.q`, in its order. figure: of the person."""
    stage = Stage.empty()
    frames = Frames.of(float(played.time[0]), float(played.time[-1]), len(played.time))
    shown = frames.nearest(played.time)
    base = played.base[shown] if robot.floating else None
    order = [list(joints).index(name) for name in robot.tree.joints]
    view = draw_robot(stage, robot, urdf, open_mesh, played.q[shown][:, order], base, None)
    legend = list[dict[str, Any]]()
    if np.isfinite(played.pressure).any() and len(played.outline) > 2:
        legend += _draw_balance(stage, played, shown)
    if np.isfinite(played.pairs).any():
        legend += _draw_pair(stage, view, played, shown)
    legend += _draw_bounds(stage, view, robot, dict(zip(joints, played.at_bound.T > 0.5, strict=True)), shown)
    if len(played.ghost_q):
        ghost = played.ghost_base[shown] if robot.floating else None
        draw_ghost(stage, robot, urdf, open_mesh, played.ghost_q[shown][:, order], ghost)
        legend.append({"layer": "ghost", "label": "frame by frame", "color": as_hex(GHOST), "size": "nothing planned"})
    aim(stage, view, TOWARD)
    if figure is not None and len(played.moment):
        place = _beside(view, figure, *played.person)
        legend += _draw_person(stage, figure, played.moment[shown], place)
        _look_at_both(stage, view, figure, place)
    notes = ["The person stands beside the robot, on the same clock."] if len(played.moment) else []
    return stage.packed(_about("motion", frames, legend, notes))


def draw_captured(figure: Figure) -> bytes:
    """The packed scene of a person alone, where it was captured."""
    stage = Stage.empty()
    frames = Frames.of(float(figure.time[0]), float(figure.time[-1]), len(figure.time))
    legend = _draw_person(stage, figure, figure.time[frames.nearest(figure.time)], np.eye(4))
    every = _seen(figure)
    low, high = every.min(axis=0), every.max(axis=0)
    size = float(max((high - low).max(), 0.2))
    cell = 0.1
    stage.scene.add_grid(
        "/floor", width=4.0, height=4.0, cell_size=cell, section_size=5 * cell, cell_thickness=0.6,
        section_thickness=0.9, cell_color=(150, 156, 166), section_color=(120, 126, 138),
        position=(*(0.5 * (low + high))[:2].round(1).tolist(), float(min(low[2], 0.0))),
    )  # fmt: skip
    stage.layers["floor"] = ["/floor"]
    middle = 0.5 * (low + high)
    stage.look(middle + 1.8 * size * np.array(TOWARD) / np.linalg.norm(TOWARD), middle)
    return stage.packed(_about("capture", frames, legend, []))


def _about(log: str, frames: Frames, legend: Sequence[Mapping[str, Any]], notes: Sequence[str]) -> dict[str, Any]:
    return {
        "log": log, "start": frames.start, "end": frames.end, "fps": frames.fps, "frames": frames.count,
        "legend": list(legend), "marked": [], "notes": [*notes, f"{frames.said}.".capitalize()],
    }  # fmt: skip


def _draw_person(stage: Stage, figure: Figure, moment: Array, place: Array) -> list[dict[str, Any]]:
    """place: (4, 4) world from the capture."""
    at = np.searchsorted(figure.time, moment).clip(0, len(figure.time) - 1)
    legend, names = [], []
    turn, origin = place[:3, :3], place[:3, 3]
    if figure.lines.shape[1]:
        lines = (figure.lines[at] @ turn.T + origin).astype(np.float32)
        stage.scene.add_frame("/person", show_axes=False)
        stage.scene.add_line_segments("/person/bones", lines[0], BONE, thickness=4.0, thickness_units="screen")
        stage.move("points", "/person/bones", np.nan_to_num(lines, nan=HIDDEN))
        names.append("/person/bones")
        legend.append({"layer": "person", "label": "person", "color": as_hex(BONE), "size": ""})
    if figure.points.shape[1]:
        points = np.nan_to_num(figure.points[at] @ turn.T + origin, nan=HIDDEN).astype(np.float32)
        colours = np.tile(np.array(MARKER, dtype=np.uint8), (points.shape[1], 1))
        stage.scene.add_point_cloud(
            "/markers", points[0], colours, point_size=0.025, point_shape="circle", precision="float32"
        )
        stage.move("points", "/markers", points)
        stage.layers["markers"] = ["/markers"]
        legend.append({"layer": "markers", "label": "marker", "color": as_hex(MARKER), "size": ""})
    stage.layers["person"] = names
    return legend


def _beside(view: RobotView, figure: Figure, heading: float, mirrored: float) -> Array:
    """(4, 4) that lets the person face where the robot does, at its left side, on its floor."""
    every = _seen(figure)
    turn = Rotation.from_euler("z", -heading).as_matrix() @ np.diag([1.0, -1.0 if mirrored else 1.0, 1.0])
    turned = every @ turn.T
    low, high = turned.min(axis=0), turned.max(axis=0)
    middle = 0.5 * (low + high)
    place = np.eye(4)
    place[:3, :3] = turn
    robot = 0.5 * (view.low + view.high)
    place[:3, 3] = [robot[0] - middle[0], view.high[1] + BESIDE - low[1], -low[2]]
    return place


def _look_at_both(stage: Stage, view: RobotView, figure: Figure, place: Array) -> None:
    at = _seen(figure) @ place[:3, :3].T + place[:3, 3]
    low, high = np.minimum(view.low, at.min(axis=0)), np.maximum(view.high, at.max(axis=0))
    middle, size = 0.5 * (low + high), float((high - low).max())
    stage.look(middle + 1.3 * size * np.array(TOWARD) / np.linalg.norm(TOWARD), middle)


def _seen(figure: Figure) -> Array:
    """(N, 3) [m] all that is seen of the person at first."""
    every = np.concatenate([figure.points[0].reshape(-1, 3), figure.lines[0].reshape(-1, 3)])
    return np.asarray(every[np.isfinite(every).all(axis=1)])


def _draw_balance(stage: Stage, played: Played, shown: NDArray[np.intp]) -> list[dict[str, Any]]:
    """The centre of pressure, and what the feet that stand then stand on: a polygon for every set of them."""
    floor = float(played.outline[:, 2].mean()) + ABOVE
    stage.scene.add_frame("/balance", show_axes=False)
    names = ["/balance/pressure"]
    stands = played.stands[shown] > 0.5
    for k, on in enumerate(np.unique(stands, axis=0)):
        corners = played.outline[on[played.foot.astype(int)]]
        hull = corners[ConvexHull(corners[:, :2]).vertices][:, :2]
        inner = _shrunk(hull, float(played.inner[0]))
        then = (stands == on).all(axis=1)
        for name, ring, colour, thick in (("outline", hull, STANDS, 2.5), ("inner", inner, INNER, 1.5)):
            if len(ring) < 3:
                continue
            node = f"/balance/{name}_{k}"
            stage.scene.add_line_segments(
                node, _ring(ring, floor), colour, thickness=thick, thickness_units="screen", visible=bool(then[0])
            )
            if not then.all():
                stage.move("visible", node, then.astype(np.uint8)[:, None])
            names.append(node)
    stage.scene.add_icosphere("/balance/pressure", 0.016, color=PRESSURE)
    at = played.pressure[shown].copy()
    at[:, 2] = floor
    stage.move("place", "/balance/pressure", np.nan_to_num(at, nan=HIDDEN).astype(np.float32))
    stage.layers["balance"] = names
    least = f"at least {1e3 * float(np.nanmin(played.inside)):.0f} mm inside"
    return [
        {"layer": "balance", "label": "centre of pressure", "color": as_hex(PRESSURE), "size": least},
        {"layer": "balance", "label": "what the feet stand on", "color": as_hex(STANDS), "size": ""},
        {"layer": "balance", "label": "margin", "color": as_hex(INNER), "size": f"{1e3 * played.inner[0]:.0f} mm"},
    ]


def _draw_pair(stage: Stage, view: RobotView, played: Played, shown: NDArray[np.intp]) -> list[dict[str, Any]]:
    lines = played.pairs[shown][:, None].astype(np.float32)
    stage.scene.add_line_segments("/nearest", np.nan_to_num(lines[0], nan=HIDDEN), PAIR, thickness=5.0,
                                  thickness_units="screen")  # fmt: skip
    stage.move("points", "/nearest", np.nan_to_num(lines, nan=HIDDEN))
    stage.layers["nearest"] = ["/nearest"]
    least = f"{1e3 * float(played.apart.min()):.0f} mm at least"
    return [{"layer": "nearest", "label": "nearest pair", "color": as_hex(PAIR), "size": least}]


def _draw_bounds(
    stage: Stage, view: RobotView, robot: Robot, at_bound: Mapping[str, NDArray[np.bool_]], shown: NDArray[np.intp]
) -> list[dict[str, Any]]:
    """A glow round each joint while it is at a bound. at_bound: joint -> (T,)."""
    tree, names = robot.tree, []
    for body, dof in enumerate(tree.dof):
        joint = tree.joints[dof] if dof >= 0 else ""
        at = at_bound.get(joint)
        if at is None or not at[shown].any():
            continue
        name = f"{view.nodes[int(tree.parent[body])]}/bound_{body}"
        place = tuple(np.asarray(tree.T_before[body].translation))
        stage.scene.add_icosphere(name, BALL * view.size, color=MARK, opacity=0.45, position=place, cast_shadow=False)
        stage.move("visible", name, at[shown].astype(np.uint8)[:, None])
        names.append(name)
    stage.layers["bounds"] = names
    return [{"layer": "bounds", "label": "joint at a bound", "color": as_hex(MARK), "size": ""}] if names else []


def _ring(corners: Array, height: float) -> NDArray[np.float32]:
    """(K, 2, 3) segments round (K, 2) corners."""
    at = np.column_stack([corners, np.full(len(corners), height)])
    return np.stack([at, np.roll(at, -1, axis=0)], axis=1).astype(np.float32)


def _shrunk(corners: Array, by: float) -> Array:
    """(K', 2) corners of what lies `by` [m] inside a convex polygon (K, 2), empty where nothing does."""
    equations = ConvexHull(corners).equations
    kept = corners
    for normal, offset in ((each[:2], each[2] + by) for each in equations):
        side = kept @ normal + offset
        clipped = list[Array]()
        for k in range(len(kept)):
            a, b, at, to = kept[k], kept[(k + 1) % len(kept)], side[k], side[(k + 1) % len(kept)]
            if at <= 0.0:
                clipped.append(a)
            if at * to < 0.0:
                clipped.append(a + (b - a) * at / (at - to))
        kept = np.array(clipped).reshape(-1, 2)
        if len(kept) < 3:
            return np.zeros((0, 2))
    return kept
