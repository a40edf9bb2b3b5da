"""Distances of a robot's shapes are MuJoCo's, found wherever they are small, and a plan keeps them."""

from __future__ import annotations

import shutil
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import trimesh
import yaml
from tests.motion.by_mujoco import Shapes

from exogauge.criteria.motion_plan import USUAL
from exogauge.errors import BadRobot
from exogauge.motion.plan.asked import Asked
from exogauge.motion.plan.judge import judge
from exogauge.motion.plan.outcome import may_touch
from exogauge.motion.plan.rows import shares, slopes
from exogauge.motion.plan.solve import plan
from exogauge.motion.plan.spline import through
from exogauge.motion.robot_file import load_motion_robot
from exogauge.robots.moving.robot import MotionRobot, Shape
from exogauge.robots.moving.standing import standing
from exogauge.robots.moving.touching import FLOOR, Pairs, hulls_alone
from exogauge.synthetic.urdf import robot_urdf


@pytest.fixture(scope="module")
def pairs(robot: MotionRobot) -> Pairs:
    return Pairs(robot, USUAL.clearance_m)


def anywhere(robot: MotionRobot, count: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    q = np.tile(robot.home, (count, 1))
    q[:, robot.base :] = rng.uniform(robot.limits.lower, robot.limits.upper, (count, len(robot.joints)))
    return q


@pytest.mark.slow
def test_distances_are_those_of_mujoco(robot: MotionRobot, pairs: Pairs) -> None:
    shapes, q = Shapes(robot, robot_urdf()), anywhere(robot, 5, 0)
    near = pairs.near(q, 0.5)
    assert len(near.sample) > 1000
    for t, p, distance in zip(near.sample, near.pair, near.distance, strict=True):
        shapes.stand(q[t])
        seen = shapes.distance(*pairs.names[p])
        assert distance == pytest.approx(seen, abs=1e-4) or (distance < 0.0 and seen < 0.0)


@pytest.mark.slow
def test_no_near_pair_is_missed_over_a_motion_and_slopes_are_those_of_the_distances(
    robot: MotionRobot, pairs: Pairs
) -> None:
    ends = anywhere(robot, 4, 1)
    q = np.concatenate([a + np.linspace(0.0, 1.0, 150)[:, None] * (b - a) for a, b in pairwise(ends)])
    found = pairs.near(q, 0.02)
    one_by_one = [pairs.near(posture[None], 0.02) for posture in q]
    alone = {(t, p) for t, each in enumerate(one_by_one) for p in each.pair}
    assert {(t, p) for t, p in zip(found.sample, found.pair, strict=True)} == alone
    slopes = pairs.slopes(q, found)
    rng = np.random.default_rng(2)
    apart, off = 0, 0
    for b in rng.permutation(np.flatnonzero(found.distance > 0.002))[:200]:
        t, p = found.sample[b], found.pair[b]
        step = 1e-4 * rng.normal(size=q.shape[1])
        ahead, behind = (pairs.near(q[None, t] + sign * step, 0.1) for sign in (1.0, -1.0))
        change = 0.5 * (ahead.distance[ahead.pair == p] - behind.distance[behind.pair == p])[0]
        apart += 1
        off += abs(change - slopes[b] @ step) > 0.05 * abs(change) + 2e-6
    assert apart == 200
    assert off < 20  # edges of boxes, where what is nearest jumps


def test_what_touches_by_construction_is_left_out_and_told(robot: MotionRobot, pairs: Pairs) -> None:
    assert ("BODY", "chest") in pairs.left_out  # named in the file
    assert ("l_hip_yaw_link", "l_thigh") in pairs.left_out  # inside each other at home
    shapes = Shapes(robot, robot_urdf())
    shapes.stand(robot.home)
    for pair in pairs.left_out[1:]:
        assert shapes.distance(*pair) < USUAL.clearance_m
    asked = {frozenset(pair) for pair in pairs.names}
    assert frozenset(("chest", "l_shoulder_pitch_link")) not in asked  # one joint between them
    assert frozenset(("l_hand", "r_hand")) in asked
    assert frozenset((FLOOR, "l_hand")) in asked
    assert frozenset((FLOOR, "l_sole")) not in asked


def test_a_pair_that_is_nearer_at_home_than_is_asked_for_binds_nothing_there(robot: MotionRobot, pairs: Pairs) -> None:
    """An upper arm so thick that it is 12 mm from the chest, where 15 are asked of others."""
    arm = ("chest", "l_upper_arm")
    gap = pairs.at_home[pairs.names.index(arm)]
    thick = tuple(
        replace(shape, size=(shape.size[0] + gap - 0.0125, *shape.size[1:])) if shape.link == arm[1] else shape
        for shape in robot.shapes
    )
    changed = replace(robot, shapes=thick)
    close = Pairs(changed, USUAL.clearance_m)
    assert USUAL.clearance_m < close.at_home[close.names.index(arm)] < USUAL.apart_m
    step, place = 1.0 / USUAL.nodes_per_s, standing(robot)
    still = Asked(np.tile(robot.home, (5, 1)), np.ones(robot.model.nq), step, np.ones((5, 2), bool), (place,) * 5)
    spline = through(still.q, step)
    used = shares(changed, spline, slopes(changed, still, spline, np.zeros((5, 2, 6))), close, USUAL)
    assert close.names.index(arm) in used.near.pair
    assert (used.apart <= used.near.distance + 1e-9).all()


@pytest.mark.slow
def test_arms_that_are_asked_into_the_trunk_stay_out(robot: MotionRobot, pairs: Pairs) -> None:
    step = 1.0 / USUAL.nodes_per_s
    s = np.clip(2.0 * np.minimum(np.linspace(0, 1, 181), np.linspace(1, 0, 181)), 0.0, 1.0)[:, None]
    inside = robot.home.copy()
    for name, value in {"shoulder_pitch": -0.3, "elbow_pitch": -1.6}.items():
        for side in "lr":
            inside[robot.base + robot.joints.index(f"{side}_{name}")] = value
    inside[robot.base + robot.joints.index("l_shoulder_yaw")] = -1.2
    inside[robot.base + robot.joints.index("r_shoulder_yaw")] = 1.2
    q = robot.home + s**3 * (10.0 - 15.0 * s + 6.0 * s**2) * (inside - robot.home)
    stray = np.full(robot.model.nq, np.inf)
    stray[:6], stray[robot.base + np.array(robot.beyond("thorax"))] = 0.2, USUAL.limb_rad
    stray[robot.base + np.array(robot.torso)] = USUAL.trunk_rad
    asked = Asked(q, stray, step, np.ones((181, 2), bool), (standing(robot),) * 181)
    alone = judge(robot, through(q, step), asked.place[0])
    assert alone.nearest is not None
    assert alone.apart.min() < -0.01
    assert any(line.startswith("distance of") for line in alone.broken)
    planned = plan(robot, asked)
    judged = judge(robot, planned.spline, asked.place[0], planned=planned, rate=1000.0)
    assert judged.broken == ()
    assert USUAL.clearance_m <= judged.apart.min() < USUAL.apart_m + 0.002  # as near as it may
    seen = Shapes(robot, robot_urdf()).nearer_than(USUAL.clearance_m - 1e-4, judged.q[::5])
    assert not seen & {frozenset(pair) for pair in pairs.names}
    assert all(tuple(pair) in pairs.left_out or tuple(pair)[::-1] in pairs.left_out or FLOOR in pair for pair in seen)


@pytest.mark.slow
def test_what_touches_only_as_a_convex_hull_is_told_by_name_with_how_far_its_mesh_is(robot: MotionRobot) -> None:
    """The left hand holds two plates, 6 cm on either side of the right one; the hull of both goes through it."""
    left, right = "l_hand", "r_hand"
    pin.forwardKinematics(robot.model, robot.data, robot.home)
    here, there = (
        pin.updateFramePlacement(robot.model, robot.data, robot.frame(each)).copy() for each in (left, right)
    )
    plate = trimesh.creation.box((0.2, 0.02, 0.2))
    plates = trimesh.util.concatenate([plate.copy().apply_translation([0.0, side * 0.1, 0.0]) for side in (-1.0, 1.0)])
    hollow = Shape(left, "hull", (), here.actInv(there), np.asarray(plates.vertices),
                   (np.asarray(plates.vertices), np.asarray(plates.faces, dtype=np.intp)))  # fmt: skip
    ball = Shape(right, "sphere", (0.03,))
    holds = replace(robot, shapes=(*(each for each in robot.shapes if each.link not in (left, right)), hollow, ball))
    pairs = Pairs(holds, USUAL.clearance_m)
    assert (left, right) in pairs.left_out
    assert hulls_alone(holds, [(left, right)], USUAL.clearance_m)[left, right] == pytest.approx(0.06, abs=1e-6)
    said = may_touch(holds, pairs.left_out)
    assert "l_hand and r_hand (60 mm)" in said["touch as hulls"]
    assert "l_hand and r_hand" not in said["may touch"]
    assert "BODY and chest" in said["may touch"]
    solid = replace(holds, shapes=(*holds.shapes[:-2], replace(hollow, mesh=None), ball))
    assert "l_hand and r_hand" in may_touch(solid, Pairs(solid, USUAL.clearance_m).left_out)["may touch"]
    assert "l_hand and r_hand in part" not in may_touch(solid, Pairs(solid, USUAL.clearance_m).left_out)["may touch"]
    two = replace(
        solid, shapes=(*solid.shapes, Shape(right, "sphere", (0.01,), pin.SE3(np.eye(3), np.array([0.0, -0.3, 0.0]))))
    )
    partly = Pairs(two, USUAL.clearance_m)
    assert (left, right) in partly.names  # the other one is looked at: Panda's link 5 and a finger stood in both
    assert "l_hand and r_hand in part" in may_touch(two, partly.left_out)["may touch"]
    away = holds.home.copy()
    away[holds.base + holds.joints.index("r_shoulder_roll")] -= 1.0
    elsewhere = replace(holds, home=away)  # from where they come together
    still = through(np.tile(holds.home, (5, 1)), 0.1)
    told = judge(elsewhere, still, standing(holds)).broken
    (line,) = (line for line in told if line.startswith("distance of l_hand and r_hand"))
    assert line.endswith("as convex hulls, the surfaces of their meshes are 0.06 m apart then")


def test_shapes_of_the_file_stand_in_for_those_of_the_urdf(folder: Path, tmp_path: Path) -> None:
    whole = yaml.safe_load((folder / "robot.yaml").read_text())
    block = {"capsule": [0.05, 0.1], "xyz": [0.0, 0.0, -0.06], "rpy": [0.0, 1.57, 0.0]}
    shutil.copy(folder / "robot.urdf", tmp_path)
    for collision, fault in (
        ({"shapes": {"l_hand": [block]}}, None),
        ({"shapes": {"hand": [block]}}, "collision.shapes"),
        ({"left_out": [["l_hand", "hand"]]}, "collision.left_out"),
        ({"shapes": {"l_hand": [block | {"sphere": 0.1}]}}, "collision.shapes.l_hand.0"),
        ({"shapes": {"l_hand": [{"sphere": -0.1}]}}, "collision.shapes.l_hand.0.sphere"),
    ):
        (tmp_path / "robot.yaml").write_text(yaml.safe_dump(whole | {"collision": collision}))
        if fault is None:
            (hand,) = (shape for shape in load_motion_robot(tmp_path / "robot.yaml").shapes if shape.link == "l_hand")
            assert (hand.kind, hand.size) == ("capsule", (0.05, 0.1))
            continue
        with pytest.raises(BadRobot) as told:
            load_motion_robot(tmp_path / "robot.yaml")
        assert told.value.faults[0].column == fault


def test_a_mesh_becomes_its_hull_and_one_that_is_not_there_is_told(
    folder: Path, tmp_path: Path, robot: MotionRobot
) -> None:
    """A hand as a mesh of its own box: the same distances; as a file that is missing: told."""
    box = '<box size="0.04 0.08 0.1" />'
    assert robot_urdf().count(box) == 4  # seen and felt, left and right
    (tmp_path / "robot.urdf").write_text(robot_urdf().replace(box, '<mesh filename="package://any/hand.stl" />'))
    shutil.copy(folder / "robot.yaml", tmp_path)
    assert load_motion_robot(tmp_path / "robot.yaml").shapeless == ("l_hand", "r_hand")
    trimesh.creation.box((0.04, 0.08, 0.1)).export(tmp_path / "hand.stl")
    meshed = load_motion_robot(tmp_path / "robot.yaml")
    assert meshed.shapeless == ()
    (hand,) = (shape for shape in meshed.shapes if shape.link == "l_hand")
    assert np.ptp(hand.mesh[0], axis=0) == pytest.approx([0.04, 0.08, 0.1])
    q = anywhere(robot, 3, 3)
    ours, theirs = Pairs(robot, 0.01).near(q, 0.3), Pairs(meshed, 0.01).near(q, 0.3)
    assert (ours.pair == theirs.pair).all()
    outside = ours.distance > 0.0
    assert theirs.distance[outside] == pytest.approx(ours.distance[outside], abs=1e-4)
    none = replace(robot, shapes=())
    assert Pairs(none, 0.01).names == ()
    assert len(Pairs(none, 0.01).near(q, 0.3).distance) == 0
