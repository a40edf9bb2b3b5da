"""Bands are drawn through their via points, in the colour of their tension, dashed while slack."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from exogauge.devices.device import Band, Device, ViaPoint
from exogauge.devices.posture import Posture
from exogauge.robots.description import Robot
from exogauge.scene.colours import TENSION, round_up
from exogauge.scene.recording import dashed, draw_bands
from exogauge.scene.robot_view import draw_robot
from exogauge.scene.stage import Stage

BAND = Band("back", "back", (ViaPoint("leg", (0.1, 0.0, 0.0)), ViaPoint("pelvis", (-0.1, 0.0, 0.1)),
                             ViaPoint("arm", (0.0, 0.1, 0.2))))  # fmt: skip
Q = np.random.default_rng(4).uniform(-1.0, 1.0, (4, 4))


def drawn(robot: Robot, urdf: bytes, unpack: Any, tension: dict[str, np.ndarray]) -> tuple[Any, float]:
    stage = Stage.empty()
    view = draw_robot(stage, robot, urdf, lambda name: None, Q, None, None)
    most = draw_bands(stage, view, robot.tree, Device("suit", (BAND,)), tension)
    return unpack(stage.packed({})), most


def test_a_band_runs_through_its_via_points_in_every_frame(
    make_robot: Callable[..., Robot], urdf: bytes, unpack: Any
) -> None:
    robot = make_robot("pelvis", False)
    scene, _ = drawn(robot, urdf, unpack, {})
    lines = scene.track("points", "/bands/0").reshape(4, 2, 2, 3)
    for frame, q in enumerate(Q):
        posture = Posture(robot.tree, q)
        places = np.array([posture.place(point) for point in BAND.via_points])
        np.testing.assert_allclose(lines[frame, :, 0], places[:-1], atol=1e-4)
        np.testing.assert_allclose(lines[frame, :, 1], places[1:], atol=1e-4)


def test_the_colour_follows_the_tension_up_to_the_scales_end(
    make_robot: Callable[..., Robot], urdf: bytes, unpack: Any
) -> None:
    scene, most = drawn(make_robot(), urdf, unpack, {"back": np.array([1e-9, 5.0, 15.0, 20.0])})
    colours = scene.track("colors", "/bands/0").reshape(4, -1, 3)
    assert most == 20.0
    assert (colours == colours[:, :1]).all()
    np.testing.assert_array_equal(colours[[0, 1, 2, 3], 0], TENSION[[0, 1, 3, 4]])


def test_a_slack_band_is_dashed_and_never_both(make_robot: Callable[..., Robot], urdf: bytes, unpack: Any) -> None:
    scene, _ = drawn(make_robot(), urdf, unpack, {"back": np.array([0.0, 5.0, 0.0, 20.0])})
    solid, dashes = (scene.track("visible", name)[:, 0] for name in ("/bands/0", "/bands/0_slack"))
    assert solid.tolist() == [0, 1, 0, 1]
    assert dashes.tolist() == [1, 0, 1, 0]


def test_dashes_cover_half_of_the_band() -> None:
    lines = np.random.default_rng(1).normal(size=(3, 4, 2, 3))
    whole = np.linalg.norm(lines[:, :, 1] - lines[:, :, 0], axis=2).sum(axis=1)
    pieces = dashed(lines)
    np.testing.assert_allclose(np.linalg.norm(pieces[:, :, 1] - pieces[:, :, 0], axis=2).sum(axis=1), whole / 2)
    np.testing.assert_allclose(pieces[:, 0, 0], lines[:, 0, 0])


@pytest.mark.parametrize(
    ("value", "end"), [(0.0, 1.0), (19.3, 20.0), (20.0, 20.0), (21.0, 25.0), (0.034, 0.05), (7, 10)]
)
def test_a_scale_ends_at_a_round_number(value: float, end: float) -> None:
    assert round_up(value) == pytest.approx(end)
