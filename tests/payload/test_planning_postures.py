"""[Payload] 3.1: postures, and where the sensor's axes may point."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray
from tests.payload.conftest import GRAVITY, STD
from tests.payload.planned import arm_of, wrist_limits

from exogauge.errors import NotIdentifiable
from exogauge.payload.planning.postures import (
    Believed,
    algorithm_1,
    choose,
    grid,
    informations,
    least_travel,
    std_of,
)
from exogauge.payload.planning.workspace import Cap, inside
from exogauge.payload.statics import force_columns

Array = NDArray[np.float64]

DOWN = Cap(2, theta=(np.radians(120.0), np.pi))
BELIEVED = Believed(40.0, np.array([0.01, 0.02, 0.03]), GRAVITY, -1, STD / np.sqrt(250))


def within_60_degrees(rotation: Array) -> NDArray[np.bool_]:
    return inside((DOWN,), rotation)


def printed(n: int, K: float) -> Array:
    """Lines 2-13 of Algorithm 1 with i and j from 0 to n, by pinocchio alone."""
    turns = []
    for i in range(n + 1):
        z = 2 * np.pi * i / n
        x = K * z if z < np.pi else -K * (2 * np.pi - z)
        turns += [pin.rpy.rpyToMatrix(x, np.pi * j / n, z) for j in range(n + 1)]
    return np.array(turns)


def test_printed_algorithm_1_repeats_itself_and_ours_has_the_same_postures_once() -> None:
    """As printed n = 4 gives 25 postures, the last turn of which is the first again."""
    as_printed = printed(4, -0.2)
    assert len(as_printed) == 25
    assert as_printed[-5:] == pytest.approx(as_printed[:5])
    found = algorithm_1(13, -0.2, lambda R: np.ones(len(R), dtype=bool))
    apart = np.abs(found[:, None, 2] - found[None, :, 2]).max(axis=2) + np.eye(len(found))
    assert apart.min() > 1e-6
    assert len(grid(4, -0.2)) == 20


@pytest.mark.parametrize("count", [15, 21])
def test_algorithm_1_keeps_the_stated_conditions_within_sixty_degrees(count: int) -> None:
    found = algorithm_1(count, -0.2, within_60_degrees)
    assert 15 <= len(found) <= 21
    assert (found[:, 2, 2] <= -0.5 + 1e-12).all()
    force, moment = BELIEVED.solution(found).condition
    assert force <= 4.5
    assert moment <= 6.5


def test_k_of_zero_without_duplicates_is_singular_and_refused() -> None:
    every = printed(8, 0.0)
    _, first = np.unique(np.round(every[:, 2], 9), axis=0, return_index=True)
    assert np.linalg.matrix_rank(force_columns(every[first]), tol=1e-9) < 6
    with pytest.raises(NotIdentifiable, match=r"K = 0 .* singular"):
        algorithm_1(15, 0.0, within_60_degrees)


def test_a_workspace_without_room_is_refused() -> None:
    with pytest.raises(NotIdentifiable, match="widen it"):
        algorithm_1(15, -0.2, lambda R: inside((Cap(2, theta=(3.13, np.pi)),), R))


@pytest.mark.parametrize("count", [15, 21])
def test_chosen_postures_leave_less_than_algorithm_1_and_keep_the_conditions(count: int) -> None:
    arm = arm_of()
    limits = wrist_limits()
    q = np.random.default_rng(3).uniform(limits.lower[3:], limits.upper[3:], (2000, 3))
    rotation = arm.rotations(q)
    rotation = rotation[within_60_degrees(rotation)]
    chosen = rotation[choose(rotation, count, BELIEVED)]
    solution = BELIEVED.solution(chosen)
    assert solution.condition[0] <= 4.5
    assert solution.condition[1] <= 6.5
    known = [0, 1, 2, 3, 10, 11]
    printed_ones = BELIEVED.solution(algorithm_1(21, -0.2, within_60_degrees)[:count]).std
    assert np.log(solution.std[known]).mean() < np.log(printed_ones[known]).mean()


def test_the_criterion_is_the_static_stages_own_standard_deviation() -> None:
    turns = algorithm_1(15, -0.2, within_60_degrees)
    force, moment = (each.sum(axis=0)[None] for each in informations(turns, BELIEVED))
    stage = BELIEVED.solution(turns).std[[0, 1, 2, 3, 10, 11]]
    assert std_of(force, moment, BELIEVED)[0] == pytest.approx(stage, rel=1e-5)


def test_too_few_feasible_postures_are_said() -> None:
    with pytest.raises(NotIdentifiable, match="only 3 of the postures"):
        choose(grid(1, -0.2)[[0, 0, 1]], 6, BELIEVED)


def test_36_takes_columns_for_axes_and_wraps_phi() -> None:
    """Rows for axes, as printed, tell another feasibility."""
    R = pin.rpy.rpyToMatrix(0.4, 0.6, 1.1)
    x = R @ np.eye(3)[0]
    phi = float(np.arctan2(x[1], x[0]))
    near = Cap(0, phi=(phi - 0.1, phi + 0.1))
    assert inside((near,), R[None])[0]
    assert not inside((near,), R.T[None])[0]
    behind = Cap(0, phi=(np.radians(170.0), np.radians(190.0)))
    assert inside((behind,), pin.rpy.rpyToMatrix(0.0, 0.0, np.radians(-175.0))[None])[0]
    assert not inside((behind,), pin.rpy.rpyToMatrix(0.0, 0.0, np.radians(165.0))[None])[0]
    assert inside((behind,), pin.rpy.rpyToMatrix(0.0, -np.pi / 2, 0.0)[None])[0]  # θ = 0: φ is not defined


def test_margins_of_a_workspace_are_negative_outside_and_their_slopes_are_differences() -> None:
    rng = np.random.default_rng(5)
    cap = Cap(1, phi=(0.3, 1.9), theta=(0.4, 2.0))
    d = rng.standard_normal((200, 3))
    d /= np.linalg.norm(d, axis=1)[:, None]
    phi, theta = np.arctan2(d[:, 1], d[:, 0]), np.arccos(d[:, 2])
    by_angles = (phi >= 0.3) & (phi <= 1.9) & (theta >= 0.4) & (theta <= 2.0)
    margins, slopes = cap.margins(d)
    assert np.array_equal((margins >= 0).all(axis=1), by_angles)
    assert by_angles.any()
    for k, e in enumerate(np.eye(3)):
        difference = (cap.margins(d + 1e-6 * e)[0] - cap.margins(d - 1e-6 * e)[0]) / 2e-6
        assert slopes[:, :, k] == pytest.approx(difference, abs=1e-7)


def test_the_way_is_shorter_than_as_given_and_avoids_what_is_not_passable() -> None:
    places = np.array([[0.0], [3.0], [1.0], [4.0], [2.0]])
    order = least_travel(places, np.array([-1.0]), np.ones(1), lambda a, b: True)
    assert places[order].ravel().tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]

    def never_by_one(a: Array, b: Array) -> bool:
        return abs(float(a[0] - b[0])) != 1.0

    order = least_travel(places, np.array([-2.5]), np.ones(1), never_by_one)
    assert sorted(order) == [0, 1, 2, 3, 4]
    assert (np.abs(np.diff(places[order].ravel())) > 1.0).all()


def test_an_orientation_is_reached_by_the_joints_that_move() -> None:
    arm, limits = arm_of(), wrist_limits()
    for R in algorithm_1(15, -0.2, within_60_degrees):
        angles = arm.reach(R, limits.lower[3:], limits.upper[3:])
        if angles is not None:
            assert arm.rotations(angles[None])[0] == pytest.approx(R, abs=1e-8)
    assert arm.reach(np.eye(3), np.zeros(3), np.full(3, 1e-3)) is None
