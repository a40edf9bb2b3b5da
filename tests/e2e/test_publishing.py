"""From an invitation to what everybody reads, and back: invite, share with one lab, publish, cite, revoke, delete."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import httpx
import pytest
from playwright.sync_api import expect
from tests.e2e.arm import arm_study
from tests.e2e.conftest import running

from exogauge import Client
from exogauge.cli import main

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page
    from tests.e2e.conftest import Service

WORDS = "three old lamps glow"
EVALUATED_MS = 240_000


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory, browser: Browser) -> Iterator[Service]:
    with running(tmp_path_factory.mktemp("publishing"), workers=1, EXOGAUGE_ACCOUNTS="1") as started:
        yield started


@pytest.fixture(scope="module")
def north(service: Service) -> Iterator[httpx.Client]:
    """Ada, admin of North and of South, as her browser would ask."""
    base = {"base_url": f"{service.url}/api/v1", "headers": {"Origin": service.url}, "timeout": 60.0}
    with httpx.Client(**base) as ada:  # type: ignore[arg-type]
        first = {"code": (service.data / "set-up-code").read_text(), "email": "ada@example.org", "name": "Ada"}
        assert ada.post("/set-up", json={**first, "password": WORDS, "lab": "North"}).status_code == 204
        assert ada.post("/labs", json={"name": "South"}).status_code == 201
        yield ada


def test_what_is_shared_published_and_revoked_is_read_by_those_who_may_and_is_gone_then(
    page: Page,
    service: Service,
    browser: Browser,
    north: httpx.Client,
    screenshot: Callable[..., None],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    page.goto("/sign-in")
    page.get_by_label("E-mail address").fill("ada@example.org")
    page.get_by_label("Password").first.fill(WORDS)
    page.get_by_role("button", name="Sign in").click()
    expect(page.get_by_role("button", name="Account of Ada, lab South")).to_be_visible()
    page.goto("/lab")
    page.get_by_label("E-mail address").fill("cleo@example.org")
    page.get_by_label("As", exact=True).select_option("viewer")
    page.get_by_role("button", name="Invite", exact=True).click()
    link = page.get_by_test_id("secret").inner_text().strip()
    cleo = browser.new_context(base_url=service.url).new_page()
    cleo.goto(link)
    cleo.get_by_label("Your name").fill("Cleo")
    cleo.get_by_label("Password").first.fill(WORDS)
    cleo.get_by_role("button", name="Make the account and join").click()
    expect(cleo.get_by_role("heading", name="Studies", level=1)).to_be_visible()

    labs = {lab["name"]: lab["id"] for lab in north.get("/session").json()["labs"]}
    north.put("/session/lab", json={"lab_id": labs["North"]})
    made = north.post("/studies", files=[("files", (path, text)) for path, text in arm_study().items()]).json()
    token = north.post("/tokens", json={"name": "bench", "scope": "write"}).json()["secret"]
    with Client(service.url, token=token) as client:
        client.wait(client.submit(made["id"]), progress=False, timeout_s=EVALUATED_MS / 1000)
    page.get_by_role("button", name="Account of Ada").click()
    page.get_by_role("menuitem", name="North", exact=True).click()
    expect(page.get_by_role("button", name="Account of Ada, lab North")).to_be_visible()

    page.goto(f"/studies/{made['id']}")
    page.get_by_role("button", name="Share").click()
    page.get_by_label("Name of another lab").fill("South")
    page.get_by_role("dialog").get_by_role("button", name="Share", exact=True).click()
    expect(page.get_by_role("button", name="End for South")).to_be_visible()
    page.keyboard.press("Escape")
    cleo.goto("/studies")
    cleo.get_by_role("region", name="Shared with your lab").get_by_role("link").click()
    expect(cleo.get_by_role("heading", level=1)).to_contain_text(made["name"])
    for name in ("Publish", "Share", "Delete"):
        expect(cleo.get_by_role("button", name=name)).to_have_count(0)

    page.get_by_role("button", name="Publish").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("Title").fill("An arm on a bench")
    dialog.get_by_label("Creators, one a line").fill("Lovelace, Ada; 0000-0001-5109-3700; North\nBabbage, Charles")
    dialog.get_by_label("Abstract").fill("What an arm weighs.")
    dialog.get_by_role("button", name="Publish for everybody").click()
    to = dialog.get_by_role("link", name="An arm on a bench, version 1").get_attribute("href")

    anybody = browser.new_context(base_url=service.url).new_page()
    anybody.goto(str(to))
    expect(anybody.get_by_role("heading", name="An arm on a bench", level=1)).to_be_visible()
    expect(anybody.get_by_text("Published by North, version 1")).to_be_visible()
    expect(anybody.get_by_role("heading", name="Identification")).to_be_visible()
    expect(anybody.get_by_test_id("citation")).to_contain_text("Lovelace, Ada; Babbage, Charles (20")
    with anybody.expect_download() as download:
        anybody.get_by_role("link", name="results/results.json").click()
    shown = hashlib.sha256(download.value.path().read_bytes()).hexdigest()
    expect(anybody.get_by_role("row", name="results/results.json")).to_contain_text(shown[:16])
    with anybody.expect_popup() as report:
        anybody.get_by_role("link", name="The whole report").click()
    expect(report.value.get_by_role("heading").first).to_be_visible()
    page.goto(str(to))
    expect(page.get_by_role("heading", name="Identification")).to_be_visible()
    screenshot("published")

    monkeypatch.setenv("EXOGAUGE_TOKEN", token)
    first = north.get("/publications").json()["items"][0]
    again = ["publish", made["id"], "--title", "An arm, again", "--creator", "Lovelace, Ada; 0000-0001-5109-3700"]
    assert main([*again, "--follows", first["id"], "--server", service.url]) == 0
    second = re.search(r"/published/(\w+)\nversion 2", capsys.readouterr().out)
    assert second is not None
    anybody.reload()
    anybody.get_by_role("alert").get_by_role("link", name="Version 2").click()
    expect(anybody.get_by_text("Published by North, version 2")).to_be_visible()

    page.goto(f"/studies/{made['id']}")
    page.get_by_role("button", name="Publish: 2").click()
    page.get_by_role("button", name="Revoke version 1").click()
    page.get_by_label("Why, told at its address").fill("the wrong arm")
    page.get_by_role("button", name="Revoke it").click()
    expect(page.get_by_text("revoked", exact=False).first).to_be_visible()
    assert main(["revoke", second[1], "--reason", "too", "--server", service.url]) == 0
    anybody.goto(str(to))
    expect(anybody.get_by_role("alert")).to_contain_text("the wrong arm")
    expect(anybody.get_by_role("row", name="results/results.json")).to_contain_text(shown[:16])
    expect(anybody.get_by_role("link", name="results/results.json")).to_have_count(0)
    assert httpx.get(f"{service.url}/api/v1/published/{first['key']}/files/results/results.json").status_code == 410
    page.goto(str(to))
    expect(page.get_by_role("alert")).to_be_visible()
    screenshot("revoked")

    page.goto(f"/studies/{made['id']}")
    page.get_by_role("button", name="Delete").click()
    page.get_by_role("dialog").get_by_role("button", name="Keep it").click()
    expect(page.get_by_role("dialog")).to_have_count(0)
    expect(page.get_by_role("heading", name=made["name"], level=1)).to_be_visible()
    page.get_by_role("button", name="Delete").click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    expect(page.get_by_role("heading", name="Studies", level=1)).to_be_visible()
    expect(page.get_by_role("link", name=made["name"])).to_have_count(0)
    cleo.reload()
    expect(cleo.get_by_role("alert")).to_contain_text("no study")
    anybody.reload()
    expect(anybody.get_by_role("heading", name="An arm on a bench", level=1)).to_be_visible()
