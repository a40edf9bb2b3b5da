"""What a page says when something is wrong: a defect of its own, a job that failed, nothing there yet, a slow line."""

from __future__ import annotations

import os
import re
import signal
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from playwright.sync_api import expect
from tests.e2e.arm import arm_study, zipped
from tests.e2e.test_import_page import hand_in_arm, vendor_log
from tests.e2e.test_studies_page import A_STUDY, drop
from tests.whole_service import small_study

from exogauge import Client

if TYPE_CHECKING:
    from playwright.sync_api import Page, Route
    from tests.e2e.conftest import Seen, Service

SLOW = {"offline": False, "latency": 400, "downloadThroughput": 50_000, "uploadThroughput": 50_000}
SHIFTS = """new PerformanceObserver((list) => {
  window.shifts = [...(window.shifts ?? []), ...list.getEntries().filter((each) => !each.hadRecentInput).map((each) =>
    [each.value, each.sources.map(({node}) => node?.outerHTML?.slice(0, 80))])];
}).observe({type: "layout-shift", buffered: true});"""
GOOD = 0.1  # what the web's own measure calls good
EMPTY = {
    "studies": "No studies yet", "robots": "No robots yet", "devices": "No devices yet", "import": "Drop a log",
    "compare": "No evaluation has finished yet",
}  # fmt: skip


@pytest.mark.parametrize("place", list(EMPTY))
def test_every_page_of_an_empty_service_says_where_to_begin(
    page: Page, place: str, screenshot: Callable[[str], None]
) -> None:
    page.goto(f"/{place}")
    expect(page.get_by_role("heading", name=EMPTY[place])).to_be_visible()
    expect(page.get_by_role("alert")).to_have_count(0)
    screenshot(f"empty-{place}")


@pytest.mark.parametrize("place", ["studies", "robots", "devices"])
def test_what_is_not_there_is_told(page: Page, place: str) -> None:
    page.goto(f"/{place}/00000000-0000-4000-8000-000000000000")
    expect(page.get_by_role("alert")).to_contain_text(re.compile("no such|not found|does not exist|there is no", re.I))


def test_a_defect_of_a_page_is_told_with_words_to_report(
    page: Page, seen: Seen, screenshot: Callable[[str], None]
) -> None:
    """An answer that no version of the service gives breaks the page that reads it, and nothing else."""
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.route("**/api/v1/studies?*", lambda route: route.fulfill(json={"items": [{"id": "x"}]}))
    page.goto("/studies")
    alert = page.get_by_role("alert")
    expect(alert.get_by_role("heading", name="This page has a defect")).to_be_visible()
    expect(alert).to_contain_text("TypeError")
    screenshot("defect")
    alert.get_by_role("button", name="Copy the details").click()
    expect(alert.get_by_role("button", name="Copied")).to_be_visible()
    words = page.evaluate("navigator.clipboard.readText()")
    assert re.search(r"TypeError: .*\nPage: http.*/studies\nTime: 20\S+Z\nBrowser: .*\n.*assets/", words, re.DOTALL)
    assert seen.errors
    seen.errors.clear()
    page.get_by_role("navigation", name="Main").get_by_role("link", name="Import").click()  # reads no studies
    expect(page.get_by_role("heading", name="Import logs", level=1)).to_be_visible()
    page.unroute_all()
    page.goto("/studies")
    expect(page.get_by_role("heading", name="Studies", level=1)).to_be_visible()


def test_a_failed_job_says_why_and_keeps_the_logs_in_reach(
    page: Page, service: Service, tmp_path: Path, screenshot: Callable[[str], None]
) -> None:
    """Logs of a robot that stands still are in order, and there is nothing to identify from them."""
    files = arm_study("At rest")
    still = "t,q.elbow,tau.elbow\n" + "".join(f"{k / 100:.3f},0.1,-0.2\n" for k in range(2000))
    (tmp_path / "still.zip").write_bytes(zipped(files | dict.fromkeys(("logs/id.csv", "logs/val.csv"), still.encode())))
    with Client(service.url) as client:
        study = client.upload_study(tmp_path / "still.zip")
        job = client.submit(study)
        page.goto(f"/studies/{study.id}")
        alert = page.get_by_role("alert")
        expect(alert).to_contain_text("No joint moves steadily in any fitted log", timeout=120_000)
        assert client.job(job).state == "failed"
    expect(alert).to_contain_text("Record longer movements")
    steps = page.get_by_role("list", name="Steps").get_by_role("listitem")
    expect(steps.filter(has_text="Identification")).to_contain_text("failed here")
    expect(steps.filter(has_text="Missing effects")).to_contain_text("not reached")
    expect(steps.filter(has_text="Bands")).to_contain_text("no log was recorded with the device on")
    expect(page.get_by_text("Correct it, hand it in again, and run that.")).to_be_visible()
    screenshot("review-failed")
    page.get_by_role("link", name="Log and raw data").click()
    with page.expect_download() as download:
        page.get_by_role("link", name="logs/id.csv").click()
    assert download.value.path().read_text() == still
    page.goto("/studies")
    row = page.get_by_role("listitem").filter(has_text="At rest")
    expect(row).to_contain_text("Failed")
    expect(row).to_contain_text("no joint moves steadily")


