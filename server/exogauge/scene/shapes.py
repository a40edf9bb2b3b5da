"""What the bodies of a robot look like: its URDF's own shapes and meshes where it has any, else made from its tree."""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin
import trimesh
from numpy.typing import NDArray

from exogauge.robots.tree import RigidTree
from exogauge.robots.urdf_check import numbers, read_urdf
from exogauge.studies.intake.mesh_files import Opener, load_mesh

Array = NDArray[np.float64]

MOST_FACES = 4000  # of one mesh; finer ones are simplified
SLIMMEST, WIDEST = 0.012, 0.06  # [m] radii of made-up limbs
BODY_DENSITY = 600.0  # [kg/m³] of made-up bodies: motors, shells and air


def body_shapes(tree: RigidTree, urdf: bytes, open_mesh: Opener) -> dict[int, trimesh.Trimesh]:
    """Body (-1: the fixed base) -> its shape in the body's frame. open_mesh: a mesh file's bytes by the name in the
    URDF, None where there is none."""
    drawn, lacking = dict[int, list[trimesh.Trimesh]](), set[int]()
    for link in read_urdf(urdf).findall("link"):
        place = tree.frames.get(link.get("name", ""))
        if place is None:
            continue
        body, T_body_link = place
        for visual in link.findall("visual"):
            shape = _visual(visual, open_mesh)
            if shape is not None:
                drawn.setdefault(body, []).append(shape.apply_transform(T_body_link.homogeneous))
            else:
                lacking.add(body)
    made = {body: parts for body, parts in made_up(tree).items() if not drawn or body in lacking - set(drawn)}
    return {body: joined(parts) for body, parts in (drawn | made).items()}


def joined(parts: list[trimesh.Trimesh]) -> trimesh.Trimesh:
    """One mesh of several."""
    first = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.faces + start for part, start in zip(parts, first[:-1], strict=True)]
    return trimesh.Trimesh(np.vstack([part.vertices for part in parts]), np.vstack(faces), process=False)


def made_up(tree: RigidTree) -> dict[int, list[trimesh.Trimesh]]:
    """Limbs from each body's origin to where its children hang, and a box of its mass and shape round its centre."""
    parts = dict[int, list[trimesh.Trimesh]]()
    ends = dict[int, list[Array]]()
    for i, parent in enumerate(tree.parent):
        if parent >= 0 or not tree.floating:
            ends.setdefault(int(parent), []).append(np.asarray(tree.T_before[i].translation))
    for frame_body, T in tree.frames.values():
        if frame_body not in ends:  # a limb's last body reaches to its farthest frame
            ends[frame_body] = [np.asarray(T.translation)]
    for body in range(-1, len(tree.bodies)):
        mass = float(tree.phi[body, 0]) if body >= 0 else 0.0
        radius = float(np.clip(0.03 * max(mass, 0.05) ** (1 / 3), SLIMMEST, WIDEST))
        made = [limb(np.zeros(3), end, radius) for end in ends.get(body, []) if np.linalg.norm(end) > radius]
        box = _box_of(tree.phi[body]) if body >= 0 else None
        if box is not None:
            made.append(box)
        if not made and body >= 0:
            made.append(trimesh.creation.icosphere(2, radius))
        if made:
            parts[body] = made
    return parts


def limb(start: Array, end: Array, radius: float) -> trimesh.Trimesh:
    """A capsule from start to end [m]."""
    along = end - start
    length = float(np.linalg.norm(along))
    shape = trimesh.creation.capsule(height=length, radius=radius, count=[16, 16])
    turn = np.eye(4)
    turn[:3, :3] = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), along / length).matrix()
    turn[:3, 3] = start
    return shape.apply_transform(turn)


def _box_of(phi: Array) -> trimesh.Trimesh | None:
    """The box with a body's centre of mass, axes and proportions, of a size that its mass fills; None without mass."""
    mass = float(phi[0])
    if mass <= 1e-3:
        return None
    body = pin.Inertia.FromDynamicParameters(phi)
    moments, axes = np.linalg.eigh(np.asarray(body.inertia))
    squares = np.maximum(moments.sum() / 2.0 - moments, 1e-3 * max(moments.sum(), 1e-12)) * 12.0 / mass
    edges = np.sqrt(np.maximum(squares, 1e-6))
    edges *= min((mass / BODY_DENSITY / edges.prod()) ** (1 / 3), 1.0)
    if np.linalg.det(axes) < 0:
        axes[:, 0] *= -1.0
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = axes, np.asarray(body.lever)
    box: trimesh.Trimesh = trimesh.creation.box(edges, place)
    return box


def _visual(visual: Element, open_mesh: Opener) -> trimesh.Trimesh | None:
    """One <visual> in its link's frame; None where it cannot be drawn."""
    geometry = visual.find("geometry")
    shape = None if geometry is None else next(_shapes(geometry, open_mesh), None)
    if shape is None:
        return None
    origin = visual.find("origin")
    xyz, rpy = (_numbers(origin, key) or [0.0, 0.0, 0.0] for key in ("xyz", "rpy"))
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = pin.rpy.rpyToMatrix(np.array(rpy)), xyz
    shape.apply_transform(place)
    return shape


def _shapes(geometry: Element, open_mesh: Opener) -> Iterator[trimesh.Trimesh]:
    for part in geometry:
        size, radius, length = (_numbers(part, key) for key in ("size", "radius", "length"))
        if part.tag == "box" and len(size) == 3:
            yield trimesh.creation.box(size)
        elif part.tag == "cylinder" and radius and length:
            yield trimesh.creation.cylinder(radius[0], length[0], sections=24)
        elif part.tag == "capsule" and radius and length:
            yield trimesh.creation.capsule(length[0], radius[0], count=[16, 16])
        elif part.tag == "sphere" and radius:
            yield trimesh.creation.icosphere(2, radius[0])
        elif part.tag == "mesh":
            mesh = read_mesh(part, open_mesh)
            if mesh is not None:
                yield mesh


def read_mesh(part: Element, open_mesh: Opener) -> trimesh.Trimesh | None:
    """The file of a <mesh> simplified to `MOST_FACES`; None where there is none to be read."""
    mesh = load_mesh(part, open_mesh)
    return simplified(mesh) if mesh is not None and len(mesh.faces) > MOST_FACES else mesh


def simplified(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """Vertices of one cell of a grid become their mean; the grid is as coarse as `MOST_FACES` asks."""
    low, extent = mesh.vertices.min(axis=0), float(np.ptp(mesh.vertices, axis=0).max()) or 1.0
    for cells in (96, 64, 48, 32, 24, 16, 12):
        grid = np.floor((mesh.vertices - low) * (cells / extent)).astype(np.int64)
        _, cell = np.unique(grid, axis=0, return_inverse=True)
        cell = cell.reshape(-1)
        count = np.bincount(cell)
        vertices = np.column_stack([np.bincount(cell, mesh.vertices[:, k]) / count for k in range(3)])
        faces = cell[mesh.faces]
        faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])]
        if len(faces) <= MOST_FACES:
            break
    return trimesh.Trimesh(vertices, faces, process=False)


def _numbers(element: Element | None, key: str) -> list[float]:
    try:
        return numbers(element.get(key, "")) if element is not None else []
    except ValueError:
        return []
