"""A guard in front of the service whose session has ended: it is told, what was typed stays, and uploads go on."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from playwright.sync_api import expect
from tests.e2e.arm import arm_study
from tests.e2e.proxy import Guard, serve_below
from tests.e2e.test_import_page import hand_in_arm, vendor_log
from tests.e2e.test_studies_page import A_STUDY, drop

if TYPE_CHECKING:
    from playwright.sync_api import Locator, Page, Route
    from tests.e2e.conftest import Seen, Service

EXPIRED = "Your session has expired"
PIECE = 8 << 20


every_guard = pytest.mark.parametrize("guard", [401, 403, 302], indirect=True)


@pytest.fixture
def guard(request: pytest.FixtureRequest) -> Guard:
    return Guard(says=getattr(request, "param", 302))


@pytest.fixture
def guarded(guard: Guard, service: Service, page: Page) -> Iterator[str]:
    """The service behind the guard, below a path; the tab is signed in."""
    with serve_below(service.url, "/lab", guard) as url:
        page.goto(f"{url}/studies")
        page.get_by_role("link", name="Sign in").click()
        expect(page.get_by_role("heading", name="Studies", level=1)).to_be_visible()
        yield url


def banner(page: Page) -> Locator:
    return page.get_by_role("alert").filter(has_text=EXPIRED).filter(has_text="What you typed on this page stays")


def look_again(page: Page) -> None:
    """As a person does who comes back to the tab."""
    page.evaluate("document.dispatchEvent(new Event('visibilitychange'))")


def sign_in_again(page: Page) -> None:
    """Load the page anew, which leads to the guard's own page, and come back."""
    banner(page).get_by_role("button", name="Sign in again").click()
    page.get_by_role("link", name="Sign in").click()
    expect(page.get_by_role("navigation", name="Main")).to_be_visible()


def sign_in_elsewhere(page: Page, name: str = "In another tab") -> None:
    with page.context.expect_page() as opened:
        banner(page).get_by_role("link", name=name).click()
    opened.value.get_by_role("link", name="Sign in").click()
    expect(opened.value.get_by_role("navigation", name="Main")).to_be_visible()
    opened.value.close()
    look_again(page)


def map_columns(page: Page, name: str, log: bytes) -> None:
    drop(page, {name: log})
    page.get_by_role("button", name="Ignore the 2 open ones").click()
    expect(page.get_by_text("This makes a log of 2 channels")).to_be_visible()
    page.get_by_label("Keep this mapping").uncheck()  # it would spare the next one its questions


@every_guard
def test_the_end_of_a_session_is_told_and_what_was_typed_is_there_afterwards(
    page: Page, guarded: str, guard: Guard, screenshot: Callable[[str], None]
) -> None:
    hand_in_arm(page, guarded)
    map_columns(page, "vendor.csv", vendor_log(frozen=False))
    page.get_by_role("button", name="Store the log").click()
    expect(page.get_by_text("vendor.csv is stored")).to_be_visible()
    page.get_by_label("Name of the study").fill("Typed before")
    page.get_by_label("Evaluate at once").uncheck()
    map_columns(page, "other.csv", vendor_log(frozen=False).replace(b",ok", b",yes"))
    guard.expire()
    page.get_by_label("Unit of elbow_pos").select_option("rad")
    expect(banner(page)).to_be_visible()
    screenshot(f"session-expired-{guard.says}")
    sign_in_again(page)
    expect(page.get_by_label("Unit of elbow_pos")).to_have_value("rad")
    expect(page.get_by_label("Name of the study")).to_have_value("Typed before")
    expect(page.get_by_label("Evaluate at once")).not_to_be_checked()
    expect(page.get_by_label("Keep this mapping")).not_to_be_checked()
    expect(banner(page)).to_have_count(0)
    page.get_by_label("Unit of elbow_pos").select_option("deg")
    page.get_by_role("button", name="Store the log").click()
    expect(page.get_by_text("other.csv is stored")).to_be_visible()
    page.reload()
    expect(page.get_by_role("heading", name="Put stored logs into a study")).to_be_visible()
    expect(page.get_by_label("Name of the study")).to_have_value("")  # kept over a sign-in, not for ever


