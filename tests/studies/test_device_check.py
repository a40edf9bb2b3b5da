"""What a person is told of a device file: lengths, which joints the bands pull, which way, and a picture."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Callable
from pathlib import Path
from xml.etree.ElementTree import fromstring

import numpy as np
import pytest

from exogauge.cli import main
from exogauge.devices.device import Band, Device, ViaPoint
from exogauge.logs.model import Log
from exogauge.robots.description import Robot
from exogauge.studies.device_pages.device_picture import draw_device
from exogauge.studies.device_pages.link_table import link_table
from exogauge.studies.intake.device_check import check_device
from exogauge.studies.intake.device_on_robot import robot_of_urdf
from exogauge.studies.intake.robot_file import load_robot
from exogauge.studies.words.pull_words import Ways

SUIT = """version: 1
name: Suit & co
bands:
  - name: back
    via_points:
      - {link: chest_1, xyz: [-0.1, 0, 0.2]}
      - {link: BODY, xyz: [-0.1, 0, 0.1]}
    stiffness_n_per_m: 200
    natural_length_m: 0.4
"""


@pytest.fixture
def robot(folder: Path) -> Robot:
    return load_robot(folder)


@pytest.fixture
def device() -> Device:
    """One band 0.1 m behind the back, parallel to it: 0.5 m long, arm 0.1 m about torso_pitch, none about the yaw."""
    points = (ViaPoint("chest_1", (-0.1, 0.0, 0.2)), ViaPoint("BODY", (-0.1, 0.0, 0.1)))
    return Device("Suit & co", (Band("back", "back", points, 200.0, 0.4),))


def test_a_band_over_the_back_pulls_the_trunk_back(robot: Robot, device: Device) -> None:
    check = check_device(robot, device)
    (band,) = check.bands
    (arm,) = band.arms
    assert (band.length, band.stretch, band.tension) == pytest.approx((0.5, 0.1, 20.0))
    assert (arm.joint, arm.arm, arm.sign) == ("torso_pitch", pytest.approx(0.1), -1.0)
    assert arm.way == "moves chest_1 back"
    assert check.torque == {"torso_yaw": pytest.approx(0.0), "torso_pitch": pytest.approx(-2.0)}


def test_over_a_log_lengths_and_arms_have_a_range(robot: Robot, device: Device) -> None:
    q = np.linspace(-0.3, 0.5, 50)
    log = Log("l", np.arange(50.0), {"q.torso_yaw": np.zeros(50), "q.torso_pitch": q})
    (band,) = check_device(robot, device, log).bands

    def length(q: np.ndarray) -> np.ndarray:  # in the plane of the back, torso_pitch 0.4 m above the origin of BODY
        x = 0.2 * np.sin(q) - 0.1 * np.cos(q)
        z = 0.4 + 0.2 * np.cos(q) + 0.1 * np.sin(q)
        return np.hypot(x + 0.1, z - 0.1)

    slope = (length(q + 1e-6) - length(q - 1e-6)) / 2e-6
    assert (band.shortest, band.longest) == pytest.approx((length(q).min(), length(q).max()))
    assert (band.arms[0].lowest, band.arms[0].highest) == pytest.approx((slope.min(), slope.max()), abs=1e-8)
    assert not band.arms[0].changes_sides


def test_a_band_that_passes_from_one_side_of_a_joint_to_the_other_is_said_to(robot: Robot) -> None:
    points = (ViaPoint("chest_1", (0.0, 0.0, 0.2)), ViaPoint("BODY", (0.0, 0.0, 0.1)))
    log = Log("l", np.arange(3.0), {"q.torso_yaw": np.zeros(3), "q.torso_pitch": np.array([-0.5, 0.0, 0.5])})
    (band,) = check_device(robot, Device("d", (Band("b", "b", points),)), log).bands
    assert band.arms[0].changes_sides
    assert band.tension is None


@pytest.mark.parametrize(
    ("joint", "sign", "words"),
    [
        ("torso_pitch", 1.0, "moves chest_1 forward"),
        ("torso_pitch", -1.0, "moves chest_1 back"),
        ("torso_yaw", 1.0, "turns chest_0 to the left"),
        ("torso_yaw", -1.0, "turns chest_0 to the right"),
    ],
)
def test_the_way_of_a_joint_is_said_in_words(robot: Robot, joint: str, sign: float, words: str) -> None:
    assert Ways(robot.tree).words(joint, sign) == words


def test_links_are_told_with_place_and_axes(robot: Robot) -> None:
    lines = {line.split()[0].strip(","): line for line in link_table(robot).splitlines()[2:]}
    assert re.split(r"\s{2,}", lines["chest_1"])[1:] == ["torso_pitch", "0.000", "0.000", "0.400", "forward, left, up"]
    assert "fixed to BODY" in lines["imu_link"]


def test_a_urdf_alone_makes_a_robot_of_all_that_moves(folder: Path) -> None:
    robot = robot_of_urdf((folder / "robot.urdf").read_bytes(), "robot.urdf")
    assert robot.tree.joints == ("torso_yaw", "torso_pitch", "r_elbow")
    assert robot.tree.frames["BODY"][0] == -1


def test_a_picture_holds_every_band_twice_and_numbers_its_via_points(robot: Robot, device: Device) -> None:
    svg = draw_device(robot, device)
    root = fromstring(svg)
    tags = [element.tag.rpartition("}")[2] for element in root.iter()]
    numbers = [element.text for element in root.iter() if element.get("class") == "number"]
    assert tags.count("polyline") == 2
    assert numbers == ["1", "2"] * 2
    assert "Suit &amp; co" in svg
    assert "prefers-color-scheme: dark" in svg


def test_places_of_a_picture_are_those_of_the_robot(robot: Robot, device: Device) -> None:
    root = fromstring(draw_device(robot, device))
    lines = [element.get("points", "").split() for element in root.iter() if element.tag.endswith("polyline")]
    (front, side) = [np.array([[float(x) for x in point.split(",")] for point in points]) for points in lines]
    bar = next(element for element in root.iter() if element.get("class") == "scale")
    metre = (float(bar.get("x2", "")) - float(bar.get("x1", ""))) / 0.1
    np.testing.assert_allclose(front[1] - front[0], [0.0, 0.5 * metre], atol=0.2)
    np.testing.assert_allclose(side[1] - side[0], [0.0, 0.5 * metre], atol=0.2)


def test_the_command_checks_a_file_and_draws_it(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "suit.yaml").write_text(SUIT)
    picture = folder / "pictures" / "bands.svg"
    for robot in (["--robot", str(folder / "robot.urdf")], ["--robot", str(folder / "robot.yaml")]):
        assert main(["device", str(folder / "suit.yaml"), *robot, "--picture", str(picture)]) == 0
        said = capsys.readouterr().out
        assert "negative angles: moves chest_1 back" in said
        assert "No fault." in said
        assert fromstring(picture.read_text()).tag.endswith("svg")
    assert main(["device", "--robot", str(folder / "robot.urdf")]) == 0
    assert "fixed to BODY" in capsys.readouterr().out


@pytest.mark.slow
def test_the_command_reads_a_log_of_the_study(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "suit.yaml").write_text(SUIT)
    for log in ("val_1", str(folder / "logs/val_1.parquet")):
        assert main(["device", str(folder / "suit.yaml"), "--study", str(folder), "--log", log]) == 0
        assert "over the log" in capsys.readouterr().out
    (folder / "short.csv").write_text("t,q.torso_yaw\n" + "".join(f"{k / 100},0\n" for k in range(20)))
    given = ["device", str(folder / "suit.yaml"), "--robot", str(folder / "robot.urdf"), "--log"]
    assert main([*given, str(folder / "short.csv")]) == 2
    assert "q.torso_pitch" in capsys.readouterr().err


def test_a_device_file_may_lie_anywhere_and_its_tables_beside_it(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = tmp_path / "elsewhere"
    other.mkdir()
    (other / "suit.yaml").write_text(SUIT + "    bench: {file: bench.csv}\n")
    (other / "bench.csv").write_text("length_m,force_n\n0.4,0\n0.5,20\n0.6,40\n")
    for robot in (["--study", str(folder)], ["--robot", str(folder / "robot.urdf")]):
        assert main(["device", str(other / "suit.yaml"), *robot]) == 0
        assert "No fault." in capsys.readouterr().out
    with zipfile.ZipFile(tmp_path / "s.zip", "w") as archive:
        (folder / "suit.yaml").write_text(SUIT)
        for each in folder.rglob("*.*"):
            archive.write(each, each.relative_to(folder).as_posix())
    assert main(["device", "suit.yaml", "--study", str(tmp_path / "s.zip"), "--log", "val_1"]) == 0
    assert "over the log" in capsys.readouterr().out


def test_the_command_ends_with_2_and_all_faults(
    folder: Path, rewrite: Callable[[str, str, str], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "suit.yaml").write_text(SUIT)
    rewrite("suit.yaml", "link: chest_1", "link: chest_2")
    rewrite("suit.yaml", "_m: 200", "_m: 0")
    assert main(["device", str(folder / "suit.yaml"), "--robot", str(folder / "robot.urdf")]) == 2
    said = capsys.readouterr().err
    assert "row 6" in said
    assert "row 8" in said
    assert main(["device", str(folder / "suit.yaml")]) == 2
    assert "--robot" in capsys.readouterr().err
    assert main(["device", str(folder / "none.yaml"), "--robot", str(folder / "robot.urdf")]) == 2
    assert "no such file" in capsys.readouterr().err
