"""The suit on the robot, against plain geometry of the same facts: positions, lengths, levers, forces."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from exogauge.synthetic.mjcf import mujoco_model
from exogauge.synthetic.motion import standing
from exogauge.synthetic.robot_facts import AXES, BY_NAME, JOINT_NAMES, LINKS, Link
from exogauge.synthetic.simulation import LOG_RATE_HZ
from exogauge.synthetic.suit import BANDS, LAYER, STRETCH_STANDING, BandFacts

pytestmark = pytest.mark.slow

PITCH, YAW = JOINT_NAMES.index("torso_pitch"), JOINT_NAMES.index("torso_yaw")
NEAR = ("BODY", "waist", "chest", "computer", "neck", "l_thigh", "r_thigh", "l_hip_roll_link", "r_hip_roll_link")
POSTURES = [{}, {"torso_pitch": 0.4}, {"torso_pitch": 0.75}] + [{"torso_yaw": yaw} for yaw in (-0.8, -0.4, 0.4, 0.8)]


def _frames(q: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """link -> (rotation, origin) in the base frame."""
    angle, frames = dict(zip(JOINT_NAMES, q, strict=True)), {}
    for link in LINKS:
        R, p = frames[link.parent] if link.parent else (np.eye(3), np.zeros(3))
        p = p + R @ link.origin
        if link.joint:
            x, y, z = AXES[link.joint.axis]
            K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
            a = angle[link.joint.name]
            R = R @ (np.eye(3) + np.sin(a) * K + (1 - np.cos(a)) * K @ K)
        frames[link.name] = (R, p)
    return frames


def _course(band: BandFacts, q: np.ndarray) -> np.ndarray:
    frames = _frames(q)
    return np.array([frames[p.link][1] + frames[p.link][0] @ p.xyz for p in band.via_points])


def _lengths(q: np.ndarray) -> np.ndarray:
    return np.array([np.linalg.norm(np.diff(_course(band, q), axis=0), axis=1).sum() for band in BANDS])


def _levers(q: np.ndarray, joint: int) -> np.ndarray:
    """d length / d angle (W,), by central differences."""
    step = np.zeros(len(q))
    step[joint] = 1e-5
    return (_lengths(q + step) - _lengths(q - step)) / 2e-5


def _outside(link: Link, point: np.ndarray) -> float:
    """How far a point of the link's frame lies outside its shape; for boxes by the face that it is farthest from."""
    d, half = np.abs(point - link.centre), np.array(link.size) / 2
    if link.shape == "cylinder":
        return max(np.hypot(d[0], d[1]) - half[0], d[2] - half[2])
    return float((d - half).max())


@pytest.fixture(scope="module")
def upright(planner: mujoco.MjModel) -> np.ndarray:
    return standing(planner).angles[0]


def test_bands_lie_on_the_soft_layer_over_the_hard_shapes() -> None:
    for band in BANDS:
        for point in band.via_points:
            assert _outside(BY_NAME[point.link], np.array(point.xyz)) == pytest.approx(LAYER, abs=1e-4), band.name


@pytest.mark.parametrize("posture", POSTURES, ids=str)
def test_bands_run_round_the_body_and_not_through_it(posture: dict[str, float], upright: np.ndarray) -> None:
    q = upright.copy()
    q[[JOINT_NAMES.index(name) for name in posture]] = list(posture.values())
    frames = _frames(q)
    for band in BANDS:
        for a, b in zip(_course(band, q)[:-1], _course(band, q)[1:], strict=True):
            for share in np.linspace(0.0, 1.0, 50):
                for link in NEAR:
                    R, p = frames[link]
                    assert _outside(BY_NAME[link], R.T @ (a + share * (b - a) - p)) > 0.0, (band.name, link)


