"""The list of studies, from nothing to an evaluated study."""

from __future__ import annotations

import base64
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from playwright.sync_api import expect
from tests.e2e.arm import arm_study, zipped

if TYPE_CHECKING:
    from playwright.sync_api import Page, Route

A_STUDY = re.compile(r"/studies/[0-9a-f-]{36}$")
DROP = """([target, files]) => {
  const data = new DataTransfer();
  for (const [name, content] of files) {
    data.items.add(new File([Uint8Array.from(atob(content), (c) => c.charCodeAt(0))], name));
  }
  target.dispatchEvent(new DragEvent("drop", {dataTransfer: data, bubbles: true, cancelable: true}));
}"""


def drop(page: Page, files: Mapping[str, bytes]) -> None:
    target = page.locator(".mantine-Dropzone-root").element_handle()
    page.evaluate(DROP, [target, [[name, base64.b64encode(content).decode()] for name, content in files.items()]])


def test_an_empty_service_says_what_to_do(page: Page, screenshot: Callable[[str], None]) -> None:
    page.goto("/")
    expect(page.get_by_role("heading", name="No studies yet")).to_be_visible()
    expect(page.get_by_text("At most 8 GiB and 1000 files.")).to_be_visible()
    assert page.title() == "Studies · exogauge"
    screenshot("studies-empty")


def test_a_dropped_zip_becomes_an_evaluated_study(page: Page) -> None:
    page.goto("/studies")
    drop(page, {"arm.zip": zipped(arm_study())})
    page.wait_for_url(A_STUDY)
    expect(page.get_by_role("heading", name="Arm on a bench", level=1)).to_be_visible()
    page.get_by_role("link", name="Studies", exact=True).click()
    row = page.get_by_role("listitem").filter(has_text="Arm on a bench")
    expect(row.get_by_text("Done")).to_be_visible(timeout=120_000)
    expect(row).to_contain_text("One-joint arm · 1 joint · 2 logs")


def test_single_files_without_a_description_are_not_sent(page: Page) -> None:
    page.goto("/studies")
    page.locator("input[type=file]").nth(1).wait_for(state="attached")
    drop(page, {"id.csv": b"t\n0\n"})
    alert = page.get_by_role("alert")
    expect(alert).to_contain_text("Nothing was sent")
    expect(alert).to_contain_text("study.yaml is not among these files")


def test_a_folder_is_handed_in_with_its_paths(page: Page, tmp_path: Path) -> None:
    for path, content in arm_study("From a folder").items():
        (tmp_path / "my study" / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "my study" / path).write_bytes(content)
    page.goto("/studies")
    page.get_by_label("Evaluate at once").uncheck()
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Choose a folder").click()
    chooser.value.set_files(tmp_path / "my study")
    page.wait_for_url(A_STUDY)
    expect(page.get_by_role("heading", name="From a folder", level=1)).to_be_visible()
    expect(page.get_by_text("Not evaluated yet")).to_be_visible()


def test_what_is_wrong_with_a_study_is_a_list_with_file_row_and_advice(
    page: Page, screenshot: Callable[[str], None]
) -> None:
    files = arm_study("Broken")
    files["logs/id.csv"] = files["logs/id.csv"].replace(b"\n0.020,", b"\n0.020x,")
    page.goto("/studies")
    drop(page, {"broken.zip": zipped(files)})
    alert = page.get_by_role("alert")
    expect(alert.get_by_role("listitem").first).to_contain_text("logs/id.csv, row 3")
    expect(alert).to_contain_text("0.020x")
    screenshot("studies-refused")


def test_a_broken_line_goes_on_where_it_was(page: Page, tmp_path: Path) -> None:
    """20 MB in three pieces, of which the second is cut once."""
    files = arm_study("Over a bad line") | {"logs/notes.csv": b"# nothing\n" * 2_000_000}
    for path, content in files.items():
        (tmp_path / "bad line" / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "bad line" / path).write_bytes(content)
    pieces: list[tuple[str, str]] = []

    def cut(route: Route) -> None:
        asked = route.request
        if asked.method == "PATCH":
            pieces.append((asked.url, asked.headers["upload-offset"]))
            if asked.headers["upload-offset"] == str(8 << 20) and pieces.count(pieces[-1]) == 1:
                route.abort()
                return
        route.fallback()

    page.route("**/api/v1/uploads/*", cut)
    page.goto("/studies")
    page.get_by_label("Evaluate at once").uncheck()
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Choose a folder").click()
    chooser.value.set_files(tmp_path / "bad line")
    page.wait_for_url(A_STUDY, timeout=60_000)
    large = {url for url, offset in pieces if offset == str(8 << 20)}
    assert [offset for url, offset in pieces if url in large] == ["0", str(8 << 20), str(8 << 20), str(16 << 20)]


def test_the_list_is_searched_by_every_word(page: Page) -> None:
    page.goto("/studies")
    rows = page.get_by_role("main").get_by_role("listitem")
    expect(rows).to_have_count(3)
    page.get_by_label("Search studies").fill("one-joint folder")
    expect(rows).to_have_count(1)
    expect(rows).to_contain_text("From a folder")
    page.get_by_label("Search studies").fill("nothing like it")
    expect(rows).to_have_count(0)
    expect(page.get_by_role("status").filter(has_text="No study has “nothing like it”")).to_be_visible()
    page.reload()
    expect(page.get_by_label("Search studies")).to_have_value("nothing like it")
    page.get_by_role("button", name="Show all").click()
    expect(rows).to_have_count(3)
    page.goto("/studies?search=ARM&state=succeeded")
    expect(rows).to_have_count(1)
    expect(rows).to_contain_text("Arm on a bench")
