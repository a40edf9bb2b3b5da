"""[Payload] 3: least squares with errors in the regressor, in one go and by recursion."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from exogauge.errors import NotIdentifiable
from exogauge.payload.total_least_squares import Recursion, only_output, solve, triangle

Array = NDArray[np.float64]

LS = [0.981576164, -2.012190193, 0.483336303]
GTLS = [1.017134938, -2.030587318, 0.48630473]


@pytest.fixture
def rows() -> tuple[Array, Array]:
    """Test vector 4: (200, 4) rows [A b] and the covariance of one."""
    rng = np.random.default_rng(0)
    A = rng.normal(size=(200, 3))
    E = np.diag([0.2, 0.1, 0.0, 0.3])
    Z = np.column_stack([A, A @ [1.0, -2.0, 0.5]]) + rng.normal(size=(200, 4)) @ E
    return Z, E @ E


def test_least_squares_is_gtls_with_errors_in_the_output_alone(rows: tuple[Array, Array]) -> None:
    Z, _ = rows
    assert solve(triangle(Z), only_output(4)).value == pytest.approx(LS, abs=1e-8)
    assert solve(triangle(Z), only_output(4)).value == pytest.approx(np.linalg.lstsq(Z[:, :3], Z[:, 3])[0], abs=1e-12)


def test_plain_tls_is_the_last_right_singular_vector_over_minus_its_last_entry(rows: tuple[Array, Array]) -> None:
    """As printed, (28) has the sign of the whole vector right and divides by v_q without saying of which sign."""
    v = np.linalg.svd(rows[0])[2][-1]
    found = solve(triangle(rows[0]), np.eye(4)).value
    assert found == pytest.approx(-v[:3] / v[3], abs=1e-12)
    corrected = rows[0] - rows[0] @ np.outer(v, v)
    assert corrected[:, :3] @ found == pytest.approx(corrected[:, 3], abs=1e-12)
    printed = rows[0] @ np.outer(v, v)
    assert np.abs(printed[:, :3] @ found - printed[:, 3]).max() > 0.1


def test_restricted_tls_of_the_test_vector(rows: tuple[Array, Array]) -> None:
    Z, P = rows
    found = solve(triangle(Z), 200 * P)
    assert found.value == pytest.approx(GTLS, abs=1e-8)
    assert found.mu == pytest.approx(0.937, abs=5e-4)


def test_the_quotient_of_33_is_least_with_p_r_and_not_with_p_l(rows: tuple[Array, Array]) -> None:
    Z, P = rows
    phi = solve(triangle(Z), P).value

    def quotient(phi: Array, metric: Array) -> float:
        v = np.append(phi, -1.0)
        return float(np.sum((Z @ v) ** 2) / (v @ metric @ v))

    def slope(metric: Array) -> Array:
        return np.array([quotient(phi + 1e-5 * e, metric) - quotient(phi - 1e-5 * e, metric) for e in np.eye(3)]) / 2e-5

    assert np.abs(slope(P)).max() < 1e-4 * quotient(phi, P)
    assert np.abs(slope(np.eye(4))).max() > 1e-2 * quotient(phi, np.eye(4))


def test_units_of_columns_change_nothing_but_with_plain_tls(rows: tuple[Array, Array]) -> None:
    Z, P = rows
    scale = np.array([1000.0, 1.0, 0.01, 1.0])
    scaled = solve(triangle(Z * scale), P * np.outer(scale, scale)).value * scale[:3]
    assert scaled == pytest.approx(solve(triangle(Z), P).value, rel=1e-10)
    plain = solve(triangle(Z * scale), np.eye(4)).value * scale[:3]
    assert np.abs(plain - solve(triangle(Z), np.eye(4)).value).max() > 1e-3


def test_recursion_tracks_the_batch_and_reaches_it(rows: tuple[Array, Array]) -> None:
    Z, P = rows
    recursion = Recursion(3)
    for z in Z:
        recursion.update(z[None], P)
    assert recursion.value == pytest.approx(GTLS, abs=1e-3)
    recursion.iterate(6)
    assert recursion.value == pytest.approx(GTLS, abs=1e-7)
    assert recursion.mu == pytest.approx(0.937, abs=1e-3)


def test_recursion_with_errors_in_the_output_alone_is_recursive_least_squares(rows: tuple[Array, Array]) -> None:
    out = Recursion(3, relative=1e-12).run(rows[0][:, None], np.broadcast_to(only_output(4), (200, 4, 4)).copy())
    assert out[-1] == pytest.approx(LS, abs=1e-8)
    assert out[99] == pytest.approx(np.linalg.lstsq(rows[0][:100, :3], rows[0][:100, 3])[0], abs=1e-8)


def test_forgetting_counts_old_rows_least(rows: tuple[Array, Array]) -> None:
    """As printed, P_l = diag(λ^{k-1}, …, 1) divides by it, so the oldest rows would count most."""
    Z, P = rows
    age = np.arange(199, -1, -1.0)
    out = Recursion(3, forget=0.99).run(Z[:, None], np.broadcast_to(P, (200, 4, 4)).copy())
    right = solve(triangle(Z * 0.99 ** (age[:, None] / 2)), P).value
    printed = solve(triangle(Z * 0.99 ** (-age[:, None] / 2)), P).value
    assert np.abs(out[-1] - right).max() < 1e-3
    assert np.abs(printed - right).max() > 0.01


def test_nothing_is_told_before_there_are_rows_enough_or_a_prior(rows: tuple[Array, Array]) -> None:
    Z, P = rows
    recursion = Recursion(3)
    recursion.update(Z[:2], 2 * P)
    assert recursion.value is None
    prior = Recursion(3, np.column_stack([np.eye(3), [1.0, -2.0, 0.5]]) / 0.1, start=np.array([1.0, -2.0, 0.5]))
    prior.update(Z[:2], 2 * P)
    assert prior.value == pytest.approx([1.0, -2.0, 0.5], abs=0.2)


def test_forgetting_stops_while_nothing_moves(rows: tuple[Array, Array]) -> None:
    Z, P = rows
    recursion = Recursion(3, forget=0.98)
    for z in Z:
        recursion.update(z[None], P)
    before = recursion.R.copy()
    for _ in range(400):
        recursion.update(np.array([[1e-4, 0.0, 0.0, 1e-4]]), P)
    assert recursion.frozen
    assert np.array_equal(recursion.R, before)


def test_a_regressor_without_full_rank_is_refused() -> None:
    with pytest.raises(NotIdentifiable):
        solve(triangle(np.column_stack([np.ones(9), np.ones(9), np.arange(9.0)])), only_output(3))


def test_an_output_of_nothing_but_zeros_is_explained_by_zeros(rows: tuple[Array, Array]) -> None:
    """A payload that is believed to hang in the sensor's origin has no moment to measure."""
    A = rows[0][:, :3]
    found = solve(triangle(np.column_stack([A, np.zeros(len(A))])), only_output(4))
    assert found.value == pytest.approx(np.zeros(3), abs=1e-12)
