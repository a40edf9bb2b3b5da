"""Devices: taken over, changed, undone, asked what they would do, and saved as a new version."""

from __future__ import annotations

import re
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import yaml
from playwright.sync_api import expect
from tests.motion.robots import sample_folder

from exogauge.client import Client

if TYPE_CHECKING:
    from playwright.sync_api import Page
    from tests.e2e.conftest import Service

STRAP = """version: 1
name: Back strap
bands:
  - name: left
    group: back
    via_points: [{link: chest, xyz: [-0.1, 0.08, 0.2]}, {link: BODY, xyz: [-0.12, 0.08, -0.05]}]
    stiffness_n_per_m: 300
    natural_length_m: 0.3
  - name: right
    group: back
    via_points: [{link: chest, xyz: [-0.1, -0.08, 0.2]}, {link: BODY, xyz: [-0.12, -0.08, -0.05]}]
    natural_length_m: 0.3
"""
A_DEVICE = re.compile(r"/devices/[0-9a-f-]{36}$")
NAME = "Smart Suit Lite, normal"


def open_device(page: Page) -> None:
    """The sample's device, taken over from its study where that was not done before."""
    page.goto("/devices")
    listed = page.get_by_role("link", name=NAME)
    take = page.get_by_role("button", name=f"Add it to the list: {NAME}")
    expect(listed.or_(take)).to_be_visible()
    if listed.is_visible():
        listed.click()
    else:
        take.click()
    page.wait_for_url(A_DEVICE)
    expect(page.get_by_role("heading", name=NAME, level=1)).to_be_visible()


def peak_now(page: Page, joint: str) -> float:
    row = page.get_by_role("region", name="Torque by joint: table").get_by_role("row").filter(has_text=joint)
    return float(row.get_by_role("cell").nth(1).inner_text().replace("−", "-"))


def test_an_empty_list_says_what_a_device_is(page: Page, screenshot: Callable[[str], None]) -> None:
    page.goto("/devices")
    expect(page.get_by_role("heading", name="No devices yet")).to_be_visible()
    expect(page.get_by_text("A device is checked on a robot")).to_be_visible()
    screenshot("devices-empty")


def test_a_stiffer_band_pulls_more_at_once(
    page: Page, sample_service: Service, screenshot: Callable[[str], None]
) -> None:
    open_device(page)
    expect(page.get_by_test_id("elapsed")).to_have_text(re.compile(r"answered in \d+ ms"), timeout=60_000)
    before = peak_now(page, "torso_pitch")
    page.get_by_label("Stiffness [N/m]", exact=True).fill("395.6")  # of both groups, A is the one over the back
    expect(page.get_by_text("2 changes, not saved")).to_be_visible()  # and no longer ground truth
    row = page.get_by_role("region", name="Torque by joint: table").get_by_role("row").filter(has_text="torso_pitch")
    expect(row.get_by_role("cell").nth(3)).to_have_text(re.compile(r"\+\d"))
    assert 1.5 * abs(before) < abs(peak_now(page, "torso_pitch")) < 2.5 * abs(before)
    screenshot("device-changed")


def test_a_law_of_bands_is_chosen_with_its_values_and_saved(
    page: Page, service: Service, tmp_path: Path, screenshot: Callable[[str], None]
) -> None:
    sample_folder(tmp_path / "robot")
    (tmp_path / "device.yaml").write_text(STRAP)
    with Client(service.url) as client:
        robot = client.upload_robot(tmp_path / "robot")
        device = client.upload_device(tmp_path / "device.yaml", robot)
    page.goto(f"/devices/{device.id}")
    page.get_by_role("combobox", name="Law").click()
    page.get_by_role("option", name="hysteresis").click()
    page.get_by_role("option", name="hardening").click()
    page.keyboard.press("Escape")
    expect(page.get_by_text("by a share that no speed changes")).to_be_visible()
    share = page.get_by_label("hysteresis", exact=True)
    expect(share).to_have_value("0.1")
    share.fill("2")
    expect(page.get_by_text("It must be 1 or less.")).to_be_visible()
    share.fill("0.25")
    expect(page.get_by_text("It must be 1 or less.")).to_be_hidden()
    screenshot("device-law")
    page.get_by_role("button", name="Save as a new version").click()
    dialog = page.get_by_role("dialog")
    expect(dialog).to_contain_text("Law of back: linear → hardening and hysteresis")
    expect(dialog).to_contain_text("hysteresis 0.25")
    dialog.get_by_role("button", name="Save", exact=True).click()
    expect(page.get_by_text("Version 2", exact=False).first).to_be_visible()
    expect(page.get_by_label("hysteresis", exact=True)).to_have_value("0.25")
    with page.expect_download() as download:
        page.get_by_role("link", name="device.yaml").click()
    bands = yaml.safe_load(download.value.path().read_text(encoding="utf-8"))["bands"]
    assert [band["law"] for band in bands] == ["hardening+hysteresis"] * 2
    assert [band["law_values"]["hysteresis"] for band in bands] == [0.25, 0.25]


