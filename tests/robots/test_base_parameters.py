"""The base parameters hold all that the equations of motion can tell, and nothing twice."""

from __future__ import annotations

import numpy as np
import pytest

from exogauge.robots.parameters import find_base_parameters, parameter_names, parameter_units
from exogauge.robots.regressor import regressor
from exogauge.robots.urdf import load_tree


@pytest.mark.parametrize("name", ["talos", "ur5", "ur10", "panda", "odd"])
def test_base_columns_times_base_parameters_are_all_of_the_dynamics(name, robot, random_motion):
    tree, _, _ = robot(name)
    base = find_base_parameters(tree)
    Y = regressor(tree, random_motion(tree, 20, seed=9))
    phi = np.random.default_rng(1).normal(size=10 * len(tree.bodies))
    assert np.abs(Y[:, :, base.columns] @ (base.regroup @ phi) - Y @ phi).max() < 1e-10
    assert np.abs(Y[:, :, base.columns] @ base.regroup - Y).max() < 1e-10


def test_a_floating_tree_loses_three_parameters_per_revolute_joint_and_nothing_else(robot):
    tree, _, _ = robot("talos")
    assert find_base_parameters(tree).rank == 10 * 33 - 3 * 32 == 234


@pytest.mark.parametrize("base", ["head_2_link", "leg_left_6_link"])
def test_the_rank_does_not_depend_on_where_the_tree_is_rooted(base, robot, urdf_of):
    joints = robot("talos")[0].joints
    assert find_base_parameters(load_tree(urdf_of("talos"), joints=joints, base_link=base, floating=True)).rank == 234


def test_the_arms_have_the_published_numbers(robot, urdf_of):
    assert find_base_parameters(robot("ur5")[0]).rank == 36
    joints = [f"panda_joint{i}" for i in range(1, 8)]
    panda = load_tree(urdf_of("panda"), joints=joints, base_link="panda_link0", floating=False)
    assert find_base_parameters(panda).rank == 43


def test_a_slope_under_a_fixed_arm_makes_more_visible(robot):
    tree, _, _ = robot("ur10")
    assert find_base_parameters(tree, up=np.array([2.0, 1.0, 9.5])).rank == 38  # first moments of the first link


@pytest.mark.slow
def test_kept_columns_are_well_conditioned_and_do_not_depend_on_the_draw(robot, random_motion):
    tree, _, _ = robot("talos")
    base, again = (find_base_parameters(tree, np.random.default_rng(seed)) for seed in (1, 2))
    assert base.columns.tolist() == again.columns.tolist()
    assert base.regroup == pytest.approx(again.regroup, abs=1e-12)
    Y = regressor(tree, random_motion(tree, 60))[:, :, base.columns].reshape(-1, base.rank)
    assert np.linalg.cond(Y / np.linalg.norm(Y, axis=0)) < 200


def test_parameters_are_named_by_link_and_component(robot):
    tree, _, _ = robot("ur10")
    names, units = parameter_names(tree), parameter_units(tree)
    assert names[:10] == tuple(
        f"{s}[shoulder_link]" for s in ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
    )
    assert units[:5] == ("kg", "kg·m", "kg·m", "kg·m", "kg·m²")
    base = find_base_parameters(tree)
    assert base.names == tuple(names[c] for c in base.columns)
    assert "m[forearm_link]" in base.combination(base.names.index("mz[upper_arm_link]"), names)
