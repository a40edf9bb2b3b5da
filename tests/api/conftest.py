"""A one-joint study on files, small enough to hand in again and again."""

from __future__ import annotations

import io
import math
import zipfile
from collections.abc import Callable, Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from fastapi.testclient import TestClient
    from tests.api.people import People

    from exogauge.settings import Settings
    from exogauge.storage.store import Storage

LINK = (
    '<link name="{0}"><inertial><origin xyz="0 0 0.1"/><mass value="2.0"/>'
    '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial></link>'
)
URDF = (
    '<robot name="arm">' + LINK.format("base") + LINK.format("arm") + '<joint name="elbow" type="revolute">'
    '<parent link="base"/><child link="arm"/><origin xyz="0 0 0.2"/><axis xyz="0 1 0"/>'
    '<limit lower="-2" upper="2" effort="50" velocity="5"/></joint></robot>'
)
ROBOT = """version: 1
name: One-joint arm
urdf: robot.urdf
base: fixed
base_link: base
joints:
  - {name: elbow, actuation: torque, gear_ratio: 50.0}
"""
STUDY = """version: 1
name: Arm
robot: robot.yaml
logs:
  - {file: logs/id.csv, role: identification}
  - {file: logs/val.csv, role: validation}
"""


def table(phase: float, samples: int = 400) -> str:
    rows = ["t,q.elbow,tau.elbow"]
    for k in range(samples):
        t = k / 100
        rows.append(f"{t:.3f},{math.sin(2 * t + phase):.6f},{1.5 * math.sin(2 * t + phase) + 0.2 * math.cos(t):.6f}")
    return "\n".join(rows) + "\n"


@pytest.fixture
def people(settings: Settings) -> Iterator[People]:
    """Of a service with accounts that other machines reach."""
    from tests.api.people import People

    from exogauge.api.app import create_app

    app = create_app(settings.model_copy(update={"accounts": True, "host": "0.0.0.0"}))
    yield People(app)
    app.state.installation.close()


@pytest.fixture
def study_files() -> dict[str, bytes]:
    """path -> content of a study that is right in every way; tests break it."""
    texts = {"study.yaml": STUDY, "robot.yaml": ROBOT, "robot.urdf": URDF}
    logs = {"logs/id.csv": table(0.0), "logs/val.csv": table(0.7)}
    return {path: text.encode() for path, text in (texts | logs).items()}


@pytest.fixture
def robot_files(study_files: dict[str, bytes]) -> dict[str, bytes]:
    return {path: study_files[path] for path in ("robot.yaml", "robot.urdf")}


def zipped(files: Mapping[str, bytes]) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, content in files.items():
            archive.writestr(zipfile.ZipInfo(path, (2026, 1, 1, 0, 0, 0)), content)
    return packed.getvalue()


@pytest.fixture
def pack() -> Callable[[Mapping[str, bytes]], bytes]:
    """A zip of path -> content, the same bytes each time."""
    return zipped


@pytest.fixture
def as_form() -> Callable[[Mapping[str, bytes]], list[tuple[str, tuple[str, bytes]]]]:
    """path -> content as the files of a multipart form."""
    return lambda files: [("files", (path, content)) for path, content in files.items()]


@pytest.fixture
def unchecked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Take the bundle at its word: for tests of everything but the reading, which takes a second per upload."""
    from exogauge.api import checking

    monkeypatch.setattr(checking, "check_study", lambda folder: {"name": "Arm", "logs": []})
    monkeypatch.setattr(checking, "check_robot", lambda folder, file="robot.yaml": {"name": "One-joint arm"})
    monkeypatch.setattr(checking, "check_device", lambda folder, robot_folder: {"name": "Elbow strap"})
    monkeypatch.setattr(checking, "check_log", lambda folder, file, mapping=None, robot=None: {"samples": 3})


@pytest.fixture
def study_id(client: TestClient, unchecked: None, study_files: dict[str, bytes]) -> str:
    answer = client.post("/api/v1/studies", files={"bundle": ("arm.zip", zipped(study_files))})
    assert answer.status_code == 201, answer.text
    key: str = answer.json()["id"]
    return key


@pytest.fixture
def finished_job(study_id: str, client: TestClient, tmp_path: Path) -> str:
    """A job that has succeeded, with results, a report and a series, as a worker leaves it."""
    from exogauge.storage.tables import Artifact, Job, Result

    storage: Storage = client.app.state.installation.of_lab("local")  # type: ignore[attr-defined]
    made = {
        "results.json": (b'{"version": 1}', "application/json"),
        "report.html": (b"<h1>report</h1><script>alert(1)</script>", "text/html"),
        "series/id.parquet": (bytes(range(256)) * 8, "application/vnd.apache.parquet"),
    }
    with storage.transaction() as store:
        now = datetime.now(UTC)
        job = Job(
            kind="evaluate", study_id=study_id, request_hash="0" * 64, state="succeeded", progress=1.0,
            started_at=now, finished_at=now,
        )  # fmt: skip
        store.session.add(job)
        store.session.flush()
        for name, (content, media_type) in made.items():
            common = {"job_id": job.id, "sha256": store.blobs.put(content), "size": len(content)}
            store.session.add(Artifact(name=name, media_type=media_type, **common))
            if name == "results.json":
                store.session.add(Result(study_id=study_id, **common))
        key: str = job.id
    return key