def slow_down(page: Page) -> None:
    line = page.context.new_cdp_session(page)
    line.send("Network.enable")
    line.send("Network.emulateNetworkConditions", SLOW)


def test_a_job_whose_process_was_killed_is_begun_anew_and_the_page_says_so(
    page: Page, service: Service, tmp_path: Path, screenshot: Callable[[str], None]
) -> None:
    for path, content in small_study("killed on the way").items():
        (tmp_path / path).parent.mkdir(exist_ok=True)
        (tmp_path / path).write_bytes(content)
    with Client(service.url) as client:
        job = client.submit(client.upload_study(tmp_path))
        page.goto(f"/studies/{job.study_id}")
        while (now := client.job(job)).progress == 0.0:
            assert now.state in ("queued", "running")
            time.sleep(0.1)
        os.kill(computing(service.data), signal.SIGKILL)
        expect(page.get_by_text("Begun 2 times")).to_be_visible()
        assert client.wait(job, progress=False).state == "succeeded"
    expect(page.get_by_text("Begun 2 times")).to_contain_text("Nothing that was handed in is lost")
    screenshot("begun-again")
    page.get_by_text("Begun 2 times").get_by_role("link", name="Log and raw data").click()
    expect(page.get_by_role("region", name="Log of the job")).to_contain_text("signal 9")


def computing(data: Path) -> int:
    """The process that computes for the service with this folder."""
    for entry in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            words, environment = (entry / "cmdline").read_bytes(), (entry / "environ").read_bytes()
            if b"exogauge.jobs.child" in words and f"EXOGAUGE_DATA_DIR={data}\0".encode() in environment:
                return int(entry.name)
    raise AssertionError("nothing computes")


@pytest.mark.parametrize("part", ["", "/summary", "/identification", "/support", "/disagreement", "/plots?robot=yes"])
def test_over_a_slow_line_a_page_says_that_it_loads_and_nothing_jumps(
    page: Page, study: dict[str, Any], part: str
) -> None:
    """On a second visit, with the page's scripts at hand: 50 kB/s and 0.4 s a question."""
    at = f"{study['path']}{part}" if part else "/studies"
    page.add_init_script(SHIFTS)
    page.goto(at)
    expect(page.get_by_role("main").get_by_role("heading", level=2).last).to_be_visible()
    slow_down(page)
    page.goto(at, wait_until="commit")
    expect(page.get_by_role("status").filter(has_text=re.compile("Loading|reading|Reading"))).not_to_have_count(0)
    expect(page.get_by_role("main").get_by_role("heading", level=2).last).to_be_visible()
    page.wait_for_load_state("networkidle", timeout=60_000)
    shifts = page.evaluate("window.shifts ?? []")
    assert sum(value for value, _ in shifts) < GOOD, shifts


def test_over_a_slow_line_nothing_is_sent_twice(page: Page) -> None:
    asked: list[str] = []
    hand_in_arm(page)
    drop(page, {"slow.csv": vendor_log(frozen=False)})
    page.get_by_role("button", name="Ignore the 2 open ones").click()
    expect(page.get_by_text("This makes a log of 2 channels")).to_be_visible()
    slow_down(page)
    page.on("request", lambda one: asked.append(one.url) if one.method == "POST" else None)
    page.get_by_role("button", name="Store the log").dblclick()
    expect(page.get_by_text("slow.csv is stored")).to_be_visible()
    page.get_by_label("Name of the study").fill("Over a slow line")
    page.get_by_label("Evaluate at once").uncheck()
    page.get_by_role("button", name="Make the study").dblclick()
    page.get_by_role("button", name="Make the study").click(force=True)
    page.wait_for_url(A_STUDY)
    page.get_by_role("button", name="Evaluate").dblclick()
    expect(page.get_by_role("combobox", name="Job")).to_be_visible()
    made = [re.sub(r".*/api/v1/", "", url) for url in asked if "preview" not in url]
    assert made == ["logs/from-upload", "studies", "jobs"]


def test_a_silent_answer_leaves_the_page_as_it_was_and_can_be_asked_for_again(page: Page) -> None:
    """One question of a page is answered 500; the rest of the page stays, and the question is put again by hand."""
    broken = {"now": True}

    def answer(route: Route) -> None:
        if broken["now"]:
            route.fulfill(status=500, body="<h1>Internal error</h1>", content_type="text/html")
        else:
            route.fallback()

    page.route("**/api/v1/studies?*", answer)
    page.goto("/studies")
    expect(page.get_by_role("button", name="Choose files")).to_be_visible()
    alert = page.get_by_role("alert")
    expect(alert).to_contain_text("500")
    broken["now"] = False
    alert.get_by_role("button", name="Try again").click()
    expect(alert).to_have_count(0)
