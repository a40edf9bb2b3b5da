"""What-if over HTTP: uploaded, asked, answered as the numerics answer, and again without reading anything."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fastapi.testclient import TestClient

from exogauge.api import benches
from exogauge.api.app import create_app
from exogauge.api.benches import Benches, Ready, open_bench, read_back, refuse_large
from exogauge.client import Client
from exogauge.devices.changes import apply
from exogauge.devices.what_if import what_if
from exogauge.errors import TooLarge
from exogauge.jobs.attempt import Runner
from exogauge.jobs.engine import migrate_engine
from exogauge.jobs.leases import Lease
from exogauge.robots.plain_tree import to_plain
from exogauge.settings import Settings
from exogauge.studies.device_pages.change_entries import ChangesFile
from exogauge.studies.device_pages.device_content import device_content
from exogauge.studies.device_pages.entry_changes import changes_of
from exogauge.studies.intake.bundle import Bundle
from exogauge.studies.series.recorded_motion import read_motion

pytestmark = pytest.mark.slow

V1 = "/api/v1"
LINK = (
    '<link name="{0}"><inertial><origin xyz="0 0 0.1"/><mass value="2.0"/>'
    '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial></link>'
)
JOINT = (
    '<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/><origin xyz="0 0 0.2"/><axis xyz="{3}"/>'
    '<limit lower="-2" upper="2" effort="50" velocity="5"/></joint>'
)
URDF = (
    '<robot name="arm">'
    + "".join(LINK.format(name) for name in ("base", "arm", "hand"))
    + JOINT.format("elbow", "base", "arm", "0 1 0")
    + JOINT.format("wrist", "arm", "hand", "1 0 0")
    + "</robot>"
)
ROBOT = """version: 1
name: Two-joint arm
urdf: robot.urdf
base: fixed
base_link: base
joints:
  - {name: elbow, actuation: torque, gear_ratio: 50.0}
  - {name: wrist, actuation: torque, gear_ratio: 50.0}
"""
STUDY = """version: 1
name: Arm
robot: robot.yaml
device: device.yaml
logs:
  - {file: logs/id.csv, role: identification}
  - {file: logs/worn.csv, role: with_device}
"""
DEVICE = """version: 1
name: Elbow band
bands:
  - name: A
    via_points: [{link: base, xyz: [0.1, 0.0, 0.0]}, {link: arm, xyz: [0.05, 0.0, 0.2]}]
    stiffness_n_per_m: 150
    natural_length_m: 0.3
  - name: B
    via_points: [{link: base, xyz: [-0.1, 0.02, 0.0]}, {link: hand, xyz: [-0.05, 0.02, 0.1]}]
    stiffness_n_per_m: 100
    natural_length_m: 0.38
"""
CHANGES = [
    {"change": "stiffness", "of": "A", "to": 300},
    {"change": "move_point", "band": "B", "point": 1, "by": [0, 0, 0.02]},
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study with a device and a log that wears it; another device file lies beside."""
    root = tmp_path_factory.mktemp("whatif") / "study"
    t = np.arange(400) / 100
    columns = (t, np.sin(2 * t), 0.5 * np.sin(3 * t + 0.4), np.cos(2 * t), np.cos(3 * t))
    log = "t,q.elbow,q.wrist,tau.elbow,tau.wrist\n" + "\n".join(
        ",".join(f"{value:.6f}" for value in row) for row in zip(*columns, strict=True)
    )
    files = {
        "study.yaml": STUDY,
        "robot.yaml": ROBOT,
        "robot.urdf": URDF,
        "logs/id.csv": log,
        "logs/worn.csv": log,
        "device.yaml": DEVICE,
        "other.yaml": DEVICE.replace("150", "300").replace("Elbow band", "Other"),
    }
    for path, content in files.items():
        (root / path).parent.mkdir(exist_ok=True, parents=True)
        (root / path).write_text(content)
    return root


@pytest.fixture(scope="module")
def client(folder: Path) -> Iterator[TestClient]:
    settings = Settings(data_dir=folder.parent / "data", workers=0)
    app = create_app(settings)
    migrate_engine(settings.database_url)
    with TestClient(app, raise_server_exceptions=False) as opened:
        yield opened


@pytest.fixture(scope="module")
def study(client: TestClient, folder: Path) -> str:
    with Client("http://testserver", transport=client._transport) as service:
        return service.upload_study(folder).id


