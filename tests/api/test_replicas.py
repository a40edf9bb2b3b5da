"""Two servers of one database and one object store, each with a disk of its own, as behind a proxy that sends a client
now to this one and now to that."""

from __future__ import annotations

import base64
import io
import json
import zipfile
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack
from pathlib import Path
from typing import Any

import httpx
import pytest
from tests.object_store import BUCKET, KEYS, s3_server
from tests.whole_service import Service, small_study

At = Callable[[Service], httpx.Client]
TUS = {"Tus-Resumable": "1.0.0"}
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def servers(
    throw_away_database: Callable[..., AbstractContextManager[str]], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tuple[Service, Service]]:
    """One, and another with a worker."""
    with s3_server() as port, throw_away_database() as url:
        stored = {"blob_url": f"s3://{BUCKET}/replicas", "s3_endpoint": f"http://127.0.0.1:{port}", **KEYS}
        made = [
            Service(tmp_path_factory.mktemp(f"server-{workers}"), url, workers=workers, **stored)
            for workers in ("0", "1")
        ]
        yield made[0], made[1]
        for each in made:
            if each.running():
                each.kill()


@pytest.fixture
def at() -> Iterator[Callable[[Service], httpx.Client]]:
    """A client of a server, which is started where it does not run."""
    with ExitStack() as opened:

        def client(server: Service) -> httpx.Client:
            url = server.url if server.running() else server.start()
            return opened.enter_context(httpx.Client(base_url=f"{url}/api/v1", timeout=60.0))

        yield client


def zipped(files: dict[str, bytes]) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, content in files.items():
            archive.writestr(path, content)
    return packed.getvalue()


def piece(client: httpx.Client, key: str, offset: int, content: bytes) -> httpx.Response:
    headers = {**TUS, "Upload-Offset": str(offset), "Content-Type": "application/offset+octet-stream"}
    return client.patch(f"/uploads/{key}", headers=headers, content=content)


def last_event(client: httpx.Client, job: str) -> dict[str, Any]:
    with client.stream("GET", f"/jobs/{job}/events") as told:
        data = [line.removeprefix("data: ") for line in told.iter_lines() if line.startswith("data: ")]
    return dict(json.loads(data[-1]))


def test_two_servers_are_one_service(servers: tuple[Service, Service], at: At) -> None:
    first, second = servers
    one, other = at(first), at(second)
    whole = zipped(small_study("replicas"))
    half, most = len(whole) // 2, 2 * len(whole) // 3
    name = base64.b64encode(b"study.zip").decode()
    begun = {**TUS, "Upload-Length": str(len(whole)), "Upload-Metadata": f"filename {name}"}
    key = one.post("/uploads", headers=begun).raise_for_status().json()["id"]
    assert piece(one, key, 0, whole[:half]).headers["Upload-Offset"] == str(half)

    assert other.head(f"/uploads/{key}", headers=TUS).headers["Upload-Offset"] == str(half)
    assert piece(other, key, 0, whole[:10]).status_code == 409
    assert piece(other, key, half, whole[half:most]).headers["Upload-Offset"] == str(most)
    assert piece(one, key, half, whole[half:]).status_code == 409  # what came at the other counts here too
    first.kill()
    assert piece(other, key, most, whole[most:]).headers["Upload-Offset"] == str(len(whole))
    one = at(first)
    study = one.post("/studies/from-upload", json={"upload_ids": [key]}).raise_for_status().json()["id"]
    assert other.head(f"/uploads/{key}", headers=TUS).status_code == 404

    job = one.post("/jobs", json={"study_id": study, "kind": "evaluate"}).raise_for_status().json()["id"]
    assert [last_event(each, job)["state"] for each in (one, other)] == ["succeeded", "succeeded"]
    log = other.get(f"/studies/{study}").raise_for_status().json()["summary"]["logs"][0]["name"]
    channels = [each.get(f"/studies/{study}/series/{log}").raise_for_status().json() for each in (one, other)]
    assert channels[0] == channels[1]
    assert channels[0]["samples"] == 400
    results = [each.get(f"/jobs/{job}/artifacts/results.json").raise_for_status().content for each in (one, other)]
    assert results[0] == results[1]


def test_a_killed_server_leaves_nothing_that_others_do_not_see(servers: tuple[Service, Service], at: At) -> None:
    """What lies on its disk and was never shared is no part of the upload: it was not acknowledged."""
    first, second = servers
    one, other = at(first), at(second)
    begun = {**TUS, "Upload-Length": "30", "Upload-Metadata": f"filename {base64.b64encode(b'a.csv').decode()}"}
    key = one.post("/uploads", headers=begun).raise_for_status().json()["id"]
    assert piece(one, key, 0, b"a" * 10).status_code == 204
    first.kill()
    with (first.folder / "data" / "uploads" / key).open("ab") as left:
        left.write(b"killed before it was shared")
    one = at(first)
    assert one.head(f"/uploads/{key}", headers=TUS).headers["Upload-Offset"] == "10"
    assert piece(one, key, 10, b"b" * 10).status_code == 204
    assert piece(other, key, 20, b"c" * 10).status_code == 204
    assert piece(one, key, 30, b"d").status_code in (409, 413)
    copies = [Path(each.folder / "data" / "uploads" / key).read_bytes() for each in (first, second)]
    assert b"a" * 10 + b"b" * 10 + b"c" * 10 in copies
    for each in (one, other):
        assert each.delete(f"/uploads/{key}", headers=TUS).status_code in (204, 404)
    assert one.head(f"/uploads/{key}", headers=TUS).status_code == 404
