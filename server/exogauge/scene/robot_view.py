"""The robot on a stage: its bodies as a tree of nodes that turn, the floor, and where the base is in the world."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, final

import numpy as np
import trimesh
from numpy.typing import NDArray

from exogauge.robots.description import Robot
from exogauge.robots.tree import RigidTree
from exogauge.scene.colours import BODY, BODY_DARKER, GHOST, Rgb
from exogauge.scene.poses import InBase, planted, quaternions, upright
from exogauge.scene.shapes import body_shapes
from exogauge.scene.stage import Stage
from exogauge.studies.intake.mesh_files import Opener

Array = NDArray[np.float64]
BaseKnown = Literal["fixed", "logged", "tilt", "none"]

ROOT, GHOST_ROOT = "/robot", "/ghost"
OPACITY = 0.6  # what turns and pulls inside the bodies is seen through them
GHOST_OPACITY = 0.35
BASE_WORDS: dict[BaseKnown, str] = {
    "fixed": "The base is fixed.",
    "logged": "The base moves as logged.",
    "tilt": "The log holds no base pose: the base is held in place, by its feet where they have sensors, "
    "and tilts as the accelerometer says.",
    "none": "The log holds no base pose: the base is held in place, upright.",
}


@final
@dataclass(frozen=True)
class RobotView:
    """The drawn robot. nodes: body (-1: the fixed base) -> name of its node. R, p: (F, 3, 3), (F, 3) [m] of the base.

    floor: [m] height of the ground. low, high: (3,) [m] corners of what it fills at the first frame. size: [m].
    """

    nodes: dict[int, str]
    in_base: InBase
    R: Array
    p: Array
    known: BaseKnown
    low: Array
    high: Array

    @property
    def size(self) -> float:
        return float(max((self.high - self.low).max(), 0.2))

    def world(self, body: int, xyz: Array) -> Array:
        """(F, 3) [m] of a point of a body."""
        found: Array = np.einsum("fij,fj->fi", self.R, self.in_base.points(body, xyz)) + self.p
        return found


def draw_robot(
    stage: Stage, robot: Robot, urdf: bytes, open_mesh: Opener, q: Array, base: Array | None, up: Array | None
) -> RobotView:
    """q: (F, J) [rad or m]; base, up: as in `Take`, None where the log does not tell."""
    in_base = InBase.of(robot.tree, q)
    R, p, known = _base(robot, in_base, base, up)
    shapes = body_shapes(robot.tree, urdf, open_mesh)
    nodes = _add_bodies(stage, robot.tree, in_base, R, p, shapes, ROOT, (BODY, BODY_DARKER), OPACITY)
    stage.layers["robot"] = [f"{name}/shape" for body, name in nodes.items() if body in shapes]
    low, high = _extent(shapes, in_base, R, p)
    view = RobotView(nodes, in_base, R, p, known, low, high)
    _add_floor(stage, view)
    return view


def draw_ghost(stage: Stage, robot: Robot, urdf: bytes, open_mesh: Opener, q: Array, base: Array | None) -> None:
    """The same robot as it moves otherwise, in the same world, hidden until its layer is asked for."""
    in_base = InBase.of(robot.tree, q)
    R, p, _ = _base(robot, in_base, base, None)
    shapes = body_shapes(robot.tree, urdf, open_mesh)
    _add_bodies(stage, robot.tree, in_base, R, p, shapes, GHOST_ROOT, (GHOST, GHOST), GHOST_OPACITY, shown=False)
    stage.layers["ghost"] = [GHOST_ROOT]
    stage.hidden.append("ghost")


def _add_bodies(
    stage: Stage, tree: RigidTree, in_base: InBase, R: Array, p: Array, shapes: dict[int, trimesh.Trimesh], root: str,
    colours: tuple[Rgb, Rgb], opacity: float, shown: bool = True,
) -> dict[int, str]:  # fmt: skip
    """Bodies as a tree of nodes below `root`; their names."""
    nodes = _nodes(tree.parent, tree.floating, root)
    stage.scene.add_frame(root, show_axes=False, visible=shown)
    stage.move("turn", root, quaternions(R).astype(np.float32))
    stage.move("place", root, p.astype(np.float32))
    local = in_base.seen_from_parents(tree)
    for body, name in nodes.items():
        if body >= 0 and tree.dof[body] >= 0:
            stage.scene.add_frame(name, show_axes=False)
            stage.move("turn", name, local.turn[:, body].astype(np.float32))
            stage.move("place", name, local.place[:, body].astype(np.float32))
        if body in shapes:
            _add_shape(stage, f"{name}/shape", shapes[body], colours[body % 2 == 0], opacity)
    return nodes


def _base(robot: Robot, in_base: InBase, base: Array | None, up: Array | None) -> tuple[Array, Array, BaseKnown]:
    frames = len(in_base.p)
    still, origin = np.broadcast_to(np.eye(3), (frames, 3, 3)), np.zeros((frames, 3))
    if not robot.floating:
        return still, origin, "fixed"
    if base is not None:
        x, y, z, w = (base[:, 3:] / np.maximum(np.linalg.norm(base[:, 3:], axis=1, keepdims=True), 1e-9)).T
        return _rotations(w, x, y, z), base[:, :3], "logged"
    R, known = (upright(up), "tilt") if up is not None else (still, "none")
    feet = [robot.tree.frames[s.frame] for s in robot.sensors if s.role == "contact" and s.frame in robot.tree.frames]
    if not feet:
        return R, origin, "none" if known == "none" else "tilt"
    places = np.array([in_base.points(body, np.asarray(T.translation)) for body, T in feet])
    return R, planted(R, places), "tilt" if known == "tilt" else "none"


def _rotations(w: Array, x: Array, y: Array, z: Array) -> Array:
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def _nodes(parent: NDArray[np.intp], floating: bool, root: str) -> dict[int, str]:
    """Body -> node; a body's node is below that of the body that carries it. A floating base is the root itself."""
    nodes = {-1: root}
    for body, up in enumerate(parent):
        nodes[body] = root if floating and body == 0 else f"{nodes[int(up)]}/{body}"
    if floating:
        del nodes[-1]
    return nodes


