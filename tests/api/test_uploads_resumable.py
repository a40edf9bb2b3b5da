"""Resumable uploads by tus 1.0.0: what was confirmed is there, what was not is asked for again."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Callable, Mapping
from datetime import UTC, datetime, timedelta
from email.utils import parsedate_to_datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

pytestmark = pytest.mark.slow

if TYPE_CHECKING:
    from fastapi.testclient import TestClient

    from exogauge.settings import Settings

V1 = "/api/v1"
TUS = {"Tus-Resumable": "1.0.0"}
PIECE = {"Content-Type": "application/offset+octet-stream"}
NOBODY = "00000000-0000-4000-8000-000000000000"
on_sqlite = pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)


def meta(**given: str) -> dict[str, str]:
    pairs = (f"{key} {base64.b64encode(value.encode()).decode()}" for key, value in given.items())
    return {"Upload-Metadata": ",".join(pairs)}


def create(client: TestClient, size: int, name: str = "study.zip", **more: str) -> Any:
    headers = {**TUS, "Upload-Length": str(size), **meta(filename=name), **more}
    return client.post(f"{V1}/uploads", headers=headers)


def begin(client: TestClient, size: int, name: str = "study.zip") -> str:
    answer = create(client, size, name)
    assert answer.status_code == 201, answer.text
    location: str = answer.headers["location"]
    return location


def send(client: TestClient, place: str, offset: int, data: Any, **more: str) -> Any:
    return client.patch(place, content=data, headers={**TUS, **PIECE, "Upload-Offset": str(offset), **more})


def offset(client: TestClient, place: str) -> int:
    answer = client.head(place, headers=TUS)
    assert answer.status_code == 200, answer.headers
    assert answer.headers["cache-control"] == "no-store"
    return int(answer.headers["upload-offset"])


def upload(client: TestClient, data: bytes, name: str = "study.zip") -> str:
    """The id of an upload that has arrived."""
    place = begin(client, len(data), name)
    assert send(client, place, 0, data).status_code == 204
    return place.rsplit("/", 1)[-1]


def checksum(data: bytes, algorithm: str = "sha256") -> dict[str, str]:
    digest = hashlib.new(algorithm, data).digest()
    return {"Upload-Checksum": f"{algorithm} {base64.b64encode(digest).decode()}"}


@on_sqlite
def test_the_server_says_what_it_speaks_and_how_much_it_takes(client: TestClient, settings: Settings) -> None:
    answer = client.options(f"{V1}/uploads")
    assert answer.status_code == 204
    assert answer.headers["tus-version"] == "1.0.0"
    assert answer.headers["tus-max-size"] == str(settings.max_bundle_bytes)
    assert set(answer.headers["tus-extension"].split(",")) == {"creation", "termination", "checksum", "expiration"}
    for method, path in (("POST", "uploads"), ("HEAD", f"uploads/{NOBODY}"), ("PATCH", f"uploads/{NOBODY}")):
        refused = client.request(method, f"{V1}/{path}", headers={"Upload-Length": "1", "Upload-Offset": "0"})
        assert (refused.status_code, refused.headers["tus-version"]) == (412, "1.0.0")
        assert refused.headers["tus-resumable"] == "1.0.0"


def test_a_study_arrives_in_pieces_and_is_what_was_sent(
    client: TestClient, study_files: dict[str, bytes], pack: Callable[..., bytes]
) -> None:
    data = pack(study_files)
    place = begin(client, len(data))
    assert parsedate_to_datetime(client.head(place, headers=TUS).headers["upload-expires"]).tzinfo is not None
    for start in range(0, len(data), 1000):
        answer = send(client, place, start, data[start : start + 1000])
        assert (answer.status_code, answer.headers["upload-offset"]) == (204, str(min(start + 1000, len(data))))
    key = place.rsplit("/", 1)[-1]
    study = client.post(f"{V1}/studies/from-upload", json={"upload_ids": [key]})
    assert study.status_code == 201, study.text
    hashes = {file["path"]: file["sha256"] for file in study.json()["files"]}
    assert hashes == {path: hashlib.sha256(content).hexdigest() for path, content in study_files.items()}
    assert client.head(place, headers=TUS).status_code == 404  # used up
    assert not any(client.app.state.settings.uploads.iterdir())  # type: ignore[attr-defined]


@on_sqlite
def test_several_files_become_a_study_under_the_paths_they_are_given(
    client: TestClient, study_files: dict[str, bytes]
) -> None:
    ids = [upload(client, content, path.rsplit("/", 1)[-1]) for path, content in study_files.items()]
    short = client.post(f"{V1}/studies/from-upload", json={"upload_ids": ids, "paths": ["a"]})
    assert (short.status_code, short.json()["errors"][0]["code"]) == (422, "paths_differ")
    out = client.post(f"{V1}/studies/from-upload", json={"upload_ids": ids[:1], "paths": ["../study.yaml"]})
    assert (out.status_code, out.json()["errors"][0]["code"]) == (422, "unsafe_path")
    study = client.post(f"{V1}/studies/from-upload", json={"upload_ids": ids, "paths": list(study_files)})
    assert study.status_code == 201, study.text
    assert study.json()["summary"]["robot"]["joints"] == ["elbow"]


@on_sqlite
def test_a_broken_study_is_refused_at_its_place_and_its_upload_stays(
    client: TestClient, study_files: dict[str, bytes], pack: Callable[..., bytes]
) -> None:
    study_files["logs/id.csv"] = study_files["logs/id.csv"].replace(b"\n0.100,", b"\n0.100,nonsense", 1)
    key = upload(client, pack(study_files))
    for _ in range(2):
        refused = client.post(f"{V1}/studies/from-upload", json={"upload_ids": [key]})
        assert refused.status_code == 422
        (error,) = refused.json()["errors"]
        assert (error["file"], error["row"], error["column"]) == ("logs/id.csv", 11, "q.elbow")


@on_sqlite
def test_an_upload_that_has_not_arrived_cannot_be_used(client: TestClient) -> None:
    place = begin(client, 10)
    send(client, place, 0, b"12345")
    answer = client.post(f"{V1}/studies/from-upload", json={"upload_ids": [place.rsplit("/", 1)[-1]]})
    assert answer.status_code == 409
    assert "5 of 10 bytes" in answer.json()["detail"]


MAPPING = {
    "version": 1,
    "files": [{"file": "vendor.csv", "time": {"column": "ms", "unit": "ms"},
               "columns": {"angle": {"channel": "q.elbow", "unit": "deg"}}}],
}  # fmt: skip


@on_sqlite
def test_a_log_arrives_with_its_mapping(client: TestClient) -> None:
    table = b"ms,angle\n" + b"".join(b"%d,%d\n" % (10 * k, k % 7) for k in range(100))
    answer = client.post(
        f"{V1}/logs/from-upload", json={"upload_id": upload(client, table, "vendor.csv"), "mapping": MAPPING}
    )
    assert answer.status_code == 201, answer.text
    assert (answer.json()["summary"]["channels"], answer.json()["sha256"]) == (
        ["q.elbow"],
        hashlib.sha256(table).hexdigest(),
    )


@on_sqlite
@pytest.mark.parametrize("algorithm", ["sha1", "sha256"])
def test_a_piece_that_is_not_what_its_checksum_says_is_left_out(client: TestClient, algorithm: str) -> None:
    place = begin(client, 10)
    assert send(client, place, 0, b"12345", **checksum(b"12345", algorithm)).status_code == 204
    wrong = send(client, place, 5, b"67x90", **checksum(b"67890", algorithm))
    assert (wrong.status_code, wrong.headers["content-type"]) == (460, "application/problem+json")
    assert offset(client, place) == 5
    assert send(client, place, 5, b"67890", **checksum(b"67890", algorithm)).headers["upload-offset"] == "10"
    folder = client.app.state.settings.uploads  # type: ignore[attr-defined]
    assert [path.read_bytes() for path in folder.iterdir()] == [b"1234567890"]


def raw(headers: Mapping[str, str | bytes]) -> Mapping[bytes, bytes]:
    """Letters beyond ASCII, as a careless client sends them."""
    return {name.encode(): value if isinstance(value, bytes) else value.encode() for name, value in headers.items()}


@on_sqlite
@pytest.mark.parametrize(
    ("headers", "data", "status"),
    [
        ({"Upload-Offset": "4"}, b"x", 409),
        ({"Upload-Offset": "-1"}, b"x", 422),
        ({"Upload-Offset": "many"}, b"x", 422),
        ({}, b"x", 422),
        ({"Upload-Offset": "5", "Content-Type": "text/plain"}, b"x", 415),
        ({"Upload-Offset": "5"}, b"678901", 413),
        ({"Upload-Offset": "5", "Upload-Checksum": "md5 eA=="}, b"x", 400),
        ({"Upload-Offset": "5", "Upload-Checksum": "sha256 eA=="}, b"x", 400),
        ({"Upload-Offset": "5", "Upload-Checksum": "sha256 !"}, b"x", 400),
        ({"Upload-Offset": "5", "Upload-Checksum": b"sha256 \xe9"}, b"x", 400),
        ({"Upload-Offset": "5", "Origin": "http://evil.example"}, b"x", 403),
        ({"Upload-Offset": "5", "Tus-Resumable": "0.2.2"}, b"x", 412),
    ],
)
def test_a_piece_that_cannot_follow_is_refused_and_writes_nothing(
    client: TestClient, headers: Mapping[str, str | bytes], data: bytes, status: int
) -> None:
    place = begin(client, 10)
    send(client, place, 0, b"12345")
    refused = client.patch(place, content=data, headers=raw({**TUS, **PIECE, **headers}))
    assert refused.status_code == status, refused.text
    assert refused.headers["content-type"] == "application/problem+json"
    assert offset(client, place) == 5


@on_sqlite
@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Upload-Length": "many"}, 422),
        ({"Upload-Length": str(10**14)}, 413),
        ({"Upload-Metadata": "filename !"}, 400),
        ({"Upload-Metadata": "filename Li4vZXZpbA=="}, 422),
        ({"Upload-Metadata": "filename /w=="}, 400),
        ({"Upload-Metadata": b"filename \xe9"}, 400),
    ],
)
def test_an_upload_that_cannot_be_is_not_begun(
    client: TestClient, headers: Mapping[str, str | bytes], status: int
) -> None:
    refused = client.post(f"{V1}/uploads", headers=raw({**TUS, "Upload-Length": "5", **headers}))
    assert refused.status_code == status, refused.text
    assert refused.headers["content-type"] == "application/problem+json"
    folder = client.app.state.settings.uploads  # type: ignore[attr-defined]
    assert not folder.is_dir() or not any(folder.iterdir())


def test_nobody_else_and_nobody_later_finds_an_upload(client: TestClient) -> None:
    place = begin(client, 3)
    other = place.replace(place.rsplit("/", 1)[-1], NOBODY)
    for method in ("HEAD", "PATCH", "DELETE"):
        headers = {**TUS, **PIECE, "Upload-Offset": "0"}
        assert client.request(method, other, headers=headers).status_code == 404
    settings = client.app.state.settings  # type: ignore[attr-defined]
    object.__setattr__(settings, "lab", "elsewhere")
    assert client.head(place, headers=TUS).status_code == 404
    object.__setattr__(settings, "lab", "local")
    assert client.delete(place, headers=TUS).status_code == 204
    assert client.head(place, headers=TUS).status_code == 404


@on_sqlite
def test_a_server_whose_clock_is_ahead_gives_no_upload_up(client: TestClient, monkeypatch: pytest.MonkeyPatch) -> None:
    from exogauge.api import uploads_resumable
    from exogauge.storage import sweeping, table_kinds, uploads

    place = begin(client, 3)
    send(client, place, 0, b"1")

    def ahead() -> datetime:
        return datetime.now(UTC) + timedelta(days=400)

    for module in (uploads, table_kinds, uploads_resumable):
        monkeypatch.setattr(module, "utc_now", ahead, raising=False)
    settings, installation = client.app.state.settings, client.app.state.installation  # type: ignore[attr-defined]
    assert sweeping.sweep_machine(installation, settings).uploads == 0
    assert offset(client, place) == 1


@on_sqlite
def test_what_nobody_comes_back_for_is_removed(client: TestClient) -> None:
    from exogauge.storage.sweeping import sweep_machine

    place = begin(client, 3)
    settings, installation = client.app.state.settings, client.app.state.installation  # type: ignore[attr-defined]
    storage = installation.of_lab("local")
    send(client, place, 0, b"1")
    with storage.transaction() as store:
        store.uploads.wait_longer(place.rsplit("/", 1)[-1], timedelta(seconds=-1))
    gone = client.head(place, headers=TUS)
    assert gone.status_code == 404
    fresh = begin(client, 3)
    sweep_machine(installation, settings, young_s=0.0)
    assert [path.name for path in settings.uploads.iterdir()] == [fresh.rsplit("/", 1)[-1]]


@on_sqlite
def test_an_upload_begun_twice_under_one_key_is_one(client: TestClient) -> None:
    first, second = (create(client, 5, **{"Idempotency-Key": "k"}) for _ in range(2))
    assert first.headers["location"] == second.headers["location"]
    assert second.headers["idempotency-replayed"] == "true"
    assert second.headers["upload-expires"] == first.headers["upload-expires"]


@on_sqlite
def test_a_piece_may_be_larger_than_any_other_body_and_comes_without_its_length(client: TestClient) -> None:
    settings = client.app.state.settings  # type: ignore[attr-defined]
    size = settings.max_upload_bytes + 500_000
    block = bytes(range(250)) * 400
    place = begin(client, size)
    answer = send(client, place, 0, iter([block] * (size // len(block))))
    assert (answer.status_code, answer.headers["upload-offset"]) == (204, str(size))


@on_sqlite
def test_two_cannot_send_to_one_upload_at_a_time(client: TestClient) -> None:
    from exogauge.storage.partial_files import PartialFiles

    place = begin(client, 5)
    files = PartialFiles(client.app.state.settings.uploads)  # type: ignore[attr-defined]
    with files.appending(place.rsplit("/", 1)[-1]):
        assert send(client, place, 0, b"12345").status_code == 423
    assert send(client, place, 0, b"12345").status_code == 204


@on_sqlite
@pytest.mark.parametrize("hashed", [False, True])
@pytest.mark.parametrize("announced", [False, True])
def test_a_piece_beyond_the_end_leaves_nothing(
    client: TestClient, settings: Settings, hashed: bool, announced: bool
) -> None:
    size = 3 << 20  # more than is gathered before it is written
    place = begin(client, size)
    assert send(client, place, 0, b"12345").status_code == 204
    data = bytes(size)
    pieces = data if announced else (data[start : start + 65536] for start in range(0, size, 65536))
    answer = send(client, place, 5, pieces, **(checksum(data) if hashed else {}))
    assert answer.status_code == 413
    assert answer.json()["errors"][0]["code"] == "beyond_upload_length"
    assert offset(client, place) == 5
    assert [path.read_bytes() for path in settings.uploads.iterdir()] == [b"12345"]
    assert send(client, place, 5, data[5:]).status_code == 204


@on_sqlite
def test_who_uses_what_another_request_uses_is_told_to_try_again(client: TestClient, tmp_path: Path) -> None:
    from obstore.store import LocalStore

    from exogauge.api.uploads_resumable import whole
    from exogauge.errors import Conflict
    from exogauge.storage.objects import SharedPieces, Stores
    from exogauge.storage.partial_files import PartialFiles
    from exogauge.storage.reach import Reach

    place: Any = LocalStore(str(tmp_path / "away"), mkdir=True)
    files = PartialFiles(tmp_path / "here", SharedPieces(Stores(place, place), Reach()))
    storage = client.app.state.installation.of_lab("local")  # type: ignore[attr-defined]
    key = begin(client, 0).rsplit("/", 1)[-1]
    with files.appending(key), pytest.raises(Conflict, match="try again"):
        whole([key], storage, files)
    assert whole([key], storage, files)[0][1].read_bytes() == b""
