"""The fast rows are the regressor's rows, without its zeros."""

from __future__ import annotations

import numpy as np
import pytest

from exogauge.robots.parameters import find_base_parameters
from exogauge.robots.regressor import regressor
from exogauge.robots.row_blocks import RowBlocks

ROBOTS = ("talos", "ur5", "panda", "odd")


def _coupling(tree, seed=4):
    """C: the last two joints form a differential, joint 0 turns with joint 1, and the order of motors is another."""
    rng, n = np.random.default_rng(seed), len(tree.joints)
    C = np.eye(n)
    C[-2:, -2:] = [[1.0, 0.4], [-0.7, 1.0]]
    C[0, 1] = 0.3
    return C @ np.diag(rng.uniform(0.5, 2.0, n))


def _dense_rows(tree, base, C, motion):
    Y = regressor(tree, motion)[:, :, base.columns]
    Y[:, -len(tree.joints) :] = np.einsum("aj,tjk->tak", np.linalg.inv(C).T, Y[:, -len(tree.joints) :])
    return Y


@pytest.mark.parametrize("coupled", [False, True])
@pytest.mark.parametrize("name", ROBOTS)
def test_blocks_are_the_rows_of_the_regressor_and_all_else_is_zero(name, coupled, robot, random_motion):
    tree, _, _ = robot(name)
    base, C = find_base_parameters(tree), _coupling(tree) if coupled else np.eye(len(tree.joints))
    motion = random_motion(tree, 37)
    rows = RowBlocks(tree, base, C)
    blocks, dense = rows.fill(motion, extra=2), _dense_rows(tree, base, C, motion)
    assert len(blocks) == len(rows.columns) == dense.shape[1]
    for r, (block, columns) in enumerate(zip(blocks, rows.columns, strict=True)):
        assert block.flags.f_contiguous
        assert np.abs(block[:, :-2] - dense[:, r, columns]).max() < 1e-9
        assert not block[:, -2:].any()
        assert np.abs(np.delete(dense[:, r], columns, axis=1)).max(initial=0.0) < 1e-12


def test_overwritten_blocks_hold_nothing_of_the_chunk_before(robot, random_motion):
    tree, _, _ = robot("odd")
    rows = RowBlocks(tree, find_base_parameters(tree), np.eye(4))
    blocks = rows.fill(random_motion(tree, 20, seed=1), extra=3)
    for block in blocks:
        block[:] = np.nan
    again = rows.fill(random_motion(tree, 20, seed=2), 3, blocks)
    fresh = rows.fill(random_motion(tree, 20, seed=2), 3)
    assert all(a is b for a, b in zip(again, blocks, strict=True))
    assert all(np.array_equal(a, b) for a, b in zip(again, fresh, strict=True))
    assert rows.fill(random_motion(tree, 7), 3, blocks)[0].shape[0] == 7


def test_a_leaf_axis_has_seven_columns_and_a_force_row_no_inertia(robot):
    tree, _, _ = robot("talos")
    base = find_base_parameters(tree)
    columns = RowBlocks(tree, base, np.eye(32)).columns
    assert len(columns[0]) == 4 + 2 * 32
    assert len(columns[5]) == base.rank
    assert len(columns[6 + tree.joints.index("leg_left_6_joint")]) == 7
    assert len(columns[6 + tree.joints.index("leg_left_1_joint")]) == 6 * 7
