"""From upload to what a list shows, with everything real: child processes, database, blobs."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient

V1 = "/api/v1"


@pytest.mark.slow  # reads in child processes
def test_a_study_is_handed_in_pinned_and_listed(
    client: TestClient, study_files: dict[str, bytes], pack: Callable[..., bytes]
) -> None:
    folder = {f"my study/{path}": content for path, content in study_files.items()}
    answer = client.post(f"{V1}/studies", files={"bundle": ("arm.zip", pack(folder))})
    assert answer.status_code == 201, answer.text
    study = answer.json()
    assert study["name"] == "Arm"
    assert study["summary"]["robot"]["joints"] == ["elbow"]
    assert [(log["role"], log["samples"]) for log in study["summary"]["logs"]] == [
        ("identification", 400),
        ("validation", 400),
    ]
    hashes = {file["path"]: file["sha256"] for file in study["files"]}
    assert hashes == {path: hashlib.sha256(content).hexdigest() for path, content in study_files.items()}
    assert client.get(f"{V1}/studies/{study['id']}").json() == study
    assert [item["id"] for item in client.get(f"{V1}/studies").json()["items"]] == [study["id"]]

    again = client.post(f"{V1}/studies", files={"bundle": ("arm.zip", pack(study_files))})
    assert again.status_code == 200
    assert again.json()["id"] == study["id"]


@pytest.mark.slow  # reads in child processes
@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_a_study_can_be_put_together_from_a_robot_and_logs(
    client: TestClient, study_files: dict[str, bytes], robot_files: dict[str, bytes], as_form: Callable[..., Any]
) -> None:
    robot = client.post(f"{V1}/robots", files=as_form(robot_files))
    assert robot.status_code == 201, robot.text
    assert robot.json()["version"] == 1
    ids = []
    for path in ("logs/id.csv", "logs/val.csv"):
        log = client.post(f"{V1}/logs", files={"file": (path.split("/")[1], study_files[path])})
        assert log.status_code == 201, log.text
        assert log.json()["sha256"] == hashlib.sha256(study_files[path]).hexdigest()
        assert log.json()["summary"]["channels"] == ["q.elbow", "tau.elbow"]
        ids.append(log.json()["id"])
    logs = [{"log_id": ids[0], "role": "identification"}, {"log_id": ids[1], "role": "validation", "rows": [0, 300]}]
    wanted = {"name": "From parts", "robot_id": robot.json()["id"], "logs": logs, "settings": {"cutoff_hz": 8}}
    study = client.post(f"{V1}/studies", json=wanted)
    assert study.status_code == 201, study.text
    assert [log["samples"] for log in study.json()["summary"]["logs"]] == [400, 300]
    paths = [file["path"] for file in study.json()["files"]]
    assert paths == ["logs/0/id.csv", "logs/1/val.csv", "robot.urdf", "robot.yaml", "study.yaml"]


def test_other_files_under_the_same_robot_name_are_its_next_version(
    client: TestClient, unchecked: None, robot_files: dict[str, bytes], as_form: Callable[..., Any]
) -> None:
    first = client.post(f"{V1}/robots", files=as_form(robot_files)).json()
    same = client.post(f"{V1}/robots", files=as_form(robot_files))
    other = client.post(f"{V1}/robots", files=as_form(robot_files | {"robot.urdf": b"<robot/>"})).json()
    assert (same.status_code, same.json()["id"]) == (200, first["id"])
    assert (first["version"], other["version"]) == (1, 2)


MAPPING = b"""version: 1
files:
  - file: vendor.csv
    time: {column: ms, unit: ms}
    columns:
      angle: {channel: q.elbow, unit: deg}
"""


@pytest.mark.slow
@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_a_log_with_a_mapping_keeps_both(client: TestClient) -> None:
    table = b"ms,angle\n" + b"".join(b"%d,%d\n" % (10 * k, k % 7) for k in range(100))
    files = {"file": ("vendor.csv", table), "mapping": ("mapping.yaml", MAPPING)}
    answer = client.post(f"{V1}/logs", files=files)
    assert answer.status_code == 201, answer.text
    assert answer.json()["summary"]["channels"] == ["q.elbow"]
    assert answer.json()["mapping_sha256"] == hashlib.sha256(MAPPING).hexdigest()
