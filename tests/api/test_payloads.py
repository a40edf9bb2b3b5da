"""Payloads over HTTP: checked in a child process, versioned, pinned, and never identified by the web process."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient
from tests.api.small_payload import MASS, payload_files
from tests.payload.planned import plan_yaml

from exogauge.api.app import create_app
from exogauge.payload.compute import identify
from exogauge.settings import Settings
from exogauge.storage.store import Storage
from exogauge.storage.tables import Artifact, Job, Result
from exogauge.synthetic import payload as generator

V1 = "/api/v1"
NOBODY = "00000000-0000-4000-8000-000000000000"
on_sqlite = pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
Post = Callable[[dict[str, bytes]], Any]


@pytest.fixture
def hand_in(client: TestClient, as_form: Callable[..., Any]) -> Post:
    return lambda files: client.post(f"{V1}/payloads", files=as_form(files))


@pytest.fixture(scope="module")
def handed_in(migrated_sqlite: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """A folder with a database and blobs that hold one payload, and what was answered when it was handed in."""
    folder = tmp_path_factory.mktemp("handed_in")
    shutil.copy(migrated_sqlite, folder / "test.sqlite")
    settings = Settings(data_dir=folder / "data", database_url=f"sqlite:///{folder / 'test.sqlite'}", workers=0)
    with TestClient(create_app(settings)) as client:
        form = [("files", (path, content)) for path, content in payload_files().items()]
        answer = client.post(f"{V1}/payloads", files=form)
    assert answer.status_code == 201, answer.text
    return folder, answer.json()


@pytest.fixture
def settings(request: pytest.FixtureRequest, settings: Settings, tmp_path: Path) -> Settings:
    """Where a test asks for what is `stored`, it is there: a copy, as children take seconds to read it."""
    if "stored" in request.fixturenames:
        shutil.copytree(request.getfixturevalue("handed_in")[0], tmp_path, dirs_exist_ok=True)
    return settings


@pytest.fixture
def stored(handed_in: tuple[Path, dict[str, Any]]) -> dict[str, Any]:
    return handed_in[1]


@pytest.mark.slow  # reads in child processes
def test_a_payload_is_read_pinned_and_handed_back(client: TestClient, hand_in: Post) -> None:
    files = payload_files()
    answer = hand_in(files)
    assert answer.status_code == 201, answer.text
    stored = answer.json()
    assert (stored["name"], stored["version"], stored["latest_job"]) == ("Gripper", 1, None)
    assert [(log["role"], log["samples"], log["rate_hz"]) for log in stored["summary"]["logs"]] == [
        ("postures", 12, None)
    ]
    hashes = {file["path"]: file["sha256"] for file in stored["files"]}
    assert hashes == {path: hashlib.sha256(content).hexdigest() for path, content in files.items()}
    assert client.get(f"{V1}/payloads/{stored['id']}").json() == stored
    for path, content in files.items():
        assert client.get(f"{V1}/payloads/{stored['id']}/files/{path}").content == content
    again = hand_in(files)
    assert (again.status_code, again.json()["id"]) == (200, stored["id"])
    other = hand_in(files | {"payload.yaml": files["payload.yaml"] + b"# again\n"}).json()
    assert (other["version"], other["name"]) == (2, "Gripper")
    assert [each["id"] for each in client.get(f"{V1}/payloads").json()["items"]] == [other["id"], stored["id"]]
    assert [each["id"] for each in client.get(f"{V1}/payloads?search=GRIP").json()["items"]] == [
        other["id"],
        stored["id"],
    ]


@pytest.mark.slow
@on_sqlite
@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (
            lambda files: {"logs/poses.csv": files["logs/poses.csv"].replace(b",fx,", b",f_x,")},
            {"code": "missing_column", "file": "logs/poses.csv", "column": "fx", "advice": "Did you mean 'f_x'?"},
        ),
        (
            lambda files: {"logs/poses.csv": broken_row(files["logs/poses.csv"])},
            {"code": "not_a_rotation", "file": "logs/poses.csv", "row": 3, "column": "r11"},
        ),
        (
            lambda files: {"payload.yaml": files["payload.yaml"].replace(b"sensor:", b"senzor:")},
            {"file": "payload.yaml", "advice": "sensor"},
        ),
        (
            lambda files: {"payload.yaml": files["payload.yaml"].replace(b"logs/poses.csv", b"logs/other.csv")},
            {"code": "no_file", "file": "payload.yaml", "value": "logs/other.csv"},
        ),
        (
            lambda files: {"payload.yaml": files["payload.yaml"].partition(b"logs:")[0]},
            {"code": "no_logs", "file": "payload.yaml"},
        ),
    ],
    ids=["column", "row", "key", "file", "nothing"],
)
def test_bad_input_is_refused_with_its_place(
    hand_in: Post, change: Callable[[dict[str, bytes]], dict[str, bytes]], expected: dict[str, Any]
) -> None:
    files = payload_files()
    answer = hand_in(files | change(files))
    assert answer.status_code == 422, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    wanted = expected | {"advice": expected.get("advice", "")}
    advised = (error for error in told(answer) if wanted["advice"] in (error["advice"] or ""))
    found = [error | {"advice": wanted["advice"]} for error in advised]
    assert any(wanted.items() <= error.items() for error in found), answer.text


def told(answer: Any) -> list[dict[str, Any]]:
    errors: list[dict[str, Any]] = answer.json()["errors"]
    return errors


@pytest.mark.slow
@on_sqlite
def test_logs_of_one_name_are_told_apart_and_one_log_twice_is_refused(hand_in: Post) -> None:
    files = payload_files()
    entry = b"  - {file: logs/poses.csv, role: postures, each_row: true}\n"
    other = b"  - {file: again/poses.csv, role: postures, each_row: true}\n"
    both = {"again/poses.csv": files["logs/poses.csv"]}
    answer = hand_in(files | both | {"payload.yaml": files["payload.yaml"].replace(entry, entry + other)})
    assert answer.status_code == 201, answer.text
    assert [each["name"] for each in answer.json()["summary"]["logs"]] == ["logs/poses", "again/poses"]
    answer = hand_in(files | {"payload.yaml": files["payload.yaml"].replace(entry, entry + entry)})
    assert answer.status_code == 422
    wanted = {"code": "log_twice", "file": "payload.yaml", "column": "logs[1]", "value": "logs/poses.csv"}
    assert wanted.items() <= told(answer)[0].items()
    assert "span" in told(answer)[0]["advice"]


def broken_row(table: bytes) -> bytes:
    lines = table.split(b"\n")
    cells = lines[3].split(b",")
    lines[3] = b",".join([b"0.5", *cells[1:]])
    return b"\n".join(lines)


@pytest.mark.slow
@on_sqlite
def test_a_plan_that_cannot_be_made_is_refused_when_it_is_handed_in(hand_in: Post) -> None:
    files = {"arm.urdf": generator.arm_urdf().encode(), "payload.yaml": plan_yaml(joints=["a4", "a9"]).encode()}
    answer = hand_in(files)
    assert answer.status_code == 422
    assert answer.json()["errors"][0] | {"detail": ""} == {
        "detail": "", "code": "unknown_joint", "pointer": None, "file": "payload.yaml", "row": None,
        "column": "plan.joints", "value": "a9", "advice": answer.json()["errors"][0]["advice"],
    }  # fmt: skip


@pytest.mark.slow
@on_sqlite
def test_jobs_are_of_what_their_kind_is_of(client: TestClient, stored: dict[str, Any]) -> None:
    job = client.post(f"{V1}/jobs", json={"payload_id": stored["id"], "kind": "payload"})
    assert job.status_code == 202, job.text
    assert (job.json()["payload_id"], job.json()["study_id"], job.json()["kind"]) == (stored["id"], None, "payload")
    again = client.post(f"{V1}/jobs", json={"payload_id": stored["id"], "kind": "payload"})
    assert (again.status_code, again.json()["id"]) == (200, job.json()["id"])
    other = client.post(
        f"{V1}/jobs", json={"payload_id": stored["id"], "kind": "payload", "settings": {"inclination": "fit"}}
    )
    assert (other.status_code, other.json()["settings"]) == (202, {"inclination": "fit"})
    assert client.get(f"{V1}/payloads/{stored['id']}").json()["latest_job"]["id"] == other.json()["id"]
    listed = client.get(f"{V1}/jobs", params={"payload_id": stored["id"]}).json()["items"]
    assert [each["id"] for each in listed] == [other.json()["id"], job.json()["id"]]
    for wanted, code in (
        ({"payload_id": stored["id"]}, "wrong_owner"),
        ({"study_id": stored["id"], "kind": "payload"}, "wrong_owner"),
        ({"payload_id": stored["id"], "study_id": NOBODY, "kind": "payload"}, "wrong_owner"),
        ({"payload_id": stored["id"], "kind": "payload", "settings": {"inclination": "maybe"}}, "literal_error"),
        ({"payload_id": stored["id"], "kind": "payload_plan", "settings": {"what": "postures"}}, "no_plan"),
        ({"payload_id": stored["id"], "kind": "payload_plan"}, "missing"),
    ):
        answer = client.post(f"{V1}/jobs", json=wanted)
        assert answer.status_code == 422, (wanted, answer.text)
        assert answer.json()["errors"][0]["code"] == code, answer.text
    assert client.post(f"{V1}/jobs", json={"payload_id": NOBODY, "kind": "payload"}).status_code == 404


@pytest.mark.slow
@on_sqlite
def test_what_is_not_there_is_not_found(client: TestClient, stored: dict[str, Any]) -> None:
    for path in (
        f"payloads/{NOBODY}", f"payloads/{NOBODY}/plans", f"payloads/{NOBODY}/exports/csv",
        f"payloads/{NOBODY}/results",
        f"payloads/{stored['id']}/results", f"payloads/{stored['id']}/exports/csv",
        f"payloads/{stored['id']}/files/other.csv",
    ):  # fmt: skip
        assert client.get(f"{V1}/{path}").status_code == 404, path


@pytest.fixture
def identified(client: TestClient, stored: dict[str, Any], tmp_path: Path) -> str:
    """The id of a payload whose job has ended as a worker ends it; its results are the recipe's own."""
    storage: Storage = client.app.state.installation.of_lab("local")  # type: ignore[attr-defined]
    with storage.transaction() as store:
        store.payloads.write_to(stored["id"], tmp_path / "in")
        identify(tmp_path / "in", tmp_path / "out", lambda share, doing, stage: None, {})
        content, now = (tmp_path / "out" / "results.json").read_bytes(), datetime.now(UTC)
        job = Job(
            kind="payload", payload_id=stored["id"], request_hash="0" * 64, state="succeeded", progress=1.0,
            started_at=now, finished_at=now,
        )  # fmt: skip
        store.session.add(job)
        store.session.flush()
        made = {"job_id": job.id, "sha256": store.blobs.put(content), "size": len(content)}
        store.session.add(Artifact(name="results.json", media_type="application/json", **made))
        store.session.add(Result(payload_id=stored["id"], **made))
    key: str = stored["id"]
    return key