@pytest.fixture(scope="module")
def ready(folder: Path) -> Ready:
    return open_bench(folder, "worn", None)


def ask(client: TestClient, study: str, **wanted: Any) -> Any:
    return client.post(f"{V1}/studies/{study}/whatif", json={"log": "worn"} | wanted)


def test_a_question_is_answered_as_the_numerics_do_and_then_without_reading(
    client: TestClient, study: str, folder: Path
) -> None:
    first = ask(client, study, changes=CHANGES, series=True)
    assert first.status_code == 200, first.text
    again = ask(client, study, changes=CHANGES, series=True)
    times = ("elapsed_ms", "opening_ms")
    assert {**first.json(), **dict.fromkeys(times)} == {**again.json(), **dict.fromkeys(times)}
    assert again.json()["opening_ms"] < 0.2 * first.json()["opening_ms"]
    assert len(client.app.state.benches) == 1  # type: ignore[attr-defined]

    motion = read_motion(Bundle(folder, "study.yaml"), "worn")
    changes = changes_of(ChangesFile.model_validate({"version": 1, "changes": CHANGES}).changes)
    fresh = what_if(motion.tree, motion.device, apply(motion.device, changes, motion.tree), motion.q, motion.time)
    assert [(joint["joint"], joint["unit"]) for joint in first.json()["joints"]] == [("elbow", "N·m"), ("wrist", "N·m")]
    for joint, expected in zip(first.json()["joints"], fresh.joints, strict=True):
        for when in ("before", "after"):
            assert joint[when] == {key: pytest.approx(getattr(getattr(expected, when), key)) for key in joint[when]}
            torque = first.json()["series"]["joints"][joint["joint"]][when]
            np.testing.assert_allclose(torque, getattr(expected, when).torque, atol=1e-4)
        assert joint["percent"] == pytest.approx(dict(expected.percent))
    assert first.json()["main"] == ["elbow"]
    assert first.json()["interference"] == [
        {"joint": "wrist", "before": fresh.interference[0].before, "after": fresh.interference[0].after}
    ]
    assert first.json()["changed"]["bands"][0]["stiffness_n_per_m"] == 300.0


def test_a_client_asks_from_another_device_file(client: TestClient, study: str) -> None:
    with Client("http://testserver", transport=client._transport) as service:
        changed = service.what_if(study, "worn", CHANGES[:1])
        other = service.what_if(study, "worn", device="other.yaml")
        assert changed.joints[0]["after"] == pytest.approx(other.joints[0]["before"])
        assert (other.device["name"], changed.series) == ("Other", None)
        assert changed.main == ["elbow"]


FAULTS = [
    ({"log": "warn"}, "unknown_log", "log", "Did you mean 'worn'"),
    ({"log": "/etc/passwd"}, "unknown_log", "log", "Known here: id, worn"),
    ({"device": "devise.yaml"}, "missing_file", "device", "Did you mean 'device.yaml'"),
    ({"main": ["knee"]}, "unknown_joint", "main", "elbow"),
]
CHANGE_FAULTS = [
    ({"change": "stiffness", "of": "C", "to": 1}, "unknown_band", "of", "Known here: A, B"),
    ({"change": "remove_point", "band": "A", "point": 5}, "unknown_via_point", "point", "from 0"),
    ({"change": "natural_length", "of": "A", "by": -9}, "natural_length_impossible", "by", "above 0"),
]
FAULTS += [({"changes": [change]}, rule, f"changes.0.{key}", said) for change, rule, key, said in CHANGE_FAULTS]


def test_what_cannot_be_asked_is_a_problem_that_names_the_place(client: TestClient, study: str) -> None:
    for wanted, rule, column, advice in FAULTS:
        answer = ask(client, study, **wanted)
        assert answer.status_code == 422, answer.text
        assert answer.headers["content-type"] == "application/problem+json"
        (error,) = answer.json()["errors"]
        assert (error["code"], error["column"]) == (rule, column)
        assert advice in error["advice"]


