"""From payload.yaml to a plan."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from tests.payload.conftest import generator
from tests.payload.planned import arm_of, plan_yaml

from exogauge.cli import main
from exogauge.errors import BadStudy
from exogauge.payload.planning.plan import open_plan


def written(folder: Path, **changes: object) -> Path:
    (folder / "payload.yaml").write_text(plan_yaml(**changes))
    (folder / "arm.urdf").write_text(generator.arm_urdf())
    return folder


def table_of(path: Path) -> dict[str, np.ndarray]:
    names = path.read_text().splitlines()[0].split(",")
    return dict(zip(names, np.loadtxt(path, delimiter=",", skiprows=1).T, strict=True))


@pytest.mark.parametrize("choice", ["least_std", "algorithm_1"])
def test_postures_are_written_with_what_they_will_tell(
    tmp_path: Path, choice: str, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = written(tmp_path, postures={"count": 15, "choice": choice})
    assert main(["payload", "postures", str(folder), "--out", str(tmp_path / "out")]) == 0
    assert "condition" in capsys.readouterr().out
    told = json.loads((tmp_path / "out" / "postures.json").read_text())
    assert told["condition"][0] <= 4.5
    assert told["condition"][1] <= 6.5
    assert {"Ixx", "Izz"} <= set(told["undecided"])
    table = table_of(tmp_path / "out" / "postures.csv")
    assert len(table["posture"]) >= 15
    q = np.column_stack([table[f"q.{name}"] for name in generator.JOINTS])
    rotation = arm_of().rotations(q[:, 3:])
    assert np.abs(q[:, 3:]).max() <= 2.8
    assert (rotation[:, 2, 2] <= -0.5 + 1e-9).all()
    assert -rotation[:, 2] == pytest.approx(np.column_stack([table[f"gravity.{axis}"] for axis in "xyz"]), abs=1e-9)


@pytest.mark.slow
def test_excitation_is_written_with_what_it_will_tell(tmp_path: Path) -> None:
    folder = written(tmp_path)
    assert main(["payload", "excite", str(folder), "--out", str(tmp_path / "out")]) == 0
    told = json.loads((tmp_path / "out" / "excitation.json").read_text())
    assert told["undecided"] == []
    assert told["strain"] <= 1.0
    std = {each["name"]: each["std"] for each in told["certainties"]}
    assert all(std[name] <= 0.002 for name in ("Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz"))
    table = table_of(tmp_path / "out" / "excitation.csv")
    assert len(table["t"]) == 2501
    for name in generator.JOINTS:
        assert np.gradient(table[f"q.{name}"], table["t"])[1:-1] == pytest.approx(table[f"dq.{name}"][1:-1], abs=1e-3)


@pytest.mark.slow
def test_postures_about_one_axis_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["payload", "postures", str(written(tmp_path, joints=["a6"])), "--out", str(tmp_path / "out")]) != 0
    assert "postures decide" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_payload_that_meets_the_robot_is_told(tmp_path: Path) -> None:
    """A box of 5 m about the sensor reaches the shoulder, which has a shape here."""
    folder = written(tmp_path, payload={"mass_kg": 40.0, "centre_m": [0.0, 0.0, 0.0], "size_m": [5.0, 5.0, 5.0]})
    shape = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
    urdf = generator.arm_urdf().replace('<link name="link2">', f'<link name="link2">{shape}')
    (folder / "arm.urdf").write_text(urdf)
    assert arm_of(urdf=urdf).pairs == 1
    with pytest.raises(BadStudy, match=r"collides at home: \w+ with payload"):
        open_plan(folder)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"joints": ["a7"]}, "no such joint .*a7"),
        ({"home": {"a1": 0.0}}, "a joint has no home .*Add `a2`"),
        ({"acceleration": {"a4": 6.0}}, "a joint has no acceleration .*Add `a5`"),
        ({"position": {"a4": [1.0, -1.0]}}, "empty range"),
        ({"position": {"a5": [-1.0, 1.0]}}, "home of a5 is outside .*rad"),
        ({"workspace": [{"axis": "z", "theta_deg": [0.0, 30.0]}]}, "outside the workspace.*theta"),
        ({"workspace": [{"axis": "z", "theta_deg": [30.0, 10.0]}]}, "theta_deg"),
        ({"payload": {"mass_kg": -1.0, "centre_m": [0, 0, 0], "size_m": [1, 1, 1]}}, "mass_kg"),
        ({"excitation": {"harmonics": 2}}, "harmonics"),
    ],
)  # fmt: skip
def test_bad_input_is_refused_with_advice(tmp_path: Path, changes: dict[str, object], said: str) -> None:
    with pytest.raises(BadStudy, match=said) as refused:
        open_plan(written(tmp_path, **changes))
    assert refused.value.faults[0].file == "payload.yaml"


def test_a_file_without_a_plan_a_frame_or_a_mesh_is_refused(tmp_path: Path) -> None:
    folder = written(tmp_path)
    text = (folder / "payload.yaml").read_text()
    (folder / "payload.yaml").write_text(text[: text.index("plan:")])
    with pytest.raises(BadStudy, match="nothing says what may be planned"):
        open_plan(folder)
    (folder / "payload.yaml").write_text(text.replace("frame: ft", "frame: fr"))
    with pytest.raises(BadStudy, match="no such frame"):
        open_plan(folder)
    (folder / "payload.yaml").write_text(text)
    mesh = '<collision><geometry><mesh filename="link2.stl"/></geometry></collision>'
    (folder / "arm.urdf").write_text(generator.arm_urdf().replace('<link name="link2">', f'<link name="link2">{mesh}'))
    with pytest.raises(BadStudy, match=r"collision shape cannot be read.*<collision>"):
        open_plan(folder)
