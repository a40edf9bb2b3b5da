"""Of recordings that are as described the doctor says nothing; of signs turned in them it names the joint."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from tests.real import test_icub_walking as icub
from tests.real import test_staubli_tx40 as tx40
from tests.real import test_ur10 as ur10
from tests.real import test_z1 as z1

from exogauge.identification.settings import Recording
from exogauge.logs.model import Log
from exogauge.plausibility.examine import examine_against_robot
from exogauge.robots.description import Robot
from exogauge.studies.admit import admit
from exogauge.studies.open import open_study

pytestmark = pytest.mark.slow

Place = Callable[..., Path]


def of_tx40(recording: Place, fixed_arm: Callable[..., None]) -> Path:
    folder = recording("staubli_tx40", ("pos_read_data.csv.gz", "curr_data.csv.gz", "tx40_mdh_modified.urdf"))
    (folder / "study.yaml").write_text(tx40.STUDY)
    (folder / "robot.yaml").write_text(tx40.ROBOT)
    (folder / "mapping.yaml").write_text(tx40._mapping())
    return folder


def of_ur10(recording: Place, fixed_arm: Callable[..., None]) -> Path:
    folder = recording("ur10_rosbag2", (ur10.BAG,))
    fixed_arm(folder, "ur_description/urdf/ur10_robot.urdf", ur10.JOINTS)
    pq.write_table(pa.table(ur10.joint_states(folder / ur10.BAG)), folder / "log.parquet")
    (folder / "study.yaml").write_text(ur10.STUDY.format(fitted=ur10.FORWARD[0], held_out=ur10.FORWARD[1]))
    return folder


def of_z1(recording: Place, fixed_arm: Callable[..., None]) -> Path:
    folder = recording("z1_pd_chirp", (z1.LOG, z1.GAINS))
    fixed_arm(folder, "z1_description/urdf/z1.urdf", z1.JOINTS)
    pq.write_table(pa.table(z1.commanded(folder)), folder / "log.parquet")
    logs = "".join(z1.ENTRY.format(*part) for part in z1.SPLITS["slow_part"])
    (folder / "study.yaml").write_text(z1.HEAD + logs)
    return folder


def of_icub(recording: Place, fixed_arm: Callable[..., None]) -> Path:
    folder = recording("icub_walking", ("walking.mat", "model.urdf"))
    (folder / "study.yaml").write_text(icub.STUDY)
    (folder / "mapping.yaml").write_text(icub.MAPPING)
    (folder / "robot.yaml").write_text(icub.ROBOT.format(base_link="root_link", imu="root_link_imu_frame"))
    return folder


def opened(folder: Path) -> tuple[Robot, Sequence[Recording]]:
    with open_study(folder) as study:
        return study.robot, admit(study).recordings


def errors(robot: Robot, logs: Sequence[Log]) -> set[tuple[str, str]]:
    return {(each.channel, each.rule) for _, each in examine_against_robot(robot, logs)}


@pytest.mark.parametrize("make", [of_tx40, of_ur10, of_icub])
def test_no_recording_is_blamed(make: Callable[..., Path], recording: Place, fixed_arm: Callable[..., None]) -> None:
    robot, recordings = opened(make(recording, fixed_arm))
    assert errors(robot, [each.log for each in recordings]) == set()


def test_of_commanded_torques_it_is_told_only_that_they_come_early(
    recording: Place, fixed_arm: Callable[..., None]
) -> None:
    """The Z1's are those of its controller: by regression 35 to 50 ms before the motion, most at joints 1, 2, 5."""
    robot, recordings = opened(of_z1(recording, fixed_arm))
    found = [each for _, each in examine_against_robot(robot, [each.log for each in recordings])]
    assert {(each.severity, each.rule) for each in found} == {("warning", "effort_delay")}
    assert all(-0.05 < (each.value or 0.0) < -0.03 for each in found)
    told = " ".join(each.channel + each.detail for each in found)
    assert all(name in told for name in ("tau.joint1", "tau.joint2", "tau.joint5"))


@pytest.mark.parametrize("order", ["yzx", "xzy"])
def test_a_walking_robots_imu_with_its_axes_exchanged_is_told(
    order: str, recording: Place, fixed_arm: Callable[..., None]
) -> None:
    robot, recordings = opened(of_icub(recording, fixed_arm))
    turned = []
    for log in (each.log for each in recordings):
        signs = (1.0, 1.0, 1.0) if order == "yzx" else (1.0, -1.0, 1.0)  # a right-handed frame again
        sources = zip("xyz", order, signs, strict=True)
        axes = {f"{k}.{to}": s * log.channels[f"{k}.{source}"] for to, source, s in sources for k in ("acc", "gyro")}
        turned.append(Log(log.name, log.time, {**log.channels, **axes}))
    assert errors(robot, turned) == {("acc", "imu_frame")}


@pytest.mark.parametrize("make", [of_tx40, of_ur10, of_z1])
def test_a_sign_that_is_turned_is_named_at_its_joint(
    make: Callable[..., Path], recording: Place, fixed_arm: Callable[..., None]
) -> None:
    """By the effort or by the position: of a wrist that bears nothing only friction tells, and only of the two."""
    robot, recordings = opened(make(recording, fixed_arm))
    for joint in robot.joints:
        for kind in ("q", "tau"):
            name = f"{kind}.{joint.name}"
            turned = [
                Log(each.log.name, each.log.time, {**each.log.channels, name: -each.log.channels[name]})
                for each in recordings
            ]
            found = errors(robot, turned)
            assert {channel.partition(".")[2] for channel, _ in found} == {joint.name}, (name, found)
            assert {rule for _, rule in found} <= {"effort_reversed", "position_reversed"}, (name, found)