@pytest.mark.parametrize(
    ("change", "pointer"),
    [
        ({"change": "stiffness", "of": "A", "to": -1}, "#/changes/0/stiffness/to"),
        ({"change": "stiffness", "of": "A", "to": 10**400}, "#/changes/0/stiffness/to"),
        ({"change": "stiffness", "of": "A"}, "#/changes/0/stiffness"),
        ({"change": "melt", "of": "A"}, "#/changes/0"),
        ({"change": "move_point", "band": "A", "point": 0, "by": [1, 2]}, "#/changes/0/move_point/by/2"),
    ],
)
def test_a_change_that_is_none_is_refused_at_its_pointer(client: TestClient, change: Any, pointer: str) -> None:
    answer = ask(client, "00000000-0000-0000-0000-000000000000", changes=[change])
    assert answer.status_code == 422
    assert answer.json()["errors"][0]["pointer"] == pointer


def test_an_unknown_study_is_not_found(client: TestClient) -> None:
    assert ask(client, "00000000-0000-0000-0000-000000000000").status_code == 404


def test_a_job_is_refused_where_its_settings_are_wrong(client: TestClient, study: str) -> None:
    wanted = {"study_id": study, "kind": "whatif", "settings": {"log": "worn", "changes": [{"change": "melt"}]}}
    answer = client.post(f"{V1}/jobs", json=wanted)
    assert answer.status_code == 422
    assert answer.json()["errors"][0]["column"].startswith("settings.changes.0")


@pytest.mark.slow
def test_a_job_takes_all_samples_and_is_no_result_of_the_study(client: TestClient, study: str, tmp_path: Path) -> None:
    with Client("http://testserver", transport=client._transport) as service:
        job = service.submit(study, "whatif", {"log": "worn", "changes": CHANGES})
        installation = client.app.state.installation  # type: ignore[attr-defined]
        lease = Lease(installation.engine, "this test", 60.0)
        lease.take()
        runner = Runner(installation, "this test", tmp_path)
        runner.run()
        runner._child.kill()  # a worker ends with its process
        lease.give_back()
        assert service.job(job).state == "succeeded", service.job(job).log
        found, at_once = service.results(job), service.what_if(study, "worn", CHANGES)
        assert found["joints"] == at_once.joints
        assert found["samples"] == found["of_samples"] == 400
        names = {artifact.name for artifact in service.artifacts(job)}
        assert names == {"what_if.json", "series/what_if.parquet", "device.yaml"}
    assert client.get(f"{V1}/studies/{study}/results").status_code == 404
    assert client.get(f"{V1}/studies/{study}").json()["latest_job"] is None


def test_what_the_reader_leaves_is_believed_only_whole(ready: Ready, tmp_path: Path) -> None:
    plain = json.loads(
        json.dumps(
            {"tree": to_plain(ready.motion.tree), "device": device_content(ready.motion.device)}
            | {key: getattr(ready.motion, key) for key in ("device_file", "log", "of_samples", "every", "cutoff_hz")}
            | {"samples": len(ready.motion.time)}
        )
    )
    table, file = np.column_stack([ready.motion.time, ready.motion.q]), tmp_path / "motion.f64"
    table.tofile(file)
    again = read_back(plain, file)
    np.testing.assert_array_equal(again.q, ready.motion.q)
    assert again.device == ready.motion.device
    for wrong in (
        {"samples": 10**9},
        {"samples": len(table) - 1},
        {"tree": plain["tree"] | {"parent": [5]}},
        {"tree": plain["tree"] | {"frames": {"base": [7, [0.0] * 12]}}},
        {"tree": plain["tree"] | {"dof": [3]}},
        {"device": {"name": "x", "bands": [{"name": "A"}]}},
    ):
        with pytest.raises((ValueError, KeyError, TypeError)):
            read_back(plain | wrong, file)
    table[3, 0] = table[2, 0]
    table.tofile(file)
    with pytest.raises(ValueError, match="time does not rise"):
        read_back(plain, file)


def test_the_cache_forgets_what_was_asked_for_least_recently(ready: Ready, monkeypatch: pytest.MonkeyPatch) -> None:
    kept = Benches(kept_bytes=int(2.5 * ready.bench.nbytes))
    made: list[str] = []

    def get(name: str) -> None:
        kept.get((name, "worn", None), lambda: made.append(name) or ready)  # type: ignore[func-returns-value]

    for name in ("a", "b", "a", "c", "a", "b"):
        get(name)
    assert made == ["a", "b", "c", "b"]
    assert len(kept) == 2
    monkeypatch.setattr(benches, "WIRE_BYTES", 10)
    with pytest.raises(TooLarge, match="whatif"):
        refuse_large(ready.motion, ready.motion.device, benches.BENCH_BYTES)
