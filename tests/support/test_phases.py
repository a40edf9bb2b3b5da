"""Parts of a motion: what a person would call them."""

from __future__ import annotations

import numpy as np
import pytest

from exogauge.logs.derivatives import differentiate
from exogauge.logs.filtering import LowPass
from exogauge.support.phases import find_phases, main_joint, phase_names

RATE = 200.0
STANDING, OUT, HOLDING, BACK = range(4)


def found(ramps, corners, noise=2e-5, offset=0.0, seconds=14.0, seed=0):
    """(time of begin, phase) of every part; the angle is an encoder's, low-passed as a log's is."""
    t = np.arange(0.0, seconds, 1.0 / RATE)
    angle = offset + ramps(t, corners)[0] + noise * np.random.default_rng(seed).normal(size=len(t))
    q = LowPass(10.0, RATE).apply(np.column_stack([0.02 * np.sin(t), angle]))
    phase = find_phases(t, q, differentiate(q, RATE), main_joint(q))
    starts = np.flatnonzero(np.diff(phase, prepend=-1))
    return [(float(t[k]), int(phase[k])) for k in starts]


def order(parts):
    return [phase for _, phase in parts]


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("offset", [0.0, -0.4])
@pytest.mark.parametrize("noise", [0.0, 2e-5, 2e-4])
def test_a_bend_is_standing_lowering_holding_raising_standing(ramps, sign, offset, noise):
    corners = [(2, 0), (4, 0.8 * sign), (6, 0.8 * sign), (8.5, 0), (14, 0)]
    parts = found(ramps, corners, noise, offset)
    assert order(parts) == [STANDING, OUT, HOLDING, BACK, STANDING]
    for (begin, _), true in zip(parts[1:], (2, 4, 6, 8.5), strict=True):
        assert abs(begin - true) < 0.45  # a seventh-degree ramp hardly moves for the first 0.3 s


def test_a_twist_to_both_sides_turns_out_and_back_on_each(ramps):
    corners = [(1, 0), (3, 0.6), (4, 0.6), (6, 0), (7, 0), (9, -0.5), (10, -0.5), (12, 0), (14, 0)]
    parts = found(ramps, corners)
    assert order(parts) == [STANDING, OUT, HOLDING, BACK, STANDING, OUT, HOLDING, BACK, STANDING]


def test_a_twist_from_side_to_side_comes_back_and_goes_out_again_at_the_middle(ramps):
    corners = [(1, 0), (3, 0.6), (4, 0.6), (7, -0.6), (8, -0.6), (10, 0), (14, 0)]
    parts = found(ramps, corners)
    assert order(parts) == [STANDING, OUT, HOLDING, BACK, OUT, HOLDING, BACK, STANDING]
    middle = next(
        begin for (begin, phase), (_, before) in zip(parts[1:], parts, strict=False) if (before, phase) == (BACK, OUT)
    )
    assert abs(middle - 5.5) < 0.02


def test_a_stop_on_the_way_out_is_a_hold_of_its_own(ramps):
    parts = found(ramps, [(1, 0), (3, 0.4), (4.5, 0.4), (6, 0.8), (7, 0.8), (9, 0), (14, 0)])
    assert order(parts) == [STANDING, OUT, HOLDING, OUT, HOLDING, BACK, STANDING]


def test_a_pause_near_the_start_is_standing_not_a_hold(ramps):
    corners = [(1, 0), (2, 0.08), (4, 0.08), (6, 0.8), (8, 0.8), (10, 0.05), (14, 0.05)]
    assert order(found(ramps, corners)) == [STANDING, OUT, STANDING, OUT, HOLDING, BACK, STANDING]


def test_noise_makes_no_splinters(ramps):
    corners = [(1, 0), (3, 0.5), (5, 0.5), (7, 0), (14, 0)]
    for seed in range(20):
        parts = found(ramps, corners, noise=5e-4, seed=seed)
        begins = [begin for begin, _ in parts] + [14.0]
        assert min(np.diff(begins)) >= 0.15 - 1.5 / RATE


def test_the_joint_that_moves_most_decides():
    t = np.linspace(0, 1, 50)
    assert main_joint(np.column_stack([5.0 + 0.1 * t, -0.3 * t, 0.2 * np.sin(9 * t)])) == 2
    assert main_joint(np.column_stack([5.0 + 0.1 * t, -0.5 * t, 0.2 * np.sin(9 * t)])) == 1


def test_a_log_in_which_nothing_moves_is_standing_throughout():
    t = np.arange(0.0, 3.0, 1.0 / RATE)
    q = np.full((len(t), 1), 0.3)
    assert not find_phases(t, q, np.zeros_like(q), 0).any()


def test_names_follow_the_joints_axis(biped):
    """Upright axes turn, level ones bend, wherever the robot's URDF puts them."""
    tree = biped.robot.tree
    assert phase_names(tree, "torso_pitch") == ("standing", "lowering", "holding", "raising")
    assert phase_names(tree, "torso_yaw") == ("standing", "turning out", "holding", "turning back")
    assert phase_names(tree, "l_knee")[OUT] == "lowering"
