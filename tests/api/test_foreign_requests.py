"""Requests as scripts send them that were not written with this service: each is understood, or told what is wrong
with it; none is taken for another."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable, Mapping
from typing import Any

import pytest
from fastapi.testclient import TestClient
from tests.api.test_problems import NOBODY, problem

V1 = "/api/v1"
JSON = {"Content-Type": "application/json"}
JOB = json.dumps({"study_id": NOBODY})
TUS = {"Tus-Resumable": "1.0.0"}

pytestmark = pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-32"])
@pytest.mark.parametrize("path", ["jobs", "studies"])
def test_json_in_any_unicode_is_read(client: TestClient, path: str, encoding: str) -> None:
    """PowerShell and .NET write byte order marks and UTF-16."""
    answer = client.post(f"{V1}/{path}", content='{"study_id": 3}'.encode(encoding), headers=JSON)
    assert "json_invalid" not in {error["code"] for error in problem(answer, 422)["errors"]}


@pytest.mark.parametrize("path", ["jobs", "studies"])
@pytest.mark.parametrize(
    ("body", "told"),
    [
        (b'{"kind": "evaluate", "kind": "support"}', "'kind' stands twice"),
        (b'{"kind": NaN}', "NaN stands in it"),
        (b'{"settings": {"x": -Infinity}}', "-Infinity stands in it"),
        (b'{"settings": {"x": 1e999}}', "1e999 is too large"),
        (b'{"settings": {"x": ' + b"9" * 5000 + b"}}", "too many digits"),
        (b"[" * 100_000, "too deeply nested"),
        (b'{"kind": "\xe4"}', "byte 10 is no UTF-8"),
        (b'{"kind": "evaluate"\n "study_id": 1}', "in line 2, column 2"),
    ],
)
def test_json_with_no_one_meaning_is_refused_at_its_place(
    client: TestClient, path: str, body: bytes, told: str
) -> None:
    answer = problem(client.post(f"{V1}/{path}", content=body, headers=JSON), 422)
    assert told in answer["detail"]
    assert [(error["code"], error["pointer"]) for error in answer["errors"]] == [("json_invalid", "#")]


@pytest.mark.parametrize("kind", ["", "text/plain", "application/x-www-form-urlencoded", "nonsense"])
def test_json_under_another_name_is_told_its_name(client: TestClient, kind: str) -> None:
    """`curl -d`, `Invoke-RestMethod -Body` and `fetch` without headers."""
    answer = problem(client.post(f"{V1}/jobs", content=JOB, headers={"Content-Type": kind}), 415)
    assert "`Content-Type: application/json`" in answer["detail"]
    assert problem(client.post(f"{V1}/jobs", content=JOB, headers={"Content-Type": "application/x+json"}), 404)
    assert "multipart/form-data" in problem(client.post(f"{V1}/logs", content=b"t;q", headers=JSON), 415)["detail"]


@pytest.mark.parametrize("path", ["jobs", "studies", f"uploads/{NOBODY}"])
def test_a_packed_body_is_not_taken_for_a_plain_one(client: TestClient, path: str) -> None:
    packed = {"Content-Encoding": "gzip", **JSON, **TUS}
    answer = client.request(
        "PATCH" if "uploads" in path else "POST", f"{V1}/{path}", content=b"\x1f\x8b", headers=packed
    )
    assert "gzip" in problem(answer, 415)["detail"]
    assert answer.headers["accept-encoding"] == "identity"
    assert client.post(f"{V1}/jobs", content=JOB, headers={**JSON, "Content-Encoding": "identity"}).status_code == 404


def form(*parts: tuple[bytes, bytes], end: bytes = b"--x--\r\n") -> dict[str, Any]:
    """What `post` takes; parts: what follows `form-data; `, and content."""
    said = [b"--x\r\nContent-Disposition: form-data; " + head + b"\r\n\r\n" + body + b"\r\n" for head, body in parts]
    return {"content": b"".join(said) + end, "headers": {"Content-Type": "multipart/form-data; boundary=x"}}


@pytest.mark.parametrize(
    "name",
    [
        b"filename*=UTF-8''st%C3%BCdy.csv",
        b"filename=\"=?utf-8?B?c3TDvGR5LmNzdg==?=\"; filename*=utf-8''st%C3%BCdy.csv",
        b"filename*=iso-8859-1'de'st%FCdy.csv",
        'filename="stüdy.csv"'.encode(),
        b'filename="C:\\\\data\\\\st\xc3\xbcdy.csv"',
    ],
)
def test_a_file_keeps_its_name_however_it_is_written(client: TestClient, unchecked: None, name: bytes) -> None:
    answer = client.post(f"{V1}/logs", **form((b'name="file"; ' + name, b"t,q\n0,1\n")))
    assert answer.status_code == 201, answer.text
    assert answer.json()["name"] == "stüdy.csv"


def test_folders_by_backslashes_are_folders(client: TestClient, unchecked: None, study_files: dict[str, bytes]) -> None:
    """As scripts on Windows name files."""
    parts = [
        (b'name="files"; filename="%s"' % path.replace("/", "\\").encode(), body) for path, body in study_files.items()
    ]
    made = client.post(f"{V1}/studies", **form(*parts))
    assert made.status_code == 201, made.text
    assert {file["path"] for file in made.json()["files"]} == set(study_files)
    for bad in (b"..\\study.yaml", b"logs\\..\\..\\study.yaml"):
        problem(client.post(f"{V1}/studies", **form((b'name="files"; filename="' + bad + b'"', b"x"))), 422)


@pytest.mark.parametrize(("system", "status"), [(0, 201), (3, 422)])
def test_a_zip_that_old_net_made_keeps_its_folders(
    client: TestClient, unchecked: None, study_files: dict[str, bytes], system: int, status: int
) -> None:
    """Where a name may hold a backslash (3: Unix), it is refused as before."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for name, content in {"logs/": b"", **study_files}.items():
            entry = zipfile.ZipInfo(name.replace("/", "\\"))
            entry.create_system = system
            archive.writestr(entry, content)
    made = client.post(f"{V1}/studies", files={"files": ("study.zip", packed.getvalue())})
    assert made.status_code == status, made.text
    if status == 201:
        assert {file["path"] for file in made.json()["files"]} == set(study_files)


