"""A POST that is sent twice happens once."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Mapping
from datetime import timedelta
from typing import Any, final

import pytest
import sqlalchemy as sa
from fastapi.testclient import TestClient

from exogauge.api import checking, idempotency
from exogauge.api.app import create_app
from exogauge.errors import Unavailable
from exogauge.settings import Settings
from exogauge.storage.store import Storage
from exogauge.storage.tables import IdempotencyKey, Robot

ROBOTS = "/api/v1/robots"
Form = Callable[[Mapping[str, bytes]], list[tuple[str, tuple[str, bytes]]]]
pytestmark = pytest.mark.usefixtures("unchecked")


def post(client: TestClient, files: Any, key: str) -> Any:
    return client.post(ROBOTS, files=files, headers={"Idempotency-Key": key})


def test_the_same_request_gets_the_same_answer(
    client: TestClient, robot_files: dict[str, bytes], as_form: Form
) -> None:
    first = post(client, as_form(robot_files), "k1")
    second = post(client, as_form(robot_files), "k1")
    assert (first.status_code, second.status_code) == (201, 201)
    assert first.content == second.content
    assert first.request.headers["content-type"] != second.request.headers["content-type"]  # another boundary
    assert "Idempotency-Replayed" not in first.headers
    assert second.headers["Idempotency-Replayed"] == "true"
    assert second.headers["content-type"] == "application/json"


def test_another_request_under_the_key_is_refused(
    client: TestClient, robot_files: dict[str, bytes], as_form: Form
) -> None:
    post(client, as_form(robot_files), "k1")
    for other in (robot_files | {"robot.urdf": b"<robot/>"}, robot_files | {"robot.urdf": b""}):
        answer = post(client, as_form(other), "k1")
        assert answer.status_code == 422
        assert answer.json()["type"] == "urn:exogauge:problem:idempotency-key-reused"
    elsewhere = client.post("/api/v1/studies", files=as_form(robot_files), headers={"Idempotency-Key": "k1"})
    assert elsewhere.status_code == 422


def test_a_refusal_is_replayed_too(client: TestClient, as_form: Form) -> None:
    answers = [post(client, as_form({"readme.txt": b"no robot"}), "k1") for _ in range(2)]
    assert [answer.status_code for answer in answers] == [422, 422]
    assert answers[0].json() == answers[1].json()
    assert answers[1].headers["content-type"] == "application/problem+json"
    assert answers[1].headers["Idempotency-Replayed"] == "true"


def test_while_the_first_runs_the_second_is_told_to_wait(
    client: TestClient, robot_files: dict[str, bytes], as_form: Form, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, go_on = threading.Event(), threading.Event()

    def slow(_folder: object, file: str = "") -> dict[str, Any]:
        begun.set()
        assert go_on.wait(20)
        return {"name": "arm"}

    monkeypatch.setattr(checking, "check_robot", slow)
    answers = list[Any]()
    first = threading.Thread(target=lambda: answers.append(post(client, as_form(robot_files), "k1")))
    first.start()
    assert begun.wait(20)
    second = post(client, as_form(robot_files), "k1")
    go_on.set()
    first.join()
    assert second.status_code == 409
    assert second.headers["Retry-After"]
    assert answers[0].status_code == 201
    assert post(client, as_form(robot_files), "k1").headers["Idempotency-Replayed"] == "true"


def test_an_answer_that_asks_to_try_again_is_not_kept(
    client: TestClient, robot_files: dict[str, bytes], as_form: Form, monkeypatch: pytest.MonkeyPatch
) -> None:
    def away(_folder: object, file: str = "") -> dict[str, Any]:
        raise Unavailable("not now")

    with monkeypatch.context() as patch:
        patch.setattr(checking, "check_robot", away)
        refused = post(client, as_form(robot_files), "k1")
        assert refused.status_code == 503
        assert refused.headers["Retry-After"]
    assert post(client, as_form(robot_files), "k1").status_code == 201


@pytest.fixture
def replica(settings: Settings) -> Iterator[TestClient]:
    """Another server on the same database and blobs."""
    with TestClient(create_app(settings), raise_server_exceptions=False) as opened:
        yield opened


@pytest.fixture
def slow(monkeypatch: pytest.MonkeyPatch) -> Iterator[Slow]:
    made = Slow()
    monkeypatch.setattr(checking, "check_robot", made)
    yield made
    made.go_on.set()


@final
class Slow:
    """A check of a robot that takes until it is told to go on."""

    def __init__(self) -> None:
        self.begun, self.go_on, self.times = threading.Event(), threading.Event(), 0

    def __call__(self, _folder: object, file: str = "") -> dict[str, Any]:
        self.times += 1
        self.begun.set()
        assert self.go_on.wait(20)
        return {"name": "arm"}


def test_of_two_servers_on_one_database_one_answers(
    client: TestClient, replica: TestClient, slow: Slow, robot_files: dict[str, bytes], as_form: Form
) -> None:
    answers = list[Any]()
    first = threading.Thread(target=lambda: answers.append(post(client, as_form(robot_files), "k1")))
    first.start()
    assert slow.begun.wait(20)
    assert post(replica, as_form(robot_files), "k1").status_code == 409
    slow.go_on.set()
    first.join()
    again = post(replica, as_form(robot_files), "k1")
    assert answers[0].status_code == again.status_code == 201
    assert again.headers["Idempotency-Replayed"] == "true"
    assert again.content == answers[0].content
    assert slow.times == 1


def test_one_key_of_two_labs_is_two_requests(
    client: TestClient, replica: TestClient, slow: Slow, robot_files: dict[str, bytes], as_form: Form
) -> None:
    """In one process or in two: what one lab is busy with does not keep another waiting."""
    object.__setattr__(replica.app.state, "settings", client.app.state.settings.model_copy(update={"lab": "far"}))  # type: ignore[attr-defined]
    answers = list[Any]()
    first = threading.Thread(target=lambda: answers.append(post(client, as_form(robot_files), "k1")))
    first.start()
    assert slow.begun.wait(20)
    slow.go_on.set()
    other = post(replica, as_form(robot_files | {"readme.txt": b"another request"}), "k1")
    first.join()
    assert (answers[0].status_code, other.status_code) == (201, 201)
    assert answers[0].json()["id"] != other.json()["id"]
    assert replica.get(f"{ROBOTS}/{answers[0].json()['id']}").status_code == 404
    assert post(client, as_form(robot_files), "k1").json()["id"] == answers[0].json()["id"]


def test_a_request_that_takes_longer_than_the_lease_keeps_its_key(
    client: TestClient,
    replica: TestClient,
    slow: Slow,
    robot_files: dict[str, bytes],
    as_form: Form,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    lease = timedelta(seconds=0.6)
    monkeypatch.setattr(idempotency, "LEASE", lease)
    answers = list[Any]()
    first = threading.Thread(target=lambda: answers.append(post(client, as_form(robot_files), "k1")))
    first.start()
    assert slow.begun.wait(20)
    end = time.monotonic() + 3 * lease.total_seconds()
    while time.monotonic() < end:
        assert post(replica, as_form(robot_files), "k1").status_code == 409
        time.sleep(0.1)
    slow.go_on.set()
    first.join()
    assert answers[0].status_code == 201
    assert slow.times == 1


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_a_key_that_a_killed_server_left_in_flight_is_free_after_its_lease(
    client: TestClient, robot_files: dict[str, bytes], as_form: Form
) -> None:
    storage: Storage = client.app.state.installation.of_lab("local")  # type: ignore[attr-defined]
    with storage.transaction() as store:
        store.keys.reserve("k1", timedelta(seconds=0.5))
    assert post(client, as_form(robot_files), "k1").status_code == 409
    time.sleep(0.6)
    assert post(client, as_form(robot_files), "k1").status_code == 201
    with storage.reading() as store:
        assert store.session.scalar(sa.select(sa.func.count()).select_from(Robot)) == 1
        assert store.session.scalar(sa.select(IdempotencyKey.answer)) is not None


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
@pytest.mark.parametrize("key", ["", "k" * 256])
def test_an_unusable_key_is_refused(client: TestClient, key: str) -> None:
    assert client.post(ROBOTS, headers={"Idempotency-Key": key}).status_code == 422


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_a_body_cut_anywhere_is_the_same_request(client: TestClient) -> None:
    body = (
        b'--BOUND\r\nContent-Disposition: form-data; name="f"; filename="robot.yaml"\r\n\r\nversion: 1\r\n--BOUND--\r\n'
    )

    def cut(size: int) -> Iterator[bytes]:
        yield from (body[k : k + size] for k in range(0, len(body), size))

    headers = {"Idempotency-Key": "k1", "content-type": "multipart/form-data; boundary=BOUND"}
    answers = [client.post(ROBOTS, content=cut(size), headers=headers) for size in (1000, 1, 3, 7)]
    assert [answer.status_code for answer in answers] == [201] * 4
    assert all(answer.headers.get("Idempotency-Replayed") for answer in answers[1:])
