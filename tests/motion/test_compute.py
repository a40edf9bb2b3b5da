"""What workers compute of motions: a body fitted to markers, a motion that identifies."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from tests.motion.captures import bow, bvh
from tests.motion.robots import ARMS, arm_folder

from exogauge.cli import main
from exogauge.errors import BadMotion
from exogauge.motion import compute
from exogauge.motion.contract import ContactsEntry
from exogauge.motion.figure import read_figure
from exogauge.motion.files import open_motion
from exogauge.motion.intake import contacts_from, open_capture, spans_of
from exogauge.studies.series.file import SeriesFile


def quiet(share: float, words: str) -> None:
    assert 0.0 <= share <= 1.0
    assert words


def motion_folder(folder: Path, **more: str) -> Path:
    folder.mkdir()
    (folder / "bow.bvh").write_bytes(bvh(bow()))
    lines = ["version: 1", "name: Bow", "file: bow.bvh", *(f"{key}: {value}" for key, value in more.items())]
    (folder / "motion.yaml").write_text("\n".join(lines))
    return folder


def test_stretches_and_samples_say_the_same() -> None:
    time = np.arange(20) / 10.0
    stands = np.isin(np.arange(20), [0, 1, 2, 7, 8, 19])
    spans = spans_of(time, stands)
    assert spans == [pytest.approx(each) for each in ([0.0, 0.2], [0.7, 0.8], [1.9, 1.9])]
    back = contacts_from(time, ContactsEntry(left=spans, right=[]))
    assert (back.left == stands).all()
    assert not back.right.any()


def test_a_foot_stands_no_longer_than_the_motion_lasts() -> None:
    """A stretch of 0 to 9 s was kept of a motion of 1.9."""
    said = ContactsEntry(left=[[0.0, 0.5], [0.7, 1.94]], right=[[0.0, 9.0]])
    with pytest.raises(BadMotion) as refused:
        said.within(1.9, 10.0)
    assert [(each.rule, each.column, each.value) for each in refused.value.faults] == [
        ("past_the_end", "right.0", "0 to 9 s")
    ]
    rounded = ContactsEntry(left=said.left, right=[])
    assert rounded.within(1.9, 10.0) == rounded


def test_names_that_are_mapped_are_read_as_what_they_are_called(tmp_path: Path) -> None:
    path = tmp_path / "a.bvh"
    path.write_bytes(bvh(bow()).replace(b"Spine2", b"Brust"))
    known = open_motion(path, names={"Brust": "Spine2", "Nichts": "Head2"})
    assert known.tree is not None
    assert known.tree.segment["Spine2"] == "thorax"
    assert known.told["renamed"] == "Brust = Spine2"
    assert known.told["not in the file"] == "Nichts"
    with pytest.raises(BadMotion) as refused:
        open_motion(path, names={"Brust": "Head"})
    assert refused.value.faults[0].rule == "same_name"


def test_a_capture_that_names_no_file_is_refused_with_the_key(tmp_path: Path) -> None:
    folder = motion_folder(tmp_path / "m", skeleton="person.asf")
    with pytest.raises(BadMotion) as refused:
        open_capture(folder)
    assert (refused.value.faults[0].column, refused.value.faults[0].value) == ("skeleton", "person.asf")


@pytest.mark.slow
def test_a_body_is_fitted_and_drawn_as_it_bent(tmp_path: Path) -> None:
    folder, out = motion_folder(tmp_path / "m"), tmp_path / "out"
    out.mkdir()
    compute.fit(folder, out, quiet, {})
    document = json.loads((out / compute.FIT).read_text())
    assert document["rms_m"] < 0.05
    figure = read_figure(out / compute.FIGURE)
    assert figure.lines.shape[1:] == (18, 2, 3)
    assert np.isfinite(figure.lines).all()
    series = SeriesFile(out / compute.SERIES)
    flexion = series.read("angle.trunk_flexion", 0, len(series.groups) - 1)
    assert np.degrees(np.ptp(flexion)) == pytest.approx(20.0, abs=3.0)


@pytest.mark.slow
def test_an_arms_motion_that_identifies_tells_what_will_be_known(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The same from the command as from the job, to the byte; links do not count beside what they are made of."""
    robot = arm_folder(tmp_path / "plan" / "robot", "ur10")
    (tmp_path / "plan" / "plan.yaml").write_text("version: 1\nrobot: x\nexcite: {seconds: 3}\n")
    out = tmp_path / "out"
    out.mkdir()
    told = list[tuple[float, str]]()
    compute.excite(tmp_path / "plan", out, lambda *now: told.append(now), {})
    shares = np.array([share for share, _ in told])
    assert (np.diff(shares) >= 0.0).all()
    searched = [share for share, words in told if words.startswith("search")]
    assert searched[0] < 0.1
    document = json.loads((out / compute.PLAN).read_text())
    assert document["broken"] == []
    assert document["margins"]["pressure_inside_m"] is None
    names = SeriesFile(out / compute.SERIES).names
    assert {"margin.nearest_pair", "bound.torque", "binds"} <= set(names)
    assert not any(name.startswith(("pressure.", "margin.pressure")) for name in names)  # it does not stand
    decided = [each for each in document["parameters"] if each["decided"]]
    assert len(decided) > 10
    assert all(0.0 < each["std"] < each["before"] for each in decided)
    largest = {each["kind"]: each["share"] for each in document["margins"]["bounds"]}
    assert 0.2 < max(largest.values()) <= 1.0001
    with pytest.raises(BadMotion):
        compute.retarget(tmp_path / "plan", out, quiet, {})

    by_command = tmp_path / "command.csv"
    assert main(["motion", "excite", "--robot", str(robot), "--seconds", "3", "--json", "--out", str(by_command)]) == 0
    said = json.loads(capsys.readouterr().out)
    assert {**said, "written": 0} == {**document["told"], "written": 0}
    assert by_command.with_suffix(".json").read_bytes() == (out / compute.PLAN).read_bytes()
    assert by_command.read_bytes() == (out / compute.MOTION).read_bytes()
    rows = list(csv.DictReader(by_command.read_text().splitlines()))
    assert len(rows) == pytest.approx(said["seconds"] * 200.0, abs=2)
    first, last = ([float(row[f"q.{joint}"]) for joint in ARMS["ur10"][1]] for row in (rows[0], rows[-1]))
    assert first == pytest.approx(ARMS["ur10"][2], abs=1e-6)
    assert last == pytest.approx(first, abs=1e-6)
    assert all(each["std"] <= each["before"] * 1.001 for each in document["parameters"] if each["kind"] == "base")

    told_by = {"base": lambda name: name.startswith("base["), "joint": lambda name: name.split("[")[1][:-1] in joints}
    joints = set(ARMS["ur10"][1])
    links = [each for each in document["parameters"] if each["kind"] == "link"]
    assert len(links) == 10 * len({each["name"].split("[")[1] for each in links}) > 0
    for count in document["counts"]:
        of = [each for each in document["parameters"] if each["kind"] == count["kind"] and each["before"] > 0.0]
        assert all(told_by[count["kind"]](each["name"]) for each in of)
        assert count["of"] == len(of) > 20
        assert count["decided"] == sum(each["decided"] for each in of)
        assert document["told"][f"{count['kind']} parameters"].startswith(f"{count['decided']} of {count['of']} ")