@pytest.mark.parametrize(
    ("made", "told"),
    [
        (lambda one: form(one, one, end=b""), "did not arrive whole"),
        (lambda one: {**form(one), "headers": {"Content-Type": "multipart/form-data; boundary=y"}}, "boundary"),
        (lambda one: form((one[0] + b"\r\nContent-Transfer-Encoding: base64", one[1])), "base64"),
    ],
)
def test_a_form_that_would_lose_a_file_is_refused(
    client: TestClient, pack: Callable[[Mapping[str, bytes]], bytes], unchecked: None, study_files: dict[str, bytes],
    made: Callable[[tuple[bytes, bytes]], dict[str, Any]], told: str,
) -> None:  # fmt: skip
    """Cut off at a part's end it looks like a smaller form."""
    whole = (b'name="files"; filename="study.zip"', pack(study_files))
    assert told in problem(client.post(f"{V1}/studies", **made(whole)), 400)["detail"]
    assert client.post(f"{V1}/studies", **form(whole)).status_code == 201


@pytest.mark.parametrize(
    "path", ["jobs?study=1", "jobs?states=running", "studies?name=a", "jobs?limit=3&since=2026-01-01"]
)
def test_a_misspelt_filter_does_not_list_everything(client: TestClient, path: str) -> None:
    (error,) = problem(client.get(f"{V1}/{path}"), 422)["errors"]
    assert error["code"] == "unknown_parameter"
    assert "cursor, limit" in error["detail"]
    assert client.get("/healthz?now=1").status_code == 200


def test_a_filter_takes_an_id_as_a_path_does(client: TestClient, finished_job: str) -> None:
    study = client.get(f"{V1}/jobs/{finished_job}").json()["study_id"]
    for written in (study.upper(), study.replace("-", ""), f"{{{study}}}"):
        assert [job["id"] for job in client.get(f"{V1}/jobs", params={"study_id": written}).json()["items"]] == [
            finished_job
        ]


def test_what_has_no_etag_is_not_changed_under_if_match(client: TestClient, study_id: str) -> None:
    place = f"{V1}/studies/{study_id}"
    for tags in ('"1"', 'W/"1"', '"1", "2"'):
        problem(client.delete(place, headers={"If-Match": tags}), 412)
    assert client.get(place, headers={"If-Match": '"1"'}).status_code == 200
    assert client.delete(place, headers={"If-Match": "*"}).status_code == 204