def test_every_change_is_undone_and_redone_by_keys(page: Page, sample_service: Service) -> None:
    open_device(page)
    stretch = page.get_by_role("region", name="Bands: table").get_by_role("row").filter(has_text="B_left")
    page.get_by_role("radio", name="B_left").check()
    stiffness = page.get_by_label("Stiffness [N/m]", exact=True)
    slider = page.get_by_label("x of point 1, moved by [mm]")
    slider.focus()
    page.clock.set_fixed_time(datetime.now(UTC))  # presses within a moment are one step, on a busy machine too
    for _ in range(5):
        slider.press("ArrowRight")
    expect(page.get_by_label("x of point 1 [m]")).to_have_value("-0.115")  # from -0.12
    moved = stretch.inner_text()
    stiffness.fill("300")
    expect(stretch).to_contain_text("300")
    slider.focus()
    page.keyboard.press("Control+z")
    expect(stiffness).to_have_value("197.8")
    assert stretch.inner_text() == moved
    page.keyboard.press("Control+z")
    expect(page.get_by_text("As saved", exact=True)).to_be_visible()
    page.keyboard.press("Control+Shift+z")
    expect(page.get_by_label("x of point 1 [m]")).to_have_value("-0.115")


def test_the_device_is_shown_in_3d_where_it_is_asked_for(page: Page, sample_service: Service) -> None:
    open_device(page)
    page.get_by_text("3D", exact=True).click()
    frame = page.frame_locator("iframe")
    expect(frame.locator("canvas").first).to_be_visible(timeout=120_000)
    page.get_by_text("Drawing", exact=True).click()
    expect(page.get_by_role("img", name=re.compile("all joints at zero"))).to_be_visible()


def test_a_point_keeps_its_place_on_another_link_and_a_new_one_changes_nothing_yet(
    page: Page, sample_service: Service
) -> None:
    open_device(page)
    length = page.get_by_role("region", name="Bands: table").get_by_role("row").filter(has_text="A_left")
    before = length.get_by_role("cell").nth(3).inner_text()
    page.get_by_label("Link of point 3").select_option("BODY")
    expect(page.get_by_label("z of point 3 [m]")).not_to_have_value("0.11")
    assert length.get_by_role("cell").nth(3).inner_text() == before
    page.get_by_label("Add a point after 7").click()
    expect(page.get_by_label("Remove point 9")).to_be_visible()
    assert length.get_by_role("cell").nth(3).inner_text() == before


def test_a_change_is_saved_as_the_next_version_and_keeps_the_comments(page: Page, sample_service: Service) -> None:
    open_device(page)
    page.get_by_label("z of point 1 [m]").fill("0.4")
    page.get_by_label("Serial number").fill("0042")
    page.get_by_role("button", name="Save as a new version").click()
    dialog = page.get_by_role("dialog")
    expect(dialog).to_contain_text("Serial number: – → 0042")
    expect(dialog).to_contain_text("Via point 1 of A_left moved by 15 mm")
    dialog.get_by_label("Name").fill("Suit with a higher shoulder")
    dialog.get_by_role("button", name="Save", exact=True).click()
    expect(page.get_by_role("heading", name="Suit with a higher shoulder", level=1)).to_be_visible()
    with page.expect_download() as download:
        page.get_by_role("link", name="device.yaml").click()
    text = download.value.path().read_text(encoding="utf-8")
    assert text.startswith("# SYNTHETIC: written by")
    assert "xyz: [ 0.05, 0.085, 0.4 ]" in text or "xyz: [0.05, 0.085, 0.4]" in text
    assert 'serial: "0042"' in text
    expect(page.get_by_label("Serial number")).to_have_value("0042")
    assert text.count("ground_truth: true") == 2  # a moved point does not touch what is true of the band


def test_what_the_service_refuses_is_told_with_line_and_advice(page: Page, sample_service: Service) -> None:
    open_device(page)
    page.get_by_role("radio", name="B_left").check()
    for k in (3, 4):
        page.get_by_label(f"Link of point {k}").select_option("BODY")
    page.get_by_role("button", name="Save as a new version").click()
    page.get_by_role("dialog").get_by_role("button", name="Save", exact=True).click()
    alert = page.get_by_role("dialog").get_by_role("alert")
    expect(alert).to_contain_text("acts on no joint")
    expect(alert).to_contain_text("A band must cross a joint")
