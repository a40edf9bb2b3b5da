"""The whole way through the web app, from nothing to a link that brings the view back; and by keys alone."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from playwright.sync_api import expect
from tests.e2e.arm import arm_study, zipped
from tests.e2e.conftest import PATIENCE_MS, WIDE
from tests.e2e.robot_in_3d import differing, listen, picture, stopped_at, wait_until_drawn
from tests.e2e.test_device_pages import A_DEVICE
from tests.e2e.test_import_page import hand_in_arm, vendor_log
from tests.e2e.test_robot_in_3d import hover, wait_until_read_at
from tests.e2e.test_studies_page import A_STUDY

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Locator, Page
    from tests.e2e.conftest import Service

NAME = "A bend with and without a suit"
SUIT = "Smart Suit Lite, normal"
STUDY = f"""version: 1
name: {NAME}
robot: robot.yaml
device: device.yaml
logs:
- {{file: logs/id_1.parquet, role: identification}}
- {{file: logs/val_1.parquet, role: validation}}
- {{file: logs/bend_plain_1.parquet, role: without_device, motion: bend}}
- {{file: logs/bend_plain_2.parquet, role: without_device, motion: bend}}
- {{file: logs/bend_normal_1.parquet, role: with_device, motion: bend}}
- {{file: logs/bend_normal_2.parquet, role: with_device, motion: bend}}
"""
STAGES = ("Reading", "Identification", "Missing effects", "Supporting torque", "Bands", "Results")
EVALUATED_MS = 1_800_000  # two minutes on an idle machine
PLOTS = ("Supporting torque at torso_pitch", "Tension of the bands")


@pytest.fixture(scope="module")
def suit_zip(sample: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six logs of the sample: enough for every step."""
    names = ["robot.yaml", "robot.urdf", "device.yaml", *re.findall(r"logs/\w+\.parquet", STUDY)]
    files = {name: (sample / name).read_bytes() for name in names}
    path = tmp_path_factory.mktemp("suit") / "suit.zip"
    path.write_bytes(zipped({"study.yaml": STUDY.encode(), **files}))
    return path


def test_from_a_zip_and_a_controllers_log_to_a_link_that_brings_the_view_back(
    page: Page, browser: Browser, service: Service, suit_zip: Path
) -> None:
    listen(page)
    study = hand_in(page, suit_zip)
    import_a_controllers_log(page)
    run(page, study)
    results = review(page, study)
    move_through_time(page, study)
    change_the_device(page)
    compare_and_take_away(page, results)
    link = take_a_window_away(page, study)
    assert opened_elsewhere(browser, service, link) == (link, words_of(page))


def hand_in(page: Page, path: Path) -> str:
    """The address of the new study."""
    page.goto("/studies")
    page.get_by_label("Evaluate at once").uncheck()
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Choose files").click()
    chooser.value.set_files(path)
    page.wait_for_url(A_STUDY, timeout=120_000)
    expect(page.get_by_role("heading", name=NAME, level=1)).to_be_visible()
    return page.url


def import_a_controllers_log(page: Page) -> None:
    """Of another robot; its study is evaluated meanwhile."""
    hand_in_arm(page)
    for name, role, note in (("first.csv", "identification", b",ok"), ("second.csv", "validation", b",fine")):
        with page.expect_file_chooser() as chooser:
            page.get_by_role("button", name="Choose a file").click()
        log = vendor_log(frozen=False).replace(b",ok", note)
        chooser.value.set_files({"name": name, "mimeType": "text/csv", "buffer": log})
        if role == "identification":
            page.get_by_role("button", name="Ignore the 2 open ones").click(timeout=60_000)
        page.get_by_role("button", name="Store the log").click(timeout=60_000)
        expect(page.get_by_text(f"{name} is stored")).to_be_visible(timeout=60_000)
        page.get_by_label(f"Role of {name}").select_option(role)
    page.get_by_label("Name of the study").fill("Arm from its controller")
    page.get_by_role("button", name="Make the study").click()
    page.wait_for_url(A_STUDY)
    parts = page.get_by_role("navigation", name="Parts of the review")
    expect(parts.get_by_role("link", name="Identification", exact=True)).to_be_visible(timeout=300_000)


