from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from exogauge.robots.consistency import (
    from_log_cholesky,
    inertial_parameters,
    is_physical,
    log_cholesky_jacobian,
    log_det_distance,
    nearest_possible,
    pseudo_inertia,
    to_log_cholesky,
    violations,
)

THETA = np.array([0.5, -1, -1.2, -0.8, 0.1, -0.05, 0.02, 0.1, -0.2, 0.3])


@pytest.fixture
def thetas() -> np.ndarray:
    rng = np.random.default_rng(4)
    return rng.normal(size=(50, 10)) * np.r_[1, 0.5, 0.5, 0.5, 0.3, 0.3, 0.3, 0.5, 0.5, 0.5]


def in_frame(phi: np.ndarray, placement: pin.SE3) -> np.ndarray:
    return np.asarray(placement.act(pin.Inertia.FromDynamicParameters(phi)).toDynamicParameters())


def box(mass: float, x: float, y: float, z: float) -> np.ndarray:
    """A homogeneous box about its centre."""
    return np.asarray(pin.Inertia.FromBox(mass, x, y, z).toDynamicParameters())


def test_log_cholesky_reaches_the_published_test_vector() -> None:
    expected = [2.718281828, 0.271828183, -0.543656366, 0.815484549, 1.155580942, -0.024789157, 1.216789391,
                -0.10597651, 0.224167048, 0.785456332]  # fmt: skip
    np.testing.assert_allclose(from_log_cholesky(THETA), expected, atol=1e-9)


def test_log_cholesky_agrees_with_pinocchio(thetas: np.ndarray) -> None:
    for theta in thetas:
        reference = pin.LogCholeskyParameters(theta)
        np.testing.assert_allclose(from_log_cholesky(theta), reference.toDynamicParameters(), rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(log_cholesky_jacobian(theta), reference.calculateJacobian(), rtol=1e-12, atol=1e-12)


def test_pseudo_inertia_agrees_with_pinocchio_and_is_undone(thetas: np.ndarray) -> None:
    phi = from_log_cholesky(thetas)
    for one in phi:
        J = pin.Inertia.FromDynamicParameters(one).toPseudoInertia().toMatrix()
        np.testing.assert_allclose(pseudo_inertia(one), J, rtol=1e-11, atol=1e-12 * np.abs(J).max())
    np.testing.assert_allclose(inertial_parameters(pseudo_inertia(phi)), phi, rtol=1e-12, atol=1e-12)


def test_log_cholesky_is_undone_by_its_inverse(thetas: np.ndarray) -> None:
    np.testing.assert_allclose(to_log_cholesky(from_log_cholesky(thetas)), thetas, atol=1e-10)


def test_log_cholesky_jacobian_is_the_slope(thetas: np.ndarray) -> None:
    step = 1e-6
    for k in range(10):
        ahead, behind = (from_log_cholesky(thetas + sign * step * np.eye(10)[k]) for sign in (1, -1))
        slope = (ahead - behind) / (2 * step)
        np.testing.assert_allclose(log_cholesky_jacobian(thetas)[:, :, k], slope, rtol=1e-6, atol=1e-6)


def test_distance_does_not_depend_on_the_frame() -> None:
    phi, reference = from_log_cholesky(THETA), from_log_cholesky(THETA + 0.1)
    placement = pin.SE3(pin.rpy.rpyToMatrix(0.3, -0.7, 1.1), np.array([0.4, -0.2, 0.9]))
    moved, moved_reference = in_frame(phi, placement), in_frame(reference, placement)
    assert log_det_distance(moved, moved_reference) == pytest.approx(log_det_distance(phi, reference), rel=1e-9)
    assert np.linalg.norm(moved - moved_reference) > 1.5 * np.linalg.norm(phi - reference)


def test_distance_is_zero_at_the_reference_and_infinite_outside(thetas: np.ndarray) -> None:
    phi = from_log_cholesky(thetas)
    np.testing.assert_allclose(log_det_distance(phi, phi), 0, atol=1e-7)
    assert np.all(log_det_distance(phi, np.roll(phi, 1, axis=0)) > 0)
    assert log_det_distance(-phi[0], phi[1]) == np.inf


def test_physical_means_mass_and_moments_and_triangle_inequality() -> None:
    rng = np.random.default_rng(7)
    verdicts = []
    for _ in range(2000):
        mass, centre = rng.normal(1, 1), rng.normal(size=3)
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        principal = rng.normal(1.0, 0.6, size=3)
        I = turn @ np.diag(principal) @ turn.T + mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))  # noqa: E741
        phi = np.r_[mass, mass * centre, I[0, 0], I[0, 1], I[1, 1], I[0, 2], I[1, 2], I[2, 2]]
        expected = mass > 0 and principal.min() > 0 and principal.sum() > 2 * principal.max()
        assert is_physical(phi) == expected
        verdicts.append(expected)
    assert 0.1 < np.mean(verdicts) < 0.9


def test_violations_say_what_is_wrong_and_by_how_much() -> None:
    fine = box(2.0, 0.1, 0.2, 0.3)
    light, lopsided, negative = -fine, fine.copy(), fine.copy()
    lopsided[9] = 0.05  # more than Ixx + Iyy = 0.0217 + 0.0167
    negative[4] = -0.01
    said = violations(np.array([fine, light, lopsided, negative]), ["a", "b", "c", "d"])
    assert said[0] == "b: mass is -2 kg, must be positive"
    assert said[1].startswith("c: principal moments 0.01667 + 0.02167 kg·m² do not exceed 0.05 kg·m² (short by 0.0117)")
    assert said[2].startswith("d: smallest principal moment of inertia about the centre of mass is -0.01 kg·m²")
    assert all(text.startswith("d: ") for text in said[2:])


def test_a_massless_link_breaks_no_rule() -> None:
    assert is_physical(np.zeros(10))
    assert violations(np.zeros((1, 10)), ["frame"]) == ()


def test_a_flat_plate_is_possible_only_with_tolerance() -> None:
    plate = box(1.0, 0.3, 0.2, 0.0)
    assert not is_physical(plate, 1e-12)
    assert is_physical(plate, -1e-9)


def test_nearest_possible_keeps_mass_and_centre_and_what_was_possible(thetas: np.ndarray) -> None:
    phi = from_log_cholesky(thetas)
    np.testing.assert_array_equal(nearest_possible(phi), phi)
    point = np.r_[1.5, 1.5 * np.array([0.1, 0.0, -0.2]), np.zeros(6)]
    repaired = nearest_possible(point)
    assert is_physical(repaired)
    np.testing.assert_allclose(repaired[:4], point[:4])
