"""Mesh files that came with a study, found by the names that its URDF gives them."""

from __future__ import annotations

import io
from collections.abc import Callable
from itertools import takewhile
from pathlib import Path, PurePosixPath

import numpy as np
import trimesh

Opener = Callable[[str], bytes | None]

MESHES = (".stl", ".obj", ".ply")
MESH_BYTES = 20_000_000  # of one mesh file; a larger one is left out
ALL_BYTES = 150_000_000  # of all meshes of a robot; what comes after is left out


def mesh_opener(root: Path) -> Opener:
    """Opens mesh files below `root` only, whatever scheme or package a name begins with: the file is meant whose path
    ends as the name does, over most of its parts."""
    files = {
        path.relative_to(root).parts: path
        for path in sorted(root.rglob("*"))
        if path.suffix.lower() in MESHES and path.is_file() and not path.is_symlink()
    }
    left = ALL_BYTES

    def open_mesh(name: str) -> bytes | None:
        nonlocal left
        wanted = PurePosixPath(name.replace("\\", "/").rpartition("://")[2]).parts
        alike = {parts: shared_end(parts, wanted) for parts in files}
        best = max(alike, key=lambda parts: alike[parts], default=None)
        if best is None or alike[best] == 0:
            return None
        size = files[best].stat().st_size
        if size > left:
            return None
        left -= size
        return files[best].read_bytes()

    return open_mesh


def load_mesh(name: str, open_mesh: Opener) -> trimesh.Trimesh | None:
    """A mesh file as it is; None where it is missing, too large, of another kind, or broken."""
    kind = PurePosixPath(name).suffix.lower()
    data = open_mesh(name) if kind in MESHES else None
    if data is None or len(data) > MESH_BYTES:
        return None
    try:
        mesh = trimesh.load_mesh(io.BytesIO(data), file_type=kind[1:], process=False, skip_materials=True)
    except (ValueError, KeyError, IndexError, TypeError, AttributeError, UnicodeError):
        return None  # one does without it
    if not isinstance(mesh, trimesh.Trimesh) or not len(mesh.faces) or not np.isfinite(mesh.vertices).all():
        return None
    return trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)


def shared_end(one: tuple[str, ...], other: tuple[str, ...]) -> int:
    """How many of their last parts are the same."""
    pairs = zip(reversed(one), reversed(other), strict=False)
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], pairs))