def run(page: Page, study: str) -> None:
    """Start the evaluation and watch it: its steps come in their order, and the progress never goes back."""
    page.goto(study)
    page.get_by_role("button", name="Evaluate").click()
    steps = page.get_by_role("list", name="Steps")
    expect(steps.locator("[aria-current=step]")).not_to_have_count(0, timeout=60_000)
    page.evaluate("""() => {
      window.watched = [];
      window.setInterval(() => window.watched.push([
        Number(document.querySelector('[aria-label="Progress of the job"]')?.getAttribute('aria-valuenow') ?? 0),
        [...document.querySelectorAll('[aria-current=step]')].map((each) => each.innerText.split('\\n')[0])]), 300);
    }""")
    expect(page.get_by_role("link", name="Summary", exact=True)).to_be_visible(timeout=EVALUATED_MS)
    watched: list[tuple[float, list[str]]] = page.evaluate("window.watched")
    shares = [share for share, now in watched if now]
    assert shares == sorted(shares)
    seen = list(dict.fromkeys(word for _, now in watched for word in now))
    order = [next(k for k, name in enumerate(STAGES) if each.startswith(name)) for each in seen]
    assert order == sorted(order)
    assert len(order) >= 4, seen


def review(page: Page, study: str) -> Any:
    """Each part shows what results.json holds."""
    page.goto(f"{study}/summary")
    (job,) = page.request.get(f"/api/v1/jobs?study_id={study.rsplit('/', 1)[1]}").json()["items"]
    results = page.request.get(f"/api/v1/jobs/{job['id']}/results").json()
    folded = [each for each in results["notices"] if each["short"] != each["sentence"]]
    mind = page.get_by_role("region", name="To keep in mind")
    expect(mind.locator("details")).to_have_count(len(folded))
    for each in folded:
        expect(mind.get_by_text(f"all {len(each['names'])}", exact=True).first).to_be_visible()
    parts = page.get_by_role("navigation", name="Parts of the review")
    parts.get_by_role("link", name="Identification").click()
    expect(page.get_by_label("Find a parameter")).to_be_visible()
    page.get_by_label("Find a parameter").fill("k_T[torso_pitch]")
    expect(page.locator("[data-parameter]")).to_have_count(1)
    parts.get_by_role("link", name="Support", exact=True).click()
    main = [each for each in results["support"] if each["main"]]
    expect(page.locator("[data-support$='|A']")).to_have_count(len(main))
    parts.get_by_role("link", name="Bands").click()
    expect(page.locator("[data-band]")).to_have_count(len(results["stiffness"]))
    parts.get_by_role("link", name="Disagreement").click()
    expect(page.get_by_test_id("verdict")).to_have_text(re.compile(r"\w"))
    findings = results["discrepancy"]["findings"]
    expect(page.get_by_role("main").locator("[id^=finding-]")).to_have_count(len(findings))
    return results


def move_through_time(page: Page, study: str) -> None:
    """The pointer in one plot moves the readings of all and the robot; the robot, playing, moves them back."""
    shown = "&".join(["show=support.torso_pitch", "show=tension"])
    page.goto(f"{study}/plots?log=bend_normal_1&{shown}&robot=yes&at=0")
    wait_until_drawn(page)
    expect(page.locator(".u-over")).to_have_count(2)
    hover(page, 0.02)
    upright = picture(page)
    wanted = hover(page, 0.5)
    assert differing(upright, picture(page)) > 0.01
    wait_until_read_at(page, wanted)
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("(at) => window.heard.at(-1).time > at + 0.5", arg=wanted)
    page.get_by_role("button", name="Pause").click()
    wait_until_read_at(page, stopped_at(page))


def change_the_device(page: Page) -> None:
    """A via point of the suit is moved, moved back, moved again, and saved as the next version."""
    page.goto("/devices")
    page.get_by_role("button", name=f"Add it to the list: {SUIT}").click()
    page.wait_for_url(A_DEVICE)
    before = page.url
    height = page.get_by_label("z of point 1 [m]")
    height.fill("0.4")
    expect(page.get_by_text("1 change, not saved")).to_be_visible()
    page.get_by_role("button", name="Undo").click()
    expect(page.get_by_text("As saved", exact=True)).to_be_visible()
    page.get_by_role("button", name="Redo").click()
    expect(height).to_have_value("0.4")
    page.get_by_role("button", name="Save as a new version").click()
    page.get_by_role("dialog").get_by_role("button", name="Save", exact=True).click()
    page.wait_for_url(lambda url: url != before)
    expect(page.get_by_text(re.compile("version 2", re.I)).first).to_be_visible()
    expect(page.get_by_label("z of point 1 [m]")).to_have_value("0.4")


def compare_and_take_away(page: Page, results: Any) -> None:
    page.goto("/compare")
    for name in (NAME, "Arm from its controller"):
        page.get_by_label(re.compile(f"Compare {name}")).check()
    differing_part = page.get_by_role("region", name="What else differs: table").get_by_role("row")
    expect(differing_part.filter(has_text="robot").first).to_be_visible()
    rows = list(csv.DictReader(taken(page, page.get_by_role("link", name="supporting torque as CSV")).splitlines()))
    assert len(rows) == sum(len(each["approaches"]) for each in results["support"])
    assert r"\begin{tabular}" in taken(page, page.get_by_role("link", name="stiffness as LaTeX"))


