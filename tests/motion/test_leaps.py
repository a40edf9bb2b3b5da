"""Points that are elsewhere from one frame to the next, and names of left and right that do not agree: each was fitted
or retargeted in silence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.motion.captures import bow, bvh, written_order
from tests.motion.test_fit import bowing
from tests.motion.test_reading import trc

from exogauge.criteria.motion_import import USUAL
from exogauge.errors import BadMotion
from exogauge.motion.contract import RetargetEntry
from exogauge.motion.files import open_motion
from exogauge.motion.fit.fit import fit_human
from exogauge.motion.human import HumanMotion, Markers
from exogauge.motion.leaps import farthest, leaps_of
from exogauge.motion.person import person_of, person_of_fit
from exogauge.motion.retargeting import changed


def read(folder: Path, markers: Markers, position: np.ndarray, rate: float = 100.0) -> HumanMotion:
    return open_motion(trc(folder / "made.trc", position, labels=markers.labels, rate=rate))


def place_in(motion: HumanMotion, label: str) -> np.ndarray:
    assert motion.markers is not None
    return motion.markers.position[:, motion.markers.labels.index(label)]


def test_a_motion_that_is_smooth_has_no_leaps_at_any_rate() -> None:
    """A hand that swings by 80 cm twice a second, and a foot by a metre."""
    for rate in (20.0, 30.0, 100.0, 500.0):
        time = np.arange(int(4 * rate)) / rate
        swing = np.stack([0.4 * np.sin(4 * np.pi * time), 0.5 * np.cos(3 * np.pi * time), np.zeros_like(time)], axis=1)
        assert leaps_of(swing[:, None], rate, [0]) == {}
        assert farthest(rate) < 0.2


@pytest.mark.parametrize(("frames", "by"), [(slice(50, 51), 0.1), (slice(40, 48), 0.08), (slice(70, None), 0.12)])
def test_a_marker_that_slips_is_not_seen_there_and_told(tmp_path: Path, frames: slice, by: float) -> None:
    """10 cm in one frame took the trunk 2.4 degrees aside."""
    whole = bowing().markers
    slipped = whole.position.copy()
    slipped[frames, whole.labels.index("C7"), 0] += by
    motion = read(tmp_path, whole, slipped)
    first, last = frames.start / 100, ((frames.stop or 101) - 1) / 100
    assert motion.told["slips"] == "C7 " + (f"at {first:.2f} s" if first == last else f"{first:.2f} to {last:.2f} s")
    lost = np.isnan(place_in(motion, "C7")[:, 0])
    assert np.flatnonzero(lost).tolist() == list(range(*frames.indices(101)))
    assert np.isfinite(motion.markers.position[:, [k for k, each in enumerate(whole.labels) if each != "C7"]]).all()


@pytest.mark.parametrize("pair", [("C7", "LSHO"), ("LANK", "RANK")])
def test_labels_that_are_exchanged_for_a_while_are_put_back_and_told(tmp_path: Path, pair: tuple[str, str]) -> None:
    """Of a quarter of the frames one of the two was named, and nothing fitted."""
    whole = bowing().markers
    wrong, at = whole.position.copy(), [whole.labels.index(each) for each in pair]
    wrong[30:55, at] = wrong[30:55, at[::-1]]
    motion = read(tmp_path, whole, wrong)
    assert motion.told["exchanged"] == f"{pair[0]} and {pair[1]} 0.30 to 0.54 s: put back"
    assert motion.markers.position == pytest.approx(whole.position, abs=1e-6)
    assert "slips" not in motion.told


@pytest.mark.parametrize("frames", [slice(30, 55), slice(40, 41), slice(20, None)])
def test_neighbours_that_are_exchanged_are_put_back_though_neither_leaps_far(tmp_path: Path, frames: slice) -> None:
    """Two markers of a shoulder, 4 cm apart: the trunk was .4 degrees off, in silence."""
    whole = bowing().markers
    at = [whole.labels.index(each) for each in ("LSHO", "C7")]
    near = whole.position.copy()
    near[:, at[1]] = near[:, at[0]] + np.array([0.03, 0.02, 0.01])
    wrong = near.copy()
    wrong[frames, at] = wrong[frames, at[::-1]]
    motion = read(tmp_path, whole, wrong)
    assert "C7 and LSHO" in motion.told["exchanged"] or "LSHO and C7" in motion.told["exchanged"]
    got = motion.markers.position
    other = got.copy()
    other[:, at] = other[:, at[::-1]]  # of two ways the more frequent one is kept
    assert min(np.abs(got - near).max(), np.abs(other - near).max()) < 1e-6
    assert "exchanged" not in read(tmp_path, whole, near).told


@pytest.mark.parametrize("by", [0.035, 0.05])
def test_a_marker_of_the_trunk_that_slips_by_less_is_doubted(tmp_path: Path, by: float) -> None:
    whole = bowing().markers
    slipped = whole.position.copy()
    slipped[60:, whole.labels.index("C7"), 1] += by
    motion = read(tmp_path, whole, slipped)
    assert motion.told["strays"] == f"C7 by {100 * by:.1f} cm at 0.60 s"
    assert motion.markers.position == pytest.approx(slipped, abs=1e-6)  # nothing is changed by a doubt
    assert fit_human(motion).told["strays"] == motion.told["strays"]
    assert "strays" not in read(tmp_path, whole, whole.position).told


def test_a_rate_at_which_everybody_would_be_slow_is_told(tmp_path: Path) -> None:
    """Bows of two seconds at 240 frames a second, said to be 24: ten times too few were taken in silence."""
    whole = bowing().markers
    fine = np.moveaxis(np.array([[np.interp(np.arange(480) / 4.8, np.arange(101), column) for column in label.T]
                                 for label in np.moveaxis(whole.position, 1, 0)]), 2, 0)  # fmt: skip
    many = np.concatenate([fine, fine])
    assert "rate_doubt" not in read(tmp_path, whole, many, 240.0).told
    assert "ten times as fast" in read(tmp_path, whole, many, 24.0).told["rate_doubt"]
    still = np.tile(fine[:1], (len(many), 1, 1))
    assert "rate_doubt" not in read(tmp_path, whole, still, 24.0).told  # of who stands a rate is told by nothing


@pytest.mark.parametrize(("frames", "words"), [(slice(30, 50), "0.31 to 0.49 s"), (slice(0, 101), "0.00 to 1.00 s")])
def test_values_that_are_held_are_gaps(tmp_path: Path, frames: slice, words: str) -> None:
    whole = bowing().markers
    wrong, at = whole.position.copy(), whole.labels.index("C7")
    wrong[frames, at] = wrong[frames.start, at]
    motion = read(tmp_path, whole, wrong)
    assert motion.told["held"] == f"C7 {words}"
    assert np.isnan(place_in(motion, "C7")[frames.stop - 2]).all()
    assert "held" not in read(tmp_path, whole, whole.position).told  # feet that stand repeat themselves too


def test_takes_that_were_joined_are_told_and_no_marker_is_blamed(tmp_path: Path) -> None:
    whole = bowing().markers
    two = np.concatenate([whole.position[:60], whole.position[:60] + np.array([0.4, 0.3, 0.0])])
    motion = read(tmp_path, whole, two)
    assert motion.told["joined"].startswith("most markers are elsewhere from one frame to the next at 0.59 s")
    assert not {"slips", "exchanged"} & set(motion.told)
    assert np.isfinite(motion.markers.position).all()


def turned(text: bytes, frame: int, column: int, by: float, until: int | None = None) -> bytes:
    lines = text.decode().splitlines()
    first = lines.index("MOTION") + 3
    for t in range(first + frame, first + (until or frame + 1)):
        words = lines[t].split()
        words[column] = f"{float(words[column]) + by:.6f}"
        lines[t] = " ".join(words)
    return "\n".join(lines).encode()


SPINE = 3 + 3 * written_order().index("Spine2") + 1


@pytest.mark.parametrize(
    ("column", "by", "bone", "part"), [(0, 80.0, "Hips", "pelvis"), (SPINE, 60.0, "Head", "chest")]
)
def test_a_skeleton_that_leaps_is_told_and_not_retargeted_across_it(
    tmp_path: Path, column: int, by: float, bone: str, part: str
) -> None:  # fmt: skip
    """A root that was 80 cm aside for three frames, a spine that turned by 60 degrees for one."""
    file = tmp_path / "bow.bvh"
    file.write_bytes(turned(bvh(bow(20.0)), 50, column, by, 53 if part == "pelvis" else None))
    motion = open_motion(file)
    assert motion.told["leaps"].startswith(f"{bone} is 0.")
    assert "elsewhere from 0.82 s to the next frame" in motion.told["leaps"]
    person = person_of(motion)
    with pytest.raises(BadMotion, match=r"elsewhere from 0\.8") as refused:
        changed(person, RetargetEntry())
    assert (refused.value.faults[0].rule, refused.value.faults[0].column) == ("leap", part)
    assert changed(person, RetargetEntry(begin=1.0)).time[-1] == pytest.approx(1.0)
    file.write_bytes(bvh(bow(20.0)))
    assert "leaps" not in open_motion(file).told


@pytest.mark.parametrize("factor", [0.1, 10.0])
def test_a_rate_at_which_nobody_moves_is_told(tmp_path: Path, factor: float) -> None:
    whole = bowing().markers
    slow = np.concatenate([whole.position, whole.position])
    assert "rate_doubt" not in read(tmp_path, whole, slow).told
    assert "frames a second" in read(tmp_path, whole, slow, rate=100.0 * factor).told["rate_doubt"]


@pytest.mark.parametrize("exchanged", [("LSHO", "RSHO"), ("LHEE", "RHEE", "LTOE", "RTOE"), ("LKNE", "RKNE")])
def test_some_names_of_left_and_right_that_are_exchanged_are_refused(
    tmp_path: Path, exchanged: tuple[str, ...]
) -> None:
    """Of the shoulders the trunk was turned by 180 degrees; of the feet its flexion was off by 3.5."""
    whole = bowing().markers
    other = dict(zip(exchanged, [each.translate(str.maketrans("LR", "RL")) for each in exchanged], strict=True))
    labels = tuple(other.get(each, each) for each in whole.labels)
    motion = open_motion(trc(tmp_path / "made.trc", whole.position, labels=labels))
    assert all(f"{a} and {b}" in motion.told["sides_doubt"]
               for a, b in zip(exchanged[::2], exchanged[1::2], strict=True))  # fmt: skip
    with pytest.raises(BadMotion) as refused:
        fit_human(motion)
    assert refused.value.faults[0].rule == "mirrored"


def test_legs_that_cross_in_a_part_of_the_motion_are_no_names_exchanged(tmp_path: Path) -> None:
    whole = bowing().markers
    crossed, share = whole.position.copy(), int(0.8 * USUAL.crossed * 101)
    for each in ("HEE", "TOE"):
        at = [whole.labels.index(side + each) for side in "LR"]
        crossed[:share, at, 1] *= -0.5
    for t in range(10):  # and apart again
        crossed[share + t] += (t - 9) / 10 * (crossed[share + t] - crossed[share - 1])
    assert "sides_doubt" not in read(tmp_path, whole, crossed).told


@pytest.mark.slow
def test_who_walks_in_is_fitted_from_where_he_is_seen(tmp_path: Path) -> None:
    """A traceback: frames without any marker had a part in lengths and places."""
    whole = bowing().markers
    late = whole.position.copy()
    late[:20] = np.nan
    fit = fit_human(read(tmp_path, whole, late))
    assert fit.told["guessed"].startswith("fewer than 3 markers of pelvis or thorax are seen 0.00 to 0.19 s")
    flexion = np.degrees(fit.trunk[20:, 0])
    assert flexion.max() - flexion[-1] == pytest.approx(40.0, abs=0.5)
    person = person_of_fit(fit)
    with pytest.raises(BadMotion, match=r"0\.00 to 0\.19 s"):
        person.cut(0.0, 1.0)
    assert len(person.cut(0.2, 1.0).time) == 81
