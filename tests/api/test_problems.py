"""Every refusal is a problem document with a place and a rule; no input makes the service fail."""

from __future__ import annotations

import contextlib
import io
import json
import random
import stat
import zipfile
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from fastapi.testclient import TestClient

from exogauge.api.uploads import Allowance, unpack
from exogauge.errors import BadInput
from exogauge.storage.held_files import LOCK

V1 = "/api/v1"
KEYS = {"type", "title", "status", "detail", "instance", "errors"}
ERROR_KEYS = {"detail", "code", "pointer", "file", "row", "column", "value", "advice"}
NOBODY = "00000000-0000-4000-8000-000000000000"

pytestmark = pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)


def problem(answer: Any, status: int) -> dict[str, Any]:
    """The problem document of an answer, after a look at its form."""
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    document: dict[str, Any] = answer.json()
    assert set(document) == KEYS
    assert document["status"] == status
    assert all(set(error) == ERROR_KEYS for error in document["errors"])
    return document


@pytest.mark.parametrize(
    ("method", "path", "status"),
    [
        ("GET", "/nowhere", 404),
        ("GET", f"{V1}/nowhere", 404),
        ("DELETE", f"{V1}/studies", 405),
        ("GET", f"{V1}/studies/{NOBODY}", 404),
        ("GET", f"{V1}/studies/not-an-id", 422),
        ("GET", f"{V1}/studies/%00", 422),
        ("GET", f"{V1}/robots/{NOBODY}", 404),
        ("GET", f"{V1}/devices/{NOBODY}", 404),
        ("GET", f"{V1}/logs/{NOBODY}", 404),
        ("GET", f"{V1}/studies/{NOBODY}/results", 404),
        ("GET", f"{V1}/jobs/{NOBODY}/results", 404),
        ("GET", f"{V1}/jobs/{NOBODY}/artifacts", 404),
        ("GET", f"{V1}/jobs/{NOBODY}/artifacts/report.html", 404),
        ("GET", f"{V1}/studies?limit=0", 422),
        ("GET", f"{V1}/studies?limit=many", 422),
        ("GET", f"{V1}/studies?cursor=guess", 422),
        ("GET", f"{V1}/studies?cursor=WzEsMl0=", 422),
        ("POST", f"{V1}/studies", 415),
        ("POST", f"{V1}/logs", 422),
    ],
)
def test_what_does_not_exist_or_cannot_be_understood_is_a_problem(
    client: TestClient, method: str, path: str, status: int
) -> None:
    problem(client.request(method, path), status)


@pytest.mark.parametrize(
    ("body", "place"),
    [
        ("{", "#"),
        ("[]", "#"),
        ("{}", "#/name"),
        ('{"name": "n", "robot_id": "r", "logs": [], "surprise": 1}', "#/logs"),
        ('{"name": "n", "robot_id": "r", "logs": [{"log_id": "l", "role": "spare"}]}', "#/logs/0/role"),
    ],
)
def test_bad_json_is_refused_with_a_pointer(client: TestClient, body: str, place: str) -> None:
    answer = client.post(f"{V1}/studies", content=body, headers={"content-type": "application/json"})
    pointers = [error["pointer"] for error in problem(answer, 422)["errors"]]
    assert place in pointers


def test_unknown_parts_of_a_study_are_not_found(client: TestClient) -> None:
    body = {"name": "n", "robot_id": "\x00", "logs": [{"log_id": "l", "role": "identification"}]}
    problem(client.post(f"{V1}/studies", json=body), 404)


