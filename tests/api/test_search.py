"""Lists searched by words over HTTP."""

from __future__ import annotations

from uuid import uuid4

import pytest
from fastapi.testclient import TestClient

from exogauge.storage.files import PinnedFile
from exogauge.storage.store import Storage

pytestmark = pytest.mark.usefixtures("without_bytes")

V1 = "/api/v1"
FILES = (("robot.yaml", "a"), ("robot.urdf", "b"), ("robot2.urdf", "c"), ("mesh.stl", "d"), ("logs/id.csv", "e"))


@pytest.fixture
def lists(client: TestClient) -> TestClient:
    """Three robots, three devices on the first, and a study."""
    storage: Storage = client.app.state.installation.of_lab("local")  # type: ignore[attr-defined]
    names = ("Größe 100%", "size_100", "size 100")
    with storage.transaction() as store:
        robots = [store.robots.add(name, [], {"name": name})[0] for name in names]
        for name in names:
            store.devices.add(name, [], {"name": name, "robot": "HRP-4"}, robot_id=robots[0].id)
        store.studies.add(names[0], [], {"robot": {"name": "R0"}})
    return client


def test_a_list_holds_what_has_every_word(lists: TestClient) -> None:
    wanted = {
        "GRÖSSE": ["Größe 100%"],
        "100%": ["Größe 100%"],
        "size_": ["size_100"],
        "100 size": ["size 100", "size_100"],
        "nothing": [],
        "": ["size 100", "size_100", "Größe 100%"],
    }
    for noun in ("robots", "devices"):
        for search, names in wanted.items():
            page = lists.get(f"{V1}/{noun}", params={"search": search}).json()
            assert [item["name"] for item in page["items"]] == names, (noun, search)
            assert page["next_cursor"] is None


def test_a_cursor_goes_on_within_what_was_sought(lists: TestClient) -> None:
    asked = {"search": "size", "limit": 1}
    first = lists.get(f"{V1}/robots", params=asked).json()
    second = lists.get(f"{V1}/robots", params={**asked, "cursor": first["next_cursor"]}).json()
    assert [page["items"][0]["name"] for page in (first, second)] == ["size 100", "size_100"]
    assert second["next_cursor"] is None


def test_studies_are_sought_by_robot_and_chosen_by_state(lists: TestClient) -> None:
    def names(**asked: str) -> list[str]:
        return [item["name"] for item in lists.get(f"{V1}/studies", params=asked).json()["items"]]

    assert names(search="r0 größe") == names(search="r0", state="none") == ["Größe 100%"]
    assert names(search="r0", state="failed") == names(search="r1") == []


def test_studies_of_a_robot_are_those_with_its_files_however_many_were_handed_in_since(client: TestClient) -> None:
    """Forty newer studies of a robot with the same name and other files lie above the one that is sought."""
    storage: Storage = client.app.state.installation.of_lab("local")  # type: ignore[attr-defined]
    yaml, old, new, extra, log = (PinnedFile(path, digit * 64, 1) for path, digit in FILES)
    moved = PinnedFile("robots/robot.yaml", yaml.sha256, 1)
    about = {"name": "R0", "urdf": old.path}
    with storage.transaction() as store:
        mine, _ = store.robots.add("R0", [yaml, old, extra], about)
        other, _ = store.robots.add("R0", [yaml, new, extra], about | {"urdf": new.path})
        empty, _ = store.robots.add("nothing", [], {})
        store.studies.add("mine", [moved, old, log], {"robot": {"name": "R0"}})
        for k in range(40):
            own = PinnedFile("study.yaml", f"{k:064x}", 1)
            store.studies.add(f"other {k}", [own, yaml, new], {"robot": {"name": "R0"}})
        store.studies.add("of no robot", [yaml, log], {"robot": {"name": "R0"}})

    def names(robot: str, **more: object) -> list[str]:
        asked = {"robot_id": robot, "limit": 200} | more
        return [item["name"] for item in client.get(f"{V1}/studies", params=asked).json()["items"]]

    assert names(mine.id) == ["mine"]
    assert names(other.id) == [f"other {k}" for k in reversed(range(40))]
    assert names(other.id, search="39", state="none") == ["other 39"]
    assert names(empty.id) == []
    assert names("none") == ["of no robot"]
    first = client.get(f"{V1}/studies", params={"robot_id": other.id, "limit": 30}).json()
    rest = client.get(f"{V1}/studies", params={"robot_id": other.id, "cursor": first["next_cursor"]}).json()
    assert len(first["items"]) + len(rest["items"]) == 40
    assert client.get(f"{V1}/studies", params={"robot_id": str(uuid4())}).status_code == 404
    assert client.get(f"{V1}/studies", params={"robot_id": "R0"}).status_code == 422


def test_what_no_database_can_be_asked_is_refused(lists: TestClient) -> None:
    for asked in (
        "studies?search=a%00b",
        "devices?name=%00",
        "jobs?study_id=%00",
        "studies?state=lost",
        f"robots?search={'x' * 201}",
    ):
        answer = lists.get(f"{V1}/{asked}")
        assert answer.status_code == 422, asked
        assert answer.headers["content-type"] == "application/problem+json"