def _add_shape(stage: Stage, name: str, shape: trimesh.Trimesh, colour: Rgb, opacity: float) -> None:
    stage.scene.add_mesh_simple(
        name,
        np.asarray(shape.vertices, dtype=np.float32),
        np.asarray(shape.faces, dtype=np.uint32),
        color=colour,
        opacity=opacity,
        flat_shading=True,
        side="front",
    )


def _extent(shapes: dict[int, trimesh.Trimesh], in_base: InBase, R: Array, p: Array) -> tuple[Array, Array]:
    """Corners of all shapes at the first frame, in the world."""
    corners = [np.zeros((1, 3))]
    for body, shape in shapes.items():
        vertices = np.asarray(shape.vertices)
        if body >= 0:
            vertices = vertices @ in_base.R[0, body].T + in_base.p[0, body]
        corners.append(vertices @ R[0].T + p[0])
    every = np.vstack(corners[1:] or corners)
    return every.min(axis=0), every.max(axis=0)


def _add_floor(stage: Stage, view: RobotView) -> None:
    """A grid of 0.1 and 0.5 m under the lowest place, or finer under a small robot."""
    cell = 0.1 if view.size > 0.4 else 0.02
    width = 10 * cell * math.ceil(0.2 * view.size / cell)
    stage.scene.add_grid(
        "/floor",
        width=width,
        height=width,
        cell_size=cell,
        section_size=5 * cell,
        cell_thickness=0.6,
        section_thickness=0.9,
        cell_color=(150, 156, 166),
        section_color=(120, 126, 138),
        position=(0.0, 0.0, float(min(view.low[2], 0.0)) - 0.002),
    )
    stage.layers["floor"] = ["/floor"]
