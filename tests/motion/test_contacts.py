"""A step that is known, and recordings whose activities their makers labelled."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest

from exogauge.motion.contacts import with_contacts
from exogauge.motion.files import open_motion
from exogauge.motion.human import HumanMotion, Markers

DATA = Path(__file__).parents[3] / "shared" / "data"


def test_a_step_is_found_and_a_flicker_is_not() -> None:
    time = np.arange(300) / 100.0
    up = np.where((time > 1.0) & (time < 1.6), np.sin(np.pi * (time - 1.0) / 0.6), 0.0)
    left = np.stack([0.5 * np.clip((time - 1.0) / 0.6, 0, 1), 0.1 + 0 * time, 0.05 + 0.12 * up], axis=1)
    right = np.stack([0 * time, -0.1 + 0 * time, 0.05 + 0 * time], axis=1)
    right[200:203] += [0.05, 0.0, 0.0]  # a marker that jumps for 30 ms
    toe = np.array([0.15, 0.0, 0.0])
    place = np.stack([left, left + toe, right, right + toe], axis=1)
    place[50:60, :2] = place[250:260, 2:] = np.nan
    labels = ("LHEE", "LTOE", "RHEE", "RTOE")
    segment = {label: ("l_foot" if label[0] == "L" else "r_foot") for label in labels}
    made = HumanMotion("made", time, Markers(labels, place, np.zeros(place.shape[:2], dtype=bool), segment))
    contacts = with_contacts(made).contacts
    swings = np.flatnonzero(~contacts.left)
    assert [time[swings[0]], time[swings[-1]]] == pytest.approx([1.0, 1.6], abs=0.06)
    assert len(swings) == swings[-1] - swings[0] + 1
    assert contacts.right.all()


def _opened(tmp_path: Path, name: str, skeleton: str | None = None) -> HumanMotion:
    folder, file = name.split("/")
    if not (DATA / folder).is_dir():
        pytest.skip(f"the capture {folder!r} is not beside the repository (../shared/data/{folder})")
    (tmp_path / file).write_bytes(gzip.decompress((DATA / folder / f"{file}.gz").read_bytes()))
    return with_contacts(open_motion(tmp_path / file, skeleton=DATA / folder / skeleton if skeleton else None))


@pytest.mark.parametrize("name", ["mocap_c3d/squat.c3d", "opencap_sts_trc_grf/STS1.trc"])
def test_feet_that_stay_stand(tmp_path, name) -> None:
    contacts = _opened(tmp_path, name).contacts
    assert (contacts.left & contacts.right).mean() > 0.97


@pytest.mark.slow
def test_jumps_knee_raises_and_squats_are_told_apart(tmp_path) -> None:
    """Times of the activities are those of the labels beside the recording."""
    motion = _opened(tmp_path, "cmu_mocap_bend_twist/13_29.amc", "02.asf")
    left, right, time = motion.contacts.left, motion.contacts.right, motion.time

    def share(which: np.ndarray, start: float, stop: float) -> float:
        return float(which[(time > start) & (time < stop)].mean())

    assert share(~left & ~right, 0.5, 3.5) > 0.1
    assert share(left ^ right, 23.5, 31.0) > 0.3
    assert share(left & right, 33.0, 38.0) > 0.95
    assert share(left & right, 11.0, 15.5) > 0.95  # arms circle
