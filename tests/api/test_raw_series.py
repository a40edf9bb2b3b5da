"""Logs of a study as they were read, for plots: before any job, and after one that failed."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from tests.api.conftest import LINK, table

from exogauge.storage.files import PinnedFile

if TYPE_CHECKING:
    from fastapi.testclient import TestClient

    from exogauge.storage.store import Storage

V1 = "/api/v1"
pytestmark = [pytest.mark.slow, pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)]


@pytest.fixture
def hand_in(client: TestClient, pack: Callable[..., bytes]) -> Callable[[dict[str, bytes]], str]:
    def post(files: dict[str, bytes]) -> str:
        answer = client.post(f"{V1}/studies", files={"bundle": ("arm.zip", pack(files))})
        assert answer.status_code == 201, answer.text
        key: str = answer.json()["id"]
        return key

    return post


def logged() -> dict[str, np.ndarray]:
    """What the log `id` was made of, by column."""
    head, *rows = csv.reader(io.StringIO(table(0.0)))
    return dict(zip(head, np.array(rows, np.float64).T, strict=True))


def test_a_log_is_drawn_before_any_job_and_after_one_that_failed(
    client: TestClient, hand_in: Callable[..., str], study_files: dict[str, bytes]
) -> None:
    from exogauge.storage.tables import Job

    study = hand_in(study_files)
    raw = f"{V1}/studies/{study}/series/id"
    facts = client.get(raw).json()
    assert (facts["samples"], facts["start"], facts["end"], facts["log"]) == (400, 0.0, 3.99, "id")
    assert [(each["name"], each["unit"]) for each in facts["channels"]] == [("q.elbow", "rad"), ("tau.elbow", "N·m")]
    storage: Storage = client.app.state.installation.of_lab("local")  # type: ignore[attr-defined]
    with storage.transaction() as store:
        store.session.add(Job(kind="evaluate", study_id=study, request_hash="0", state="failed", reason="no"))
        table_file = store.studies.file(study, "logs/id.csv")
    (storage.blobs.path_for(table_file.sha256) or raise_missing()).unlink()  # what was read once is kept
    tiles = client.get(f"{raw}/tiles", params={"channels": ["q.elbow", "tau.elbow"], "width": 1000}).json()
    values = logged()
    assert tiles["t"] == values["t"].tolist()
    assert tiles["channels"]["q.elbow"]["min"] == tiles["channels"]["q.elbow"]["max"] == values["q.elbow"].tolist()
    assert tiles["channels"]["tau.elbow"]["max"] == values["tau.elbow"].tolist()
    window = client.get(f"{raw}/window", params={"channels": "q.elbow", "start": 1.0, "end": 2.0})
    rows = [[float(cell) for cell in row] for row in list(csv.reader(io.StringIO(window.text)))[1:]]
    inside = (values["t"] >= 1.0) & (values["t"] <= 2.0)
    assert rows == np.column_stack([values["t"], values["q.elbow"]])[inside].tolist()


def test_a_joint_that_slides_has_metres_and_newtons(
    client: TestClient, hand_in: Callable[..., str], study_files: dict[str, bytes]
) -> None:
    urdf = study_files["robot.urdf"].replace(b'type="revolute"', b'type="prismatic"')
    study = hand_in(study_files | {"robot.urdf": urdf})
    channels = client.get(f"{V1}/studies/{study}/series/val").json()["channels"]
    assert {each["name"]: each["unit"] for each in channels} == {"q.elbow": "m", "tau.elbow": "N"}


def test_a_robot_that_floats_is_drawn_and_each_joint_keeps_its_own_unit(
    client: TestClient, hand_in: Callable[..., str]
) -> None:
    """Four bodies, three joints; the URDF has them in another order than robot.yaml and the log."""
    study = hand_in(floating_files())
    facts = client.get(f"{V1}/studies/{study}/series/id").json()
    units = {each["name"]: each["unit"] for each in facts["channels"]}
    assert {name: unit for name, unit in units.items() if name[0] in "qt"} == {
        "q.waist": "rad", "q.lift": "m", "q.neck": "rad", "tau.waist": "N·m", "tau.lift": "N", "tau.neck": "N·m",
    }  # fmt: skip
    assert (units["acc.x"], units["gyro.z"], units["ft.sole.fz"], units["ft.sole.mx"]) == ("m/s²", "rad/s", "N", "N·m")
    tiles = client.get(f"{V1}/studies/{study}/series/id/tiles", params={"channels": ["q.lift"], "width": 1000}).json()
    assert tiles["channels"]["q.lift"]["max"] == pytest.approx([0.1 * math.sin(0.02 * k) for k in range(300)])


def floating_files() -> dict[str, bytes]:
    """A torso on a foot's sensor that turns at the waist, lifts a slide and nods."""

    def joint(name: str, kind: str, child: str) -> str:
        return (
            f'<joint name="{name}" type="{kind}"><parent link="body"/><child link="{child}"/><axis xyz="0 1 0"/>'
            '<limit lower="-2" upper="2" effort="50" velocity="5"/></joint>'
        )

    links = "".join(LINK.format(name) for name in ("body", "head", "trunk", "tray")) + '<link name="sole"/>'
    order = (("neck", "revolute", "head"), ("waist", "revolute", "trunk"), ("lift", "prismatic", "tray"))
    joints = "".join(joint(*each) for each in order)
    joints += '<joint name="ankle" type="fixed"><parent link="body"/><child link="sole"/></joint>'
    robot = {
        "version": 1, "urdf": "robot.urdf", "base": "floating", "base_link": "body", "imu": {"frame": "body"},
        "ft_sensors": [{"name": "sole", "frame": "sole", "role": "contact", "sees": "world_on_robot"}],
        "joints": [{"name": name, "actuation": "torque"} for name in ("waist", "lift", "neck")],
    }  # fmt: skip
    others = [f"{kind}.{axis}" for kind in ("acc", "gyro") for axis in "xyz"]
    others += [f"ft.sole.{axis}" for axis in ("fx", "fy", "fz", "mx", "my", "mz")]
    names = ["t", *(f"{kind}.{name}" for name in ("waist", "lift", "neck") for kind in ("q", "tau")), *others]
    rows = [",".join(names)]
    for k in range(300):
        t, swing = 0.01 * k, 0.1 * math.sin(0.02 * k)
        rows.append(",".join(map(repr, [t, 0.2 * swing, 1.0, swing, 2.0, 0.5 * swing, 3.0, *[0.01] * len(others)])))
    logs = [{"file": "logs/id.csv", "role": "identification"}]
    study = {"version": 1, "name": "On one foot", "robot": "robot.yaml", "logs": logs}
    texts = {
        "study.yaml": json.dumps(study),
        "robot.yaml": json.dumps(robot),
        "robot.urdf": f'<robot name="nodder">{links}{joints}</robot>',
        "logs/id.csv": "\n".join(rows) + "\n",
    }
    return {path: text.encode() for path, text in texts.items()}


