"""The review of a study: what its page says is what results.json holds, and a link brings back the view."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import pyarrow.parquet as pq
import pytest
from playwright.sync_api import expect
from tests.e2e.arm import arm_study, zipped

from exogauge import Client

if TYPE_CHECKING:
    from pathlib import Path

    from playwright.sync_api import Locator, Page
    from tests.e2e.conftest import Service

PARTS = ("Summary", "Identification", "Support", "Bands", "Disagreement", "Plots", "Scope", "Files", "Run and logs")
LOG = "bend_normal_1"


def value_of(text: str) -> float:
    """The first number of a text, with the page's minus sign."""
    found = re.search(r"[−-]?\d+(?:\.\d+)?", text)
    assert found is not None, text
    return float(found.group().replace("−", "-"))


def same_to_the_digits_shown(text: str, value: float) -> bool:
    """Whether the text is `value`, rounded to the text's own last digit."""
    shown = re.search(r"\d+(?:\.(\d+))?", text)
    assert shown is not None, text
    return math.isclose(value_of(text), value, abs_tol=0.5000001 * 10.0 ** -len(shown.group(1) or ""))


def time_axis(page: Page, title: str) -> Locator:
    return page.get_by_role("slider", name=f"{title}: time")


def test_each_part_of_the_review_is_accessible_in_every_look(
    page: Page, study: dict[str, Any], screenshot: Callable[[str], None]
) -> None:
    page.goto(study["path"])
    for part in PARTS:
        link = page.get_by_role("navigation", name="Parts of the review").get_by_role("link", name=part)
        link.click()
        expect(link).to_have_attribute("aria-current", "page")
        expect(page.get_by_role("main").get_by_role("heading", level=2).first).to_be_visible()
        screenshot(f"review-{part.split()[0].lower()}")


def test_numbers_on_the_page_are_those_of_results_json(page: Page, study: dict[str, Any]) -> None:
    results = study["results"]
    page.goto(f"{study['path']}/support")
    each = next(each for each in results["support"] if each["main"])
    row = page.locator(f'[data-support="{each["device"]}|{each["motion"]}|{each["joint"]}|A"]')
    expect(row).to_be_visible()
    cells = row.get_by_role("cell").filter(has_text="N·m").all_inner_texts()
    assert any(same_to_the_digits_shown(cell, each["rmse_a"]) for cell in cells)
    assert any(same_to_the_digits_shown(cell, each["approaches"]["A"]["peak"]["value"]) for cell in cells)

    page.goto(f"{study['path']}/stiffness")
    band = results["stiffness"][0]
    row = page.locator(f'[data-band="{band["device"]}|{band["band"]}|{band["approach"]}"]')
    text = row.get_by_role("cell").filter(has_text="N/m").first.inner_text()
    assert same_to_the_digits_shown(text, band["stiffness_n_per_m"]["value"]), text

    page.get_by_text("What ought to agree").first.click()
    checks = [each for each in results["cross_checks"] if each["device"] == band["device"]]
    rows = page.get_by_role("region", name=f"What ought to agree of {band['device']}: table").locator("tbody tr")
    expect(rows).to_have_count(len(checks))
    worst = max(checks, key=lambda each: (not each["agrees"], abs(each["z"]) / each["limit"]))
    cell = rows.first.get_by_role("cell").filter(has_text="±").inner_text()
    assert same_to_the_digits_shown(cell, worst["difference"]), cell

    page.goto(f"{study['path']}/identification")
    parameter = next(each for each in results["identification"]["parameters"] if each["name"] == "k_T[torso_pitch]")
    page.get_by_label("Find a parameter").fill("k_T[torso_pitch]")
    text = (
        page.locator('[data-parameter="k_T[torso_pitch]"]').get_by_role("cell").filter(has_text="±").first.inner_text()
    )
    assert same_to_the_digits_shown(text, parameter["value"]), text


