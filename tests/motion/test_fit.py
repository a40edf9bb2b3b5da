"""The body that is fitted to markers: its kinematics by pinocchio, its trunk by OpenSim's own angles."""

from __future__ import annotations

import gzip
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from exogauge.cli import main
from exogauge.errors import BadMotion
from exogauge.motion.files import open_motion
from exogauge.motion.fit.body import SCALES, human_body
from exogauge.motion.fit.fit import fit_human
from exogauge.motion.fit.kinematics import pose
from exogauge.motion.human import HumanMotion, Markers

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


def test_markers_that_say_nothing_of_the_trunk_are_refused() -> None:
    place = np.zeros((20, 3, 3)) + np.arange(3.0)[None, :, None]
    legs = Markers(("LKNE", "RKNE", "LANK"), place, np.zeros((20, 3), bool),
                   {"LKNE": "l_thigh", "RKNE": "r_thigh", "LANK": "l_shank"})  # fmt: skip
    with pytest.raises(BadMotion):
        fit_human(HumanMotion("legs", 0.01 * np.arange(20), markers=legs))


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


@pytest.mark.slow
def test_the_command_hands_out_angles_that_are_read_again(captured: HumanMotion, fit, tmp_path: Path) -> None:
    file = tmp_path / "STS1.trc"
    file.write_bytes(gzip.decompress(CAPTURED.read_bytes()))
    assert main(["motion", "fit", str(file), "--out", str(tmp_path / "out.mot")]) == 0
    again = open_motion(tmp_path / "out.mot").angles
    assert again.names == fit.body.coordinates
    turning = again.names.index("trunk_flexion") if "trunk_flexion" in again.names else fit.body.index(again.names[6])
    assert again.value[:, turning] == pytest.approx(fit.q[:, turning], abs=1e-6)
