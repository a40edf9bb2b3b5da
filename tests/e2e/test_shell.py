"""What stands around every page: navigation, colours, the way below a proxy, and what is said when something fails."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from playwright.sync_api import expect
from tests.e2e.arm import arm_study, zipped

if TYPE_CHECKING:
    from playwright.sync_api import Page, Route
    from tests.e2e.conftest import Seen


@pytest.mark.parametrize("name", ["Studies", "Robots", "Devices", "Compare"])
def test_every_place_is_reached_from_every_page_and_says_where_it_is(page: Page, name: str) -> None:
    page.goto("/studies/none/such")
    link = page.get_by_role("navigation", name="Main").get_by_role("link", name=name)
    link.click()
    expect(page.get_by_role("heading", name=name, level=1)).to_be_visible()
    expect(link).to_have_attribute("aria-current", "page")
    assert page.title() == f"{name} · exogauge"


def test_an_unknown_address_is_answered_404_and_leads_on(page: Page, screenshot: Callable[[str], None]) -> None:
    answer = page.goto("/no/such")
    assert answer is not None
    assert answer.status == 404
    expect(page.get_by_role("heading", name="There is no such page")).to_be_visible()
    screenshot("not-found")
    page.get_by_role("link", name="To the studies").click()
    expect(page.get_by_role("heading", name="Studies", level=1)).to_be_visible()


def test_the_keyboard_skips_the_header(page: Page) -> None:
    page.goto("/studies")
    expect(page.get_by_role("heading", name="Studies", level=1)).to_be_visible()
    page.keyboard.press("Tab")
    expect(page.get_by_role("button", name="Skip to the page")).to_be_focused()
    page.keyboard.press("Enter")
    expect(page.get_by_role("main")).to_be_focused()


def test_colours_that_were_chosen_stay(page: Page) -> None:
    page.emulate_media(color_scheme="light")
    page.goto("/studies")
    root = page.locator("html")
    expect(root).to_have_attribute("data-mantine-color-scheme", "light")
    page.get_by_role("button", name="Colours").click()
    page.get_by_role("menuitemradio", name="Dark").click()
    expect(root).to_have_attribute("data-mantine-color-scheme", "dark")
    page.reload()
    expect(root).to_have_attribute("data-mantine-color-scheme", "dark")


def test_the_app_lives_below_any_path_of_a_proxy(page: Page, service_below: str) -> None:
    """Deep links, assets, API and navigation, though the service was not told the path."""
    page.goto(f"{service_below}/robots/some/where")
    page.get_by_role("link", name="Studies", exact=True).click()
    expect(page.get_by_role("heading", name="No studies yet")).to_be_visible()
    assert page.url == f"{service_below}/studies"
    page.reload()
    expect(page.get_by_role("heading", name="No studies yet")).to_be_visible()


def test_a_study_is_handed_in_below_a_path_of_a_proxy(page: Page, service_below: str, tmp_path: Path) -> None:
    (tmp_path / "arm.zip").write_bytes(zipped(arm_study()))
    page.goto(f"{service_below}/studies")
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Choose files").click()
    chooser.value.set_files(tmp_path / "arm.zip")
    expect(page.get_by_role("heading", name="Arm on a bench", level=1)).to_be_visible(timeout=60_000)
    assert page.url.startswith(f"{service_below}/studies/")


def test_a_service_that_is_silent_is_named_and_its_return_is_noticed(
    page: Page, screenshot: Callable[[str], None], seen: Seen
) -> None:
    away = {"now": False}

    def answer(route: Route) -> None:
        if away["now"]:
            route.abort()
        else:
            route.fallback()

    for pattern in ("**/api/**", "**/readyz"):
        page.route(pattern, answer)
    page.goto("/studies")
    expect(page.get_by_role("heading", name="Drop a study here")).to_be_visible()
    away["now"] = True
    page.get_by_role("link", name="exogauge", exact=True).click()
    page.evaluate("window.dispatchEvent(new Event('focus')), document.dispatchEvent(new Event('visibilitychange'))")
    banner = page.get_by_role("alert").filter(has_text="The service cannot be reached")
    expect(banner).to_be_visible(timeout=40_000)
    screenshot("unreachable")
    away["now"] = False
    banner.get_by_role("button", name="Ask now").click()
    expect(banner).to_have_count(0)


def test_a_page_whose_script_fails_says_what_to_do(page: Page, seen: Seen) -> None:
    page.route("**/assets/RobotsPage-*.js", lambda route: route.abort())
    page.goto("/robots")
    expect(page.get_by_role("heading", name="This page could not be loaded")).to_be_visible()
    expect(page.get_by_role("button", name="Load it anew")).to_be_visible()
    seen.errors.clear()
