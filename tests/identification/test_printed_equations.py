"""[Evaluator] section 3 against an independent calculation: what holds as printed, and what only in corrected form.

A small robot of our own (floating base, one foot, four joints) is computed by pinocchio; truth, friction and currents
are made here, from eqs (5)-(9), without any of the code under test elsewhere. Its motions are vigorous: how often a
wrong sign shows depends on that, the identities do not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
import pytest

JOINTS = 4
STILL = 0.4  # share of samples in which a joint rests


def small_robot() -> pin.Model:
    """Base, a leg of two joints that ends in the foot, and an arm of two joints. Gravity comes in with the IMU."""
    model = pin.Model()
    model.gravity = pin.Motion.Zero()
    base = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "base")
    hip = model.addJoint(base, pin.JointModelRY(), pin.SE3(np.eye(3), np.array([0.0, 0.1, -0.1])), "hip")
    knee = model.addJoint(hip, pin.JointModelRX(), pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.4])), "knee")
    waist = model.addJoint(base, pin.JointModelRZ(), pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.2])), "waist")
    arm = model.addJoint(waist, pin.JointModelRY(), pin.SE3(np.eye(3), np.array([0.1, 0.2, 0.3])), "arm")
    for joint, mass, size in (
        (base, 8.0, 0.3),
        (hip, 4.0, 0.2),
        (knee, 3.0, 0.25),
        (waist, 6.0, 0.35),
        (arm, 2.0, 0.2),
    ):
        body = pin.Inertia.FromBox(mass, size, 0.7 * size, 1.4 * size)
        model.appendBodyToJoint(joint, body, pin.SE3(pin.rpy.rpyToMatrix(0.1, 0.2, 0.3), np.full(3, size / 4)))
    placement = pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.1, 0.0), np.array([0.02, 0.0, -0.4]))
    model.addFrame(pin.Frame("foot", knee, 0, placement, pin.FrameType.OP_FRAME))
    return model


@dataclass(frozen=True)
class Truth:
    """T samples of Y_o (T, 6, 50), Y_j (T, 4, 50), F_o (T, 6), the others (T, 4).

    bias: c_j of (5). inertial: what is left of the joint rows, M_ojᵀ q̈_o + M_jj θ̈.
    """

    phi: np.ndarray
    k_T: np.ndarray
    k_d: np.ndarray
    tau_c: np.ndarray
    tau_s: np.ndarray
    tau_o: np.ndarray
    Y_o: np.ndarray
    Y_j: np.ndarray
    F_o: np.ndarray
    F_j: np.ndarray
    velocity: np.ndarray
    current: np.ndarray
    friction: np.ndarray
    bias: np.ndarray
    inertial: np.ndarray

    @property
    def xi(self) -> np.ndarray:
        return np.concatenate([self.k_T, self.k_d, self.tau_c, self.tau_s, self.tau_o])


@pytest.fixture(scope="module")
def truth() -> Truth:
    rng = np.random.default_rng(0)
    model = small_robot()
    data, foot = model.createData(), model.getFrameId("foot")
    phi = np.concatenate([model.inertias[i].toDynamicParameters() for i in range(1, model.njoints)])
    k_T, k_d = rng.uniform(3, 8, JOINTS), rng.uniform(0.5, 2, JOINTS)
    tau_c, tau_s, tau_o = rng.uniform(1, 3, JOINTS), rng.uniform(3, 5, JOINTS), rng.normal(0, 1, JOINTS)
    rows: dict[str, list[np.ndarray]] = {name: [] for name in ("Y_o", "Y_j", "F_o", "F_j", "v", "u", "f", "c", "Ma")}
    for _ in range(300):
        still = rng.random(JOINTS) < STILL
        q = np.r_[pin.neutral(model)[:7], rng.uniform(-1, 1, JOINTS)]
        v = np.r_[0, 0, 0, rng.normal(0, 0.5, 3), np.where(still, 0.0, rng.normal(0, 1, JOINTS))]
        proper = np.r_[0, 0, 9.81] + rng.normal(0, 4, 3)
        a = np.r_[proper, rng.normal(0, 8, 3), np.where(still, 0.0, rng.normal(0, 20, JOINTS))]
        Y = pin.computeJointTorqueRegressor(model, data, q, v, a).copy()
        K = pin.computeFrameJacobian(model, data, q, foot, pin.LOCAL).copy()
        wrench = np.linalg.solve(K[:, :6].T, Y[:6] @ phi)  # the one contact carries all that the base asks for
        F = K.T @ wrench
        sign = np.sign(v[6:])
        friction = k_d * v[6:] + tau_c * sign + (1 - np.abs(sign)) * rng.choice([-1, 1], JOINTS) * tau_s  # (7)
        tau = Y[6:] @ phi + friction - F[6:]  # the lower part of (5)
        at_rest = np.r_[0, 0, 9.81, np.zeros(3 + JOINTS)]
        bias = pin.rnea(model, data, q, v, at_rest)[6:].copy()
        M = pin.crba(model, data, q)
        inertial = (np.triu(M) + np.triu(M, 1).T)[6:] @ (a - at_rest)
        values = (Y[:6], Y[6:], F[:6], F[6:], v[6:], (tau - tau_o) / k_T, friction, bias, inertial)
        for name, value in zip(rows, values, strict=True):
            rows[name].append(value)
    return Truth(phi, k_T, k_d, tau_c, tau_s, tau_o, *(np.array(column) for column in rows.values()))


def diagonals(values: np.ndarray) -> np.ndarray:
    """(T, J) -> (T, J, J)."""
    return values[:, :, None] * np.eye(values.shape[1])


def residual_torque(t: Truth) -> np.ndarray:
    """r = u k_T + τ_o - (Y_j φ - F_j), (T, J): what eq (9) is corrected to."""
    return t.current * t.k_T + t.tau_o - (t.Y_j @ t.phi - t.F_j)


def columns_of_motor_and_friction(t: Truth) -> np.ndarray:
    """Z of (11)-(12) in corrected form, (T, J, 5 J)."""
    s = np.sign(t.velocity)
    still = (1 - np.abs(s)) * np.sign(residual_torque(t))
    offset = np.broadcast_to(np.eye(JOINTS), (len(s), JOINTS, JOINTS))
    parts = [diagonals(t.current), -diagonals(t.velocity), -diagonals(s), -diagonals(still), offset]
    return np.concatenate(parts, axis=2)


def weighted_least_squares(A: np.ndarray, y: np.ndarray, w: np.ndarray, ref: np.ndarray, W: np.ndarray) -> np.ndarray:
    """Minimiser of Σ w (A x - y)² + (x - ref)ᵀ W (x - ref), W diagonal."""
    stacked = np.vstack([A * np.sqrt(w)[:, None], np.sqrt(W)])
    return np.asarray(np.linalg.lstsq(stacked, np.r_[np.sqrt(w) * y, np.sqrt(W) @ ref], rcond=None)[0])


def stacked_rows(t: Truth) -> tuple[np.ndarray, np.ndarray]:
    """Eq (13) corrected: ([Y_o O; Y_j -Z] of all samples, [F_o; F_j])."""
    base = np.concatenate([t.Y_o, np.zeros((len(t.Y_o), 6, 5 * JOINTS))], axis=2)
    joints = np.concatenate([t.Y_j, -columns_of_motor_and_friction(t)], axis=2)
    A = np.concatenate([base, joints], axis=1)
    return A.reshape(-1, A.shape[2]), np.concatenate([t.F_o, t.F_j], axis=1).ravel()


def test_upper_part_of_5_holds_without_motor_and_friction(truth: Truth) -> None:
    np.testing.assert_allclose(truth.Y_o @ truth.phi, truth.F_o, atol=1e-9)


def test_lower_part_of_5_holds_with_motor_and_friction(truth: Truth) -> None:
    torque = truth.current * truth.k_T + truth.tau_o
    np.testing.assert_allclose(truth.Y_j @ truth.phi + truth.friction, torque + truth.F_j, atol=1e-9)


def test_motor_constant_behind_6_holds_the_gear_ratio_once_not_squared() -> None:
    N, k_t, i, joint_velocity, J_m, joint_acceleration = 100.0, 0.05, 2.0, 0.7, 3e-5, 1.3
    motor_velocity = N * joint_velocity
    power_of_motor = k_t * i * motor_velocity  # electrical power that becomes mechanical
    assert N * k_t * i * joint_velocity == pytest.approx(power_of_motor)
    assert N**2 * k_t * i * joint_velocity != pytest.approx(power_of_motor)
    power_of_rotor = J_m * (N * joint_acceleration) * motor_velocity  # the square belongs here
    assert N**2 * J_m * joint_acceleration * joint_velocity == pytest.approx(power_of_rotor)


def test_friction_of_7_takes_energy_out_of_every_motion(truth: Truth) -> None:
    moving = truth.velocity != 0
    assert np.all((truth.friction * truth.velocity)[moving] > 0)


def test_sign_in_8_is_that_of_the_same_joint(truth: Truth) -> None:
    still = truth.velocity == 0
    r = residual_torque(truth)
    own = np.sign(r) * truth.tau_s
    np.testing.assert_allclose(own[still], truth.friction[still], atol=1e-9)
    another = np.sign(np.roll(r, 1, axis=1)) * truth.tau_s  # j ≠ i, as the printed index allows
    assert np.mean(np.abs(another - truth.friction)[still] > 1.0) > 0.2


def test_sign_from_9_needs_the_full_residual_not_only_the_bias(truth: Truth) -> None:
    still = truth.velocity == 0
    full = residual_torque(truth)
    printed = truth.current * truth.k_T + truth.tau_o - truth.bias + truth.F_j  # lacks M_ojᵀ q̈_o and M_jj θ̈
    np.testing.assert_allclose(printed - full, truth.inertial, atol=1e-9)
    right = np.sign(truth.friction)
    assert np.all(np.sign(full)[still] == right[still])
    assert np.mean(np.sign(printed)[still] == right[still]) < 0.97


def test_external_forces_of_10_are_the_transposed_jacobians_times_wrench() -> None:
    model = small_robot()
    data, foot = model.createData(), model.getFrameId("foot")
    q = np.r_[pin.neutral(model)[:7], 0.3, -0.5, 0.2, 0.4]
    wrench = np.array([3.0, -2.0, 50.0, 1.0, 4.0, -0.5])
    K = pin.computeFrameJacobian(model, data, q, foot, pin.LOCAL)
    knee = model.getJointId("knee")
    outside = pin.StdVec_Force([pin.Force.Zero() for _ in range(model.njoints)])
    outside[knee] = model.frames[foot].placement.act(pin.Force(wrench))
    v = np.zeros(model.nv)
    expected = pin.rnea(model, data, q, v, v) - pin.rnea(model, data, q, v, v, outside)
    np.testing.assert_allclose(K.T @ wrench, expected, atol=1e-12)


def test_columns_of_11_and_12_enter_with_minus_and_friction_against_the_motor(truth: Truth) -> None:
    A, y = stacked_rows(truth)
    np.testing.assert_allclose(A @ np.r_[truth.phi, truth.xi], y, atol=1e-9)

    s = np.sign(truth.velocity)
    printed = np.concatenate(
        [diagonals(x) for x in (truth.current, truth.velocity, s, (1 - s) * np.sign(truth.tau_c), np.ones_like(s))],
        axis=2,
    )
    gap = truth.Y_j @ truth.phi + printed @ truth.xi - truth.F_j
    assert np.sqrt(np.mean(gap**2)) > 10.0
    only_signs = truth.Y_j @ truth.phi + columns_of_motor_and_friction(truth) @ truth.xi - truth.F_j
    assert np.sqrt(np.mean(only_signs**2)) > 10.0


def test_rest_factor_of_12_vanishes_in_motion_only_with_the_absolute_value(truth: Truth) -> None:
    s = np.sign(truth.velocity)
    moving = s != 0
    assert np.all((1 - np.abs(s))[moving] == 0)
    assert np.all((1 - s)[s < 0] == 2)  # as printed: static friction twice, while the joint moves


def test_sign_in_12_is_that_of_the_static_friction_not_of_the_coulomb_coefficient(truth: Truth) -> None:
    still = truth.velocity == 0
    by_residual = np.sign(residual_torque(truth)) * truth.tau_s
    by_coefficient = np.broadcast_to(np.sign(truth.tau_c) * truth.tau_s, by_residual.shape)
    np.testing.assert_allclose(by_residual[still], truth.friction[still], atol=1e-9)
    assert np.mean(np.abs(by_coefficient - truth.friction)[still] > 1.0) > 0.3


def test_rows_of_13_give_truth_back_by_14_up_to_what_no_motion_shows(truth: Truth) -> None:
    A, y = stacked_rows(truth)
    x = np.linalg.lstsq(A, y, rcond=1e-11)[0]
    np.testing.assert_allclose(A @ x, y, atol=1e-8)
    np.testing.assert_allclose(x[50:], truth.xi, atol=1e-8)
    assert np.linalg.matrix_rank(A, tol=1e-9 * np.linalg.norm(A)) == 10 * 5 - 3 * JOINTS + 5 * JOINTS


def test_weights_of_14_are_the_inverse_variances_of_the_rows(truth: Truth) -> None:
    rng = np.random.default_rng(1)
    A, y = stacked_rows(truth)
    std = np.tile(np.r_[np.full(3, 20.0), np.full(3, 2.0), np.full(JOINTS, 0.1)], len(truth.Y_o))
    errors = {"weighted": 0.0, "plain": 0.0}
    for _ in range(5):
        noisy = y + std * rng.normal(size=len(y))
        for name, w in (("weighted", std**-2), ("plain", np.ones(len(y)))):
            x = weighted_least_squares(A, noisy, w, np.zeros(70), 1e-12 * np.eye(70))
            errors[name] += float(np.linalg.norm((x - np.r_[truth.phi, truth.xi])[50:]))
    assert errors["weighted"] < 0.5 * errors["plain"]


def test_weights_of_15_have_one_row_per_parameter(truth: Truth) -> None:
    bodies = len(truth.phi) // 10
    phi_error, xi_error = 0.1 * truth.phi, 0.1 * truth.xi
    assert phi_error @ np.eye(10 * bodies) @ phi_error > 0
    assert xi_error @ np.eye(5 * JOINTS) @ xi_error > 0
    with pytest.raises(ValueError):
        phi_error @ np.eye(bodies) @ phi_error
    with pytest.raises(ValueError):
        xi_error @ np.eye(3 * JOINTS) @ xi_error


def test_minimum_of_15_stays_at_the_reference_where_no_row_says_anything(truth: Truth) -> None:
    A, y = stacked_rows(truth)
    ref = 1.2 * np.r_[truth.phi, truth.xi]
    x = weighted_least_squares(A, y, np.ones(len(y)), ref, np.eye(70))
    gradient = A.T @ (A @ x - y) + (x - ref)
    assert np.abs(gradient).max() < 1e-8 * np.abs(A.T @ y).max()
    _, singular, V = np.linalg.svd(A, full_matrices=False)
    unseen = V[singular < 1e-10 * singular[0]]
    assert len(unseen) == 3 * JOINTS
    np.testing.assert_allclose(unseen @ x, unseen @ ref, atol=1e-8)


def test_weights_of_16_and_17_keep_the_estimate_when_all_rows_are_rescaled(truth: Truth) -> None:
    rng = np.random.default_rng(2)
    A, y = stacked_rows(truth)
    noisy, ref = y + rng.normal(size=len(y)), 1.2 * np.r_[truth.phi, truth.xi]

    def estimate(scale: float) -> np.ndarray:
        w_o, w_j = scale * np.full(6, 0.1), scale * np.full(JOINTS, 3.0)
        lam_phi = information(truth.Y_o, w_o) + information(truth.Y_j, w_j)
        lam_T, lam_d = information(diagonals(truth.current), w_j), information(diagonals(truth.velocity), w_j)
        sizes = [largest(lam_phi), largest(lam_T), largest(lam_d), *[len(truth.Y_o) * w_j.max()] * 3]
        W = 1e-3 * np.diag(np.repeat(sizes, [50] + [JOINTS] * 5))
        return weighted_least_squares(A, noisy, np.tile(np.r_[w_o, w_j], len(truth.Y_o)), ref, W)

    np.testing.assert_allclose(estimate(100.0), estimate(1.0), rtol=1e-6, atol=1e-8)


def information(rows: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Σ_t Yᵀ W Y of (T, rows, columns)."""
    return np.einsum("tri,r,trj->ij", rows, weights, rows)


