"""Mesh files that came with a study, found by the names that its URDF gives them."""

from __future__ import annotations

import io
from collections.abc import Callable
from itertools import takewhile
from pathlib import Path, PurePosixPath
from posixpath import normpath
from xml.etree.ElementTree import Element

import numpy as np
import trimesh

from exogauge.robots.urdf_check import numbers

Opener = Callable[[str], bytes | None]

MESHES = (".stl", ".obj", ".ply")
MESH_BYTES = 20_000_000  # of one mesh file; a larger one is left out
ALL_BYTES = 150_000_000  # of all meshes of a robot; what comes after is left out


def mesh_opener(root: Path, *, beside: bool = False) -> Opener:
    """Opens mesh files below `root` only, whatever scheme, package or `../` a name begins with: the file is meant whose
    path ends as the name does, over most of its parts.

    beside: what is not there is looked for below the folders that `root` lies in, as packages lie side by side; for
    files of one's own alone.
    """
    files = {
        path.relative_to(root).parts: path
        for path in sorted(root.rglob("*"))
        if path.suffix.lower() in MESHES and path.is_file() and not path.is_symlink()
    }
    left = ALL_BYTES

    def open_mesh(name: str) -> bytes | None:
        nonlocal left
        said = name.replace("\\", "/").rpartition("://")[2].lstrip("/")
        wanted = PurePosixPath(normpath(f"/{said}")).parts[1:]  # above the top `..` leads nowhere
        alike = {parts: shared_end(parts, wanted) for parts in files}
        best = max(alike, key=lambda parts: alike[parts], default=None)
        path = files[best] if best is not None and alike[best] else _beside(root, wanted) if beside else None
        if path is None or (size := path.stat().st_size) > left:
            return None
        left -= size
        return path.read_bytes()

    return open_mesh


def _beside(root: Path, wanted: tuple[str, ...]) -> Path | None:
    """The file that ends as `wanted` does, below a folder that `root` lies in: folder and name at least."""
    paths = (folder.joinpath(*wanted[k:]) for k in range(len(wanted) - 1) for folder in root.resolve().parents)
    return next((path for path in paths if path.suffix.lower() in MESHES and path.is_file()), None)


def load_mesh(part: Element, open_mesh: Opener) -> trimesh.Trimesh | None:
    """The file that a <mesh> names, in its `scale`; None where it is missing, too large, of another kind, or broken."""
    name = part.get("filename", "")
    kind = PurePosixPath(name).suffix.lower()
    data = open_mesh(name) if kind in MESHES else None
    if data is None or len(data) > MESH_BYTES:
        return None
    try:
        scale = numbers(part.get("scale") or "1 1 1")
        x, y, z = scale if len(set(scale)) > 1 else scale[:1] * 3  # some write one, or four
        mesh = trimesh.load_mesh(io.BytesIO(data), file_type=kind[1:], process=False, skip_materials=True)
    except (ValueError, KeyError, IndexError, TypeError, AttributeError, UnicodeError):
        return None  # one does without it
    if not isinstance(mesh, trimesh.Trimesh) or not len(mesh.faces):
        return None
    points = mesh.vertices * (x, y, z)
    return trimesh.Trimesh(points, mesh.faces, process=False) if np.isfinite(points).all() else None


def shared_end(one: tuple[str, ...], other: tuple[str, ...]) -> int:
    """How many of their last parts are the same."""
    pairs = zip(reversed(one), reversed(other), strict=False)
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], pairs))
