"""A payload put together step by step: looked at, checked, kept, taken up again."""

from __future__ import annotations

import base64
from collections.abc import Callable
from typing import Any

import pytest
from fastapi.testclient import TestClient
from tests.api.small_payload import YAML, payload_files
from tests.payload.planned import plan_yaml

from exogauge.synthetic import payload as generator

V1 = "/api/v1"
on_sqlite = pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)  # what a child reads


@pytest.fixture
def uploaded(client: TestClient) -> Callable[[str, bytes], str]:
    """The id of what was sent by tus."""

    def send(name: str, content: bytes) -> str:
        told = {"Tus-Resumable": "1.0.0", "Upload-Length": str(len(content)),
                "Upload-Metadata": f"filename {base64.b64encode(name.encode()).decode()}"}  # fmt: skip
        place = client.post(f"{V1}/uploads", headers=told).headers["Location"]
        piece = {"Tus-Resumable": "1.0.0", "Upload-Offset": "0", "Content-Type": "application/offset+octet-stream"}
        assert (
            client.patch(f"{V1}/uploads/{place.rsplit('/', 1)[1]}", headers=piece, content=content).status_code == 204
        )
        return place.rsplit("/", 1)[1]

    return send


@pytest.mark.slow
@on_sqlite
def test_a_urdf_tells_its_joints_and_frames_and_a_log_its_columns(
    client: TestClient, uploaded: Callable[[str, bytes], str]
) -> None:
    rows = "\n".join(f"{10 * k},{k / 9},{k},1.5" for k in range(50))
    log = f"stamp_ms,a1_position [deg],force_x [N],note\n{rows}\n".encode()
    keys = [uploaded("arm.urdf", generator.arm_urdf().encode()), uploaded("log.csv", log)]
    seen = client.post(f"{V1}/payloads/look", json={"upload_ids": keys, "paths": ["arm.urdf", "logs/log.csv"]}).json()
    (robot,), (found,) = seen["robots"], seen["logs"]
    assert seen["errors"] == []
    assert [joint["name"] for joint in robot["joints"]] == list(generator.JOINTS)
    assert robot["joints"][0]["upper"] == 6.1
    assert "ft" in robot["frames"]
    assert robot["fixed"] == ["base"]
    channels = {each["name"]: each["suggestion"] and each["suggestion"]["channel"] for each in found["columns"]}
    assert channels == {
        "stamp_ms": "t", "a1_position [deg]": "q.a1", "force_x [N]": "ft.sensor.fx", "note": None,
    }  # fmt: skip


@on_sqlite
def test_a_file_that_cannot_be_read_is_told_beside_those_that_can(
    client: TestClient, uploaded: Callable[[str, bytes], str]
) -> None:
    keys = [uploaded("arm.urdf", b"<robot"), uploaded("log.csv", b"t,fx\n0,1\n1,2\n")]
    seen = client.post(f"{V1}/payloads/look", json={"upload_ids": keys, "paths": ["arm.urdf", "log.csv"]}).json()
    assert [each["file"] for each in seen["errors"]] == ["arm.urdf"]
    assert [each["file"] for each in seen["logs"]] == ["log.csv"]


@pytest.mark.slow  # reads in child processes
def test_a_draft_is_checked_kept_and_taken_up_again_without_its_files_being_sent_twice(
    client: TestClient, uploaded: Callable[[str, bytes], str]
) -> None:
    poses = payload_files()["logs/poses.csv"]
    draft = {"upload_ids": [uploaded("poses.csv", poses)], "paths": ["logs/poses.csv"]}
    wrong = client.post(f"{V1}/payloads/check", json=draft | {"text": YAML.replace("fx, fy", "f_x, fy")}).json()
    assert wrong["summary"] is None
    assert [(each["file"], each["column"]) for each in wrong["errors"]] == [("logs/poses.csv", "f_x")]
    right = client.post(f"{V1}/payloads/check?doctor=true", json=draft | {"text": YAML}).json()
    assert right["errors"] == []
    assert right["summary"]["logs"][0]["samples"] == 12
    assert isinstance(right["findings"], list)
    kept = client.post(f"{V1}/payloads/from-draft", json=draft | {"text": YAML})
    assert kept.status_code == 201, kept.text
    base = {"base_id": kept.json()["id"], "keep": ["logs/poses.csv"]}
    again = client.post(f"{V1}/payloads/from-draft", json=base | {"text": YAML + "ground_truth: {mass_kg: 3.2}\n"})
    assert (again.json()["version"], again.json()["name"]) == (2, "Gripper")
    files = {file["path"] for file in again.json()["files"]}
    assert files == {"payload.yaml", "logs/poses.csv"}
    assert client.post(f"{V1}/payloads/from-draft", json=draft | {"text": YAML}).status_code == 404  # used up


@on_sqlite
@pytest.mark.parametrize(
    ("draft", "status"),
    [
        ({"keep": ["logs/poses.csv"], "text": YAML}, 422),
        ({"base_id": "00000000-0000-4000-8000-000000000000", "text": YAML}, 422),
        ({"base_id": "00000000-0000-4000-8000-000000000000", "keep": ["x"], "text": YAML}, 404),
        ({"paths": ["x"], "text": YAML}, 422),
        ({}, 422),
    ],
)
def test_a_draft_of_nothing_is_refused(client: TestClient, draft: dict[str, Any], status: int) -> None:
    assert client.post(f"{V1}/payloads/from-draft", json=draft).status_code == status


@pytest.mark.slow
@on_sqlite
def test_a_plan_without_logs_is_a_payload(client: TestClient, uploaded: Callable[[str, bytes], str]) -> None:
    key = uploaded("arm.urdf", generator.arm_urdf().encode())
    draft = {"upload_ids": [key], "paths": ["arm.urdf"], "text": plan_yaml()}
    assert client.post(f"{V1}/payloads/check", json=draft).json()["errors"] == []
    wrong = client.post(f"{V1}/payloads/check", json=draft | {"text": plan_yaml(home={"a1": 0.0})}).json()
    assert wrong["errors"][0]["column"] == "plan.home"


@pytest.mark.slow
@on_sqlite
def test_what_the_doctor_finds_stands_with_the_payload(client: TestClient, as_form: Callable[..., Any]) -> None:
    files = payload_files()
    files["payload.yaml"] += b"# rated for less than it bears\n"
    text = files["payload.yaml"].replace(
        b"sensor:\n", b"sensor:\n  range: {force_n: [10, 10, 10], moment_nm: [9, 9, 9]}\n"
    )
    stored = client.post(f"{V1}/payloads", files=as_form(files | {"payload.yaml": text})).json()
    found = stored["summary"]["findings"]
    assert {(each["log"], each["rule"], each["severity"]) for each in found} >= {("poses", "saturated", "error")}
    assert client.get(f"{V1}/payloads/{stored['id']}").json()["summary"]["findings"] == found