def test_head_is_a_get_without_its_body(client: TestClient, finished_job: str) -> None:
    place = f"{V1}/jobs/{finished_job}"
    for path in ("", "/artifacts/results.json", "/artifacts", "/events", "/artifacts/nothing"):
        got, head = client.get(place + path), client.head(place + path)
        assert head.content == b""
        assert head.status_code == got.status_code
        unlike = {"x-request-id", "date"}
        assert {k: v for k, v in head.headers.items() if k not in unlike} == {
            k: v for k, v in got.headers.items() if k not in unlike
        }
    for path in ("/", "/healthz", f"{V1}/studies"):
        assert client.head(path).status_code == 200


def test_a_path_that_takes_something_else_says_what(client: TestClient) -> None:
    for path, allowed in ((f"{V1}/studies", "GET, HEAD, POST"), (f"{V1}/uploads/{NOBODY}", "DELETE, HEAD, PATCH")):
        answer = client.put(path)
        assert allowed in problem(answer, 405)["detail"]
        assert answer.headers["allow"] == allowed


@pytest.mark.parametrize("path", ["//api/v1/studies", "/api//v1/studies", "/api/v1/studies/", "/api/v1/studies//"])
@pytest.mark.parametrize("method", ["GET", "POST"])
def test_a_slash_too_many_is_told(client: TestClient, method: str, path: str) -> None:
    answer = client.request(method, f"http://testserver{path}", headers={"Accept": "*/*"})
    assert "/api/v1/studies?" in problem(answer, 404)["detail"]


def test_clients_of_other_tus_servers_are_told_what_is_not_spoken(client: TestClient) -> None:
    begin = {**TUS, "Upload-Length": "3"}
    for name, value in (("Upload-Concat", "partial"), ("Upload-Defer-Length", "1")):
        (error,) = problem(client.post(f"{V1}/uploads", headers={**begin, name: value}), 422)["errors"]
        assert error["pointer"] == f"header/{name}"


def test_a_piece_sent_along_with_an_uploads_beginning_is_asked_for_again(client: TestClient) -> None:
    piece = {"Content-Type": "application/offset+octet-stream"}
    made = client.post(f"{V1}/uploads", content=b"abc", headers={**TUS, **piece, "Upload-Length": "3"})
    assert (made.status_code, made.headers["upload-offset"]) == (201, "0")
    place = made.headers["location"]
    sent = client.post(
        place, content=b"abc", headers={**TUS, **piece, "Upload-Offset": "0", "X-HTTP-Method-Override": "PATCH"}
    )
    assert (sent.status_code, sent.headers["upload-offset"]) == (204, "3")
    assert client.post(place, headers={**TUS, "X-HTTP-Method-Override": "delete"}).status_code == 204
    study = client.post(f"{V1}/studies", headers={"X-HTTP-Method-Override": "GET"})
    problem(study, 415)


@pytest.mark.parametrize("other", [{"Upload-Length": "4"}, {"Upload-Metadata": "filename YQ=="}])
def test_an_upload_of_another_size_or_name_is_another_request(client: TestClient, other: dict[str, str]) -> None:
    first = {**TUS, "Upload-Length": "3", "Idempotency-Key": "one"}
    assert client.post(f"{V1}/uploads", headers=first).status_code == 201
    assert problem(client.post(f"{V1}/uploads", headers={**first, **other}), 422)["type"].endswith("key-reused")
    assert client.post(f"{V1}/uploads", headers=first).headers["idempotency-replayed"] == "true"


def test_any_etag_is_what_one_has(client: TestClient, finished_job: str) -> None:
    place = f"{V1}/jobs/{finished_job}/artifacts/results.json"
    etag = client.get(place).headers["etag"]
    for tags in ("*", f'"a", W/{etag}'):
        assert client.get(place, headers={"If-None-Match": tags}).status_code == 304


@pytest.mark.parametrize(
    "host",
    ["127.0.0.1", "169.254.169.254", "[::1]", "[::ffff:10.0.0.1]", "0x7f000001", "2130706433", "127.1", "0177.1"],
)
def test_a_webhook_to_a_private_number_is_refused_when_it_is_made(client: TestClient, host: str) -> None:
    """It was taken, and every delivery failed. Names are looked up when something is sent."""
    hook = {"url": f"https://{host}/hook", "events": ["job.ended"]}
    (error,) = problem(client.post(f"{V1}/webhooks", json=hook), 422)["errors"]
    assert (error["code"], error["column"]) == ("webhook_url", "url")
    for public in ("https://8.8.8.8/hook", "https://hooks.example/"):
        assert client.post(f"{V1}/webhooks", json=hook | {"url": public}).status_code == 201