def largest(matrix: np.ndarray) -> float:
    return float(np.linalg.svd(matrix, compute_uv=False)[0])


def test_matrix_of_18_adds_base_and_joint_rows_each_with_its_own_weight(truth: Truth) -> None:
    w_o, w_j = np.linspace(0.1, 1.0, 6), np.linspace(2.0, 5.0, JOINTS)
    corrected = information(truth.Y_o, w_o) + information(truth.Y_j, w_j)
    rng = np.random.default_rng(3)
    direction = rng.normal(size=50)
    rise = sum(float(np.sum((Y @ direction) ** 2 * w)) for Y, w in ((truth.Y_o, w_o), (truth.Y_j, w_j)))  # h of (14)
    assert direction @ corrected @ direction == pytest.approx(rise)
    both = np.vstack([truth.Y_o[0], truth.Y_j[0]])
    with pytest.raises(ValueError):
        both.T @ np.diag(w_o) @ both
    twice = len(truth.Y_o) * corrected  # the printed sum runs over the samples twice
    assert direction @ twice @ direction != pytest.approx(rise)


@pytest.mark.parametrize(("block", "what"), [(0, "current"), (1, "velocity")])
def test_matrices_of_19_and_20_are_the_information_on_motor_constants_and_viscosity(
    truth: Truth, block: int, what: str
) -> None:
    w_j = np.linspace(2.0, 5.0, JOINTS)
    on_xi = information(columns_of_motor_and_friction(truth), w_j)
    own = slice(block * JOINTS, (block + 1) * JOINTS)
    lam = information(diagonals(getattr(truth, what)), w_j)
    np.testing.assert_allclose(np.diag(np.diag(lam)), lam, atol=1e-12)
    np.testing.assert_allclose(on_xi[own, own], lam, atol=1e-9)


