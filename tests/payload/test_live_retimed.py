"""Poses at the times of late wrenches are those of the motion, however samples come."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from exogauge.payload.live_track import Retimed

Array = NDArray[np.float64]
TIME = np.arange(200) / 250.0


def moved(time: Array) -> Array:
    """(T, 1, 3) of a joint that swings at 1 Hz."""
    w = 2 * np.pi
    return np.stack([np.sin(w * time), w * np.cos(w * time), -(w**2) * np.sin(w * time)], axis=1)[:, None]


@pytest.mark.parametrize("late", [0.0, 0.0113, -0.0071])
@pytest.mark.parametrize("size", [1, 7, 200])
def test_poses_are_those_of_late_wrenches(late: float, size: int) -> None:
    retimed = Retimed(0.05)
    retimed.late = late
    state = moved(TIME)
    parts = [
        retimed.then(TIME[k : k + size], state[k : k + size], np.ones((len(TIME[k : k + size]), 1)))[0]
        for k in range(0, len(TIME), size)
    ]
    told = np.concatenate([*parts, retimed.then(TIME[:0], state[:0], np.ones((0, 1)), last=True)[0]])
    assert len(told) == len(TIME)
    inside = np.abs(TIME - TIME.mean()) < 0.35
    assert told[inside, 0, :2] == pytest.approx(moved(TIME - late)[inside, 0, :2], abs=1e-6)
    assert told[inside, 0, 2] == pytest.approx(moved(TIME - late)[inside, 0, 2], abs=40.0 * (0.03**2) / 8)


def test_a_delay_may_be_found_on_the_way() -> None:
    retimed, state, told = Retimed(0.05), moved(TIME), list[Array]()
    for k in range(len(TIME)):
        retimed.late = 0.0 if k < 100 else 0.02
        told.append(retimed.then(TIME[[k]], state[[k]], np.ones((1, 1)))[0])
    assert np.concatenate(told)[100:, 0, 0] == pytest.approx(moved(TIME - 0.02)[100:, 0, 0], abs=1e-6)