def taken(page: Page, link: Locator) -> str:
    with page.expect_download() as download:
        link.click()
    return download.value.path().read_text(encoding="utf-8")


def take_a_window_away(page: Page, study: str) -> str:
    """The window as rows; the address of the view, once the cursor rests in it."""
    page.goto(f"{study}/plots?log=bend_normal_1&show=support.torso_pitch&show=tension&from=2&to=3")
    expect(page.locator(".u-over")).to_have_count(2)
    hover(page, 0.25)
    expect(page).to_have_url(re.compile(r"[?&]at=2\.\d"))
    page.get_by_role("button", name="Export this window").click()
    header, *rows = taken(page, page.get_by_role("menuitem", name="CSV")).splitlines()
    assert header.startswith('"t","support_a.torso_pitch"')
    assert [float(row.split(",")[0]) for row in (rows[0], rows[-1])] == [2.0, 3.0]
    page.keyboard.press("Escape")
    return page.url


def words_of(page: Page) -> list[str]:
    """The window, and what every plot says at the cursor."""
    axes = [page.get_by_role("slider", name=f"{title}: time") for title in PLOTS]
    for axis in axes:
        expect(axis).to_have_attribute("aria-valuetext", re.compile(r"^2\.\d+ s: .*\d"))
    return [page.get_by_test_id("window").inner_text(), *(axis.get_attribute("aria-valuetext") or "" for axis in axes)]


def opened_elsewhere(browser: Browser, service: Service, link: str) -> tuple[str, list[str]]:
    """The address and the words in another person's browser, which has never seen the page."""
    context = browser.new_context(base_url=service.url, viewport=WIDE)  # type: ignore[arg-type]
    context.set_default_timeout(PATIENCE_MS)
    elsewhere = context.new_page()
    elsewhere.goto(link)
    words = words_of(elsewhere)
    address = elsewhere.url
    context.close()
    return address, words


def test_the_way_is_gone_by_keyboard_alone(page: Page, tmp_path: Path) -> None:
    """Hand in, wait for the evaluation, read, move the cursor, take the window away: no pointer anywhere."""
    (tmp_path / "arm.zip").write_bytes(zipped(arm_study("By keyboard")))
    page.on("filechooser", lambda _: None)  # from now on: asked for with the key, it may come too late
    page.goto("/studies")
    expect(page.get_by_role("heading", name="Studies", level=1)).to_be_visible()
    reach(page, page.get_by_role("button", name="Choose files"))
    with page.expect_file_chooser() as chooser:
        page.keyboard.press("Enter")
    chooser.value.set_files(tmp_path / "arm.zip")
    page.wait_for_url(A_STUDY, timeout=60_000)
    plots = page.get_by_role("link", name="Plots", exact=True)
    expect(plots).to_be_visible(timeout=300_000)
    reach(page, plots)
    page.keyboard.press("Enter")
    axis = page.get_by_role("slider", name=re.compile(": time$")).first
    expect(axis).to_be_visible()
    reach(page, axis)
    page.keyboard.press("Home")
    expect(axis).to_have_attribute("aria-valuetext", re.compile(r"^0\.000 s: .*\d"))
    for _ in range(3):
        page.keyboard.press("Shift+ArrowRight")
    expect(axis).to_have_attribute("aria-valuetext", re.compile(r"^(?!0\.000)\d+\.\d+ s: .*\d"))
    page.keyboard.press("+")
    expect(page).to_have_url(re.compile(r"[?&]to=\d"))
    reach(page, page.get_by_role("button", name="Export this window"), back=True)
    page.keyboard.press("Enter")
    item = page.get_by_role("menuitem", name="CSV")
    expect(item).to_be_visible()
    while not focused(item):
        page.keyboard.press("ArrowDown")
    with page.expect_download() as download:
        page.keyboard.press("Enter")
    assert download.value.path().read_text(encoding="utf-8").startswith('"t"')


def reach(page: Page, wanted: Locator, back: bool = False) -> None:
    """Press Tab until it has the focus, which is seen."""
    expect(wanted).to_be_visible()
    for _ in range(150):
        if focused(wanted):
            ring = wanted.evaluate("(it) => { const s = getComputedStyle(it); return s.outlineStyle + s.boxShadow; }")
            assert ring != "nonenone", "the focus is not seen"
            return
        page.keyboard.press("Shift+Tab" if back else "Tab")
    raise AssertionError(f"Tab does not reach {wanted}")


def focused(wanted: Locator) -> bool:
    return bool(wanted.evaluate("(it) => it === document.activeElement"))
