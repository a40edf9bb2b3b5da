"""Gaps are cut into motions that are known, and must close to what was there, or stay."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from exogauge.motion.files import open_motion
from exogauge.motion.gaps import fill_gaps
from exogauge.motion.human import HumanMotion, Markers

SQUAT = Path(__file__).parents[3] / "shared" / "data" / "mocap_c3d" / "squat.c3d.gz"
LABELS = ("LASI", "RASI", "LPSI", "RPSI", "SACR", "LELB", "loose")


def swinging(noise: float = 0.0) -> HumanMotion:
    """Five markers on one rigid pelvis, one on an arm, one of no known part; 4 s at 100 Hz."""
    time = np.arange(400) / 100.0
    rng = np.random.default_rng(3)
    on_body = rng.uniform(-0.15, 0.15, (7, 3))
    turn = Rotation.from_rotvec(np.stack([np.sin(2 * time), 0.6 * np.cos(3 * time), 0.3 * time], axis=1)).as_matrix()
    place = (
        np.einsum("tab,mb->tma", turn, on_body) + np.stack([0.3 * time, np.sin(time), 1 + 0 * time], axis=1)[:, None]
    )
    place = place + noise * rng.standard_normal(place.shape)
    segment = dict.fromkeys(LABELS[:5], "pelvis") | {"LELB": "l_upper_arm"}
    return HumanMotion("made", time, Markers(LABELS, place, np.zeros(place.shape[:2], dtype=bool), segment))


def cut(motion: HumanMotion, *gaps: tuple[int, int, int]) -> HumanMotion:
    place = motion.markers.position.copy()
    for marker, start, stop in gaps:
        place[start:stop, marker] = np.nan
    markers = motion.markers
    return HumanMotion("cut", motion.time, Markers(markers.labels, place, markers.filled, markers.segment))


def test_a_short_gap_closes_by_a_spline_whatever_the_marker() -> None:
    truth = swinging()
    filled = fill_gaps(cut(truth, (6, 100, 108)))
    assert np.abs(filled.markers.position - truth.markers.position).max() < 1e-4
    assert np.argwhere(filled.markers.filled).tolist() == [[t, 6] for t in range(100, 108)]


def test_a_long_gap_closes_by_the_rigid_segment_alone() -> None:
    truth = swinging()
    filled = fill_gaps(cut(truth, (0, 100, 250), (1, 0, 60), (5, 100, 250), (6, 350, 400))).markers
    assert np.abs(filled.position[:, :5] - truth.markers.position[:, :5]).max() < 1e-12
    assert np.isnan(filled.position[100:250, 5]).all()  # alone on its arm: no other marker carries it
    assert np.isnan(filled.position[350:, 6]).all()
    assert filled.filled.sum() == 150 + 60


def test_two_others_or_others_that_do_not_move_rigidly_carry_nothing() -> None:
    few = fill_gaps(cut(swinging(), (0, 100, 250), (1, 100, 250), (2, 100, 250)))
    assert np.isnan(few.markers.position[100:250, :3]).all()
    soft = fill_gaps(cut(swinging(noise=0.1), (0, 100, 250)))
    assert np.isnan(soft.markers.position[100:250, 0]).mean() > 0.9


def test_what_was_measured_stays_to_the_bit() -> None:
    motion = cut(swinging(), (0, 100, 250), (3, 20, 25))
    seen = np.isfinite(motion.markers.position[..., 0])
    filled = fill_gaps(motion).markers
    assert np.array_equal(filled.position[seen], motion.markers.position[seen])
    assert not filled.filled[seen].any()


@pytest.mark.skipif(not SQUAT.exists(), reason="the capture mocap_c3d is not beside the repository")
def test_cut_out_of_a_real_squat_the_waist_comes_back(tmp_path) -> None:
    (tmp_path / "squat.c3d").write_bytes(gzip.decompress(SQUAT.read_bytes()))
    motion = open_motion(tmp_path / "squat.c3d")
    truth, at = motion.markers.position, motion.markers.labels.index("LMWT")
    free = np.isfinite(truth[:, [motion.markers.labels.index(x) for x in ("RMWT", "LBWT", "RBWT", "LMWT")], 0]).all(
        axis=1
    )
    start = next(t for t in range(300, 2000) if free[t - 1 : t + 121].all())
    again = fill_gaps(cut(motion, (at, start, start + 120))).markers  # 1 s
    missed = np.linalg.norm(again.position[start : start + 120, at] - truth[start : start + 120, at], axis=1)
    assert np.sqrt(np.nanmean(missed**2)) < 0.02  # skin moves by as much
    assert np.isfinite(missed).mean() > 0.9
