"""Lists searched by words over HTTP."""

from __future__ import annotations

import pytest
from fastapi.testclient import TestClient

from exogauge.storage.store import Storage

V1 = "/api/v1"


@pytest.fixture
def lists(client: TestClient) -> TestClient:
    """Three robots, three devices on the first, and a study."""
    storage: Storage = client.app.state.storage  # type: ignore[attr-defined]
    names = ("Größe 100%", "size_100", "size 100")
    with storage.transaction() as store:
        robots = [store.robots.add(name, [], {"name": name})[0] for name in names]
        for name in names:
            store.devices.add(name, robots[0].id, [], {"name": name, "robot": "HRP-4"})
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
