"""Files that others captured. What is expected of them stands in the READMEs beside them."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.motion.by_mujoco import ByMuJoCo, Shapes
from tests.motion.plans import SOON
from tests.motion.robots import sample_folder

from exogauge.criteria.motion_plan import USUAL
from exogauge.errors import BadMotion
from exogauge.motion.contacts import with_contacts
from exogauge.motion.files import open_motion
from exogauge.motion.fit.fit import fit_human
from exogauge.motion.person import person_of_fit
from exogauge.motion.plan.retarget import ask
from exogauge.motion.plan.within import plan_within
from exogauge.motion.robot_file import load_motion_robot
from exogauge.motion.summary import summarise
from exogauge.robots.moving.touching import Pairs
from exogauge.synthetic.urdf import robot_urdf

DATA = Path(__file__).parents[3] / "shared" / "data"


@pytest.fixture
def captured(tmp_path: Path) -> Callable[[str], Path]:
    return partial(unpacked, tmp_path)


def unpacked(into: Path, name: str) -> Path:
    folder, _, file = name.partition("/")
    if not (DATA / folder).is_dir():
        pytest.skip(f"the capture {folder!r} is not beside the repository (../shared/data/{folder})")
    packed, path = DATA / folder / f"{file}.gz", into / file
    path.write_bytes(gzip.decompress(packed.read_bytes()) if packed.exists() else (DATA / folder / file).read_bytes())
    return path


@pytest.mark.parametrize(
    ("name", "frames", "rate", "count", "up"),
    [
        ("mocap_c3d/squat.c3d", 2539, 120, 53, "guessed: y"),
        ("mocap_c3d/cmu_02_05.c3d", 1854, 120, 41, "read: z"),
        ("mocap_c3d/sample02_pc_int.c3d", 89, 50, 36, "read: z"),
        ("mocap_c3d/duplicate_labels.c3d", 1050, 100, 48, "read: z"),
        ("opencap_sts_trc_grf/STS1.trc", 1399, 100, 51, "guessed: y"),
        ("opencap_subject4/static1.trc", 517, 100, 55, "guessed: y"),
        ("opencap_subject4/odd_header_Squat2.trc", 460, 100, 61, "guessed: y"),
        ("opencap_subject4/other_subject_squats_flipped_markers.trc", 1623, 100, 51, "guessed: y"),
    ],
)
def test_markers_are_read_as_they_were_recorded(captured, name, frames, rate, count, up) -> None:
    motion = open_motion(captured(name))
    assert motion.markers is not None
    assert motion.markers.position.shape == (frames, count, 3)
    assert motion.rate == pytest.approx(rate)
    assert motion.told["up"].startswith(up)
    high = motion.markers.position[..., 2]
    assert -0.1 < np.nanpercentile(high, 1) < 0.15  # the feet stand on the floor, in metres
    assert 1.1 < np.nanpercentile(high, 99) < 2.0


def test_gaps_of_the_squat_are_kept_and_counted(captured) -> None:
    motion = open_motion(captured("mocap_c3d/squat.c3d"))
    assert motion.markers is not None
    gap = np.isnan(motion.markers.position[..., 0])
    assert gap.mean() == pytest.approx(0.017, abs=5e-4)
    assert gap.any(axis=1).mean() == pytest.approx(0.236, abs=1e-3)
    assert "206 frames" in str(summarise(motion)["longest_gap"])
    assert motion.told["prefix"] == "SehoonVSK35"


def test_one_trial_in_six_kinds_of_bytes_is_one_motion(captured) -> None:
    kinds = [f"sample02_{order}_{size}.c3d" for order in ("pc", "dec", "sgi") for size in ("int", "real")]
    first, *others = [open_motion(captured(f"mocap_c3d/{kind}")).markers for kind in kinds]
    for each in others:
        assert each.labels == first.labels
        assert np.array_equal(np.isnan(each.position), np.isnan(first.position))
        assert np.nanmax(np.abs(each.position - first.position)) < 3e-4


@pytest.mark.parametrize("name", ["squat.c3d", "sample02_pc_real.c3d", "sample02_dec_int.c3d"])
def test_half_a_c3d_file_is_refused(captured, name) -> None:
    path = captured(f"mocap_c3d/{name}")
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(BadMotion) as refused:
        open_motion(path)
    assert refused.value.faults[0].rule == "frame_count"


def test_angles_of_opensim_are_in_radians(captured) -> None:
    motion = open_motion(captured("opencap_subject4/STS1_opensim_ik.mot"))
    assert motion.angles is not None
    assert motion.angles.value.shape == (1399, 33)
    column = motion.angles.value[:, motion.angles.names.index("lumbar_extension")]
    assert np.degrees(np.ptp(column)) == pytest.approx(39.0, abs=1.5)
    assert list(np.array(motion.angles.names)[~motion.angles.rotational]) == ["pelvis_tx", "pelvis_ty", "pelvis_tz"]


@pytest.mark.parametrize("name", ["opencap_sts_trc_grf/STS1_grf.mot", "opencap_subject4/odd_header_grf.mot"])
def test_forces_are_no_motion(captured, name) -> None:
    with pytest.raises(BadMotion) as refused:
        open_motion(captured(name))
    assert refused.value.faults[0].rule == "forces"


@pytest.mark.slow
def test_no_arm_turns_over_and_the_trunk_turns_as_its_own_markers_do(captured) -> None:
    """An elbow went round by 482 degrees; the trunk, which it drew along, was 25 degrees off, and nothing was told but
    a wrist marker that slips, which does not."""
    motion = open_motion(captured("mocap_c3d/cmu_02_05.c3d"))
    fit = fit_human(motion)
    assert not {"slips", "not_settled"} & set(fit.told)
    for name in ("l_elbow_flexion", "r_elbow_flexion", "l_knee_flexion", "r_knee_flexion"):
        assert -30.0 < np.degrees(fit.coordinates[name].min()) < np.degrees(fit.coordinates[name].max()) < 180.0
    assert motion.markers is not None
    lain = {}
    for part in ("pelvis", "thorax"):
        on = [k for k, label in enumerate(motion.markers.labels) if motion.markers.segment.get(label) == part]
        place = motion.markers.position[:, on]
        place = place[:, :, :] - np.mean(place, axis=1, keepdims=True)
        whole = np.isfinite(place).all(axis=(1, 2))
        first = place[np.flatnonzero(whole)[0]]
        lain[part] = [Rotation.align_vectors(each, first)[0] if seen else None
                      for each, seen in zip(place, whole, strict=True)]  # fmt: skip
    both = [t for t in range(len(motion.time)) if lain["pelvis"][t] and lain["thorax"][t]]
    seen = Rotation.concatenate([lain["pelvis"][t].inv() * lain["thorax"][t] for t in both])
    fitted = Rotation.from_euler("YXZ", fit.trunk[both])
    off = np.degrees((seen[0].inv() * seen).magnitude() - (fitted[0].inv() * fitted).magnitude())
    assert len(both) > 1500
    assert np.abs(off - np.median(off)).max() < 6.0


@pytest.mark.slow
def test_a_body_with_its_static_trial_settles(captured) -> None:
    """Arms swung to and fro about where two of their turns are one: steps promised .1 σ² and gained .001."""
    fit = fit_human(open_motion(captured("opencap_sts_trc_grf/STS1.trc")),
                    open_motion(captured("opencap_subject4/static1.trc")))  # fmt: skip
    assert "not_settled" not in fit.told
    assert np.degrees(np.ptp(fit.trunk[:, 0])) == pytest.approx(39.0, abs=1.5)  # as OpenSim has it


@pytest.mark.slow
def test_two_formats_of_one_bend_lean_alike(captured) -> None:
    """The BVH is a conversion to other bones, at half the rate."""
    skeleton = captured("cmu_mocap_bend_twist/02.asf")
    amc = open_motion(captured("cmu_mocap_bend_twist/02_06.amc"), skeleton=skeleton)
    bvh = open_motion(captured("cmu_mocap_bend_twist/002_06.bvh"))
    assert bvh.rate == pytest.approx(60.0, rel=1e-3)
    lean = [_inclination(motion) for motion in (amc, bvh)]
    difference = np.interp(bvh.time, amc.time, lean[0]) - lean[1]
    assert np.std(difference) <= 3.5
    neck = amc.tree.position[:, amc.tree.names.index("lowerneck")] - amc.tree.position[:, 0]
    trunk = np.degrees(np.arccos(neck[:, 2] / np.linalg.norm(neck, axis=1)))
    assert [trunk.min(), trunk.max()] == pytest.approx([2.0, 88.0], abs=1.0)


def _inclination(motion) -> np.ndarray:
    """[deg] of the line from the pelvis to the thorax against the vertical."""
    tree = motion.tree
    at = {part: tree.names.index(name) for name, part in tree.segment.items() if part in ("pelvis", "thorax")}
    way = tree.position[:, at["thorax"]] - tree.position[:, at["pelvis"]]
    return np.degrees(np.arccos(way[:, 2] / np.linalg.norm(way, axis=1)))


@pytest.mark.slow
def test_bones_keep_their_length_in_metres(captured) -> None:
    motion = open_motion(captured("cmu_mocap_bend_twist/13_29.amc"), skeleton=captured("cmu_mocap_bend_twist/02.asf"))
    tree = motion.tree
    assert tree is not None
    femur = tree.names.index("lfemur")
    length = np.linalg.norm(tree.end[:, femur] - tree.position[:, femur], axis=1)
    assert length == pytest.approx(7.59371 / 0.45 * 0.0254)  # as 02.asf has it, 1/0.45 inch a unit
    assert np.linalg.det(tree.rotation) == pytest.approx(1.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "begin", "end"),
    [
        ("opencap_sts_trc_grf/STS1.trc", 0.0, 3.0),
        pytest.param("opencap_sts_trc_grf/STS1.trc", 0.0, 9.0, marks=pytest.mark.thorough),
        pytest.param("mocap_c3d/squat.c3d", 0.0, 9.0, marks=pytest.mark.thorough),
    ],
)
def test_markers_become_a_motion_that_the_sample_can_do_as_mujoco_sees_it(captured, name, begin, end, tmp_path) -> None:
    """A squat and sitting down: a body is fitted, its motion planned, every bound and every distance judged by
    MuJoCo."""
    motion = with_contacts(open_motion(captured(name)))
    person = person_of_fit(fit_human(motion), motion.contacts).cut(begin, end)
    robot = load_motion_robot(sample_folder(tmp_path / "robot"))
    asked, _ = ask(robot, person, SOON)
    planned, judged, _ = plan_within(robot, asked)
    assert judged.broken == ()
    upper = np.array(robot.beyond("thorax") + robot.torso)
    seen = ByMuJoCo(robot, planned.spline, 1000.0)
    assert seen.inside.min() >= 0.015
    assert np.abs(seen.feet - seen.feet[0]).max() <= 1e-4
    assert (np.abs(seen.torque[:, upper]) <= robot.limits.torque[upper]).all()
    near = Shapes(robot, robot_urdf()).nearer_than(USUAL.clearance_m - 1e-4, judged.q)
    assert not near & {frozenset(pair) for pair in Pairs(robot, USUAL.clearance_m).names}
