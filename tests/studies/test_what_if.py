"""What-if from a study's files: by words, by YAML, as a job, on the command line."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from exogauge.cli import main
from exogauge.devices.band_changes import (
    CopyBand,
    InsertPoint,
    MirrorBand,
    MovePoint,
    PlacePoint,
    RemoveBand,
    RemovePoint,
)
from exogauge.devices.bench import Bench
from exogauge.devices.changes import Change, Law, NaturalLength, Pretension, Stiffness, apply
from exogauge.devices.device import Device
from exogauge.devices.what_if import WhatIf, compare
from exogauge.errors import BadInput, BadLog, BadStudy
from exogauge.studies.device_pages.change_entries import ChangesFile
from exogauge.studies.device_pages.change_text import EXAMPLES, read_change
from exogauge.studies.device_pages.device_content import device_content, device_from, write_device
from exogauge.studies.device_pages.entry_changes import change_of, changes_of
from exogauge.studies.device_pages.what_if import compute
from exogauge.studies.intake.bundle import Bundle, open_bundle
from exogauge.studies.intake.device_file import read_device
from exogauge.studies.intake.open import open_study
from exogauge.studies.intake.robot_file import load_robot
from exogauge.studies.intake.yaml_file import load_yaml
from exogauge.studies.series.recorded_motion import read_motion
from exogauge.terminal import silent

DEVICE = """version: 1
name: Suit
bands:
  - name: A_left
    group: A
    via_points: [{link: chest_1, xyz: [-0.1, 0.1, 0.3]}, {link: chest_0, xyz: [-0.12, 0.1, 0.0]},
                 {link: BODY, xyz: [-0.1, 0.1, 0.0]}]
    stiffness_n_per_m: 200
    natural_length_m: 0.4
    bench: {file: bench.csv}
  - name: A_right
    group: A
    via_points: [{link: chest_1, xyz: [-0.1, -0.1, 0.3]}, {link: BODY, xyz: [-0.1, -0.1, 0.0]}]
    natural_length_m: 0.4
    ground_truth: true
    bench: {file: bench.csv}
  - name: arm ü/2
    via_points: [{link: r_arm, xyz: [0.0, 0.05, 0.2]}, {link: chest_1, xyz: [0.1, 0.05, 0.0]}]
    stiffness_n_per_m: 90.5
    natural_length_m: 0.2
    law: kelvin_voigt
    law_values: {damping: 12.5}