def test_signed_in_in_another_tab_the_page_goes_on_by_itself(page: Page, guarded: str, guard: Guard) -> None:
    to_robots = page.get_by_role("link", name="Robots", exact=True)
    to_robots.click()
    expect(page.get_by_role("heading", name="Robots", level=1)).to_be_visible()
    page.get_by_role("link", name="Compare", exact=True).click()
    expect(page.get_by_role("heading", name="Compare", level=1)).to_be_visible()
    guard.expire()
    page.wait_for_timeout(5_000)  # what is fresher than that is not asked for again
    to_robots.click()
    expect(banner(page)).to_be_visible()
    sign_in_elsewhere(page)
    expect(banner(page)).to_have_count(0)
    hand_in_arm(page, guarded)


def test_a_page_that_is_not_loaded_yet_leads_to_the_sign_in(page: Page, guarded: str, guard: Guard, seen: Seen) -> None:
    guard.expire()
    page.get_by_role("link", name="Devices", exact=True).click()
    told = page.get_by_role("alert").filter(has_text="or your session has expired")  # a poll may say so beside it
    expect(told).to_be_visible()
    page.get_by_role("button", name="Load it anew").click()
    page.get_by_role("link", name="Sign in").click()
    expect(page.get_by_role("heading", name="No devices yet")).to_be_visible()
    seen.errors.clear()


class Pieces:
    """Offsets of the pieces, by upload; the session ends when a second piece is sent first."""

    def __init__(self, page: Page, guard: Guard) -> None:
        self.sent: dict[str, list[int]] = {}
        self.guard: Guard | None = guard
        page.route("**/api/v1/uploads/*", self.pass_on)

    def pass_on(self, route: Route) -> None:
        if route.request.method == "PATCH":
            offset = int(route.request.headers["upload-offset"])
            if offset == PIECE and self.guard:
                self.guard.expire()
                self.guard = None
            self.sent.setdefault(route.request.url, []).append(offset)
        route.fallback()

    @property
    def large(self) -> list[list[int]]:
        return [offsets for offsets in self.sent.values() if max(offsets) >= PIECE]


def large_study(folder: Path) -> Path:
    """20 MB in three pieces."""
    for path, content in (arm_study("Sent in two goes") | {"logs/notes.csv": b"# nothing\n" * 2_000_000}).items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(content)
    return folder


def choose_folder(page: Page, folder: Path) -> None:
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Choose a folder").click()
    chooser.value.set_files(folder)


@every_guard
def test_an_upload_waits_for_the_sign_in_and_goes_on_where_it_was(
    page: Page, guarded: str, guard: Guard, tmp_path: Path, screenshot: Callable[[str], None]
) -> None:
    pieces = Pieces(page, guard)
    page.get_by_label("Evaluate at once").uncheck()
    choose_folder(page, large_study(tmp_path / "study"))
    expect(page.get_by_role("heading", name="Waiting until you have signed in")).to_be_visible()
    screenshot(f"session-expired-sending-{guard.says}")
    sign_in_elsewhere(page)
    page.wait_for_url(A_STUDY, timeout=60_000)
    expect(page.get_by_role("heading", name="Sent in two goes", level=1)).to_be_visible()
    assert pieces.large == [[0, PIECE, PIECE, 2 * PIECE]]


def test_chosen_again_after_the_sign_in_an_upload_goes_on_where_it_was(
    page: Page, guarded: str, guard: Guard, tmp_path: Path
) -> None:
    pieces = Pieces(page, guard)
    page.get_by_label("Evaluate at once").uncheck()
    choose_folder(page, large_study(tmp_path / "study"))
    sign_in_again(page)
    expect(page.get_by_role("alert").filter(has_text="Choose the same files again")).to_be_visible()
    expect(page.get_by_label("Evaluate at once")).not_to_be_checked()
    choose_folder(page, tmp_path / "study")
    page.wait_for_url(A_STUDY, timeout=60_000)
    assert pieces.large == [[0, PIECE, PIECE, 2 * PIECE]]
