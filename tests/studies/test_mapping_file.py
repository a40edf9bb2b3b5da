"""mapping.yaml: faults with their place, and the examples of docs/mapping.md on real recordings."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

from exogauge.errors import BadStudy, Fault
from exogauge.logs.mapping import read_mapped
from exogauge.logs.mapping_rules import LogMapping, Values, Vector, Wrench
from exogauge.logs.units import UNITS
from exogauge.studies.intake.mapping_file import parse_mapping

ROOT = Path(__file__).parents[2]
DATA = ROOT / "../shared/data"
DOCUMENT = (ROOT / "docs/mapping.md").read_text()
EXAMPLES = [block for block in re.findall(r"```yaml\n(.*?)```", DOCUMENT, re.S) if block.startswith("version: 1")]

SMALL = """\
version: 1
files:
  - file: log.csv
    time: {column: time, unit: ms}
    columns:
      pos: {channel: q.a, unit: deg, offset: -pi/2}
      3: {channel: q.b, unit: rad}
    vectors:
      - {channel: acc, columns: [ax, ay, az], unit: g, rotation: y -x z}
    wrenches:
      - {sensor: foot, columns: [a, b, c, d, e, f], order: couple_first, force_unit: N, moment_unit: N·m}
"""


def faults(text: str) -> tuple[Fault, ...]:
    with pytest.raises(BadStudy) as caught:
        parse_mapping(text.encode(), "mapping.yaml")
    return caught.value.faults


def recording(*parts: str) -> Path:
    path = DATA.joinpath(*parts)
    if not path.exists():
        pytest.skip(f"the recording {'/'.join(parts)} is not beside this checkout")
    return path


def test_every_key_arrives_in_the_mapping(tmp_path: Path) -> None:
    (tmp_path / "mapping.yaml").write_text(SMALL)
    (file,) = parse_mapping((tmp_path / "mapping.yaml").read_bytes(), "mapping.yaml").files
    pos, third, acc, foot = file.rules
    assert (file.clock.column, file.clock.unit) == ("time", "ms")
    assert isinstance(pos, Values)
    assert pos.offset == -math.pi / 2
    assert third.source.columns == ("3",)
    assert isinstance(acc, Vector)
    assert acc.rotation == ((0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    assert isinstance(foot, Wrench)
    assert foot.order == "couple_first"


@pytest.mark.parametrize(
    ("wrong", "right", "row", "place"),
    [
        ("unit: deg", "unit: degg", 6, "files.0.columns.pos.unit"),
        ("q.a", "p.a", 6, "files.0.columns.pos.channel"),
        ("-pi/2", "-pie", 6, "files.0.columns.pos.offset"),
        ("offset: -pi/2", "side: moto", 6, "files.0.columns.pos.side"),
        ("offset: -pi/2", "ofset: 1", 6, "files.0.columns.pos.ofset"),
        ("offset: -pi/2", "sign: 2", 6, "files.0.columns.pos.sign"),
        ("unit: ms", "unit: msec", 4, "files.0.time.unit"),
        ("y -x z", "y x z", 9, "files.0.vectors.0.rotation"),
        ("y -x z", "imu", 9, "files.0.vectors.0.rotation"),
        ("[ax, ay, az]", "[ax, ay]", 9, "files.0.vectors.0.columns"),
        ("order: couple_first, ", "", 11, "files.0.wrenches.0.order"),
        ("version: 1", "version: 2", 1, "version"),
        ("files:", "constants: {ft.foot.f: 0}\nfiles:", 2, "constants.ft.foot.f"),
        ("files:", "constants: {acc.x: none}\nfiles:", 2, "constants.acc.x"),
    ],
)
def test_a_fault_names_its_place_and_line(wrong: str, right: str, row: int, place: str) -> None:
    found = faults(SMALL.replace(wrong, right, 1))
    assert [(f.file, f.row, f.column) for f in found] == [("mapping.yaml", row, place)]


def test_a_file_has_either_a_time_column_or_a_rate() -> None:
    (both,) = faults(SMALL.replace("    columns:", "    rate_hz: 100\n    columns:", 1))
    (neither,) = faults(SMALL.replace("    time: {column: time, unit: ms}\n", "", 1))
    assert both.detail == neither.detail
    assert "rate_hz" in both.detail


def test_constants_arrive_in_the_mapping() -> None:
    text = SMALL.replace("files:", "constants: {ft.hand.fx: 0, ft.hand.fz: -1.5}\nfiles:", 1)
    assert parse_mapping(text.encode(), "m").constants == (("ft.hand.fx", 0.0), ("ft.hand.fz", -1.5))


def test_rotations_may_be_named_or_written_out() -> None:
    matrix = "[[0, 1, 0], [-1, 0, 0], [0, 0, 1]]"
    named = SMALL.replace("y -x z", "imu", 1).replace("files:", f"rotations: {{imu: {matrix}}}\nfiles:", 1)
    written = SMALL.replace("y -x z", matrix, 1)
    plain = parse_mapping(SMALL.encode(), "m")
    assert parse_mapping(named.encode(), "m") == parse_mapping(written.encode(), "m") == plain


def test_a_mapping_survives_the_way_to_the_child_process() -> None:
    for text in (SMALL, *EXAMPLES):
        mapping = parse_mapping(text.encode(), "m")
        assert LogMapping.from_plain(mapping.to_plain()) == mapping


def test_every_unit_is_in_the_document() -> None:
    listed = set(re.findall(r"[^\s`·]+", DOCUMENT.split("Units:")[1].split("\n\n")[0]))
    assert set(UNITS) <= listed


def test_the_arm_of_example_1_is_read_joint_side() -> None:
    names = ("pos_read_data.csv.gz", "curr_data.csv.gz")
    paths = {name: recording("staubli_tx40", name) for name in names}
    joints = [f"joint_{k}" for k in range(1, 7)]
    gears = np.diag([32.0, 32.0, 45.0, -48.0, 45.0, 32.0])
    gears[5, 4] = 32.0
    mapping = parse_mapping(EXAMPLES[0].encode(), "m")
    log = read_mapped(paths, mapping, joints=joints, motor_from_joint=gears, name="tx40")
    q = np.degrees(log.stack([f"q.{joint}" for joint in joints]))
    torque = np.abs(log.stack([f"tau.{joint}" for joint in joints])).max(axis=0)
    assert (log.samples, round(log.rate_hz)) == (45_000, 5000)
    assert np.allclose(q.min(axis=0), [-100, -94, -45, -240, -90, -200], atol=0.2)
    assert np.allclose(q.max(axis=0), [120, 20, 120, 80, 108, 200], atol=0.2)
    assert np.allclose(torque, [93.6, 95.0, 34.4, 11.9, 21.8, 12.7], atol=0.1)


def test_the_humanoid_of_example_2_weighs_what_its_feet_say() -> None:
    path = recording("icub_walking", "walking.mat")
    mapping = parse_mapping(EXAMPLES[1].encode(), "m")
    (positions,) = [rule for rule in mapping.files[0].rules if isinstance(rule, Values) and len(rule.channels) > 1]
    joints = [name.removeprefix("q.") for name in positions.channels]
    log = read_mapped({"walking.mat": path}, mapping, joints=joints, motor_from_joint=None, name="walk")
    assert (log.samples, len(joints)) == (1200, 26)  # 1188 stamps between 0.2 and 27 ms apart, brought to 100 Hz
    assert np.ptp(np.diff(log.time)) < 1e-9
    assert not log.stack(["ft.l_foot.fx", "ft.r_foot.mz"]).any()
    assert np.linalg.norm(log.stack(["acc.x", "acc.y", "acc.z"]), axis=1).mean() == pytest.approx(10.01, abs=0.01)
    assert (log.channels["ft.l_foot.fz"] + log.channels["ft.r_foot.fz"]).mean() == pytest.approx(329.6, abs=0.1)


def test_the_two_clocks_of_example_3_become_one() -> None:
    names = ("1-baseline_wrench.csv", "1-baseline_accel.csv")
    paths = {name: recording("kuka_ft_payload", name) for name in names}
    mapping = parse_mapping(EXAMPLES[2].encode(), "m")
    log = read_mapped(paths, mapping, joints=(), motor_from_joint=None, name="baseline")
    assert log.rate_hz == pytest.approx(250.0)
    assert log.time[-1] - log.time[0] == pytest.approx(6.26, abs=0.02)
    assert np.median(np.linalg.norm(log.stack(["acc.x", "acc.y", "acc.z"]), axis=1)) == pytest.approx(9.8, abs=0.3)
    assert np.isfinite(log.stack(list(log.channels))).all()
