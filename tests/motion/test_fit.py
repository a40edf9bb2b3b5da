"""The body that is fitted to markers: its kinematics by pinocchio, its trunk by OpenSim's own angles."""

from __future__ import annotations

import gzip
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from tests.motion.test_reading import trc

from exogauge.cli import main
from exogauge.criteria.motion_fit import USUAL
from exogauge.errors import BadMotion
from exogauge.motion.files import open_motion
from exogauge.motion.fit.body import SCALES, human_body
from exogauge.motion.fit.fit import fit_human
from exogauge.motion.fit.kinematics import Points, normal, places, pose, slopes
from exogauge.motion.human import HumanMotion, Markers
from exogauge.motion.presets import recognise

DATA = Path(__file__).parents[3] / "shared" / "data"
CAPTURED = DATA / "opencap_sts_trc_grf" / "STS1.trc.gz"
ANGLES = DATA / "opencap_subject4" / "STS1_opensim_ik.mot.gz"


def test_the_body_moves_as_pinocchio_moves_it() -> None:
    body, rng = human_body(), np.random.default_rng(0)
    q, scale = rng.normal(0.0, 0.5, (5, len(body.coordinates))), rng.uniform(0.8, 1.2, len(SCALES))
    model = body.model(scale)
    data = model.createData()
    at = pose(body, q, scale)
    for t, posture in enumerate(q):
        pin.framesForwardKinematics(model, data, posture)
        for part, k in body.part.items():
            frame = data.oMf[model.getFrameId(part)]
            assert at.position[t, k] == pytest.approx(frame.translation, abs=1e-12)
            assert at.rotation[t, k] == pytest.approx(frame.rotation, abs=1e-12)


def test_normal_equations_are_those_of_the_slopes() -> None:
    body, rng = human_body(), np.random.default_rng(1)
    joint = rng.integers(0, len(body.coordinates), 9)
    points = Points(joint, rng.normal(0.0, 0.2, (9, 3)), np.zeros((9, 3), dtype=int))
    scale = np.ones(len(SCALES))
    at = pose(body, rng.normal(0.0, 0.5, (4, len(body.coordinates))), scale)
    place = places(at, points, scale, np.zeros((9, 3)))
    left, weight = rng.normal(size=place.shape), rng.uniform(0.0, 2.0, (4, 9))
    A, g = normal(body, at, points, place, left, weight)
    J, w = slopes(body, at, points, place), np.repeat(weight, 3, axis=1)
    assert pytest.approx(np.einsum("tnk,tn,tnl->tkl", J, w, J), abs=1e-12) == A
    assert pytest.approx(np.einsum("tnk,tn,tn->tk", J, w, left.reshape(4, -1)), abs=1e-12) == g


def test_markers_that_say_nothing_of_the_trunk_are_refused() -> None:
    place = np.zeros((20, 3, 3)) + np.arange(3.0)[None, :, None]
    legs = Markers(("LKNE", "RKNE", "LANK"), place, np.zeros((20, 3), bool),
                   {"LKNE": "l_thigh", "RKNE": "r_thigh", "LANK": "l_shank"})  # fmt: skip
    with pytest.raises(BadMotion):
        fit_human(HumanMotion("legs", 0.01 * np.arange(20), markers=legs))


BODY = {  # m, from the pelvis; a person who looks along x
    "pelvis": {"LASI": (0.1, 0.12, 0.02), "LPSI": (-0.09, 0.04, 0.03)},
    "thorax": {
        "C7": (-0.06, 0.0, 0.42),
        "CLAV": (0.08, 0.0, 0.36),
        "STRN": (0.11, 0.0, 0.22),
        "LSHO": (0.0, 0.18, 0.39),
    },
    "thigh": {"LTHI": (0.02, 0.13, -0.22), "LKNE": (0.0, 0.145, -0.42)},
    "shank": {"LTIB": (0.02, 0.12, -0.62), "LANK": (-0.01, 0.135, -0.82)},
    "foot": {"LHEE": (-0.06, 0.09, -0.88), "LTOE": (0.14, 0.1, -0.9)},
}


