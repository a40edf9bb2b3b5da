"""Of recordings that are as described the doctor says nothing; of signs turned in them it names the joint."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType

import pytest
from tests.real.recordings import icub_walking, staubli_tx40, ur10, z1

from exogauge.identification.settings import Recording
from exogauge.logs.model import Log
from exogauge.plausibility.examine import examine_against_robot
from exogauge.robots.description import Robot
from exogauge.studies.intake.admit import admit
from exogauge.studies.intake.open import open_study

pytestmark = pytest.mark.slow

Place = Callable[..., Path]


TX40, UR10, Z1, ICUB = (
    (staubli_tx40, "study.yaml"),
    (ur10, "forward.yaml"),
    (z1, "slow_part.yaml"),
    (icub_walking, "study.yaml"),
)


def opened(recording: Place, module: ModuleType, study_file: str) -> tuple[Robot, Sequence[Recording]]:
    folder = recording(module.RECORDING, module.FILES)
    module.write(folder)
    with open_study(folder / study_file) as study:
        return study.robot, admit(study).recordings


def errors(robot: Robot, logs: Sequence[Log]) -> set[tuple[str, str]]:
    found = [each for _, each in examine_against_robot(robot, logs)]
    return {(each.channel, each.rule) for each in found if (each.rule, each.severity) != ("sign_unsure", "note")}


@pytest.mark.parametrize("study", [TX40, UR10, ICUB], ids=["tx40", "ur10", "icub"])
def test_no_recording_is_blamed(study: tuple[ModuleType, str], recording: Place) -> None:
    robot, recordings = opened(recording, *study)
    assert errors(robot, [each.log for each in recordings]) == set()


def test_of_commanded_torques_it_is_told_only_that_they_come_early(recording: Place) -> None:
    """The Z1's are those of its controller: by regression 35 to 50 ms before the motion, most at joints 1, 2, 5."""
    robot, recordings = opened(recording, *Z1)
    found = [each for _, each in examine_against_robot(robot, [each.log for each in recordings])]
    assert {(each.severity, each.rule) for each in found} == {("warning", "effort_delay")}
    assert all(-0.05 < (each.value or 0.0) < -0.03 for each in found)
    told = " ".join(each.channel + each.detail for each in found)
    assert all(name in told for name in ("tau.joint1", "tau.joint2", "tau.joint5"))


@pytest.mark.parametrize("order", ["yzx", "xzy"])
def test_a_walking_robots_imu_with_its_axes_exchanged_is_told(order: str, recording: Place) -> None:
    robot, recordings = opened(recording, *ICUB)
    turned = []
    for log in (each.log for each in recordings):
        signs = (1.0, 1.0, 1.0) if order == "yzx" else (1.0, -1.0, 1.0)  # a right-handed frame again
        sources = zip("xyz", order, signs, strict=True)
        axes = {f"{k}.{to}": s * log.channels[f"{k}.{source}"] for to, source, s in sources for k in ("acc", "gyro")}
        turned.append(Log(log.name, log.time, {**log.channels, **axes}))
    assert errors(robot, turned) == {("acc", "imu_frame")}


@pytest.mark.parametrize("study", [TX40, UR10, Z1], ids=["tx40", "ur10", "z1"])
def test_a_sign_that_is_turned_is_named_at_its_joint(study: tuple[ModuleType, str], recording: Place) -> None:
    """By the effort or by the position: of a wrist that bears nothing only friction tells, and only of the two."""
    robot, recordings = opened(recording, *study)
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
