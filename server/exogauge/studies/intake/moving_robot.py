"""robot.yaml and its URDF become what motions are planned for.

Shapes of links are those of robot.yaml, else of the URDF's <collision>; a mesh becomes its convex hull.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal, get_args
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from exogauge.errors import BadRobot, Fault
from exogauge.robots.description import Robot
from exogauge.robots.joint_limits import JointLimits
from exogauge.robots.moving.robot import LINK, Kind, MotionRobot, Shape, Sole, flat_model
from exogauge.robots.moving.segments import LEFT, Segment
from exogauge.robots.urdf_check import numbers, read_urdf
from exogauge.studies.intake.contract import RobotFile, ShapeEntry
from exogauge.studies.intake.mesh_files import Opener, load_mesh, mesh_opener

Array = NDArray[np.float64]
HOME_FLAT_M = 0.01  # judgement: by which soles at home stray from one floor; angles in whole degrees leave some mm
SMALLEST_M2 = 1e-4  # judgement: a heel of 1 cm by 1 cm; corners on a line leave nothing


def moving_robot(robot: Robot, entry: RobotFile, urdf: bytes, path: Path, *, beside: bool = False) -> MotionRobot:
    """entry: as `path`, robot.yaml, has it; meshes are looked for below its folder, and `beside` it as `mesh_opener`
    says. Raises BadRobot, with the key that is at fault."""
    names, tree = [joint.name for joint in entry.joints], robot.tree
    model = flat_model(urdf, names, robot.floating)
    base = 6 if robot.floating else 0
    joints = tuple(list(model.names)[1 + base :])
    order = [tree.joints.index(name) for name in joints]
    links = {frame.name.removeprefix(LINK) for frame in model.frames if frame.type == pin.FrameType.BODY}
    parts = set(get_args(Segment))

    def fault(detail: str, rule: str, advice: str, column: str, value: str) -> BadRobot:
        return BadRobot(Fault(detail, rule, advice, path.name, None, column, value))

    ignored = tuple(entry.collision.left_out)
    for key, named in (
        ("soles", [sole.link for sole in entry.soles]), ("human_map", list(entry.human_map.values())),
        ("collision.shapes", list(entry.collision.shapes)),
        ("collision.left_out", [link for pair in ignored for link in pair]),
    ):  # fmt: skip
        for link in named:
            if link not in links:
                raise fault("the URDF has no such link", "unknown_link", "Name one of its links", key, link)
    for part in entry.human_map:
        if part not in parts:
            raise fault("no such part of the body", "unknown_segment", f"One of {', '.join(sorted(parts))}",
                        f"human_map.{part}", part)  # fmt: skip
    stated = {f"limits.{key}": value for key, value in entry.limits}
    for key, value in {"home": entry.home, **stated}.items():
        for name in value if isinstance(value, dict) else ():
            if name not in joints:
                raise fault(
                    "the robot has no such joint", "unknown_joint", "Name one of `joints`", f"{key}.{name}", name
                )

    def of_joints(key: str, none: float) -> Array:
        value = stated[f"limits.{key}"]
        return np.array([value.get(name, none) if isinstance(value, dict) else value for name in joints])

    endless = {each.get("name") for each in read_urdf(urdf).findall("joint[@type='continuous']")}
    # A turn each way of a joint without end is judgement, as cables bear more or less: it stands in for a limit that
    # the maker left out. `type: revolute` with limits in the URDF says otherwise.
    turn = np.array([math.tau if name in endless else np.inf for name in joints])
    limits = JointLimits(
        np.maximum(tree.lower[order], -turn), np.minimum(tree.upper[order], turn),
        tree.velocity_limit[order], of_joints("acceleration", np.inf),
        tree.effort_limit[order] * of_joints("torque_share", 1.0), of_joints("jerk", np.inf),
    )  # fmt: skip
    posture = np.array([entry.home.get(name, 0.0) for name in joints])
    for name, value, low, high in zip(joints, posture, limits.lower, limits.upper, strict=True):
        if not low <= value <= high:
            advice = "Give a posture within the limits; where they are not the joint's, correct its <limit> in the URDF"
            raise fault(f"home lies outside [{low:g}, {high:g}]", "home_outside", advice, f"home.{name}", f"{value:g}")
    soles = tuple(Sole(sole.link, np.array(sole.outline)) for sole in entry.soles)
    for k, sole in enumerate(soles):
        if (wrong := _no_sole(sole)) is not None:
            raise fault(wrong, "no_sole", "Corners of what stands on the floor, in order around", f"soles.{k}.outline",
                        sole.link)  # fmt: skip
    if len(soles) == 2:
        if soles[0].link == soles[1].link:
            raise fault("both soles are of one foot", "one_foot", "Name the other foot", "soles.1.link", soles[1].link)
        if [bool(LEFT.search(sole.link)) for sole in soles] == [False, True]:
            raise fault("the left foot is listed behind the right one", "right_first", "Name the left one first",
                        "soles.0.link", soles[0].link)  # fmt: skip
    segments: dict[Segment, str] = dict(entry.human_map)  # type: ignore[assignment]
    shapes, shapeless = shapes_of(urdf, entry.collision.shapes, mesh_opener(path.parent, beside=beside))
    made = MotionRobot(
        robot.name, model, joints, robot.floating, limits, soles, segments, None, shapes, ignored, shapeless
    )
    home = np.concatenate([np.zeros(base), posture])
    if not soles or not robot.floating:
        return replace(made, home=home)
    pin.forwardKinematics(model, made.data, home)
    at = [pin.updateFramePlacement(model, made.data, made.frame(sole.link)).copy() for sole in soles]
    corners = [sole.outline @ pose.rotation.T + pose.translation for sole, pose in zip(soles, at, strict=True)]
    home[2] = -min(each[:, 2].min() for each in corners)
    high = [float(each[:, 2].max() + home[2]) for each in corners]
    if max(high) > HOME_FLAT_M:
        k = int(np.argmax(high))
        detail = f"at home a corner of this sole is {1e3 * high[k]:.0f} mm above the floor, on which the lowest stands"
        raise fault(detail, "not_flat", "Correct `home`, by hips, knees and ankles, or the outline", f"soles.{k}",
                    soles[k].link)  # fmt: skip
    soles = tuple(
        sole if pose.rotation[2] @ sole.axes[:, 2] > 0.0 else Sole(sole.link, sole.outline[::-1].copy())
        for sole, pose in zip(soles, at, strict=True)
    )
    return replace(made, soles=soles, home=home)


def _no_sole(sole: Sole) -> str | None:
    """Why nothing stands on it."""
    spokes = sole.outline - sole.middle
    areas = 0.5 * np.cross(spokes, np.roll(spokes, -1, axis=0))
    whole = float(np.linalg.norm(areas, axis=1).sum())
    if whole < SMALLEST_M2:
        return f"the corners lie on a line: {1e4 * whole:.2g} cm² between them"
    if np.linalg.norm(areas.sum(axis=0)) < 0.5 * whole:
        return "the outline crosses itself"
    return None


SIZES: dict[str, tuple[str, ...]] = {
    "box": ("size",), "sphere": ("radius",), "cylinder": ("radius", "length"), "capsule": ("radius", "length"),
}  # fmt: skip


def shapes_of(
    urdf: bytes, stated: Mapping[str, Sequence[ShapeEntry]], open_mesh: Opener
) -> tuple[tuple[Shape, ...], tuple[str, ...]]:
    """The shapes, and the links whose shape is in a file that is not there or cannot be read."""
    shapes, lacking = list[Shape](), list[str]()
    for link in read_urdf(urdf).findall("link"):
        name = link.get("name", "")
        if name in stated:
            shapes += [_stated(name, entry) for entry in stated[name]]
            continue
        for element in link.findall("collision"):
            shape = _drawn(name, element, open_mesh)
            if shape is not None:
                shapes.append(shape)
            elif name not in lacking:
                lacking.append(name)
    return tuple(shapes), tuple(lacking)


def _stated(link: str, entry: ShapeEntry) -> Shape:
    kinds: dict[Literal["box", "sphere", "cylinder", "capsule"], tuple[float, ...] | float | None] = {
        "box": entry.box, "sphere": entry.sphere, "cylinder": entry.cylinder, "capsule": entry.capsule,
    }  # fmt: skip
    kind, size = next((kind, size) for kind, size in kinds.items() if size is not None)
    at = pin.SE3(pin.rpy.rpyToMatrix(np.array(entry.rpy)), np.array(entry.xyz))
    return Shape(link, kind, size if isinstance(size, tuple) else (size,), at)


def _drawn(link: str, element: Element, open_mesh: Opener) -> Shape | None:
    part = next(iter(element.find("geometry") or ()), None)
    if part is None:
        return None
    origin = element.find("origin")
    xyz, rpy = ((_read(origin, key) or [0.0, 0.0, 0.0]) for key in ("xyz", "rpy"))
    at = pin.SE3(pin.rpy.rpyToMatrix(np.array(rpy)), np.array(xyz))
    if part.tag in SIZES:
        kind: Kind = part.tag  # type: ignore[assignment]
        size = [number for key in SIZES[kind] for number in _read(part, key)]
        return Shape(link, kind, tuple(size), at) if size and min(size) > 0.0 else None
    mesh = load_mesh(part, open_mesh) if part.tag == "mesh" else None
    if mesh is None:
        return None
    points = np.asarray(mesh.vertices)
    try:
        hull = points[ConvexHull(points).vertices]
        return Shape(link, "hull", (), at, hull, (points, np.asarray(mesh.faces, dtype=np.intp)))
    except (QhullError, ValueError):
        return None  # flat, or too few points


def _read(element: Element | None, key: str) -> list[float]:
    try:
        return numbers(element.get(key, "")) if element is not None else []
    except ValueError:
        return []