def test_what_is_wrong_with_a_log_is_told_and_no_other_file_is_reached(
    client: TestClient, study_files: dict[str, bytes]
) -> None:
    files = study_files | {"logs/val.csv": b"t,q.elbow,tau.elbow\n0,0,0\n0.01,x,0\n"}
    storage: Storage = client.app.state.installation.of_lab("local")  # type: ignore[attr-defined]
    logs = [{"name": "id", "file": ["logs/id.csv"]}, {"name": "val", "file": ["logs/val.csv"]}]
    with storage.transaction() as store:
        pinned = [PinnedFile(path, store.blobs.put(data), len(data)) for path, data in files.items()]
        study, _ = store.studies.add("never checked", pinned, {"logs": logs})
    refused = client.get(f"{V1}/studies/{study.id}/series/val")
    assert refused.status_code == 422
    fault: dict[str, Any] = refused.json()["errors"][0]
    assert (fault["file"], fault["row"], fault["column"], fault["value"]) == ("logs/val.csv", 2, "q.elbow", "x")
    assert client.get(f"{V1}/studies/{study.id}/series/id").status_code == 200
    for name in ("study.yaml", "nothing", "logs%2Fval.csv"):
        missing = client.get(f"{V1}/studies/{study.id}/series/{name}")
        assert missing.status_code in (404, 422), name
    assert "it has id, val" in client.get(f"{V1}/studies/{study.id}/series/nothing").json()["detail"]


def raise_missing() -> Any:
    raise AssertionError("the blob has no path")