@pytest.mark.parametrize("posture", POSTURES, ids=str)
def test_back_bands_extend_the_trunk_with_a_lever_of_8_to_16_cm(posture: dict[str, float], upright: np.ndarray) -> None:
    q = upright.copy()
    q[[JOINT_NAMES.index(name) for name in posture]] = list(posture.values())
    levers = _levers(q, PITCH)[[band.group == "A" for band in BANDS]]
    assert levers.min() > 0.08
    assert levers.max() < 0.16


def test_waist_bands_resist_twisting_and_hardly_bending(upright: np.ndarray) -> None:
    side = np.array([band.group == "B" for band in BANDS])
    assert np.abs(_levers(upright, YAW)[side]).min() > 0.1
    assert np.abs(_levers(upright, PITCH)[side]).max() < 0.015
    assert np.sign(_levers(upright, YAW)[side]).sum() == 0.0, "one of the two is stretched either way"


def test_standing_every_band_is_just_taut_and_as_long_as_its_polyline(bench, planner, upright: np.ndarray) -> None:
    posture = standing(planner)
    for suit in bench.suits.values():
        model = mujoco_model(bench.robot, suit)
        data = mujoco.MjData(model)
        data.qpos[:3], data.qpos[7:] = posture.base[0], upright
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(data.ten_length, _lengths(upright), atol=1e-12)
        least, most = STRETCH_STANDING
        stretch = data.ten_length - [band.natural_length for band in suit.bands]
        assert stretch.min() >= least - 0.0005
        assert stretch.max() <= most + 0.0005


def test_recorded_torque_is_tension_times_lever(worn, bench) -> None:
    """τ = -(∂l/∂θ)ᵀ T with T = k max(l - l_0, 0), of every band on every joint, and lengths of the same instant."""
    for (_, kind), run in worn.items():
        k = np.array([band.stiffness for band in bench.suits[kind].bands])
        l_0 = np.array([band.natural_length for band in bench.suits[kind].bands])
        recording = run.recording
        for t in range(0, len(recording.time), 200):
            q = recording.q[t]
            l = _lengths(q)  # noqa: E741
            T = k * np.maximum(l - l_0, 0.0)
            np.testing.assert_allclose(recording.band_length[t], l, atol=1e-12)
            np.testing.assert_allclose(recording.band_tension[t], T, atol=1e-8)
            tau = [-_levers(q, j) @ T for j in range(len(JOINT_NAMES))]
            np.testing.assert_allclose(recording.band_torque[t], tau, atol=1e-6)


def test_a_bend_is_supported_and_twice_as_much_by_the_modified_suit(worn) -> None:
    normal, modified = (worn["bend", kind].recording for kind in ("normal", "modified"))
    bent = normal.q[:, PITCH] > 0.4
    assert bent.mean() > 0.1
    assert normal.band_torque[bent, PITCH].max() < -1.5
    ratio = modified.band_torque[bent, PITCH] / normal.band_torque[bent, PITCH]
    np.testing.assert_allclose(ratio, 2.0, rtol=0.05)


def test_a_twist_is_resisted_and_slackens_a_band(worn) -> None:
    recording = worn["twist", "normal"].recording
    twisted = recording.q[:, YAW] > 0.4
    assert recording.band_torque[twisted, YAW].max() < -1.0
    left, right = (recording.band_tension[twisted, k] for k in (2, 3))
    assert (BANDS[2].name, BANDS[3].name) == ("B_left", "B_right")
    assert left.max() == 0.0
    assert right.min() > 5.0


def test_the_robot_follows_the_plan_in_the_suit_and_stands_on_both_soles(worn) -> None:
    for run in worn.values():
        knots = run.plan.angles[160::10]  # from the end of the arrival, every 0.1 s
        followed = run.recording.q[:: round(0.1 * LOG_RATE_HZ)]
        assert len(knots) == len(followed)
        assert np.abs(followed - knots).max() < 0.010
        assert run.recording.wrench[:, :, 2].min() > 100.0


def test_without_a_suit_there_is_no_band(run) -> None:
    assert run.recording.band_length.shape == run.recording.band_tension.shape == (len(run.recording.time), 0)
    assert not run.recording.band_torque.any()