def test_the_named_effect_its_place_and_its_evidence_are_told(page: Page, study: dict[str, Any]) -> None:
    (finding,) = study["results"]["discrepancy"]["findings"]
    page.goto(f"{study['path']}/disagreement")
    expect(page.get_by_role("heading", name="Stribeck friction at torso_pitch")).to_be_visible()
    verdict = page.get_by_test_id("verdict").inner_text()
    before = re.search(r"from ([\d.]+)", verdict)
    assert before is not None, verdict
    assert same_to_the_digits_shown(before.group(1), finding["held_out"]["rmse_before"])
    page.get_by_text("The same as a table").click()
    rows = page.get_by_role("region", name="Evidence for").get_by_role("row")
    assert rows.count() == 1 + len(finding["curve"]["coordinate"]["values"])


def test_the_cursor_moves_by_keyboard_and_a_link_brings_the_view_back(page: Page, study: dict[str, Any]) -> None:
    page.goto(f"{study['path']}/plots?log={LOG}&show=support.torso_pitch&show=tension")
    axis = time_axis(page, "Supporting torque at torso_pitch")
    axis.focus()
    page.keyboard.press("Home")
    for _ in range(4):
        page.keyboard.press("Shift+ArrowRight")
    expect(page).to_have_url(re.compile(r"at=\d"))
    page.keyboard.press("+")
    expect(page).to_have_url(re.compile(r"from=\d|to=\d"))
    page.keyboard.press("ArrowRight")
    expect(axis).to_have_attribute("aria-valuetext", re.compile(r"A: without"))
    page.wait_for_timeout(1500)  # until the address holds where the cursor rests
    expect(axis).to_have_attribute("aria-valuetext", re.compile(r"A: without"))  # what was zoomed to is there
    address, window = page.url, page.get_by_test_id("window").inner_text()
    words = axis.get_attribute("aria-valuetext")
    assert words is not None
    assert "0.000 s" not in words

    page.goto("/studies")
    page.goto(address)
    expect(page.get_by_test_id("window")).to_have_text(window)
    expect(time_axis(page, "Supporting torque at torso_pitch")).to_have_attribute("aria-valuetext", words)
    expect(time_axis(page, "Tension of the bands")).to_be_visible()
    assert page.url == address


def test_a_value_at_the_cursor_is_the_sample_of_the_file(
    page: Page, study: dict[str, Any], sample_service: Service, tmp_path: Path
) -> None:
    with Client(sample_service.url) as client:
        client.download(study["job"], tmp_path)
    series = pq.read_table(tmp_path / "series" / f"{LOG}.parquet")
    row = 600
    at = series.column("t")[row].as_py()
    page.goto(f"{study['path']}/plots?log={LOG}&show=tension&at={at}")
    for band in ("A_left", "A_right"):
        cell = page.get_by_role("row", name=re.compile(band)).get_by_role("cell").last
        expect(cell).to_have_text(re.compile(r"\d"))
        assert same_to_the_digits_shown(cell.inner_text(), series.column(f"band.{band}.tension")[row].as_py())


def test_dragging_zooms_every_plot_and_a_double_click_shows_the_whole(page: Page, study: dict[str, Any]) -> None:
    page.goto(f"{study['path']}/plots?log={LOG}&show=support.torso_pitch&show=tension")
    axes = [time_axis(page, "Supporting torque at torso_pitch"), time_axis(page, "Tension of the bands")]
    whole = [(axis.get_attribute("aria-valuemin"), axis.get_attribute("aria-valuemax")) for axis in axes]
    over = page.locator(".u-over").first
    expect(over).to_be_visible()
    box = over.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 0.25 * box["width"], box["y"] + 40)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 50, steps=5)
    page.mouse.up()
    expect(page).to_have_url(re.compile(r"from=\d.*to=\d"))
    for axis, (_, before) in zip(axes, whole, strict=True):
        expect(axis).not_to_have_attribute("aria-valuemax", before or "")
    (low, high), *others = [(axis.get_attribute("aria-valuemin"), axis.get_attribute("aria-valuemax")) for axis in axes]
    assert others == [(low, high)]
    assert float(high or 0) - float(low or 0) == pytest.approx(0.25 * float(whole[0][1] or 0), rel=0.05)
    page.locator(".u-over").last.dblclick()
    expect(axes[0]).to_have_attribute("aria-valuemax", whole[0][1] or "")


