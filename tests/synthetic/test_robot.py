from __future__ import annotations

import mujoco
import numpy as np
import pytest

from exogauge.errors import BadInput
from exogauge.synthetic import robot_facts as facts
from exogauge.synthetic.hidden import parse_hidden
from exogauge.synthetic.inertia import Mass, of_shape
from exogauge.synthetic.true_robot import (
    INERTIAL_STD,
    a_priori_joint,
    a_priori_joint_std,
    a_priori_robot,
    draw_robot,
    moving_bodies,
)
from exogauge.synthetic.urdf import robot_file


def test_the_robot_has_the_published_size() -> None:
    height, link = 0.0, facts.BY_NAME["head"]
    height = link.centre[2] + link.size[2] / 2
    while link.parent:
        height, link = height + link.origin[2], facts.BY_NAME[link.parent]
    legs = facts.HIP_DROP + facts.THIGH + facts.SHANK + facts.ANKLE_HEIGHT
    assert legs + height == pytest.approx(1.51, abs=0.005)
    assert sum(link.mass for link in facts.LINKS) == pytest.approx(39.0)
    assert len(facts.JOINTS) == 34


def test_the_ground_lies_where_the_soles_end() -> None:
    sole_bottom = facts.SENSOR_DROP - facts.SOLE_CENTRE[2] + facts.SOLE_SIZE[2] / 2
    assert sole_bottom == pytest.approx(facts.ANKLE_HEIGHT)


def test_the_soles_that_are_stated_are_where_the_robot_touches_the_floor(planner: mujoco.MjModel) -> None:
    data = mujoco.MjData(planner)
    mujoco.mj_kinematics(planner, data)
    for sole in robot_file()["soles"]:
        foot = data.body(sole["link"])
        balls = [
            k for k in range(planner.ngeom) if planner.geom_bodyid[k] == planner.body(f"{sole['link'][0]}_sole").id
        ]
        seen = [foot.xmat.reshape(3, 3).T @ (data.geom_xpos[k] - foot.xpos) - [0, 0, planner.geom_size[k, 0]]
                for k in balls]  # fmt: skip
        assert sorted(np.round(seen, 9).tolist()) == pytest.approx(np.array(sorted(sole["outline"])))


def test_every_drawn_body_can_exist() -> None:
    for seed in range(20):
        for body in moving_bodies(draw_robot(np.random.default_rng(seed)).masses).values():
            assert body.mass > 0.0
            assert np.linalg.eigvalsh(body.spread).min() > 0.0


def test_soles_below_the_sensors_are_no_part_of_the_body() -> None:
    robot = a_priori_robot()
    bodies = moving_bodies(robot.masses)
    assert len(bodies) == 35
    assert bodies["l_foot"].mass == robot.masses["l_foot"].mass
    assert bodies["chest"].mass == pytest.approx(robot.masses["chest"].mass + robot.masses["computer"].mass)


def test_a_shape_turned_into_points_has_the_same_inertia() -> None:
    mass = of_shape(facts.BY_NAME["l_thigh"])
    rng = np.random.default_rng(0)
    radius, angle = facts.BY_NAME["l_thigh"].size[0] / 2 * np.sqrt(rng.random(200_000)), 2 * np.pi * rng.random(200_000)
    z = facts.BY_NAME["l_thigh"].size[2] * (rng.random(200_000) - 0.5)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z]) + mass.centre
    inertia = mass.mass * (np.eye(3) * np.mean(np.sum(points**2, axis=1)) - points.T @ points / len(points))
    expected = Mass(mass.mass, mass.centre, mass.spread).phi()
    np.testing.assert_allclose(inertia[[0, 1, 2], [0, 1, 2]], expected[[4, 6, 9]], rtol=0.01)


def test_the_a_priori_standard_deviations_describe_the_spread_of_the_truth() -> None:
    robots = [draw_robot(np.random.default_rng(seed)) for seed in range(40)]
    for kind in ("k_T", "k_d", "tau_c", "tau_s", "tau_o", "J_r"):
        z = [
            (getattr(robot.joints[joint.name], kind) - getattr(a_priori_joint(joint.drive), kind))
            / a_priori_joint_std(joint.drive)[kind]
            for robot in robots
            for joint in facts.JOINTS
        ]
        assert abs(np.mean(z)) < 0.1, kind
        assert 0.85 < np.std(z) < 1.1, kind
    prior = a_priori_robot().masses
    for link, even in prior.items():
        relative = [robot.masses[link].mass / even.mass - 1.0 for robot in robots]
        shift = [(robot.masses[link].centre - even.centre) / even.gyration for robot in robots]
        assert np.std(relative) == pytest.approx(INERTIAL_STD, rel=0.5), link
        assert np.std(shift) == pytest.approx(INERTIAL_STD, rel=0.35), link


def test_a_payload_adds_its_mass_to_the_body_that_carries_it() -> None:
    rng = np.random.default_rng(1)
    hidden = parse_hidden(["payload@computer"], rng)
    plain, loaded = draw_robot(np.random.default_rng(5)), draw_robot(np.random.default_rng(5), hidden)
    gain = {name: loaded.masses[name].mass - plain.masses[name].mass for name in plain.masses}
    assert gain.pop("computer") == pytest.approx(hidden[0].parameters["mass"])
    assert set(gain.values()) == {0.0}


@pytest.mark.parametrize(
    ("spec", "rule"),
    [
        ("gremlin@torso_pitch", "unknown_effect"),
        ("stribeck", "unknown_effect"),
        ("stribeck@chest", "unknown_joint"),
        ("payload@torso_pitch", "unknown_link"),
        ("payload@imu_link", "unknown_link"),
    ],
)
def test_what_cannot_be_hidden_is_refused_by_name(spec: str, rule: str) -> None:
    with pytest.raises(BadInput) as caught:
        parse_hidden([spec], np.random.default_rng(0))
    assert caught.value.faults[0].rule == rule
    assert caught.value.faults[0].value == spec
