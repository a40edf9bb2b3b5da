"""A device on its robot at rest: every via point can be found, chosen and dragged in its link's own frame."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from exogauge.devices.device import Band, Device, ViaPoint
from exogauge.devices.posture import Posture
from exogauge.robots.description import Robot
from exogauge.scene.recording import draw_still

DEVICE = Device(
    "suit",
    (
        Band("back", "back", (ViaPoint("leg", (0.1, 0.0, 0.0)), ViaPoint("pelvis", (-0.1, 0.0, 0.1)))),
        Band("side", "side", (ViaPoint("arm", (0.0, 0.1, 0.2)), ViaPoint("chest", (0.0, 0.1, 0.1)))),
    ),
)


@pytest.mark.parametrize(("base_link", "floating"), [("chest", True), ("pelvis", False)])
def test_a_points_place_in_its_link_is_where_its_line_begins(
    make_robot: Callable[..., Robot], urdf: bytes, unpack: Any, base_link: str, floating: bool
) -> None:
    robot = make_robot(base_link, floating)
    scene = unpack(draw_still(robot, urdf, DEVICE, lambda name: None))
    posture, points = Posture(robot.tree), scene.header["points"]
    assert [(point["band"], point["link"]) for point in points] == [
        ("back", "leg"), ("back", "pelvis"), ("side", "arm"), ("side", "chest"),
    ]  # fmt: skip
    seen = [np.array(each["rotation"]) @ each["position"] + each["origin"] for each in points]
    expected = [posture.place(point) for band in DEVICE.bands for point in band.via_points]
    np.testing.assert_allclose(np.diff(seen, axis=0), np.diff(expected, axis=0), atol=1e-9)
    for k, band in enumerate(DEVICE.bands):
        drawn = scene.message("LineSegmentsMessage", f"/bands/{k}")["props"]["points"]["__array"]
        route = [place for place, point in zip(seen, points, strict=True) if point["band"] == band.name]
        np.testing.assert_allclose(scene.array(drawn).reshape(-1, 3), route, atol=1e-6)


def test_each_point_can_be_clicked_and_has_arrows_hidden_until_then(
    make_robot: Callable[..., Robot], urdf: bytes, unpack: Any
) -> None:
    scene = unpack(draw_still(make_robot(), urdf, DEVICE, lambda name: None))
    for point in scene.header["points"]:
        assert scene.message("SetSceneNodeClickBindingsMessage", point["ball"])["bindings"]
        assert scene.message("TransformControlsMessage", point["name"])["props"]["disable_rotations"]
        assert not scene.message("SetSceneNodeVisibilityMessage", point["name"])["visible"]
        np.testing.assert_allclose(
            scene.message("SetPositionMessage", point["name"])["position"], point["position"], atol=1e-9
        )


def test_a_robot_alone_has_nothing_to_drag(make_robot: Callable[..., Robot], urdf: bytes, unpack: Any) -> None:
    header = unpack(draw_still(make_robot(), urdf, None, lambda name: None)).header
    assert (header["points"], header["frames"], header["start"], header["end"]) == ([], 1, 0.0, 0.0)