def test_dragging_asks_for_nothing_and_no_graphics_card_is_needed(page: Page, study: dict[str, Any]) -> None:
    page.goto(f"{study['path']}/plots?log={LOG}&show=support.torso_pitch&show=tension")
    expect(page.locator(".u-over")).to_have_count(2)
    over = page.locator(".u-over").first
    over.scroll_into_view_if_needed()
    expect(page.locator("[aria-busy=true]")).to_have_count(0)
    page.wait_for_timeout(1_000)
    attributes = "(all) => all.map((one) => one.getContext('2d').getContextAttributes().willReadFrequently)"
    assert page.locator("canvas").evaluate_all(attributes) == [True, True]
    box = over.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 5, box["y"] + 40)
    page.mouse.down()
    page.wait_for_timeout(1_000)
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url) if "/tiles" in request.url else None)
    for share in (0.2, 0.3, 0.4, 0.5):
        page.mouse.move(box["x"] + share * box["width"], box["y"] + 50)
        page.wait_for_timeout(250)  # longer than a cursor must rest to be read
    assert asked == []
    with page.expect_request(lambda request: "/tiles" in request.url):
        page.mouse.up()


def test_the_part_that_is_open_is_in_sight_on_a_narrow_screen(page: Page, study: dict[str, Any]) -> None:
    page.set_viewport_size({"width": 420, "height": 800})
    page.goto(f"{study['path']}/scope")
    link = page.get_by_role("navigation", name="Parts of the review").get_by_role("link", name="Scope")
    expect(link).to_have_attribute("aria-current", "page")
    expect(link).to_be_in_viewport(ratio=1.0)


def test_a_window_is_taken_away_as_rows_and_as_a_picture(page: Page, study: dict[str, Any]) -> None:
    page.goto(f"{study['path']}/plots?log={LOG}&show=tension&from=3&to=4")
    taken = {}
    for name in ("CSV", "Parquet", "SVG", "PNG"):
        page.get_by_role("button", name="Export this window").click()
        with page.expect_download() as download:
            page.get_by_role("menuitem", name=name).click()
        taken[name] = download.value.path().read_bytes()
        page.keyboard.press("Escape")
    header, *rows = taken["CSV"].decode().splitlines()
    times = [float(line.split(",")[0]) for line in rows]
    assert header.startswith('"t","band.A_left.tension"')
    assert (times[0], times[-1]) == (3.0, 4.0)
    assert pq.read_table(io.BytesIO(taken["Parquet"])).num_rows == len(rows) == 201  # 200 Hz, both ends
    assert taken["PNG"].startswith(b"\x89PNG")
    assert b"Tension of the bands [N]" in taken["SVG"]


def test_a_job_tells_its_place_in_the_queue_is_cancelled_and_run_again(
    page: Page, service: Service, tmp_path: Path, screenshot: Callable[[str], None]
) -> None:
    (tmp_path / "arm.zip").write_bytes(zipped(arm_study()))
    with Client(service.url) as client:
        study = client.upload_study(tmp_path / "arm.zip")
        for cutoff_hz in (5.0, 6.0):
            ahead = client.submit(study, settings={"cutoff_hz": cutoff_hz})
        job = client.submit(study)
        page.goto(f"/studies/{study.id}?job={job.id}")
        expect(page.get_by_text("In the queue:")).to_be_visible()
        page.get_by_role("button", name="Cancel").click()
        expect(page.get_by_text("This job was cancelled")).to_be_visible()
        screenshot("review-cancelled")
        page.get_by_role("button", name="Run it again").click()
        expect(page.get_by_role("navigation", name="Parts of the review")).to_be_visible(timeout=300_000)
        assert client.job(ahead).state == "succeeded"  # it stood before
    page.get_by_role("combobox", name="Job").click()
    expect(page.get_by_role("option")).to_have_count(4)
