"""A device file becomes bands on a robot, or every one of its faults with file, line, place, value and advice."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from exogauge.errors import BadStudy, Fault
from exogauge.robots.description import Robot
from exogauge.studies.intake.bundle import Bundle
from exogauge.studies.intake.device_check import device_doubts
from exogauge.studies.intake.device_file import read_device
from exogauge.studies.intake.robot_file import load_robot

DEVICE = """version: 1
name: Small suit
bands:
  - name: A_left
    group: A
    via_points:
      - {link: chest_1, xyz: [-0.1, 0.1, 0.2]}
      - {link: BODY, xyz: [-0.12, 0.1, 0.1]}
    stiffness_n_per_m: 200
    natural_length_m: 0.45
  - name: A_right
    group: A
    via_points:
      - {link: chest_1, xyz: [-0.1, -0.1, 0.2]}
      - {link: BODY, xyz: [-0.12, -0.1, 0.1]}
    natural_length_m: 0.45
    bench: {file: bench.csv}
tied: [A]
"""
BENCH = "length_m,force_n\n0.40,0\n0.50,10\n0.60,30\n0.70,50\n"


@pytest.fixture
def robot(folder: Path) -> Robot:
    return load_robot(folder)


@pytest.fixture
def refused(folder: Path, robot: Robot) -> Callable[..., tuple[Fault, ...]]:
    """refused((old, new), …): the faults of the device file, or of its bench table, with these changes."""

    def read(*changes: tuple[str, str]) -> tuple[Fault, ...]:
        with pytest.raises(BadStudy) as caught:
            read_device(bundle(folder, *changes), "device.yaml", robot)
        return caught.value.faults

    return read


def bundle(folder: Path, *changes: tuple[str, str]) -> Bundle:
    texts = {"device.yaml": DEVICE, "bench.csv": BENCH}
    for old, new in changes:
        (name,) = [name for name, text in texts.items() if old in text]
        texts[name] = texts[name].replace(old, new, 1)
    for name, text in texts.items():
        (folder / name).write_text(text)
    return Bundle(folder, "study.yaml")


def test_a_device_file_becomes_its_bands(folder: Path, robot: Robot) -> None:
    device = read_device(bundle(folder, ("group: A\n", "group: A\n    ground_truth: true\n")), "device.yaml", robot)
    left, right = device.bands
    assert (device.name, device.groups, device.tied) == ("Small suit", ("A",), frozenset({"A"}))
    assert (left.via_points[1].link, left.via_points[1].xyz) == ("BODY", (-0.12, 0.1, 0.1))
    assert (left.stiffness, left.natural_length, left.ground_truth, left.law) == (200.0, 0.45, True, "linear")
    assert right.bench is not None
    assert right.bench.force == (0.0, 10.0, 30.0, 50.0)
    assert not right.ground_truth


def test_a_band_without_stiffness_has_that_of_its_group(folder: Path, robot: Robot) -> None:
    assert read_device(bundle(folder), "device.yaml", robot).bands[1].stiffness == 200.0


def test_a_law_of_the_catalogue_is_taken_with_its_values(folder: Path, robot: Robot) -> None:
    law = "    group: A\n    law: hardening\n    law_values: {hardening: 400}\n"
    given = bundle(folder, ("    group: A\n", law), ("A_right\n    group: A\n", "A_right\n" + law))
    bands = read_device(given, "device.yaml", robot).bands
    assert [(band.law, band.law_values) for band in bands] == [("hardening", {"hardening": 400.0})] * 2


def test_a_band_without_a_group_is_one_of_its_own(folder: Path, robot: Robot) -> None:
    alone = bundle(folder, ("    group: A\n", ""), ("tied: [A]", "tied: [A_left]"))
    assert read_device(alone, "device.yaml", robot).groups == ("A_left", "A")


@pytest.mark.parametrize(
    ("old", "new", "row", "column", "words"),
    [
        ("link: chest_1", "link: chest_2", 7, "bands.0.via_points.0.link", "Did you mean 'chest_1'"),
        ("link: chest_1", "link: torso_pitch", 7, "bands.0.via_points.0.link", "the link that it moves is 'chest_1'"),
        ("link: chest_1", "link: wing", 7, "bands.0.via_points.0.link", "BODY, chest_0, chest_1, r_arm"),
        ("link: chest_1", "link: imu_link", 6, "bands.0.via_points", "it acts on no joint"),
        ("      - {link: BODY, xyz: [-0.12, 0.1, 0.1]}\n", "", 6, "bands.0.via_points", "at least 2 items"),
        ("0.1, 0.1]}", "0.1, 0.1]}\n      - {link: imu_link, xyz: [-0.12, 0.1, -0.1]}", 9,
         "bands.0.via_points.2", "same place as the one before"),
        ("_m: 200", "_m: -200", 9, "bands.0.stiffness_n_per_m", "greater than 0"),
        ("_m: 0.45", "_m: 0", 10, "bands.0.natural_length_m", "greater than 0"),
        ("_m: 0.45", "_m: .nan", 10, "bands.0.natural_length_m", "finite"),
        ("[-0.1, 0.1, 0.2]", "[-0.1, 0.1, 200]", 7, "bands.0.via_points.0.xyz.2", "less than or equal to 100"),
        ("[-0.1, 0.1, 0.2]", "[-0.1, .nan, 0.2]", 7, "bands.0.via_points.0.xyz.1", "finite"),
        ("A_right", "A_left", 11, "bands.1.name", "two bands are named 'A_left'"),
        ("    bench", "    stiffness_n_per_m: 210\n    bench", 17, "bands.1.stiffness_n_per_m", "has 200.0"),
        ("0.45\n    bench", "0.46\n    bench", 16, "bands.1.natural_length_m", "untie 'A'"),
        ("    bench", "    law: lnear\n    bench", 17, "bands.1.law", "Did you mean 'linear'"),
        ("    bench", "    law_values: {hardening: 3}\n    bench", 17, "bands.1.law_values.hardening", "Leave it out"),
        ("    bench", "    law: hardening\n    bench", 17, "bands.1.law_values.hardening", "N/m²"),
        ("tied: [A]", "tied: [A_left]", 18, "tied.0", "has group 'A'"),
        ("bench.csv}", "bench_A.csv}", 17, "bands.1.bench.file", "Did you mean 'bench.csv'"),
        ("name: Small suit", "nam: Small suit", 2, "nam", "Did you mean 'name'"),
        ("bands:", "bands: 3\nbends:", 3, "bands", "list"),
    ],
)  # fmt: skip
def test_a_fault_names_its_line(
    refused: Callable[..., tuple[Fault, ...]], old: str, new: str, row: int, column: str, words: str
) -> None:
    found = refused((old, new))
    assert any((f.file, f.row, f.column) == ("device.yaml", row, column) and words in str(f) for f in found), found


@pytest.mark.parametrize(
    ("old", "new", "row", "column", "words"),
    [
        ("force_n", "force_N", 0, "force_n", "Is it 'force_N'"),
        ("length_m,", "length_mm,", 0, "length_m", "Is it 'length_mm'"),
        ("0.50,10", "0.50,ten", 2, "force_n", "not a finite number"),
        ("0.50,10", "0,50,10", 2, "length_m", "a band's length is above 0"),
        ("0.50,10", "0.50", 2, "force_n", "not a finite number"),
        ("0.50,10", "nan,10", 2, "length_m", "not a finite number"),
        ("0.60,30", "600,30", 3, "length_m", "metres"),
        ("0.60,30", "0.60,-30", 3, "force_n", "cannot push"),
        ("0.50,10\n0.60,30\n", "", None, None, "fewer than two lengths"),
        (BENCH, "length_m,force_n\n0.01,20\n0.11,40\n0.21,60\n", None, "length_m", "natural length of -0.09 m"),
        (BENCH, "length_m,force_n\n0.4,50\n0.5,30\n0.6,10\n", None, "force_n", "does not grow"),
        ("0.60,30", "0.60,3e6", 3, "force_n", "newtons"),
    ],
)
def test_a_fault_of_the_bench_table_names_its_cell(
    refused: Callable[..., tuple[Fault, ...]], old: str, new: str, row: int | None, column: str | None, words: str
) -> None:
    found = refused((old, new))
    assert any(f.file == "bench.csv" and f.row == row and words in str(f) for f in found), found
    assert column is None or any(f.column == column for f in found)


def test_every_fault_is_told_at_once(refused: Callable[..., tuple[Fault, ...]]) -> None:
    found = refused(
        ("link: chest_1", "link: chst_1"),
        ("_m: 200", "_m: -1"),
        ("[-0.1, -0.1, 0.2]", "[0, .inf, 0]"),
        ("{link: BODY, xyz: [-0.12, -0.1, 0.1]}", "{link: BODI, xyz: [-0.12, -0.1, 0.1]}"),
        ("tied: [A]", "tied: [B]"),
        ("0.60,30", "0.60,x"),
    )
    places = {(fault.file, fault.row, fault.rule) for fault in found}
    assert {row for file, row, _ in places if file == "device.yaml"} == {7, 9, 14, 15, 18}
    assert ("bench.csv", 3, "not_a_number") in places


def test_a_table_with_decimal_commas_is_read(folder: Path, robot: Robot) -> None:
    text = BENCH.replace(",", ";").replace(".", ",")
    device = read_device(bundle(folder, (BENCH, text)), "device.yaml", robot)
    assert device.bands[1].bench is not None
    assert device.bands[1].bench.length == (0.4, 0.5, 0.6, 0.7)


@pytest.mark.parametrize(
    ("changes", "row", "words"),
    [
        ([("tied: [A]", ""), ("_m: 0.45", "_m: 0.9")], 10, "never taut"),
        ([("tied: [A]", ""), ("_m: 0.45", "_m: 0.05")], 10, "far from the 0.5004 m"),
        ([("[-0.12, -0.1, 0.1]", "[-0.12, 0.1, 0.1]")], 13, "mirror images"),
        ([("[-0.1, 0.1, 0.2]", "[-10, 10, 20]")], 7, "metres"),
        ([("_m: 200", "_m: 900")], 11, "rises with 200 N/m"),
        ([("0.60,30", "0.52,30")], 16, "begins to pull at"),
        ([("_m: 200", "_m: 200\n    ground_truth: true"), ("    stiffness_n_per_m: 200\n", "")], 9, "no stiffness"),
    ],
)
def test_what_looks_like_a_slip_is_a_warning_with_its_line(
    folder: Path, robot: Robot, changes: list[tuple[str, str]], row: int, words: str
) -> None:
    given = bundle(folder, *changes)
    found = device_doubts(given, "device.yaml", robot, read_device(given, "device.yaml", robot))
    assert any(doubt.row == row and words in str(doubt) for doubt in found), found


def test_a_good_device_raises_no_doubt(folder: Path, robot: Robot) -> None:
    given = bundle(folder)
    device = read_device(given, "device.yaml", robot)
    assert device_doubts(given, "device.yaml", robot, device) == ()