def bowing(wrong: str = "") -> HumanMotion:
    """Of Plug-in Gait's names, the thorax bent ahead by up to 40 degrees. wrong: `names` of left and right exchanged,
    or an `axis` that points the other way."""
    labels, places = list[str](), list[np.ndarray]()
    angle = np.radians(40.0) * np.sin(np.pi * np.linspace(0.0, 1.0, 101)) ** 2
    turn = np.zeros((101, 3, 3))
    turn[:, 1, 1] = 1.0
    turn[:, 0, 0] = turn[:, 2, 2] = np.cos(angle)
    turn[:, 0, 2], turn[:, 2, 0] = np.sin(angle), -np.sin(angle)
    waist = np.array([0.0, 0.0, 0.12])
    for part, markers in BODY.items():
        for label, place in markers.items():
            for side in ("L", "R") if label.startswith("L") else ("",):
                at = np.array(place) * [1.0, -1.0 if side == "R" else 1.0, 1.0]
                labels.append(side + label[1:] if side else label)
                places.append(turn @ (at - waist) + waist if part == "thorax" else np.tile(at, (101, 1)))
    position = np.stack(places, axis=1) + np.array([0.0, 0.0, 0.93])
    if wrong == "names":
        labels = [{"L": "R", "R": "L"}.get(label[0], label[0]) + label[1:] for label in labels]
    if wrong == "axis":
        position = position * [1.0, -1.0, 1.0]
    markers = Markers(tuple(labels), position, np.zeros(position.shape[:2], dtype=bool), recognise(labels)[1])
    return HumanMotion("bowing", 0.01 * np.arange(101), markers=markers)


@pytest.mark.slow
def test_a_bow_is_as_deep_as_it_was(tmp_path: Path) -> None:
    """And the command hands out angles that are read again."""
    markers, fit = bowing().markers, fit_human(bowing())
    assert np.ptp(np.degrees(fit.trunk[:, 0])) == pytest.approx(40.0, abs=0.5)
    file = trc(tmp_path / "bow.trc", markers.position, labels=markers.labels)
    assert main(["motion", "fit", str(file), "--out", str(tmp_path / "out.mot")]) == 0
    again = open_motion(tmp_path / "out.mot").angles
    assert again.names == fit.body.coordinates
    assert again.value == pytest.approx(fit.q, abs=1e-5)
    assert "scale_at_bound" not in fit.told  # how deep the lumbar joint lies has none
    in_parts = fit_human(bowing(), criteria=replace(USUAL, at_once=40, beside=40))
    assert in_parts.q == pytest.approx(fit.q, abs=1e-4)
    with pytest.raises(BadMotion, match="more than 100 frames"):
        fit_human(bowing(), criteria=replace(USUAL, most_frames=100))


@pytest.mark.slow
def test_a_marker_that_is_elsewhere_for_a_moment_is_left_out_and_told() -> None:
    """30 cm in one frame took the trunk 26 degrees aside there, in silence; 100 m were refused with no name."""
    bow = bowing()
    for frames, aside in ((slice(50, 51), 0.3), (slice(50, 51), 100.0), (slice(40, 60), 1.0)):
        position = bow.markers.position.copy()
        position[frames, bow.markers.labels.index("C7"), 0] += aside
        wrong = replace(bow, markers=replace(bow.markers, position=position))
        if frames == slice(50, 51):
            fit = fit_human(wrong)
            assert fit.told["slips"].startswith("C7 at 0.50 s, by ")
            assert np.ptp(np.degrees(fit.trunk[:, 0])) == pytest.approx(40.0, abs=1e-3)
            continue
        with pytest.raises(BadMotion, match=r"cm of this one at 0\.[45]") as refused:
            fit_human(wrong)
        assert (refused.value.faults[0].rule, refused.value.faults[0].column) == ("no_body", "C7")


@pytest.mark.parametrize("wrong", ["names", "axis"])
def test_a_body_in_a_mirror_is_refused_as_one(wrong: str) -> None:
    """It was fitted all the same, its trunk 33 degrees off."""
    with pytest.raises(BadMotion, match="Left and right are exchanged") as refused:
        fit_human(bowing(wrong))
    assert refused.value.faults[0].rule == "mirrored"


@pytest.mark.slow
def test_two_markers_of_a_part_whose_labels_are_exchanged_are_named_together() -> None:
    """«18 cm from where its name says» was said of each, and flexion was 3.8 degrees off."""
    whole = bowing().markers
    other = {"LASI": "LPSI", "LPSI": "LASI"}
    labels = tuple(other.get(each, each) for each in whole.labels)
    fit = fit_human(replace(bowing(), markers=replace(whole, labels=labels)))
    assert "as if exchanged" in fit.told["elsewhere"]
    assert {"LASI", "LPSI"} == set(fit.told["elsewhere"].split("as if exchanged: ")[1].split(" and "))
    assert "as if exchanged" not in fit_human(bowing()).told.get("elsewhere", "")


