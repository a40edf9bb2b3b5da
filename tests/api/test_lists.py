"""Every list is given page by page, in the same words."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from fastapi.exceptions import RequestValidationError
from fastapi.testclient import TestClient
from tests.api.people import People

from exogauge.api.lists import Key, decoded_mark, part
from exogauge.storage.accounts import Accounts
from exogauge.storage.files import PinnedFile

V1 = "/api/v1"
DOCUMENT: dict[str, Any] = json.loads((Path(__file__).parents[2] / "web" / "openapi.json").read_text())
ASKED = {
    path: route["get"]
    for path, route in DOCUMENT["paths"].items()
    if "application/json" in route.get("get", {}).get("responses", {}).get("200", {}).get("content", {})
}


def answer_of(route: dict[str, Any]) -> dict[str, Any]:
    schema: dict[str, Any] = route["responses"]["200"]["content"]["application/json"]["schema"]
    while "$ref" in schema:
        schema = DOCUMENT["components"]["schemas"][schema["$ref"].rpartition("/")[2]]
    return schema


LISTS = [path for path, route in ASKED.items() if "items" in answer_of(route).get("properties", {})]


def test_what_is_called_a_list_is_one_and_no_answer_is_a_bare_array() -> None:
    called = {path for path, route in ASKED.items() if route["operationId"].startswith("list")}
    assert called == set(LISTS)
    assert not [path for path, route in ASKED.items() if answer_of(route).get("type") == "array"]


@pytest.mark.parametrize("path", LISTS)
def test_every_list_has_pages(path: str) -> None:
    route = ASKED[path]
    asked = {each["name"]: each["schema"] for each in route["parameters"] if each["in"] == "query"}
    assert {"cursor", "limit"} <= set(asked)
    assert (asked["limit"]["default"], asked["limit"]["minimum"], asked["limit"]["maximum"]) == (50, 1, 200)
    assert set(answer_of(route)["properties"]) == {"items", "next_cursor"}


def pages(items: list[Any], key: Any, limit: int) -> list[list[Any]]:
    found, cursor, after = [], "", None
    while cursor is not None:
        shown, cursor = part(items, key, after, limit)
        after = None if cursor is None else mark(cursor)
        found.append(shown)
    return found


def mark(cursor: str) -> Key | None:
    coroutine = decoded_mark(cursor)
    try:
        coroutine.send(None)
    except StopIteration as done:
        found: Key | None = done.value
        return found
    raise AssertionError


@pytest.mark.parametrize("limit", [1, 2, 3, 6, 7, 8])
def test_pages_of_a_list_that_is_made_whole_are_the_list(limit: int) -> None:
    items = [(name, number) for name in ("b", "a", "ü|\0") for number in (-2.5, 7)] + [("a", 1e300)]
    found = pages(items, lambda item: item, limit)
    assert [item for page in found for item in page] == sorted(items)
    assert [len(page) for page in found[:-1]] == [limit] * (len(found) - 1)
    assert found[-1]


def test_a_list_that_changes_between_pages_repeats_nothing_and_leaves_out_nothing_that_stayed() -> None:
    first, cursor = part(["a", "b", "d"], lambda name: (name,), None, 2)
    assert cursor is not None
    later, end = part(["0", "c", "d"], lambda name: (name,), mark(cursor), 2)
    assert (first, later, end) == (["a", "b"], ["c", "d"], None)


@pytest.mark.parametrize("cursor", ["x", "ä", "e30=", "W1sxXV0=", "WzFd", "W251bGxd"])  # {}, [[1]], [1], [null]
def test_a_cursor_of_something_else_is_refused(cursor: str) -> None:
    with pytest.raises(RequestValidationError, match="cursor"):
        part(["a"], lambda name: (name,), mark(cursor), 2)


def walked(client: TestClient, path: str, limit: int) -> list[dict[str, Any]]:
    found, query = list[dict[str, Any]](), f"limit={limit}"
    while query:
        answer = client.get(f"{V1}{path}?{query}")
        assert answer.status_code == 200, answer.text
        page = answer.json()
        assert len(page["items"]) <= limit
        found += page["items"]
        query = page["next_cursor"] and f"limit={limit}&cursor={page['next_cursor']}"
    return found


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_what_a_job_made_is_listed_by_pages(client: TestClient, finished_job: str) -> None:
    path = f"/jobs/{finished_job}/artifacts"
    assert [each["name"] for each in walked(client, path, 1)] == ["report.html", "results.json", "series/id.parquet"]
    assert client.get(f"{V1}{path}?cursor=x").status_code == 422


def test_members_hooks_shares_and_what_is_shared_are_listed_by_pages(people: People) -> None:
    ada = people.person("ada@example.org", "north", "admin")
    eve = people.person("eve@example.org", "south", "admin")
    with people.installation.session() as session:
        accounts = Accounts(session)
        for name in ("cyd", "bob"):
            accounts.join(accounts.add(f"{name}@example.org", name, None).id, "north", "viewer", "test", "")
        accounts.found_lab("west", "west")
    with people.installation.of_lab("north").transaction() as store:
        blob = store.blobs.put(b"one file")
        studies = [store.studies.add(f"study {k}", [PinnedFile(f"{k}.yaml", blob, 8)], {})[0].id for k in range(3)]
        for study in studies:
            for lab in ("south", "west", None):
                store.shares.add(study, lab)
        hooks = [store.webhooks.add(f"https://example.org/{k}", ["job.ended"])[0].id for k in range(3)]
    with people.browser(people.session(ada)) as north, people.browser(people.session(eve)) as south:
        for limit in (1, 2, 200):
            assert [each["name"] for each in walked(north, "/lab/members", limit)] == ["ada", "bob", "cyd"]
            assert [each["id"] for each in walked(north, "/webhooks", limit)] == hooks[::-1]
            shares = walked(north, f"/studies/{studies[0]}/shares", limit)
            assert [each["lab"] for each in shares] == ["south", "west", None]
            shared = walked(south, "/shared", limit)
            assert {each["study_id"] for each in shared} == set(studies)
            assert len(shared) == 3
            assert shared == sorted(shared, key=lambda each: each["since"], reverse=True)
