"""Frames are evenly spaced, cover the log, and are never more than a browser holds."""

from __future__ import annotations

import numpy as np
import pytest

from exogauge.scene.frames import MOST_FRAMES, SMOOTH_HZ, Frames


@pytest.mark.parametrize(("duration", "samples"), [(14.0, 2800), (3600.0, 720_000), (1.0, 11), (0.004, 2), (0.0, 1)])
def test_frames_go_from_the_first_to_the_last_sample(duration: float, samples: int) -> None:
    frames = Frames.of(2.0, 2.0 + duration, samples)
    assert 1 <= frames.count <= min(MOST_FRAMES, samples)
    assert frames.fps <= SMOOTH_HZ * (1 + 1e-9) or frames.count == 2
    assert frames.times[0] == 2.0
    if frames.count > 1:
        assert frames.times[-1] == pytest.approx(2.0 + duration)


def test_a_frame_shows_the_nearest_sample() -> None:
    time = np.array([0.0, 0.1, 0.4, 0.45, 1.0])
    frames = Frames(0.0, 1.0, 4.0, 5)
    gaps = np.abs(time[frames.nearest(time)] - frames.times)
    np.testing.assert_allclose(gaps, np.abs(time[:, None] - frames.times).min(axis=0))


def test_a_log_of_one_sample_has_one_frame() -> None:
    assert Frames.of(1.0, 1.0, 1).nearest(np.array([1.0])).tolist() == [0]
