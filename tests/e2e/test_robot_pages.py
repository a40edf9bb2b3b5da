"""Robots: handed in, read, and set beside what a study identified."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING

from playwright.sync_api import expect
from tests.e2e.arm import arm_study
from tests.e2e.test_studies_page import drop

if TYPE_CHECKING:
    from playwright.sync_api import Page
    from tests.e2e.conftest import Service


def test_a_dropped_robot_shows_its_joints_drives_links_and_files(page: Page, screenshot: Callable[[str], None]) -> None:
    page.goto("/robots")
    expect(page.get_by_role("heading", name="No robots yet")).to_be_visible()
    screenshot("robots-empty")
    files = arm_study()
    drop(page, {path: files[path] for path in ("robot.yaml", "robot.urdf")})
    expect(page.get_by_role("heading", name="One-joint arm", level=1)).to_be_visible()
    elbow = page.get_by_role("region", name="Joints: table").get_by_role("row").filter(has_text="elbow")
    expect(elbow).to_contain_text("−114.6")  # -2 rad in the URDF
    expect(elbow).to_contain_text("torque")
    links = page.get_by_role("region", name="Links: table")
    expect(links.get_by_role("row").filter(has_text="elbow")).to_contain_text("0.200")
    with page.expect_download() as download:
        page.get_by_role("link", name="robot.urdf").click()
    assert download.value.path().read_bytes() == files["robot.urdf"]


def test_a_robot_without_its_urdf_is_refused_with_file_and_advice(page: Page) -> None:
    page.goto("/robots")
    page.get_by_role("button", name="Choose files").wait_for()
    drop(page, {"robot.yaml": arm_study()["robot.yaml"]})
    expect(page.get_by_role("alert")).to_contain_text("robot.urdf")


def test_a_robot_of_a_study_is_taken_over_and_shows_what_was_identified(
    page: Page, sample_service: Service, screenshot: Callable[[str], None]
) -> None:
    page.goto("/robots")
    listed = page.get_by_role("link", name="hrp4_like")  # where another test has taken over what wears its device
    take = page.get_by_role("button", name="Add it to the list")
    listed.or_(take).click()
    expect(page.get_by_role("heading", name="hrp4_like", level=1)).to_be_visible()
    expect(page.get_by_text("which has these very files")).to_be_visible()
    waist = (
        page.get_by_role("region", name="Drives and friction: table").get_by_role("row").filter(has_text="torso_yaw")
    )
    of_maker_then_identified = re.compile(r"5\.00 ± 0\.50.*±")  # torque per ampere
    expect(waist.get_by_role("cell").first).to_contain_text(of_maker_then_identified)
    page.get_by_label("Also the 12 frames fixed to them").check()
    expect(page.get_by_role("region", name="Links: table").get_by_role("row")).to_have_count(48)
    screenshot("robot")
