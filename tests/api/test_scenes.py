"""The 3D view over HTTP: what can be looked at, one recording drawn by a real child, and the page that plays it."""

from __future__ import annotations

import gzip
import json
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np
import pytest
from fastapi.testclient import TestClient

from exogauge.api.app import create_app
from exogauge.client import Client
from exogauge.jobs.engine import migrate_engine
from exogauge.settings import Settings
from exogauge.storage.store import Storage
from exogauge.studies.series.write import Columns

pytestmark = pytest.mark.slow

V1 = "/api/v1"
LINK = (
    '<link name="{0}"><inertial><origin xyz="0 0 0.1"/><mass value="2.0"/>'
    '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial></link>'
)
URDF = (
    '<robot name="arm">' + LINK.format("base") + LINK.format("arm") + '<joint name="elbow" type="revolute">'
    '<parent link="base"/><child link="arm"/><origin xyz="0 0 0.2"/><axis xyz="0 1 0"/>'
    '<limit lower="-2" upper="2" effort="50" velocity="5"/></joint></robot>'
)
STUDY = """version: 1
name: Arm
robot: robot.yaml
device: device.yaml
logs:
  - {file: logs/id.csv, role: identification}
  - {file: logs/worn.csv, role: with_device, motion: lift}
"""
FILES = {
    "study.yaml": STUDY,
    "robot.yaml": "version: 1\nname: Arm\nurdf: robot.urdf\nbase: fixed\nbase_link: base\n"
    "joints:\n  - {name: elbow, actuation: torque, gear_ratio: 50.0}\n",
    "robot.urdf": URDF,
    "device.yaml": "version: 1\nname: Band\nbands:\n  - name: A\n    via_points: [{link: base, xyz: [0.1, 0, 0]}, "
    "{link: arm, xyz: [0.05, 0, 0.2]}]\n    stiffness_n_per_m: 150\n    natural_length_m: 0.3\n",
}
T = np.arange(401) / 100
Q = np.sin(2 * T)


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    settings = Settings(data_dir=tmp_path_factory.mktemp("scenes") / "data", workers=0)
    app = create_app(settings)
    migrate_engine(settings.database_url)
    with TestClient(app, raise_server_exceptions=False) as opened:
        yield opened


@pytest.fixture(scope="module")
def job(client: TestClient, tmp_path_factory: pytest.TempPathFactory) -> str:
    """A finished job on a study whose log `worn` has a series; `id` has none."""
    folder: Path = tmp_path_factory.mktemp("study")
    (folder / "logs").mkdir()
    log = "t,q.elbow,tau.elbow\n" + "".join(f"{t:.3f},{q:.6f},{10 * q:.6f}\n" for t, q in zip(T, Q, strict=True))
    for path, content in (FILES | {"logs/id.csv": log, "logs/worn.csv": log}).items():
        (folder / path).write_text(content)
    with Client("http://testserver", transport=client._transport) as service:
        study = service.upload_study(folder).id
    return finished(client.app.state.installation.of_lab("local"), study)  # type: ignore[attr-defined]


def finished(storage: Storage, study: str) -> str:
    import io

    import pyarrow.parquet as pq

    from exogauge.storage.tables import Artifact, Job, Result

    columns, sink = Columns(T), io.BytesIO()
    columns.add("measured.tau.elbow", 10 * Q, "N·m")
    columns.add("band.A.tension", np.where(T < 2, 0.0, 8.0), "N")
    pq.write_table(columns.table({"log": "worn"}), sink)
    findings = [{"effect": "stribeck", "where": {"joint": "elbow"}}]
    results = json.dumps({"version": 1, "discrepancy": {"findings": findings}}).encode()
    with storage.transaction() as store:
        now = datetime.now(UTC)
        job = Job(kind="evaluate", study_id=study, request_hash="0", state="succeeded", started_at=now, finished_at=now)
        store.session.add(job)
        store.session.flush()
        for name, content in (("results.json", results), ("series/worn.parquet", sink.getvalue())):
            common = {"job_id": job.id, "sha256": store.blobs.put(content), "size": len(content)}
            store.session.add(Artifact(name=name, media_type="application/octet-stream", **common))
            if name == "results.json":
                store.session.add(Result(study_id=study, **common))
        key: str = job.id
    return key


