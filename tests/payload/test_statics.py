"""[Payload] 2.2: what standing still says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from tests.payload.conftest import GRAVITY, case, generator

from exogauge.errors import NotIdentifiable
from exogauge.payload.holds import find_holds
from exogauge.payload.statics import (
    Holds,
    force_columns,
    further_posture,
    gravity_of,
    inclination,
    leave_one_out,
    misread_rotation,
    moment_columns,
    static_stage,
    told_sign,
    torque_zero,
)

Array = NDArray[np.float64]
KUKA = Path(__file__).resolve().parents[3] / "shared/data/kuka_ft_payload"

MASS, CENTRE = 12.0, np.array([0.03, -0.05, 0.11])
ZERO = np.array([5.0, -3.0, 8.0, 0.4, -0.2, 0.1])
U, V = np.radians([1.8, -2.3])


def exact(count: int = 12, sign: int = -1, turns: Rotation | None = None) -> Holds:
    """Postures by Newton alone: the payload hangs on the sensor, which reads its own side of it."""
    R = (Rotation.random(count, rng=np.random.default_rng(3)) if turns is None else turns).as_matrix()
    weight = MASS * np.einsum("kji,j->ki", R, 9.81 * gravity_of(U, V))  # of the payload, on the sensor
    on_sensor = np.concatenate([weight, np.cross(CENTRE, weight)], axis=1)
    return Holds(R, -sign * on_sensor + ZERO, np.array([0.1] * 3 + [0.01] * 3))


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("method", ["ls", "tls", "gtls"])
def test_every_number_comes_back_by_either_sign(sign: int, method: str) -> None:
    found = static_stage(exact(sign=sign), GRAVITY, sign, method=method)  # type: ignore[arg-type]
    # GTLS takes off what it believes the forces' errors to be, where exact data have none
    within = 1e-9 if method != "gtls" else 1e-3
    assert found.mass == pytest.approx(MASS, rel=within)
    assert found.centre == pytest.approx(CENTRE, abs=within)
    assert found.zero == pytest.approx(ZERO, abs=10 * within)
    assert found.tilt == pytest.approx([U, V], abs=within)


def test_19_of_the_test_vector_and_its_printed_form_turned_round() -> None:
    kappa = 40.173 * 9.81 * gravity_of(*np.radians([1.8, -2.3]))  # (14), s = -1
    assert kappa == pytest.approx([-15.808020104, -12.378890004, -393.585336943], abs=1e-8)
    assert np.degrees(inclination(kappa, -1)) == pytest.approx([1.8, -2.3], abs=1e-10)
    assert np.degrees(inclination(-kappa, 1)) == pytest.approx([1.8, -2.3], abs=1e-10)
    printed = np.degrees([np.arcsin(kappa[1] / np.linalg.norm(kappa)), np.arctan(kappa[0] / kappa[2])])
    assert printed == pytest.approx([-1.8, 2.3], abs=1e-10)


def test_16_and_20_are_products_of_numbers_and_inverse_to_each_other() -> None:
    f, c, tau = np.array([5.0, -3.0, 8.0]), CENTRE, ZERO[3:]
    iota = tau + np.array([f[1] * c[2] - f[2] * c[1], f[2] * c[0] - f[0] * c[2], f[0] * c[1] - f[1] * c[0]])
    assert torque_zero(iota, c, f) == pytest.approx(tau, abs=1e-15)


def test_columns_of_13_and_15_are_those_of_forces_and_moments() -> None:
    holds = exact(5)
    kappa = MASS * 9.81 * gravity_of(U, V)
    assert (force_columns(holds.rotation) @ [*kappa, *ZERO[:3]]).reshape(-1, 3) == pytest.approx(holds.wrench[:, :3])
    iota = ZERO[3:] - np.cross(CENTRE, ZERO[:3])
    moments = (moment_columns(holds.wrench[:, :3]) @ [*CENTRE, *iota]).reshape(-1, 3)
    assert moments == pytest.approx(holds.wrench[:, 3:])


@pytest.mark.parametrize("sign", [1, -1])
def test_the_sign_is_told_from_the_postures(sign: int) -> None:
    assert told_sign(exact(sign=sign), GRAVITY) == sign


@pytest.mark.parametrize("count", [1, 2])
def test_fewer_than_three_postures_are_refused(count: int) -> None:
    with pytest.raises(NotIdentifiable, match="at least three"):
        static_stage(exact(count), GRAVITY, -1)


def test_postures_alike_in_gravity_are_refused() -> None:
    turns = Rotation.from_euler("z", np.linspace(0, 2, 9)[:, None])
    with pytest.raises(NotIdentifiable):
        static_stage(exact(turns=turns), GRAVITY, -1)


def test_ignored_inclination_leaves_twice_the_sine_of_half_the_tilt() -> None:
    level = static_stage(exact(400), GRAVITY, -1, inclined=False)
    tilt = np.arccos(-gravity_of(U, V)[2])
    left = float(np.sqrt(np.mean(np.sum(level.residual[:, :3] ** 2, axis=1))))
    assert left == pytest.approx(2 * MASS * 9.81 * np.sin(tilt / 2), rel=0.02)


def test_a_pose_the_wrong_way_round_is_told_from_wrenches_in_the_bases_axes() -> None:
    holds = exact()
    in_base = np.einsum("kij,kaj->kai", holds.rotation, holds.wrench.reshape(-1, 2, 3)).reshape(-1, 6)
    assert misread_rotation(holds, GRAVITY) is None
    assert misread_rotation(Holds(np.swapaxes(holds.rotation, 1, 2), holds.wrench, holds.std), GRAVITY) == "transposed"
    assert misread_rotation(Holds(holds.rotation, in_base, holds.std), GRAVITY) == "world_axes"


def test_a_further_posture_makes_everything_surer_by_no_more_than_it_can() -> None:
    holds = exact(4)
    found = static_stage(holds, GRAVITY, -1)
    direction, std = further_posture(holds, found)
    assert np.linalg.norm(direction) == pytest.approx(1.0)
    assert np.all(std < found.std)
    assert std[0] > found.std[0] / 2


@pytest.mark.slow
def test_intervals_hold_and_the_leave_one_out_error_is_the_noise() -> None:
    rng = np.random.default_rng(5)
    hits, errors = [], []
    for _ in range(60):
        holds = exact(15)
        noisy = Holds(holds.rotation, holds.wrench + holds.std * rng.standard_normal((15, 6)), holds.std)
        found = static_stage(noisy, GRAVITY, -1)
        error = np.array([found.mass - MASS, *(found.centre - CENTRE), *(found.zero - ZERO), *(found.tilt - [U, V])])
        hits.append(np.abs(error) < 1.96 * found.std)
        errors.append(leave_one_out(noisy, GRAVITY, -1, inclined=True).force)
    assert 0.92 < np.mean(hits) < 0.99
    assert np.mean(errors) == pytest.approx(0.1 * np.sqrt(1 + 6 / 45), rel=0.1)


def test_holds_are_found_where_the_arm_stops() -> None:
    angles, _ = case(0).postures
    time = np.arange(len(angles)) / generator.RATE_HZ
    spans = find_holds(time, angles, generator.ENCODER_NOISE)
    assert len(spans) == generator.POSTURES
    start = 2.0 * np.arange(len(spans))
    assert np.array(spans)[:, 0] == pytest.approx(start + 0.1, abs=0.15)
    assert np.array(spans)[:, 1] == pytest.approx(start + 0.9, abs=0.15)
    assert np.all(np.array(spans)[1:, 0] > start[1:])
    assert np.all(np.array(spans)[:, 1] < start + 1.0)


@pytest.mark.skipif(not KUKA.is_dir(), reason="no recordings beside the repository")
def test_postures_of_a_real_arm_are_predicted_better_with_inclination() -> None:
    table = np.genfromtxt(KUKA / "0-calibration_fts-accel.csv", delimiter=",", names=True)
    R = np.stack([table[f"r{i}{j}"] for i in "123" for j in "123"], axis=1).reshape(-1, 3, 3)
    wrench = np.stack([table[name] for name in ("fx", "fy", "fz", "tx", "ty", "tz")], axis=1)
    holds, gravity = Holds(R, wrench, np.array([0.03] * 3 + [0.001] * 3)), np.array([0.0, 0.0, -9.82085])
    assert told_sign(holds, gravity) == -1
    assert leave_one_out(holds, gravity, -1, inclined=True).force <= 0.080
    assert leave_one_out(holds, gravity, -1, inclined=False).force <= 0.091
    assert static_stage(holds, gravity, -1).mass == pytest.approx(0.93, abs=0.005)
