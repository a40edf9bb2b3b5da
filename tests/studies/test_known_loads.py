"""`known` of study.yaml: read, refused with place, value and advice, and told in results and report."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import yaml
from tests.sensor_arm import FRICTION, JOINTS, OFFSET, motion, urdf

from exogauge.api.shapes import StudyFromParts
from exogauge.errors import BadStudy
from exogauge.studies.evaluate import evaluate
from exogauge.studies.intake.contract import StudyFile
from exogauge.studies.intake.open import open_study

Rewrite = Callable[[str, str, str], Path]
KNOWN = "known:\n  - {{link: {link}, mass_kg: {mass}, std_kg: {std}, logs: {logs}{more}}}\nsettings:"


def stating(rewrite: Rewrite, link="r_arm", mass="5.0", std="0.005", logs="[id_1]", more="") -> Path:
    text = KNOWN.format(link=link, mass=mass, std=std, logs=logs, more=more)
    return rewrite("study.yaml", "settings:", text)


def test_a_load_is_read_in_the_frame_of_its_body(rewrite: Rewrite) -> None:
    with open_study(stating(rewrite, link="imu_link", more=", com_m: [0.1, 0, 0.05], std_com_m: 0.01")) as study:
        (load,) = study.robot.loads
        body, pose = study.robot.tree.frames["imu_link"]
    assert (load.name, load.body, load.mass, load.std) == ("imu_link", body, 5.0, 0.005)
    assert (load.std_centre, load.logs) == (0.01, ("id_1",))
    np.testing.assert_allclose(load.centre, pose.act(np.array([0.1, 0.0, 0.05])))


def test_where_no_centre_is_stated_it_is_somewhere_about_the_link(rewrite: Rewrite) -> None:
    with open_study(stating(rewrite)) as study:
        (near,) = study.robot.loads
    assert near.centre == (0.0, 0.0, 0.0)
    assert near.std_centre == 0.1


@pytest.mark.parametrize(
    ("key", "value", "rule", "column", "shown", "advice"),
    [
        ("link", "r_harm", "unknown_link", "known.0.link", "r_harm", "r_arm"),
        ("logs", "[id_1, id_2]", "unknown_log", "known.0.logs.1", "id_2", "id_1"),
        ("mass", "-5.0", "mass_not_positive", "known.0.mass_kg", "-5", "scales"),
        ("mass", "0.0", "mass_not_positive", "known.0.mass_kg", "0", "scales"),
        ("std", "0.0", "mass_doubt_impossible", "known.0.std_kg", "0", "standard deviation"),
        ("std", "7.0", "mass_doubt_impossible", "known.0.std_kg", "7", "standard deviation"),
    ],
)
def test_what_cannot_be_is_refused_with_its_place(
    rewrite: Rewrite, key: str, value: str, rule: str, column: str, shown: str, advice: str
) -> None:
    with pytest.raises(BadStudy) as caught, open_study(stating(rewrite, **{key: value})):
        pass
    (fault,) = caught.value.faults
    assert (fault.rule, fault.file, fault.column, fault.value) == (rule, "study.yaml", column, shown)
    assert advice in fault.advice
    assert fault.row is not None


@pytest.mark.parametrize(("link", "rule"), [("stand", "link_fixed"), ("tool", "link_left_out")])
def test_a_load_where_no_axis_feels_it_is_refused(tmp_path: Path, link: str, rule: str) -> None:
    """On the ground, and beyond a contact sensor, where the robot ends."""
    (tmp_path / "robot.urdf").write_text(urdf())
    joints = [{"name": name, "actuation": "torque"} for name in JOINTS]
    sensor = {"name": "wrist", "frame": "wrist_ft", "role": "contact", "sees": "world_on_robot"}
    about = {"base": "fixed", "base_link": "stand", "joints": joints, "ft_sensors": [sensor]}
    (tmp_path / "robot.yaml").write_text(yaml.safe_dump({"version": 1, "urdf": "robot.urdf"} | about))
    (tmp_path / "a.parquet").write_bytes(b"")
    logs = [{"file": "a.parquet", "role": "identification"}]
    known = [{"link": link, "mass_kg": 2.0, "std_kg": 0.01, "logs": ["a"]}]
    study = {"version": 1, "name": "s", "robot": "robot.yaml", "logs": logs, "known": known}
    (tmp_path / "study.yaml").write_text(yaml.safe_dump(study))
    with pytest.raises(BadStudy) as caught, open_study(tmp_path):
        pass
    assert [fault.rule for fault in caught.value.faults] == [rule]


def test_a_study_from_parts_states_it_too() -> None:
    load = {"link": "hand", "mass_kg": 5.0, "std_kg": 0.005, "logs": ["b"]}
    parts = StudyFromParts.model_validate(
        {
            "name": "s",
            "robot_id": "r",
            "logs": [{"log_id": "1", "role": "identification", "name": "b"}],
            "known": [load],
        }
    )
    written = StudyFile.model_validate(parts.study_yaml([{"file": "b.csv"}], {}))
    assert [entry.model_dump(exclude_none=True) for entry in written.known] == [load | {"logs": ("b",)}]


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict, str]:
    """results.json and the report of an arm that logs currents, with and without 3 kg at its tool."""
    import pinocchio as pin

    folder, k_T = tmp_path_factory.mktemp("arm"), np.array([6.0, 5.0, 4.0, 3.0])
    (folder / "robot.urdf").write_text(urdf())
    joints = [
        {"name": name, "actuation": "current", "prior": {"k_T": float(k * off)}, "prior_std": {"k_T": float(0.3 * k)}}
        for name, k, off in zip(JOINTS, k_T, (1.25, 0.8, 1.2, 0.85), strict=True)
    ]
    robot = {"version": 1, "urdf": "robot.urdf", "base": "fixed", "base_link": "stand", "joints": joints}
    (folder / "robot.yaml").write_text(yaml.safe_dump(robot))
    for seed, name in enumerate(("empty", "loaded", "check")):
        model = pin.buildModelFromXML(urdf(true=True))
        if name != "empty":
            tool = model.getFrameId("tool")
            frame = model.frames[tool]
            lump = pin.Inertia(3.004, np.array([0.0, 0.02, 0.05]), 0.006 * np.eye(3))
            model.appendBodyToJoint(frame.parentJoint, lump, frame.placement)
        data, rng = model.createData(), np.random.default_rng(seed)
        t, q, v, a = motion(seed + 3, 16.0)
        load = np.array([pin.rnea(model, data, *row) for row in zip(q, v, a, strict=True)])
        current = (load + FRICTION["k_d"] * v + FRICTION["tau_c"] * np.sign(v) - OFFSET) / k_T
        columns = {"t": t} | {f"q.{j}": q[:, k] + 1e-5 * rng.normal(size=len(t)) for k, j in enumerate(JOINTS)}
        columns |= {f"i.{j}": current[:, k] + 0.01 * rng.normal(size=len(t)) for k, j in enumerate(JOINTS)}
        pq.write_table(pa.table(columns), folder / f"{name}.parquet")
    roles = {"empty": "identification", "loaded": "identification", "check": "validation"}
    logs = [{"file": f"{name}.parquet", "role": role} for name, role in roles.items()]
    known = [{"link": "tool", "mass_kg": 3.0, "std_kg": 0.005, "logs": ["loaded", "check"]}]
    study = {"version": 1, "name": "arm", "robot": "robot.yaml", "logs": logs, "known": known, "steps": ["identify"]}
    (folder / "study.yaml").write_text(yaml.safe_dump(study | {"settings": {"cutoff_hz": 8.0}}))
    evaluate(folder / "study.yaml", folder / "out", lambda *_: None)
    return json.loads((folder / "out/results.json").read_text()), (folder / "out/report.html").read_text()


@pytest.mark.slow
def test_a_load_at_a_fixed_link_gives_the_torque_constants_from_files(told: tuple[dict, str]) -> None:
    found = told[0]["identification"]
    for joint, k in zip(found["joints"], (6.0, 5.0, 4.0, 3.0), strict=True):
        assert abs(joint["k_T"]["value"] - k) < 2.5 * joint["k_T"]["std"]
        assert joint["k_T"]["std"] < 0.05 * k
    assert all(fit["rmse_moving"] < 1.15 * fit["noise_floor"] for fit in found["validation"] if fit["held_out"])


@pytest.mark.slow
def test_results_and_report_tell_what_was_known_and_what_it_fixed(told: tuple[dict, str]) -> None:
    found, report = told[0]["identification"], told[1]
    (load,) = found["known_loads"]
    assert (load["load"], load["mass_kg"], load["std_kg"]) == ("tool", 3.0, 0.005)
    assert load["logs"] == ["loaded", "check"]
    assert not load["part_of_its_link"]
    assert abs(load["found_kg"] - 3.0) < 0.01
    factor = found["common_factor"]
    assert factor["known"]
    assert factor["std"] < 0.25 * factor["unweighed"]
    assert "Known loads" in report
    assert "They fix the scale of all torques" in report