@pytest.mark.slow
@on_sqlite
def test_results_and_exports_are_those_of_the_latest_job(client: TestClient, identified: str) -> None:
    results = client.get(f"{V1}/payloads/{identified}/results")
    mass = {each["name"]: each for each in results.json()["static"]["values"]}["m"]
    assert abs(mass["value"] - MASS) < 4 * mass["std"] < 0.2
    assert results.headers["etag"]
    ur = client.get(f"{V1}/payloads/{identified}/exports/ur")
    assert ur.status_code == 200, ur.text
    assert ur.headers["content-disposition"] == 'attachment; filename="payload.script"'
    assert f"set_target_payload({mass['value']:.9f}, [" in ur.text
    assert "frame: axes and origin of the sensor" in ur.text
    moved = client.get(f"{V1}/payloads/{identified}/exports/json", params={"flange": [0, 0, 0.05, 0, 0, 0]}).json()
    held = client.get(f"{V1}/payloads/{identified}/exports/json").json()
    z = [{each["name"]: each["value"] for each in body["values"]}["cz"] for body in (moved, held)]
    assert z[0] - z[1] == pytest.approx(0.05, abs=1e-12)
    assert moved["frame"].startswith("flange")


@on_sqlite
def test_an_export_that_cannot_be_made_says_why(client: TestClient, identified: str) -> None:
    for path, code, advice in (
        ("urdff", "unknown_format", "urdf"),
        ("urdf", "no_inertia", "excitation"),
        ("ur?flange=0&flange=0&flange=50&flange=0&flange=0&flange=0", "bad_pose", "in m"),
    ):
        answer = client.get(f"{V1}/payloads/{identified}/exports/{path}")
        assert answer.status_code == 422, answer.text
        error = answer.json()["errors"][0]
        assert error["code"] == code
        assert advice in error["advice"]
    short = client.get(f"{V1}/payloads/{identified}/exports/ur?flange=0")
    assert short.status_code == 422
    assert short.json()["errors"][0]["pointer"] == "query/flange"


