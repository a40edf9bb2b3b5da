"""A payload on its robot: what is drawn has the place, size and inertia of what it stands for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from tests.payload.test_exports import BODY, found

from exogauge.payload.exports.body import body_of
from exogauge.payload.planning.workspace import Cap
from exogauge.robots.description import Joint, Robot
from exogauge.robots.urdf import load_tree
from exogauge.scene.payload_view import cap_mesh, draw_payload, solid_ellipsoid
from exogauge.synthetic import payload as generator

HOME = np.asarray(generator.WORK, dtype=np.float64)
CAPS = (Cap(2, theta=(np.radians(120.0), np.pi)), Cap(0, phi=(np.radians(150.0), np.radians(230.0))))


@pytest.fixture(scope="module")
def arm() -> tuple[Robot, bytes]:
    urdf = generator.arm_urdf().encode()
    joints = list(generator.JOINTS)
    tree = load_tree(urdf, joints=joints, base_link="base", floating=False)
    return Robot("arm", tree, tuple(Joint(name, "none") for name in joints), None, (), np.eye(len(joints))), urdf


def drawn(arm: tuple[Robot, bytes], unpack: Callable[[bytes], Any], **what: Any) -> Any:
    given = {"caps": (), "postures": None, "body": None} | what
    return unpack(draw_payload(*arm, lambda name: None, "ft", HOME, **given))


def vertices(scene: Any, name: str) -> np.ndarray:
    (node,) = [each for each in scene.header["messages"] if each.get("name", "").endswith(name) and "props" in each]
    return scene.array(node["props"]["vertices"]["__array"]).reshape(-1, 3).astype(np.float64)


def test_the_solid_ellipsoid_has_the_mass_and_inertia_of_the_body() -> None:
    shape = solid_ellipsoid(BODY.mass, np.asarray(BODY.inertia))
    assert shape is not None
    half, axes = shape
    rebuilt = axes @ pin.Inertia.FromEllipsoid(BODY.mass, *half).inertia @ axes.T
    np.testing.assert_allclose(rebuilt, BODY.inertia, atol=1e-12)
    assert solid_ellipsoid(1.0, np.diag([1.0, 1.0, 2.5])) is None


def test_the_body_is_drawn_about_its_centre_and_its_doubt_as_large_as_is_said(
    arm: tuple[Robot, bytes], unpack: Callable[[bytes], Any]
) -> None:
    C = np.zeros((16, 16))
    C[0, 0], C[1, 1], C[2, 2], C[3, 3] = 1e-8, 1e-6, 4e-6, 9e-6
    C += 1e-12 * np.eye(16)
    body = body_of(found(covariance=C))
    scene = drawn(arm, unpack, body=body)
    inertia, doubt = vertices(scene, "/inertia"), vertices(scene, "/doubt")
    for each in (inertia, doubt):
        np.testing.assert_allclose((each.max(axis=0) + each.min(axis=0)) / 2, body.centre, atol=1e-4)
    legend = {each["layer"]: each["size"] for each in scene.header["legend"]}
    times = float(legend["centre"].split()[1])
    reach = np.abs(doubt - body.centre).max(axis=0)
    np.testing.assert_allclose(reach, times * 3.0 * body.std[1:4], rtol=0.02)
    assert set(scene.header["layers"]) == {"robot", "floor", "sensor", "centre", "inertia"}
    assert legend["inertia"].endswith("mm")


def test_caps_hold_what_is_allowed_and_nothing_else() -> None:
    for cap in CAPS:
        points, faces = cap_mesh(cap)
        np.testing.assert_allclose(np.linalg.norm(points, axis=1), 1.0, atol=1e-12)
        margins = cap.margins(points)[0]
        assert margins.min() > -1e-9
        assert np.abs(margins).min() < 1e-9  # up to the bound
        assert faces.max() == len(points) - 1


def test_ghosts_end_where_the_sensor_stands_in_each_posture(
    arm: tuple[Robot, bytes], unpack: Callable[[bytes], Any]
) -> None:
    rng = np.random.default_rng(0)
    postures = HOME + rng.uniform(-0.5, 0.5, (4, len(HOME)))
    scene = drawn(arm, unpack, postures=postures, caps=CAPS)
    message = scene.message("LineSegmentsMessage", "/robot/postures")
    lines = scene.array(message["props"]["points"]["__array"]).reshape(4, -1, 2, 3)
    model = pin.buildModelFromXML(arm[1].decode())
    data, frame = model.createData(), model.getFrameId("ft")
    rays, order = (
        scene.array(scene.message("LineSegmentsMessage", f"/robot/postures/{part}")["props"]["points"]["__array"])
        for part in ("z", "order")
    )
    np.testing.assert_allclose(order.reshape(3, 2, 3)[1:, 0], order.reshape(3, 2, 3)[:-1, 1])
    for q, line, ray in zip(postures, lines, rays.reshape(4, 2, 3), strict=True):
        pin.framesForwardKinematics(model, data, q)
        along = (ray[1] - ray[0]) / np.linalg.norm(ray[1] - ray[0])
        np.testing.assert_allclose(along, data.oMf[frame].rotation[:, 2], atol=1e-5)
        np.testing.assert_allclose(line[-1, 1], data.oMf[frame].translation, atol=1e-5)
        np.testing.assert_allclose(line[0, 0], 0.0, atol=1e-9)
    assert len(scene.header["layers"]["workspace"]) == 2


def test_contacts_are_arrows_that_push_at_the_sensor_the_largest_longest(
    arm: tuple[Robot, bytes], unpack: Callable[[bytes], Any]
) -> None:
    forces = [np.array([0.0, 40.0, 0.0]), np.array([0.0, 0.0, -10.0])]
    scene = drawn(arm, unpack, contacts=forces)
    (message,) = [
        each for each in scene.header["messages"] if each.get("name", "").endswith("/contacts") and "props" in each
    ]
    lines = scene.array(message["props"]["points"]["__array"]).reshape(-1, 2, 3).astype(np.float64)
    np.testing.assert_allclose(lines[:, 1], 0.0, atol=1e-9)  # all end in the sensor's origin
    shafts = lines[: len(forces), 1] - lines[: len(forces), 0]
    np.testing.assert_allclose(shafts / np.linalg.norm(shafts[0]), np.array(forces) / 40.0, atol=1e-6)
    (entry,) = [each for each in scene.header["legend"] if each["layer"] == "contacts"]
    assert entry["size"] == "the longest 40 N"


def test_what_the_data_do_not_decide_is_not_drawn_and_said(
    arm: tuple[Robot, bytes], unpack: Callable[[bytes], Any]
) -> None:
    scene = drawn(arm, unpack, body=body_of(found(identified=False)))
    assert "inertia" not in scene.header["layers"]
    assert "The data decide no inertia." in scene.header["notes"]