tied: [A]
"""


@pytest.fixture
def study(folder: Path, log_writer: Callable[..., None]) -> Path:
    """A study with a device and a log that wears it."""
    (folder / "device.yaml").write_text(DEVICE)
    (folder / "bench.csv").write_text("length_m,force_n\n0.4,0\n0.5,20\n0.6,40\n")
    with open_study(folder) as opened:
        log_writer(folder / "logs" / "worn.parquet", opened.robot, 1000)
    text = (folder / "study.yaml").read_text()
    worn = "  - {file: logs/worn.parquet, role: with_device, device: device.yaml}\nsettings"
    (folder / "study.yaml").write_text(text.replace("settings", worn, 1))
    return folder


def asked(study: Path, *changes: Change, device: str | None = None) -> WhatIf:
    motion = read_motion(open_bundle(study), "worn", device)
    changed = apply(motion.device, changes, motion.tree)
    return compare(Bench(motion.tree, motion.device, motion.q, motion.time), changed)


def equal_torques(one: WhatIf, when: str, other: WhatIf, when_other: str) -> None:
    for first, second in zip(one.joints, other.joints, strict=True):
        assert first.joint == second.joint
        np.testing.assert_allclose(getattr(first, when).torque, getattr(second, when_other).torque, atol=1e-9)


@pytest.mark.slow
def test_a_moved_via_point_is_what_a_device_file_written_so_gives(study):
    (study / "other.yaml").write_text(DEVICE.replace("[-0.12, 0.1, 0.0]", "[-0.12, 0.1, 0.02]"))
    moved = asked(study, MovePoint("A_left", 1, (0.0, 0.0, 0.02)))
    written = asked(study, device="other.yaml")
    equal_torques(moved, "after", written, "before")
    assert any(abs(each.percent["rms"] or 0.0) > 0.1 for each in moved.joints)


@pytest.mark.slow
def test_what_is_saved_is_what_was_asked(study):
    changes = (MovePoint("A_left", 1, (0.1, 0.2, 0.3)), Stiffness("A", times=1.1), Pretension("arm ü/2", 0.01))
    now = asked(study, *changes)
    written = write_device(now.changed, study / "new.yaml", study)
    assert [path.name for path in written] == ["new.yaml"]  # other stiffness: the bench tests are not theirs any more
    again = asked(study, device="new.yaml")
    assert again.device.groups == now.changed.groups
    equal_torques(now, "after", again, "before")


@pytest.mark.slow
def test_a_device_file_survives_being_read_written_and_read(study):
    motion = read_motion(open_bundle(study), "worn")
    (study / "deep").mkdir()
    files = write_device(motion.device, study / "deep" / "copy.yaml", study)
    assert [path.name for path in files] == ["copy.yaml", "copy_A_left_bench.csv"]
    assert read_motion(open_bundle(study), "worn", "deep/copy.yaml").device == motion.device
    plain = device_from(json.loads(json.dumps(device_content(motion.device))))
    assert [(band.name, band.group, band.via_points, band.law_values) for band in plain.bands] == [
        (band.name, band.group, band.via_points, band.law_values) for band in motion.device.bands
    ]
    with pytest.raises(BadInput, match="no band left"):
        write_device(Device("bare", ()), study / "bare.yaml")


TEXTS: list[tuple[str, str, Change]] = [
    ("set", "A.stiffness=300", Stiffness("A", to=300.0)),
    ("set", "arm ü/2.natural_length=.25", NaturalLength("arm ü/2", to=0.25)),
    ("set", "*.pretension=-0.01", Pretension("*", -0.01)),
    ("set", "v1.2.stiffness=3e2", Stiffness("v1.2", to=300.0)),
    ("set", "A_left.3=0.1,0,-0.2", PlacePoint("A_left", 3, (0.1, 0.0, -0.2))),
    ("set", "A_left.3=chest", PlacePoint("A_left", 3, link="chest")),
    ("set", "A_left.0=chest:0.1,0,0", PlacePoint("A_left", 0, (0.1, 0.0, 0.0), "chest")),
    ("scale", "A.stiffness=2", Stiffness("A", times=2.0)),
    ("scale", "A.natural_length=0.95", NaturalLength("A", times=0.95)),
    ("move", "A_left.3=0,0,0.01", MovePoint("A_left", 3, (0.0, 0.0, 0.01))),
    ("move", "A_left.natural_length=-0.02", NaturalLength("A_left", by=-0.02)),
    ("set", "A.law=kelvin_voigt,damping=12", Law("A", "kelvin_voigt", {"damping": 12.0})),
    ("add", "A_left.3=chest:0.1,0,0.2", InsertPoint("A_left", 3, "chest", (0.1, 0.0, 0.2))),
    ("remove", "A_left.3", RemovePoint("A_left", 3)),
    ("remove", "A_left", RemoveBand("A_left")),
    ("copy", "A_left=A_left_2", CopyBand("A_left", "A_left_2")),
    ("mirror", "A_left=A_right", MirrorBand("A_left", "A_right")),
]


@pytest.mark.parametrize(("option", "text", "change"), TEXTS)
def test_words_become_changes(option, text, change):
    assert change_of(read_change(option, text)) == change


def test_every_example_of_the_help_can_be_read():
    for examples in EXAMPLES.values():
        for example in examples.split(", --"):
            option, _, text = example.removeprefix("--").partition(" ")
            assert read_change(option, text)


WRONG_WORDS = [
    ("set", "A.stiffnes=3", "Did you mean 'stiffness'?"),
    ("set", "stiffness=3", "expected BAND.WHAT=VALUE"),
    ("set", "A.stiffness=many", "expected a number, not 'many'"),
    ("set", "A.stiffness=-3", "greater than 0"),
    ("set", "A.stiffness=nan", "finite number"),
    ("set", "A.3=1,2", "expected three numbers"),
    ("set", "A.99=1,2,3", "less than or equal to 49"),
    ("scale", "A.pretension=2", "none of stiffness, natural_length"),
    ("move", "A.3=chest", "expected a number, not 'chest'"),
    ("add", "A.3=0,0,1", "its link and its place"),
    ("copy", "A", "expected BAND=NEW_NAME"),
]


@pytest.mark.parametrize(("option", "text", "said"), WRONG_WORDS)
def test_words_that_are_no_change_are_refused_with_an_example(option, text, said):
    with pytest.raises(BadInput) as refused:
        read_change(option, text)
    assert refused.value.faults[0].column == f"--{option} {text}"
    assert said in str(refused.value)


def test_the_same_changes_in_yaml():
    text = b"version: 1\nchanges:\n  - {change: stiffness, of: A, to: 300}\n  - {change: move_point, band: A_left, point: 3, by: [0, 0, 0.01]}\n"  # noqa: E501
    read = changes_of(load_yaml(text, ChangesFile, file="c.yaml").changes)
    assert read == (Stiffness("A", to=300.0), MovePoint("A_left", 3, (0.0, 0.0, 0.01)))
    with pytest.raises(BadStudy) as refused:
        load_yaml(text.replace(b"to: 300", b"to: 0"), ChangesFile, file="c.yaml")
    assert refused.value.faults[0].row == 3


@pytest.mark.slow
def test_the_job_uses_every_sample_and_its_series_holds_what_its_json_sums_up(study, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    changes = [{"change": "stiffness", "of": "A", "times": 2}, {"change": "remove_band", "of": "arm ü/2"}]
    compute(study, out, silent, {"log": "worn", "changes": changes})
    said = json.loads((out / "what_if.json").read_text())
    assert (said["samples"], said["of_samples"], said["every"]) == (1000, 1000, 1)
    table = pq.read_table(out / "series" / "what_if.parquet")
    assert table.num_rows == 1000
    for joint in said["joints"]:
        for when in ("before", "after"):
            torque = table[f"{when}.{joint['joint']}"].to_numpy()
            assert joint[when]["peak"] == torque[np.argmax(np.abs(torque))]
    assert "band.arm ü/2.tension.before" in table.column_names
    assert "band.arm ü/2.tension.after" not in table.column_names
    saved = read_device(Bundle(out, "device.yaml"), "device.yaml", load_robot(study))
    assert [(band.name, band.stiffness) for band in saved.bands] == [("A_left", 400.0), ("A_right", 400.0)]
    with pytest.raises(BadInput, match=r"settings\.changes\.0\.of"):
        compute(study, out, silent, {"log": "worn", "changes": [{"change": "remove_band", "of": "Z"}]})


@pytest.mark.slow
def test_long_motions_are_thinned_evenly_and_say_so(study):
    whole, thin = (read_motion(open_bundle(study), "worn", most=most) for most in (None, 300))
    assert (len(thin.time), thin.of_samples, thin.every) == (250, 1000, 4)
    np.testing.assert_array_equal(thin.q, whole.q[::4])
    np.testing.assert_array_equal(thin.time, whole.time[::4])


def test_a_missing_log_position_or_device_is_named(study, rewrite, log_writer):
    with pytest.raises(BadStudy, match="Did you mean 'worn'"):
        read_motion(open_bundle(study), "warn")
    with pytest.raises(BadStudy, match="no such file"):
        read_motion(open_bundle(study), "worn", "devise.yaml")
    with open_study(study) as opened:
        log_writer(study / "logs" / "worn.parquet", opened.robot, drop=("q.r_elbow",))
    with pytest.raises(BadLog, match=r"q\.r_elbow"):
        read_motion(open_bundle(study), "worn")


def run(*arguments: object) -> int:
    return main(["whatif", *map(str, arguments)])


def test_the_command_prints_before_and_after(study, capsys):
    assert run(study, "--log", "worn", "--scale", "A.stiffness=2", "--remove", "arm ü/2") == 0
    said = capsys.readouterr().out
    assert "torso_pitch *" in said
    assert "100.0" in said
    assert "-100.0" in said
    assert "A_left" in said


@pytest.mark.slow
def test_the_command_takes_changes_in_their_order_and_saves_the_device(study, capsys):
    copied = ("--copy", "A_left=C", "--move", "C.1=0,0,0.01", "--scale", "C.natural_length=0.9")
    assert run(study, "--log", "worn", *copied, "--save", study / "new.yaml", "--json") == 0
    said = json.loads(capsys.readouterr().out)
    assert [band["band"] for band in said["bands"]] == ["A_left", "A_right", "arm ü/2", "C"]
    assert run(study, "--log", "worn", "--device", "new.yaml", "--json") == 0
    again = json.loads(capsys.readouterr().out)
    for one, other in zip(said["joints"], again["joints"], strict=True):
        assert one["after"] == pytest.approx(other["before"])


def test_the_command_takes_a_log_and_a_device_from_elsewhere(study, tmp_path, capsys, monkeypatch):
    (study / "logs" / "worn.parquet").rename(tmp_path / "mine.parquet")
    (tmp_path / "mine.yaml").write_text(DEVICE.replace("    bench: {file: bench.csv}\n", ""))
    monkeypatch.chdir(tmp_path)
    assert run(study, "--log", "mine.parquet", "--device", "mine.yaml", "--json") == 0
    assert json.loads(capsys.readouterr().out)["samples"] == 1000


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--log", "warn"), "Did you mean 'worn'"),
        (("--log", "worn", "--set", "A.stiffness=-3"), "--set A.stiffness=-3"),
        (("--log", "worn", "--move", "A_left.7=0,0,1"), "has 3 via points, 0 to 2"),
        (("--log", "worn", "--main", "knee"), "no joint 'knee'"),
        (("--log", "worn", "--changes", "nowhere.yaml"), "nowhere.yaml"),
        (("--log", "worn", "--save", "x.yaml", "--remove", "*"), "no band left"),
    ],
)
def test_the_command_ends_with_2_and_says_what_is_wrong(study, capsys, arguments, said):
    assert run(study, *arguments) == 2
    assert said in capsys.readouterr().err