@pytest.mark.slow
def test_markers_that_are_no_body_in_a_mirror_either_are_refused_once() -> None:
    """Each mirror was refused for its own mirror: the search went on for an hour."""
    bow = bowing()
    shuffled = bow.markers.position[:12].copy()
    shuffled[..., 2] = np.random.default_rng(1).permutation(shuffled[..., 2], axis=1)
    few = replace(bow.markers, position=shuffled, filled=np.zeros(shuffled.shape[:2], dtype=bool))
    with pytest.raises(BadMotion, match="no body fits these markers") as refused:
        fit_human(replace(bow, time=bow.time[:12], markers=few))
    assert refused.value.faults[0].rule == "no_body"


def test_optitracks_markers_are_known_by_their_places(tmp_path: Path) -> None:
    """Those of the body above that OptiTrack has too, under its names."""
    names = {"LASI": "WaistLFront", "LPSI": "WaistLBack", "C7": "BackTop", "CLAV": "Chest", "LSHO": "LShoulderTop",
             "LTHI": "LThigh", "LKNE": "LKneeOut", "LTIB": "LShin", "LANK": "LAnkleOut", "LHEE": "LHeel",
             "LTOE": "LToeIn"}  # fmt: skip
    names |= {f"R{own[1:]}": other.replace("WaistL", "WaistR") if own[1:] in ("ASI", "PSI") else f"R{other[1:]}"
              for own, other in names.items() if own[0] == "L"}  # fmt: skip
    bow = bowing().markers
    kept = [k for k, label in enumerate(bow.labels) if label in names]
    labels = tuple(f"Skeleton_{names[bow.labels[k]]}" for k in kept)
    motion = open_motion(trc(tmp_path / "bow.trc", bow.position[:, kept], labels=labels))
    assert motion.told["preset"] == "OptiTrack and Qualisys"
    assert np.ptp(np.degrees(fit_human(motion).trunk[:, 0])) == pytest.approx(40.0, abs=1.0)


def test_one_of_two_people_is_fitted_when_named_by_the_command(tmp_path: Path, capsys) -> None:
    """It was told to say which, and knew no option to."""
    bow = bowing().markers
    two = np.concatenate([bow.position, bow.position + np.array([0.0, 2.0, 0.0])], axis=1)[::10]
    labels = tuple(f"{who}:{label}" for who in ("Ann", "Ben") for label in bow.labels)
    file = str(trc(tmp_path / "two.trc", two, labels=labels))
    assert main(["motion", "fit", file]) == 2
    assert "Ann, Ben" in capsys.readouterr().err
    assert main(["motion", "fit", file, "--subject", "Ben"]) == 0


@pytest.fixture(scope="module")
def captured(tmp_path_factory: pytest.TempPathFactory) -> HumanMotion:
    if not CAPTURED.is_file():
        pytest.skip("../shared/data/opencap_sts_trc_grf is not there")
    file = tmp_path_factory.mktemp("captured") / "STS1.trc"
    file.write_bytes(gzip.decompress(CAPTURED.read_bytes()))
    return open_motion(file)


@pytest.fixture(scope="module")
def fit(captured: HumanMotion):
    return fit_human(captured)


@pytest.mark.slow
def test_the_trunk_bends_as_opensim_says_it_did(fit, tmp_path: Path) -> None:
    if not ANGLES.is_file():
        pytest.skip("../shared/data/opencap_subject4 is not there")
    file = tmp_path / "angles.mot"
    file.write_bytes(gzip.decompress(ANGLES.read_bytes()))
    theirs = open_motion(file)
    lumbar = theirs.angles.value[:, theirs.angles.names.index("lumbar_extension")]
    said = -np.degrees(np.interp(fit.time, theirs.time, lumbar))
    ours = np.degrees(fit.trunk[:, 0])
    assert np.corrcoef(ours, said)[0, 1] >= 0.96
    assert np.std(ours - said) <= 3.0
    assert fit.rms <= 0.02


@pytest.mark.slow
def test_the_fit_does_not_hang_on_where_the_world_is_nor_on_the_first_frames(captured: HumanMotion, fit) -> None:
    turn = pin.rpy.rotate("z", 1.0)
    markers = captured.markers
    elsewhere = replace(captured, markers=replace(markers, position=markers.position @ turn.T + [3.0, -2.0, 0.0]))
    assert np.degrees(fit_human(elsewhere).trunk) == pytest.approx(np.degrees(fit.trunk), abs=0.1)
    late = replace(captured, time=captured.time[30:] - captured.time[30], markers=replace(
        markers, position=markers.position[30:], filled=markers.filled[30:]))  # fmt: skip
    apart = np.degrees(fit_human(late).trunk - fit.trunk[30:])
    assert np.abs(apart - apart.mean(axis=0)).max() <= 1.0
