"""A motion that is planned to tell two effects apart keeps what the robot's file says of it, as MuJoCo sees it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from tests.motion.by_mujoco import ByMuJoCo, Shapes
from tests.motion.robots import sample_folder

from exogauge.criteria.planning import Planning
from exogauge.experiment.motion_choices import Choice
from exogauge.experiment.moving_choices import Moving, moving_choices
from exogauge.experiment.reach import Reach, reach_of
from exogauge.experiment.workspace_limits import Room
from exogauge.findings.planned_motion import Sweep
from exogauge.motion.excite.search import Task
from exogauge.motion.excite.task import task_of
from exogauge.motion.plan.judge import judge
from exogauge.motion.robot_file import load_motion_robot
from exogauge.robots.description import Robot
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.standing import standing
from exogauge.studies.intake.robot_file import load_robot
from exogauge.synthetic.urdf import robot_urdf


@cache
def read(path: Path) -> tuple[Robot, MotionRobot, Task]:
    robot, moving = load_robot(path.parent, path.name), load_motion_robot(path)
    return robot, moving, task_of(robot, moving, 10.0)


def reach_at_home(path: Path, **changes: object) -> Reach:
    """As if logs had moved every joint by .2 rad about home, at .5 rad/s, standing."""
    robot, moving, task = read(path)
    order = moving.base + task.order
    posture, tree = moving.home[order], robot.tree
    resting = {f"ft.{sensor.name}.fz": 0.5 * moving.weight for sensor in robot.contacts}
    here = Room(
        posture, tree.lower + 0.02, tree.upper - 0.02, posture - 0.2, posture + 0.2, np.full(len(posture), 0.5),
        0.8 * tree.velocity_limit, np.ones(len(posture), bool), resting, 200.0,
    )  # fmt: skip
    changed = replace(moving, **changes)
    return reach_of(changed, robot, here, task.information.loads, Planning())


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return sample_folder(tmp_path_factory.mktemp("robot"))


@pytest.fixture(scope="module")
def reach(path: Path) -> Reach:
    return reach_at_home(path)


def swept(reach: Reach, joint: str, sweep: Sweep, rate: float) -> np.ndarray:
    robot = reach.stance.robot
    q = np.tile(robot.home[robot.base + reach.order], (len(sweep.position(rate)), 1))
    names = [robot.joints[k] for k in reach.order]
    q[:, names.index(joint)] = sweep.position(rate)
    return q


@pytest.mark.slow
def test_what_the_file_tells_is_known(reach: Reach, path: Path) -> None:
    assert (reach.unknown, reach.kept) == ((), ("touch", "torque", "balance"))
    assert reach_at_home(path, shapes=()).unknown == ("touch",)
    assert reach_at_home(path, soles=()).unknown == ("balance",)
    assert not reach_at_home(path, soles=()).drawn


@pytest.mark.parametrize(
    ("joint", "sweep", "keeps"),
    [
        ("torso_pitch", Sweep("sine", 0.2, 0.1, 0.0, 0.3, 20.0, 4.0), True),
        ("torso_pitch", Sweep("sine", 0.3, 0.3, 0.0, 3.0, 20.0, 0.7), False),  # presses outside the soles
        ("l_shoulder_roll", Sweep("sine", 0.1, 0.3, 0.0, 0.3, 20.0, 4.0), True),
        ("l_shoulder_roll", Sweep("sine", 0.2, -0.1, 0.0, 0.3, 20.0, 4.0), False),  # into the thigh
    ],
)
@pytest.mark.slow
def test_a_sweep_that_breaks_a_bound_is_none(reach: Reach, joint: str, sweep: Sweep, keeps: bool) -> None:
    assert reach.keeps(swept(reach, joint, sweep, 50.0), 50.0, 50.0) is keeps


class Played:
    """A table of joints as a trajectory: as `exogauge motion check` reads it."""

    def __init__(self, whole: np.ndarray, rate: float) -> None:
        self.path, self.duration = CubicSpline(np.arange(len(whole)) / rate, whole), (len(whole) - 1) / rate

    def at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return self.path(time), self.path(time, 1), self.path(time, 2)


@pytest.mark.slow
@pytest.mark.parametrize(("share", "keeps"), [(0.97, False), (1.03, True)])
def test_what_a_leg_cannot_bear_is_not_asked(reach: Reach, path: Path, share: float, keeps: bool) -> None:
    """Legs carry what moves above them: their torques were not looked at."""
    joints = swept(reach, "torso_pitch", Sweep("sine", 0.2, 0.1, 0.0, 0.3, 20.0, 4.0), 50.0)
    robot = reach.stance.robot
    whole = np.tile(robot.home, (len(joints), 1))
    whole[:, robot.base + reach.order] = joints
    seen = np.abs(judge(robot, Played(whole, 50.0), standing(robot), rate=50.0).torque)
    hip = robot.joints.index("l_hip_pitch")
    torque = load_motion_robot(path).limits.torque.copy()
    torque[hip] = share * seen[:, hip].max() / Planning().of_top
    assert seen[0, hip] < 0.5 * torque[hip]  # it can stand
    weak = replace(load_motion_robot(path).limits, torque=torque)
    assert reach_at_home(path, limits=weak).keeps(joints, 50.0, 50.0) is keeps


@pytest.mark.slow
@pytest.mark.parametrize("rate", [200.0, pytest.param(1000.0, marks=pytest.mark.thorough)])
def test_drawn_motions_and_mixtures_keep_every_bound_as_mujoco_sees_them(reach: Reach, rate: float) -> None:
    names = [reach.stance.robot.joints[k] for k in reach.order]
    sweep = Choice(names.index("torso_pitch"), Sweep("sine", 0.1, 0.1, 0.0, 0.2, 20.0, 4.0), None, (0.0, 0.0), 1.0)
    found = list(moving_choices(reach, [sweep], 20.0))
    mixed = next(each for each in found if each.swept is not None)
    alone = {each.reach.series: each for each in found if each.swept is None}.values()
    assert len(alone) == 2  # calm and brisk
    robot: MotionRobot = reach.stance.robot
    for made in (*alone, mixed):
        assert isinstance(made, Moving)
        q, _, _ = made.whole(50.0)
        moved = np.ptp(q, axis=0)
        assert (moved[robot.base :] > 1e-3).all()  # legs too: the base moves
        assert moved[:3].max() > 2e-3
        joints = np.round(q[:, robot.base + reach.order], 5)
        assert reach.keeps(joints, 50.0, 200.0)
        seen = ByMuJoCo(robot, Played(q, 50.0), rate)
        assert seen.inside.min() >= 0.015
        assert np.abs(seen.feet - seen.feet[0]).max() <= 1e-4
        upper = [k for k, name in enumerate(robot.joints) if name.split("_")[1] not in ("hip", "knee", "ankle")]
        assert (np.abs(seen.torque[:, upper]) <= robot.limits.torque[upper]).all()
        near = Shapes(robot, robot_urdf()).nearer_than(0.01 - 1e-4, q[::5])
        assert not near & {frozenset(pair) for pair in reach.bounds.pairs.names}
    lead = mixed.whole(50.0)[0][:, robot.base + reach.order[sweep.lead]]
    assert lead == pytest.approx(sweep.sweep.position(50.0))
