"""The 3D view says when all that it was asked for is drawn; pictures of it wait for that."""

from __future__ import annotations

from typing import TYPE_CHECKING

from playwright.sync_api import expect
from tests.e2e.arm import arm_study
from tests.e2e.robot_in_3d import differing, drawn, listen, picture
from tests.e2e.test_studies_page import drop

if TYPE_CHECKING:
    from playwright.sync_api import Page

DARK = 'document.querySelector("iframe").contentWindow.postMessage({type: "theme", dark: true}, "*")'


def test_a_picture_shows_what_was_asked_for_before_it(page: Page) -> None:
    listen(page)
    files = arm_study()
    page.goto("/robots")
    drop(page, {path: files[path] for path in ("robot.yaml", "robot.urdf")})
    expect(page.get_by_role("heading", name="One-joint arm", level=1)).to_be_visible()
    page.get_by_text("3D", exact=True).click()
    expect(page.frame_locator("iframe").locator("canvas").first).to_be_visible(timeout=180_000)
    light = picture(page)
    assert drawn(light) > 0.0
    page.evaluate(DARK)
    assert differing(light, picture(page)) > 0.5