@pytest.mark.slow  # reads in child processes
@pytest.mark.parametrize(
    ("file", "old", "new", "status", "expected"),
    [
        ("study.yaml", b"version: 1", b"version: 9", 422, {"file": "study.yaml", "row": 1, "column": "version"}),
        ("study.yaml", b"role: validation", b"role: spare", 422, {"file": "study.yaml", "row": 6}),
        ("study.yaml", b"logs/val.csv", b"../../etc/passwd", 422, {"file": "study.yaml", "row": 6}),
        ("study.yaml", b"logs/val.csv", b"logs/none.csv", 422, {"code": "missing_file"}),
        ("study.yaml", b"name: Arm", b"name: [", 422, {"file": "study.yaml"}),
        ("robot.yaml", b"elbow", b"knee", 422, {"row": 7, "column": "joints.0.name", "value": "knee"}),
        ("robot.yaml", b"base: fixed", b"base: loose", 422, {"file": "robot.yaml", "row": 4, "column": "base"}),
        ("robot.urdf", b'mass value="2.0"', b'mass value="-2.0"', 422, {"file": "robot.urdf"}),
        ("robot.urdf", b"<robot", b"<!DOCTYPE x><robot", 422, {"file": "robot.urdf"}),
        ("robot.urdf", b"</robot>", b"", 422, {"file": "robot.urdf"}),
        ("logs/id.csv", b"\n0.100,", b"\n0.100,nonsense", 422, {"file": "logs/id.csv", "row": 11, "column": "q.elbow"}),
        ("logs/id.csv", b"tau.elbow", b"tau.knee", 422, {"file": "logs/id.csv", "column": "tau.elbow"}),
    ],
)
def test_a_broken_study_is_refused_at_its_place(
    client: TestClient,
    study_files: dict[str, bytes],
    as_form: Callable[..., Any],
    file: str,
    old: bytes,
    new: bytes,
    status: int,
    expected: dict[str, Any],
) -> None:
    assert old in study_files[file]
    study_files[file] = study_files[file].replace(old, new, 1)
    document = problem(client.post(f"{V1}/studies", files=as_form(study_files)), status)
    found = [{key: error[key] for key in expected} for error in document["errors"]]
    assert expected in found, document
    assert client.get(f"{V1}/studies").json()["items"] == []


@pytest.mark.slow  # reads in child processes
def test_what_is_wrong_with_any_log_is_told_at_once(
    client: TestClient, study_files: dict[str, bytes], as_form: Callable[..., Any]
) -> None:
    study_files["logs/id.csv"] = study_files["logs/id.csv"].replace(b"\n0.100,", b"\n0.100,nonsense", 1)
    study_files["logs/val.csv"] = study_files["logs/val.csv"].replace(b"tau.elbow", b"tau.knee", 1)
    document = problem(client.post(f"{V1}/studies", files=as_form(study_files)), 422)
    found = [(error["file"], error["row"], error["column"]) for error in document["errors"]]
    assert found == [("logs/id.csv", 11, "q.elbow"), ("logs/val.csv", None, "tau.elbow")]


@pytest.mark.parametrize(
    "path", ["../evil", "/etc/passwd", "a/../../evil", "C:/evil", "a\\..\\evil", "a//b", "x/" * 20 + "y", "n" * 300]
)
def test_a_path_that_leaves_the_bundle_is_refused(
    client: TestClient, path: str, study_files: dict[str, bytes], pack: Callable[..., bytes]
) -> None:
    packed = pack(study_files | {path: b"evil"})
    document = problem(client.post(f"{V1}/studies", files={"bundle": ("study.zip", packed)}), 422)
    assert document["errors"][0]["code"] == "unsafe_path"


def test_links_bombs_twins_and_broken_zips_are_refused(client: TestClient, study_files: dict[str, bytes]) -> None:
    link = zipfile.ZipInfo("logs/link.csv")
    link.external_attr = (stat.S_IFLNK | 0o777) << 16
    cases = {
        "zip_entry_refused": zip_of([(link, b"/etc/passwd")]),
        "zip_unreadable": b"PK\x03\x04 and then nothing",
        "duplicate_path": zip_of([("a/B.csv", b"1"), ("A/b.csv", b"2")]),
        "path_clash": zip_of([("a", b"1"), ("a/b", b"2")]),
        "missing_file": zip_of([("readme.txt", b"no study")]),
    }
    for code, packed in cases.items():
        document = problem(client.post(f"{V1}/studies", files={"bundle": ("study.zip", packed)}), 422)
        assert document["errors"][0]["code"] == code


def test_a_bundle_that_unpacks_to_too_much_is_refused(client: TestClient) -> None:
    settings = client.app.state.settings  # type: ignore[attr-defined]
    small = settings.model_copy(update={"max_bundle_bytes": 100_000, "max_bundle_files": 5})
    client.app.state.settings = small  # type: ignore[attr-defined]
    bomb = zip_of([("zeros", bytes(1_000_000))])
    many = zip_of([(f"f{k}", b"") for k in range(6)])
    crowd = zip_of([(f"{k:0200}", b"") for k in range(200)])
    for packed, code in ((bomb, "bundle_too_large"), (many, "too_many_files"), (crowd, "too_many_files")):
        document = problem(client.post(f"{V1}/studies", files={"bundle": ("study.zip", packed)}), 413)
        assert document["errors"][0]["code"] == code
    assert not [path for own in small.scratch.iterdir() for path in own.iterdir() if path.name != LOCK]


