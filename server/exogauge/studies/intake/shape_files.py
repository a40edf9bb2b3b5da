"""Shapes of links from robot.yaml, else from the URDF's <collision>; a mesh becomes its convex hull."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin
from scipy.spatial import ConvexHull, QhullError

from exogauge.robots.moving.shapes import Kind, Shape
from exogauge.robots.urdf_check import numbers, read_urdf
from exogauge.studies.intake.contract import ShapeEntry
from exogauge.studies.intake.mesh_files import Opener, load_mesh

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
    mesh = load_mesh(part.get("filename", ""), open_mesh) if part.tag == "mesh" else None
    if mesh is None:
        return None
    points = np.asarray(mesh.vertices) * np.array(_read(part, "scale") or [1.0])
    try:
        return Shape(link, "hull", (), at, points[ConvexHull(points).vertices])
    except (QhullError, ValueError):
        return None  # flat, or too few points


def _read(element: Element | None, key: str) -> list[float]:
    try:
        return numbers(element.get(key, "")) if element is not None else []
    except ValueError:
        return []