def header(packed: bytes) -> dict[str, Any]:
    data = gzip.decompress(packed)
    said: dict[str, Any] = json.loads(data[8 : 8 + int.from_bytes(data[:8], "little")])
    return said


def test_the_list_maps_frames_to_the_logs_own_time(client: TestClient, job: str) -> None:
    (scene,) = client.get(f"{V1}/jobs/{job}/scenes").json()["items"]
    assert (scene["log"], scene["role"], scene["motion"], scene["samples"]) == ("worn", "with_device", "lift", 401)
    assert scene["start"] == 0.0
    assert scene["start"] + (scene["frames"] - 1) / scene["fps"] == pytest.approx(scene["end"]) == pytest.approx(4.0)


def test_a_recording_shows_what_the_job_found_and_is_drawn_once(client: TestClient, job: str) -> None:
    (listed,) = client.get(f"{V1}/jobs/{job}/scenes").json()["items"]
    answer = client.get(f"{V1}/jobs/{job}/scenes/worn.scene")
    assert answer.status_code == 200, answer.text
    said = header(answer.content)
    assert {key: said[key] for key in ("start", "end", "fps", "frames")} == {
        key: listed[key] for key in ("start", "end", "fps", "frames")
    }
    scales = {entry["label"]: (entry.get("high"), entry["size"]) for entry in said["legend"]}
    assert scales == {
        "band tension": (10.0, ""),
        "slack band": (None, "dashed"),
        "joint torque": (None, "¾ turn = 10 N·m"),
    }
    assert said["marked"] == [{"joint": "elbow", "effect": "Stribeck friction"}]
    assert said["notes"][0] == "The base is fixed."
    again = client.get(f"{V1}/jobs/{job}/scenes/worn.scene", headers={"If-None-Match": answer.headers["etag"]})
    assert again.status_code == 304
    kept = list((client.app.state.settings.data_dir / "scenes").iterdir())  # type: ignore[attr-defined]
    assert len(kept) == 1
    kept[0].write_bytes(b"kept")
    assert client.get(f"{V1}/jobs/{job}/scenes/worn.scene").content == b"kept"


@pytest.mark.parametrize("path", ["jobs/{0}/scenes", "jobs/{0}/scenes/worn.scene"])
def test_an_unknown_job_has_no_scenes(client: TestClient, path: str) -> None:
    answer = client.get(f"{V1}/{path.format(uuid4())}")
    assert answer.status_code == 404
    assert answer.headers["content-type"] == "application/problem+json"


@pytest.mark.parametrize("name", ["id", "nothing", "..%2F..%2Fetc%2Fpasswd", "%00"])
def test_only_logs_that_the_job_evaluated_can_be_asked_for(client: TestClient, job: str, name: str) -> None:
    assert client.get(f"{V1}/jobs/{job}/scenes/{name}.scene").status_code in (404, 422)


def test_a_stored_device_is_drawn_on_its_robot(client: TestClient) -> None:
    parts = [("files", (name, FILES[name].encode())) for name in ("robot.yaml", "robot.urdf")]
    robot = client.post(f"{V1}/robots", files=parts).json()["id"]
    made = client.post(f"{V1}/devices", files=[("files", ("device.yaml", FILES["device.yaml"].encode()))],
                       data={"robot": robot})  # fmt: skip
    assert made.status_code == 201, made.text
    answer = client.get(f"{V1}/devices/{made.json()['id']}/scene")
    assert answer.status_code == 200, answer.text
    points = header(answer.content)["points"]
    assert [(point["link"], point["position"]) for point in points] == [("base", [0.1, 0, 0]), ("arm", [0.05, 0, 0.2])]
    alone = client.get(f"{V1}/robots/{robot}/scene")
    assert header(alone.content)["points"] == []
    for path in (f"robots/{uuid4()}/scene", f"devices/{uuid4()}/scene"):
        assert client.get(f"{V1}/{path}").status_code == 404


def test_the_player_may_be_framed_by_our_page_and_reach_nothing(client: TestClient) -> None:
    answer = client.get(f"{V1}/scenes/player")
    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith("text/html")
    policy = answer.headers["content-security-policy"]
    assert "connect-src data: blob:;" in policy
    assert "frame-ancestors 'self'" in policy
    assert policy.endswith("sandbox allow-scripts")