@pytest.mark.slow
@on_sqlite
def test_a_payload_cannot_be_compared_with_studies_or_shown_as_one(client: TestClient, identified: str) -> None:
    job = client.get(f"{V1}/payloads/{identified}").json()["latest_job"]["id"]
    compared = client.get(f"{V1}/compare", params={"jobs": [job]})
    assert compared.status_code == 422
    assert compared.json()["errors"][0]["code"] == "no_results"
    assert client.get(f"{V1}/jobs/{job}/scenes").status_code == 404
    assert json.loads(client.get(f"{V1}/jobs/{job}/results").content)["name"] == "Gripper"


@on_sqlite
def test_a_payload_whose_pose_was_logged_has_no_robot_to_draw(client: TestClient, stored: dict[str, Any]) -> None:
    answer = client.get(f"{V1}/payloads/{stored['id']}/scene")
    assert answer.status_code == 404
    assert "names no robot" in answer.json()["detail"]


@pytest.mark.slow
@on_sqlite
def test_a_payload_with_a_plan_is_drawn_on_its_robot_once(client: TestClient, hand_in: Post) -> None:
    payload = hand_in({"arm.urdf": generator.arm_urdf().encode(), "payload.yaml": plan_yaml().encode()}).json()
    scene = client.get(f"{V1}/payloads/{payload['id']}/scene")
    assert scene.status_code == 200, scene.text
    assert scene.headers["content-type"] == "application/gzip"
    again = client.get(f"{V1}/payloads/{payload['id']}/scene", headers={"If-None-Match": scene.headers["etag"]})
    assert again.status_code == 304