def test_19_must_be_the_matrix_of_the_motor_constants_alone_or_the_unit_of_current_matters(truth: Truth) -> None:
    rng = np.random.default_rng(4)
    A, y = stacked_rows(truth)
    noisy, w_j = y + rng.normal(size=len(y)), np.full(JOINTS, 3.0)

    def motor_constants(unit: float, only_theirs: bool) -> np.ndarray:
        """k_T [N·m/A], with currents in `unit` amperes; one prior weight for them by (17), the others fixed."""
        units = np.ones(70)
        units[50 : 50 + JOINTS] = 1 / unit
        on_xi = information(columns_of_motor_and_friction(truth) * units[50:], w_j)
        lam = on_xi[:JOINTS, :JOINTS] if only_theirs else on_xi
        W = np.full(70, 1e-3)
        W[50 : 50 + JOINTS] = 1e-2 * largest(lam)
        ref = 1.2 * np.r_[truth.phi, truth.xi] / units
        x = weighted_least_squares(A * units, noisy, np.ones(len(y)), ref, np.diag(W))
        return (x * units)[50 : 50 + JOINTS]

    np.testing.assert_allclose(motor_constants(1e3, True), motor_constants(1.0, True), rtol=1e-8)
    as_named = motor_constants(1e3, False) / motor_constants(1.0, False)  # Λ_ξ as the matrix of all of ξ
    assert np.abs(as_named - 1).max() > 1e-3
