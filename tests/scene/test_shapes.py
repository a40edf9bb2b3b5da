"""What bodies look like: their meshes where these came along, else something of their mass and length."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
import pytest
import trimesh

from exogauge.robots.description import Robot
from exogauge.scene.shapes import MOST_FACES, body_shapes, read_mesh
from exogauge.studies.intake.mesh_files import mesh_opener

VISUAL = '<visual><origin xyz="0 0 1"/><geometry><mesh filename="{0}" scale="2 2 2"/></geometry></visual></link>'


def with_mesh(urdf: bytes, name: str) -> bytes:
    """The mesh on the last link, the foot."""
    head, _, tail = urdf.decode().rpartition("</link>")
    return (head + VISUAL.format(name) + tail).encode()


def test_a_mesh_of_the_bundle_is_found_by_the_end_of_its_name(
    make_robot: Callable[..., Robot], urdf: bytes, tmp_path: Path
) -> None:
    for place, size in (("meshes/left/foot.stl", 0.2), ("meshes/right/foot.stl", 0.1)):
        (tmp_path / place).parent.mkdir(parents=True)
        trimesh.creation.box([size] * 3).export(tmp_path / place)
    tree = make_robot().tree
    shapes = body_shapes(tree, with_mesh(urdf, "package://robot/left/foot.stl"), mesh_opener(tmp_path))
    foot = tree.bodies.index("foot")
    assert list(shapes) == [foot]
    np.testing.assert_allclose(shapes[foot].bounds, [[-0.2, -0.2, 0.8], [0.2, 0.2, 1.2]])


def test_where_meshes_were_left_out_every_body_gets_a_shape(make_robot: Callable[..., Robot], urdf: bytes) -> None:
    tree = make_robot().tree
    for described in (urdf, with_mesh(urdf, "package://robot/foot.stl")):
        assert set(body_shapes(tree, described, lambda name: None)) >= set(range(len(tree.bodies)))


def test_no_file_outside_the_bundle_is_opened(tmp_path: Path) -> None:
    trimesh.creation.box([1, 1, 1]).export(tmp_path / "secret.stl")
    inside = tmp_path / "study"
    inside.mkdir()
    (inside / "link.stl").symlink_to(tmp_path / "secret.stl")
    (tmp_path / "other").mkdir()
    trimesh.creation.box([1, 1, 1]).export(tmp_path / "other" / "secret.stl")
    opened = mesh_opener(inside)
    for name in ("../secret.stl", "../other/secret.stl", "a/../../other/secret.stl", "..\\other\\secret.stl",
                 str(tmp_path / "secret.stl"), "file:///secret.stl", "link.stl"):  # fmt: skip
        assert opened(name) is None


@pytest.mark.slow
def test_a_fine_mesh_is_simplified_and_keeps_its_extent() -> None:
    fine = trimesh.creation.icosphere(6, 0.3)
    assert len(fine.faces) > 10 * MOST_FACES
    mesh = read_mesh(Element("mesh", filename="ball.stl"), lambda name: fine.export(file_type="stl"))
    assert mesh is not None
    assert 0 < len(mesh.faces) <= MOST_FACES
    np.testing.assert_allclose(mesh.bounds, fine.bounds, atol=0.02)


def test_a_broken_mesh_is_left_out() -> None:
    for name, data in (("a.stl", b"solid"), ("a.stl", b"\0" * 84), ("a.obj", b"f 1 2 3\n"), ("a.exe", b"MZ")):
        assert read_mesh(Element("mesh", filename=name), lambda _, data=data: data) is None  # type: ignore[misc]


@pytest.mark.parametrize(
    ("scale", "size"), [("", (1, 2, 3)), ("2", (2, 4, 6)), ("1 1 1 1", (1, 2, 3)), ("1 2 3", (1, 4, 9)), ("1 2", None),
                        ("1 nan 1", None), ("a", None)]
)  # fmt: skip
def test_a_mesh_is_scaled_or_left_out(scale: str, size: tuple[float, ...] | None) -> None:
    """RACECAR writes four numbers: a traceback."""
    box = trimesh.creation.box((1, 2, 3)).export(file_type="stl")
    mesh = read_mesh(Element("mesh", filename="a.stl", scale=scale), lambda _: box)
    assert (mesh is None) is (size is None)
    if mesh is not None:
        np.testing.assert_allclose(mesh.extents, size, rtol=1e-6)
