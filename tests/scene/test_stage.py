"""The packed scene: what viser would have sent, and what moves."""

from __future__ import annotations

from typing import Any

import numpy as np

from exogauge.scene.stage import Stage, shortened


def small() -> Stage:
    stage = Stage.empty()
    stage.scene.add_line_segments("/line", np.arange(12.0).reshape(2, 2, 3), (255, 0, 0))
    stage.move("points", "/line", np.arange(36, dtype=np.float32).reshape(3, 2, 2, 3))
    stage.move("place", "/line", np.ones((3, 3), dtype=np.float32))
    return stage


def test_arrays_come_back_as_they_were(unpack: Any) -> None:
    scene = unpack(small().packed({"log": "a"}))
    points = scene.message("LineSegmentsMessage", "/line")["props"]["points"]["__array"]
    np.testing.assert_array_equal(scene.array(points), np.arange(12.0))
    np.testing.assert_array_equal(scene.track("points", "/line"), np.arange(36.0).reshape(3, 12))
    assert scene.header["log"] == "a"


def test_what_never_changes_is_said_once(unpack: Any) -> None:
    assert unpack(small().packed({})).track("place", "/line").shape == (1, 3)


def test_the_same_scene_gives_the_same_bytes() -> None:
    assert small().packed({}) == small().packed({})


def test_nothing_listens(unpack: Any) -> None:
    """viser's scene functions work without its server: no thread, no socket."""
    import threading

    before = threading.active_count()
    small().packed({})
    assert threading.active_count() == before


def test_floats_are_rounded_to_sixteen_bits() -> None:
    values = np.random.default_rng(0).normal(size=10_000).astype(np.float32)
    np.testing.assert_allclose(shortened(values), values, rtol=2.0**-16)
