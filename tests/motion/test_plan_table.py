"""A table of a motion, of a plan or of another program: read, judged, refused where it is wrong."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from tests.motion.plans import at, columns_of, table, with_cell

from exogauge.cli import main
from exogauge.criteria.motion_plan import USUAL
from exogauge.errors import BadInput, BadMotion
from exogauge.motion.plan.judge import Judged, judge
from exogauge.motion.plan.outcome import motion_table
from exogauge.motion.plan.within import read_again
from exogauge.motion.plan.written import Written, read_written
from exogauge.robots.moving.robot import MotionRobot
from exogauge.robots.moving.standing import standing


@pytest.fixture(scope="module")
def written(robot: MotionRobot, bent, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Judged]:
    asked, planned = bent
    judged = judge(robot, planned.spline, asked.place[0], planned=planned)
    file = tmp_path_factory.mktemp("plan") / "bend.csv"
    file.write_bytes(motion_table(robot, judged))
    return file, judged


@pytest.mark.slow
def test_a_written_plan_is_judged_as_it_was_planned(robot: MotionRobot, written, folder: Path, capsys) -> None:
    file, judged = written
    assert main(["motion", "check", str(file), "--robot", str(folder / "robot.yaml"), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["broken"] == []
    inside = float(said["centre of pressure"].split()[0])  # a cubic through samples rounds the nodes' kinks off
    assert inside == pytest.approx(1e3 * judged.inside.min(), abs=1.0)
    assert float(said["weight on the feet"].split()[0]) == pytest.approx(judged.carried.min(), abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda c: c | {"q.r_ankle_roll": c["q.r_ankle_roll"] + 0.01}, "turn of a standing foot"),
        (lambda c: c | {"q.torso_pitch": np.degrees(c["q.torso_pitch"])}, "position of torso_pitch"),
        (lambda c: c | {"t": c["t"] / 20.0}, "torque of torso_pitch"),
        (lambda c: c | {"t": c["t"] / 20.0}, "centre of pressure"),
    ],
)
def test_a_file_that_breaks_a_bound_is_told_which(written, folder: Path, tmp_path: Path, capsys, change, said) -> None:
    wrong = table(tmp_path / "wrong.csv", change(columns_of(written[0])))
    assert main(["motion", "check", str(wrong), "--robot", str(folder / "robot.yaml"), "--json"]) == 1
    assert any(line.startswith(said) for line in json.loads(capsys.readouterr().out)["broken"])


@pytest.mark.parametrize(
    ("change", "place"),
    [
        (lambda c: {name: x for name, x in c.items() if name != "t"}, (0, "t")),
        (lambda c: {name.replace("q.", "angle."): x for name, x in c.items()}, (0, "q.")),
        (lambda c: {name.replace("q.neck_yaw", "neck_yaw"): x for name, x in c.items()}, (0, "neck_yaw")),
        (lambda c: with_cell(c, "q.neck_yaw", 6, np.nan), (7, "q.neck_yaw")),
        (lambda c: with_cell(c, "t", 9, 0.0), (10, "t")),
        (lambda c: {name: x[:1] for name, x in c.items()}, (1, "t")),
    ],
)
def test_a_file_that_is_no_motion_is_refused_where_it_is_wrong(written, robot, tmp_path: Path, change, place) -> None:
    wrong = table(tmp_path / "wrong.csv", change(columns_of(written[0])))
    with pytest.raises(BadInput) as told:
        read_written(robot, wrong)
    fault = told.value.faults[0]
    assert fault.row == place[0]
    assert fault.column.startswith(place[1])


def test_a_table_of_degrees_is_refused_and_one_that_breaks_its_bounds_is_judged(
    robot: MotionRobot, tmp_path: Path
) -> None:
    """Degrees were judged as if a robot turned its shoulder twenty times."""
    q = np.zeros((20, len(robot.joints)))
    q[:, robot.joints.index("torso_pitch")] = np.linspace(0.0, 40.0, 20)
    q[:, robot.joints.index("l_knee_pitch")] = np.linspace(0.0, 30.0, 20)
    head = ",".join(["t", *(f"q.{name}" for name in robot.joints)])

    def table(name: str, angles: np.ndarray) -> Path:
        np.savetxt(
            tmp_path / name, np.column_stack([0.1 * np.arange(20), angles]), delimiter=",", header=head, comments=""
        )
        return tmp_path / name

    with pytest.raises(BadMotion) as refused:
        read_written(robot, table("degrees.csv", q))
    assert (refused.value.faults[0].rule, refused.value.faults[0].column) == ("degrees", "q.torso_pitch")
    beyond = np.radians(q)  # radians, one joint of them too far
    beyond[:, robot.joints.index("torso_pitch")] *= 1.7  # 68°, and it bears 60°
    assert read_written(robot, table("beyond.csv", beyond)).q.shape == (20, robot.model.nq)


def test_a_table_of_milliseconds_is_refused_and_a_joint_that_is_not_there_is_told(
    written, robot: MotionRobot, folder: Path, tmp_path: Path, capsys
) -> None:
    """A thousand times slower every bound held; a joint that was misspelt stayed at home, and its column was passed
    over."""
    columns = columns_of(written[0])
    with pytest.raises(BadMotion) as told:
        read_written(robot, table(tmp_path / "ms.csv", columns | {"t": 1000.0 * columns["t"]}))
    fault = told.value.faults[0]
    assert (fault.rule, fault.row, fault.column, fault.value) == ("slow_clock", 2, "t", "5")
    wrong = table(tmp_path / "odd.csv", {name.replace("neck_yaw", "neck"): x for name, x in columns.items()})
    assert main(["motion", "check", str(wrong), "--robot", str(folder / "robot.yaml"), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["held at home"], said["no joint of it"]) == ("neck_yaw", "q.neck")


@pytest.mark.parametrize("rate", ["0", "-5", "nan", "1", "1e9"])
@pytest.mark.parametrize("step", ["check", "export"])
def test_a_rate_at_which_nothing_can_be_judged_is_refused(written, folder: Path, capsys, step: str, rate: str) -> None:
    """-5 ended in a traceback, 1 judged nine samples of a motion and found them fine."""
    command = ["motion", step, str(written[0]), "--robot", str(folder / "robot.yaml"), "--rate", rate]
    assert main(command) == 2
    assert "--rate [Hz]" in capsys.readouterr().err


def test_joints_that_a_file_does_not_name_stay_at_home(written, robot: MotionRobot, tmp_path: Path) -> None:
    columns = columns_of(written[0])
    del columns["q.neck_yaw"]
    less = read_written(robot, table(tmp_path / "less.csv", columns))
    assert less.held == ("neck_yaw",)
    assert np.abs(less.q[:, at(robot, "neck_yaw")]).max() == 0.0


def test_what_a_table_breaks_is_found_before_it_is_written(robot: MotionRobot, tmp_path: Path) -> None:
    """JVRC-1's knee was planned within every bound, and `check` of its table told of 104 % of a torque: a foot that
    strays by micrometres between nodes takes the body with it."""
    time = np.arange(101) / 200.0
    q = np.tile(robot.home, (len(time), 1))
    q[:, 2] += 3e-6 * np.sin(2.0 * np.pi * 10.0 * time)  # the plan's base; the legs' joints are at rest
    q[:, at(robot, "torso_pitch")] += 0.1 * np.sin(np.pi * time / time[-1]) ** 3
    trajectory = Written(time, q, (), np.ones((len(time), 2), dtype=bool))
    judged = judge(robot, trajectory, standing(robot), rate=200.0, planned=trajectory)
    (tmp_path / "a.csv").write_bytes(motion_table(robot, judged))
    table = read_written(robot, tmp_path / "a.csv")
    theirs = judge(robot, table, standing(robot), rate=200.0, planned=table)
    ours = read_again(robot, judged, USUAL, 200.0)
    assert ours.inside == pytest.approx(theirs.inside, abs=1e-4)
    assert np.abs(judged.carried - theirs.carried).max() > 10.0 * np.abs(ours.carried - theirs.carried).max()


@pytest.mark.parametrize(
    ("change", "rule", "place"),
    [
        (lambda c: c | {"stands.hand": np.ones_like(c["t"])}, "unknown_foot", (0, "stands.hand")),
        (lambda c: c | {"stands.l_foot": np.full_like(c["t"], 0.5)}, "not_a_truth", (1, "stands.l_foot")),
        (lambda c: c | {f"stands.{side}_foot": (c["t"] < 1.0) * 1.0 for side in "lr"}, "flight", (201, "stands.l")),
    ],
)
def test_feet_that_cannot_be_are_refused_where_they_are_told(written, robot, tmp_path, change, rule, place) -> None:
    with pytest.raises(BadMotion) as told:
        read_written(robot, table(tmp_path / "wrong.csv", change(columns_of(written[0]))))
    fault = told.value.faults[0]
    assert (fault.rule, fault.row) == (rule, place[0])
    assert fault.column.startswith(place[1])


def test_a_table_without_feet_stands_on_both_throughout(written, robot: MotionRobot) -> None:
    assert not any(name.startswith("stands.") for name in columns_of(written[0]))
    assert read_written(robot, written[0]).standing(np.linspace(0.0, 3.0, 7)).all()