def test_a_body_over_the_limit_is_a_413_problem(client: TestClient) -> None:
    files = {"file": ("big.csv", bytes(2_100_000))}
    problem(client.post(f"{V1}/logs", files=files), 413)
    problem(client.post(f"{V1}/logs", files=files, headers={"Idempotency-Key": "big"}), 413)
    kind = {"content-type": "multipart/form-data; boundary=b"}
    head = b'--b\r\nContent-Disposition: form-data; name="file"; filename="big.csv"\r\n\r\n'
    for path in ("studies", "logs"):
        endless = iter([head, *[bytes(100_000)] * 30])
        problem(client.post(f"{V1}/{path}", content=endless, headers=kind), 413)


@pytest.mark.parametrize(
    "headers",
    [{"sec-fetch-site": "cross-site"}, {"sec-fetch-site": "same-site"}, {"origin": "http://evil.example"},
     {"origin": "http://["}],
)  # fmt: skip
def test_a_page_of_another_site_can_change_nothing(client: TestClient, headers: dict[str, str]) -> None:
    problem(client.post(f"{V1}/robots", headers=headers), 403)
    assert client.get(f"{V1}/robots", headers={"sec-fetch-site": "cross-site"}).status_code == 200


def test_a_name_that_can_be_registered_is_refused_on_the_loopback(client: TestClient) -> None:
    problem(client.get(f"{V1}/studies", headers={"host": "rebound.example:8765"}), 403)
    for host in ("localhost:8765", "127.0.0.1:8765", "[::1]:8765"):
        assert client.get(f"{V1}/studies", headers={"host": host}).status_code == 200


def test_a_defect_is_told_without_its_inside(client: TestClient, monkeypatch: pytest.MonkeyPatch) -> None:
    from exogauge.storage.bundles import Bundles

    monkeypatch.setattr(Bundles, "page", lambda *_, **__: 1 / 0)
    document = problem(client.get(f"{V1}/studies"), 500)
    assert "division" not in json.dumps(document)


def test_a_robot_that_would_crash_its_reader_is_refused(
    client: TestClient, robot_files: dict[str, bytes], as_form: Callable[..., Any]
) -> None:
    body = "<inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>"
    links = "".join(f"<link name='l{k}'>{body}</link>" for k in range(4000))
    joint = "<joint name='j{0}' type='revolute'><parent link='l{0}'/><child link='l{1}'/><axis xyz='0 0 1'/>{2}</joint>"
    limit = "<limit lower='-1' upper='1' effort='1' velocity='1'/>"
    joints = "".join(joint.format(k, k + 1, limit) for k in range(3999))
    chain = f"<robot name='chain'>{links}{joints}</robot>".encode()
    answer = client.post(f"{V1}/robots", files=as_form(robot_files | {"robot.urdf": chain}))
    assert answer.status_code in (413, 422), answer.text
    assert client.get(f"{V1}/robots").json()["items"] == []


def test_a_damaged_zip_is_read_or_refused_and_nothing_else(
    database_url: str, study_files: dict[str, bytes], pack: Callable[..., bytes], tmp_path: Path
) -> None:
    whole, rng = pack(study_files), random.Random(5)
    for k in range(300):
        damaged = bytearray(whole)
        for _ in range(rng.choice((1, 1, 3, 20))):
            damaged[rng.randrange(len(damaged))] = rng.randrange(256)
        if k % 3 == 0:
            damaged = damaged[: rng.randrange(len(damaged))]
        with contextlib.suppress(BadInput):
            unpack(io.BytesIO(damaged), "study.zip", tmp_path / str(k), Allowance(1_000_000, 100))
    assert not any(path.is_symlink() for path in tmp_path.rglob("*"))


def zip_of(entries: list[tuple[Any, bytes]]) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in entries:
            archive.writestr(name, content)
    return packed.getvalue()


def test_what_refers_to_a_thing_that_is_deleted_at_this_moment_is_a_conflict(
    client: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    from exogauge.storage.webhooks import Webhooks

    monkeypatch.setattr(Webhooks, "get", lambda *_: SimpleNamespace(disabled_at=None))  # it was there just now
    problem(client.post(f"{V1}/webhooks/{NOBODY}/ping"), 409)
