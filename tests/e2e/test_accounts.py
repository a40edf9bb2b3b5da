"""Accounts in the browser: set up, invite, join, tokens, audit, what a viewer may, sign out and in, another lab."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import httpx
import pytest
from playwright.sync_api import expect
from tests.e2e.arm import arm_study
from tests.e2e.conftest import running

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page
    from tests.e2e.conftest import Service

WORDS = "three old lamps glow"


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory, browser: Browser) -> Iterator[Service]:
    with running(tmp_path_factory.mktemp("accounts"), workers=0, EXOGAUGE_ACCOUNTS="1") as started:
        yield started


def fill(page: Page, **typed: str) -> None:
    for label, value in typed.items():
        page.get_by_label(label.replace("_", " "), exact=False).first.fill(value)


def test_a_lab_is_set_up_shared_and_looked_after(
    page: Page, service: Service, browser: Browser, screenshot: Callable[..., None]
) -> None:
    page.goto("/robots")  # leads to where the first account is made
    expect(page.get_by_role("heading", name="Set up")).to_be_visible()
    expect(page.get_by_role("navigation", name="Main")).to_have_count(0)
    screenshot("accounts-set-up")
    code = (service.data / "set-up-code").read_text()
    fill(page, Code="guessed", Your_name="Ada", Password=WORDS, Name_of_your_lab="North")
    page.get_by_label("E-mail address").fill("ada@example.org")
    page.get_by_role("button", name="Make the account").click()
    expect(page.get_by_role("alert")).to_contain_text("not the code")
    page.get_by_label("Code").fill(code)
    page.get_by_role("button", name="Make the account").click()
    expect(page.get_by_role("heading", name="Studies", level=1)).to_be_visible()

    page.get_by_role("button", name="Account of Ada").click()
    page.get_by_role("menuitem", name="Lab North").click()
    expect(page.get_by_role("heading", name="North", level=1)).to_be_visible()
    page.get_by_label("E-mail address").fill("bob@example.org")
    page.get_by_label("As", exact=True).select_option("viewer")
    page.get_by_role("button", name="Invite", exact=True).click()
    link = page.get_by_test_id("secret").inner_text().strip()
    assert link.startswith(f"{service.url}/invited#")
    screenshot("accounts-lab")
    page.get_by_label("Role of Ada").select_option("viewer")
    expect(page.get_by_role("alert").filter(has_text="keeps an admin")).to_be_visible()

    context = browser.new_context(base_url=service.url)
    bob = context.new_page()
    bob.goto(link)
    expect(bob.get_by_text("You are invited to the lab North as viewer")).to_be_visible()
    bob.get_by_label("Your name").fill("Bob")
    bob.get_by_label("Password").first.fill(WORDS)
    bob.get_by_role("button", name="Make the account and join").click()
    expect(bob.get_by_role("heading", name="Studies", level=1)).to_be_visible()
    for path in ("studies", "robots", "devices", "payloads", "payloads/new", "import"):
        bob.goto(f"/{path}")
        expect(bob.get_by_test_id("why-not").first).to_contain_text("You are viewer of the lab North, and read only")
        expect(bob.get_by_role("button", name="Choose", exact=False)).to_have_count(0)
    bob.goto("/lab")
    expect(bob.get_by_text("You are viewer of this lab")).to_be_visible()
    expect(bob.get_by_role("button", name="Remove Ada")).to_have_count(0)
    bob.goto("/lab/audit")
    expect(bob.get_by_text("bob@example.org").first).to_be_visible()
    expect(bob.get_by_text("Who did what")).to_have_count(0)

    page.goto("/account")
    page.get_by_placeholder("what it is for").fill("bench")
    page.get_by_label("It may").select_option("write")
    page.get_by_role("button", name="Make a token").click()
    token = page.get_by_test_id("secret").inner_text().strip()
    screenshot("accounts-tokens")
    asked = {"headers": {"Authorization": f"Bearer {token}"}}
    assert httpx.get(f"{service.url}/api/v1/studies", **asked).status_code == 200  # type: ignore[arg-type]
    page.get_by_role("button", name="Done").click()
    assert token not in page.content()
    page.get_by_role("button", name="Revoke bench").click()
    expect(page.get_by_role("cell", name="revoked")).to_be_visible()
    assert httpx.get(f"{service.url}/api/v1/studies", **asked).status_code == 401  # type: ignore[arg-type]

    page.goto("/lab")
    page.get_by_role("tab", name="Audit").click()
    expect(page.get_by_role("cell", name="bench, write, of its maker")).to_be_visible()
    expect(page.get_by_role("cell", name="bob@example.org as viewer, invited")).to_be_visible()
    screenshot("accounts-audit")
    page.goto("/lab")
    page.get_by_role("button", name="Remove Bob").click()
    page.get_by_role("button", name="Keep Bob").click()
    page.get_by_role("button", name="Remove Bob").click()
    page.get_by_role("button", name="Remove, with its tokens").click()
    expect(page.get_by_role("button", name="Remove, with its tokens")).to_have_count(0)
    expect(page.get_by_role("button", name="Remove Bob")).to_have_count(0)
    bob.goto("/studies")
    expect(bob.get_by_role("alert").first).to_contain_text("of no lab; ask an admin")
    context.close()

    page.goto("/account")
    page.get_by_label("Its name").fill("South")
    page.get_by_role("button", name="Found it").click()
    expect(page.get_by_role("heading", name="South", level=1)).to_be_visible()
    page.get_by_role("button", name="Account of Ada").click()
    page.get_by_role("menuitem", name="North", exact=True).click()
    expect(page.get_by_role("button", name="Account of Ada, lab North")).to_be_visible()

    page.get_by_role("button", name="Account of Ada").click()
    page.get_by_role("menuitem", name="Sign out").click()
    expect(page.get_by_role("heading", name="Sign in")).to_be_visible()
    screenshot("accounts-sign-in")
    page.goto("/devices?search=x")
    page.get_by_label("E-mail address").fill("ada@example.org")
    page.get_by_label("Password").first.fill("wrong")
    page.get_by_role("button", name="Sign in").click()
    expect(page.get_by_role("alert")).to_contain_text("is wrong")
    page.get_by_label("Password").first.fill(WORDS)
    page.get_by_role("button", name="Sign in").click()
    expect(page.get_by_role("heading", name="Devices", level=1)).to_be_visible()
    assert page.url.endswith("/devices?search=x")


def test_the_end_of_a_session_leads_to_our_own_sign_in_and_back(page: Page, service: Service) -> None:
    page.goto("/sign-in")
    page.get_by_label("E-mail address").fill("ada@example.org")
    page.get_by_label("Password").first.fill(WORDS)
    page.get_by_role("button", name="Sign in").click()
    expect(page.get_by_role("heading", name="Studies", level=1)).to_be_visible()
    page.context.clear_cookies()
    page.get_by_role("link", name="Robots", exact=True).click()
    page.get_by_role("button", name="Sign in again").click()
    page.get_by_label("E-mail address").fill("ada@example.org")
    page.get_by_label("Password").first.fill(WORDS)
    page.get_by_role("button", name="Sign in").click()
    expect(page.get_by_role("heading", name="Robots", level=1)).to_be_visible()


def test_a_study_is_shared_with_one_lab_read_there_and_gone_again(
    page: Page, service: Service, browser: Browser
) -> None:
    page.goto("/sign-in")
    sign_in(page)
    asked = {"base_url": f"{service.url}/api/v1", "headers": {"Origin": service.url}, "timeout": 60.0}
    with httpx.Client(**asked) as north:  # type: ignore[arg-type]
        north.post("/session", json={"email": "ada@example.org", "password": WORDS})
        labs = {lab["name"]: lab["id"] for lab in north.get("/session").json()["labs"]}
        north.put("/session/lab", json={"lab_id": labs["South"]})
        code = north.post("/lab/invitations", json={"email": "cleo@example.org", "role": "member"}).json()["code"]
        north.put("/session/lab", json={"lab_id": labs["North"]})
        made = north.post("/studies", files=[("files", (path, text)) for path, text in arm_study().items()]).json()
    page.goto(f"/studies/{made['id']}")
    page.get_by_role("button", name="Share").click()
    page.get_by_label("Name of another lab").fill("Nowhere")
    page.get_by_role("dialog").get_by_role("button", name="Share", exact=True).click()
    expect(page.get_by_role("alert")).to_contain_text("no other lab")
    page.get_by_label("Name of another lab").fill("South")
    page.get_by_role("dialog").get_by_role("button", name="Share", exact=True).click()
    expect(page.get_by_role("button", name="End for South")).to_be_visible()
    context = browser.new_context(base_url=service.url)
    cleo = context.new_page()
    cleo.goto(f"/invited#{code}")
    cleo.get_by_label("Your name").fill("Cleo")
    cleo.get_by_label("Password").first.fill(WORDS)
    cleo.get_by_role("button", name="Make the account and join").click()
    cleo.get_by_role("region", name="Shared with your lab").get_by_role("link").click()
    expect(cleo.get_by_role("heading", level=1)).to_contain_text(made["name"])
    expect(cleo.get_by_role("button", name="Share")).to_have_count(0)
    page.get_by_role("button", name="End for South").click()
    expect(page.get_by_role("button", name="End for South")).to_have_count(0)
    cleo.reload()
    expect(cleo.get_by_role("alert")).to_contain_text("no study")
    context.close()


def sign_in(page: Page) -> None:
    page.get_by_label("E-mail address").fill("ada@example.org")
    page.get_by_label("Password").first.fill(WORDS)
    page.get_by_role("button", name="Sign in").click()
    expect(page.get_by_role("heading", name="Studies", level=1)).to_be_visible()
