"""Motions in the browser: handed in, told, the feet corrected, planned for a robot, looked at, exported."""

from __future__ import annotations

import gzip
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
import yaml
from playwright.sync_api import expect
from tests.e2e.robot_in_3d import changed, drawn, listen, picture, wait_until_drawn
from tests.e2e.test_studies_page import drop
from tests.motion.captures import bow, bvh, knee
from tests.motion.robots import arm_folder, sample_folder
from tests.motion.tables import motive, mvnx, qualisys
from tests.motion.test_reading import LABELS, body

from exogauge.client import Client

if TYPE_CHECKING:
    from playwright.sync_api import Page
    from tests.e2e.conftest import Service

A_MOTION, A_PLAN = re.compile(r"/motions/[0-9a-f-]{36}$"), re.compile(r"/plans/[0-9a-f-]{36}$")
CMU = Path(__file__).parents[3] / "shared" / "data" / "cmu_mocap_bend_twist"
PLANNED_MS = 240_000


@pytest.fixture(scope="module")
def robot(service: Service, tmp_path_factory: pytest.TempPathFactory) -> str:
    """The name of a robot that has soles and a human_map; beside it one that has none."""
    folder = tmp_path_factory.mktemp("robots")
    sample_folder(folder / "whole")
    bare = sample_folder(folder / "bare")
    content = yaml.safe_load(bare.read_bytes())
    kept = {key: value for key, value in content.items() if key not in ("soles", "human_map")}
    bare.write_text(yaml.safe_dump(kept | {"name": "barefoot"}))
    with Client(service.url) as client:
        client.upload_robot(folder / "bare")
        return client.upload_robot(folder / "whole").name


def choose(page: Page, label: str, option: str) -> None:
    page.get_by_role("combobox", name=label).click()
    page.get_by_role("option", name=re.compile(f"^{re.escape(option)}")).click()


def test_an_empty_list_says_what_a_motion_is(page: Page, screenshot: Callable[[str], None]) -> None:
    page.goto("/motions")
    expect(page.get_by_role("heading", name="No motions yet")).to_be_visible()
    screenshot("motions-empty")


def test_what_the_file_does_not_say_is_asked_for(page: Page) -> None:
    page.goto("/motions")
    drop(page, {"notes.txt": b"nothing"})
    expect(page.get_by_role("alert").first).to_contain_text("captures")
    expect(page.get_by_role("heading", name="Say what the file does not")).to_be_visible()


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("take.csv", motive(body(40), LABELS), "trajectories without a name: 1"),
        ("take.tsv", qualisys(body(40), LABELS), "read: 0.001 m"),
        ("take.mvnx", mvnx(np.linspace(0.0, 0.4, 60)), "Xsens MVN's segments"),
    ],
)
def test_a_table_of_another_program_is_told_as_it_was_read(
    page: Page, screenshot: Callable[[str], None], name: str, text: str, said: str
) -> None:
    page.goto("/motions")
    drop(page, {name: text.encode()})
    page.wait_for_url(A_MOTION, timeout=60_000)
    expect(page.get_by_role("heading", name="take", level=1)).to_be_visible()
    expect(page.locator("dl").first).to_contain_text(said)
    screenshot(f"motion-{name.rpartition('.')[2]}")


def test_a_fitted_body_tells_how_it_fits_and_shows_its_angles(page: Page) -> None:
    """It said that the angles were below, and showed what was captured."""
    page.goto("/motions")
    drop(page, {"fitted.bvh": bvh(bow(30.0))})
    page.wait_for_url(A_MOTION, timeout=60_000)
    page.get_by_role("button", name="Fit a body").click()
    expect(page.get_by_text("its angles are below")).to_be_visible(timeout=PLANNED_MS)
    expect(page.get_by_text("cm rms, most at")).to_be_visible()
    expect(page.get_by_text("trunk flexion", exact=True).first).to_be_visible()
    with page.expect_download() as got:
        page.get_by_role("link", name="Angles over time: MOT").click()
    assert "inDegrees=yes" in Path(got.value.path()).read_text()
    page.get_by_text("As captured", exact=True).click()
    expect(page.get_by_text("Bone ", exact=False).first).to_be_visible()


def test_a_dropped_capture_becomes_a_motion_of_a_robot(
    page: Page, robot: str, screenshot: Callable[[str], None]
) -> None:
    listen(page)
    page.goto("/motions")
    drop(page, {"bow.bvh": bvh(bow())})
    page.wait_for_url(A_MOTION, timeout=60_000)
    expect(page.get_by_role("heading", name="bow", level=1)).to_be_visible()
    told = page.locator("dl").first
    expect(told).to_contain_text("guessed: y, from the feet to the head")
    expect(page.get_by_role("img", name="The left foot stands 0 to 2 s")).to_be_visible()
    screenshot("motion")

    page.get_by_label("left foot, stretch 1: to").fill("1.5")
    page.get_by_role("button", name="Keep these contacts").click()
    expect(page.get_by_text("As somebody said it.")).to_be_visible()
    page.get_by_role("button", name="As read").click()
    expect(page.get_by_role("img", name="The left foot stands 0 to 2 s")).to_be_visible()

    choose(page, "Robot", "barefoot")
    expect(page.get_by_role("alert").first).to_contain_text("lacks soles, human_map")
    choose(page, "Robot", robot)
    page.get_by_role("button", name="Plan it").click()
    page.wait_for_url(A_PLAN)
    expect(page.get_by_text("Every bound holds")).to_be_visible(timeout=PLANNED_MS)
    trunk = page.get_by_role("region", name="Trunk: table")
    expect(trunk.get_by_role("row", name="torso_pitch")).to_contain_text("0.0 … 20.0")
    expect(page.locator("tr[data-bound=torque]")).to_contain_text("%")
    expect(page.get_by_text("The bound that binds first")).to_be_visible()
    beside = page.get_by_role("region", name="Balance and distances: table")
    expect(beside.get_by_role("row", name="Centre of pressure")).to_contain_text("mm inside")
    expect(beside.get_by_role("row", name="Bounds broken")).to_contain_text("none")
    expect(page.locator(".u-over").first).to_be_visible(timeout=30_000)
    screenshot("motion-plan")
    with page.expect_download() as got:
        page.get_by_role("link", name="CSV: t, q.joint").click()
    assert Path(got.value.path()).read_text().startswith("t,q.")

    page.get_by_role("switch", name="In 3D").click()  # the address follows, then the switch: a moment later
    expect(page.get_by_role("switch", name="In 3D")).to_be_checked()
    wait_until_drawn(page)
    expect(page.get_by_text("at least", exact=False).first).to_be_visible()
    page.locator("iframe").scroll_into_view_if_needed()  # what is not seen is not drawn
    upright = picture(page)
    assert drawn(upright) > 0.02
    page.goto(f"{page.url.split('?')[0]}?robot=yes&at=3")
    wait_until_drawn(page)
    page.locator("iframe").scroll_into_view_if_needed()
    bent = picture(page)
    assert changed(upright, bent) > 0.002
    ghost = page.get_by_role("checkbox", name="frame by frame")
    expect(ghost).not_to_be_checked()
    ghost.check()
    page.locator("iframe").scroll_into_view_if_needed()
    page.wait_for_timeout(1_000)  # the player draws when it is told
    assert changed(bent, picture(page)) > 0.002
    screenshot("motion-plan-3d")


def test_a_knee_raise_tells_which_feet_stand_and_is_exported_unbroken(
    page: Page, service: Service, robot: str, tmp_path: Path, screenshot: Callable[[str], None]
) -> None:
    raised = knee()
    (tmp_path / "raise.bvh").write_bytes(bvh(np.zeros_like(raised), thigh=raised))
    with Client(service.url) as client:
        motion = client.upload_motion(tmp_path / "raise.bvh")
        plan = client.wait_plan(
            client.plan_motion(motion, next(each for each in client.robots() if each.name == robot))
        )
        assert plan.found is not None
        assert plan.found["broken"] == []
        assert (
            client.export_plan(plan, "csv", tmp_path / "raise.csv").read_text().split("\n")[0].endswith("stands.r_foot")
        )
        client.export_plan(plan, "mujoco", tmp_path / "raise.zip")  # refused where a bound is broken
    listen(page)
    page.goto(f"/plans/{plan.id}?at=3&show=trunk.torso_pitch&show=q.l_knee_pitch&show=margin.pressure_inside")
    feet = page.get_by_role("region", name="Feet that stand")
    expect(
        feet.get_by_role("img", name=re.compile(r"^l_foot stands 0 to 2\.\d* s, 3\.\d* to 6\.495 s$"))
    ).to_be_visible()
    expect(feet.get_by_role("img", name="r_foot stands 0 to 6.495 s")).to_be_visible()
    bent = page.get_by_role("region", name="Position of l_knee_pitch")
    expect(bent.get_by_role("columnheader", name="Value [°]")).to_be_visible()
    assert float(bent.get_by_role("row", name="planned").get_by_role("cell").last.inner_text()) > 45.0
    expect(page.get_by_role("region", name="Centre of pressure inside").get_by_text("[mm]")).to_be_visible()
    feet.scroll_into_view_if_needed()
    screenshot("motion-plan-feet")
    drawn_at = []
    for at in (0.1, 3.0):
        page.goto(f"/plans/{plan.id}?at={at}&show=margin.pressure_inside&robot=yes")
        wait_until_drawn(page)
        page.locator("iframe").scroll_into_view_if_needed()
        drawn_at.append(picture(page))
    assert changed(*drawn_at) > 0.002
    screenshot("motion-plan-feet-3d")


def test_a_motion_that_identifies_tells_what_will_be_known(
    page: Page, service: Service, tmp_path: Path, screenshot: Callable[[str], None]
) -> None:
    arm_folder(tmp_path / "arm", "ur10")
    with Client(service.url) as client:
        client.upload_robot(tmp_path / "arm")
    page.goto("/motions")
    page.get_by_role("link", name="Plan a motion that identifies").click()
    choose(page, "Robot", "ur10")
    page.get_by_label("Seconds of the motion itself").fill("4")
    page.get_by_role("button", name="Plan it").click()
    page.wait_for_url(A_PLAN)
    expect(page.get_by_text("will be decided by the data")).to_be_visible(timeout=PLANNED_MS)
    expect(page.get_by_role("region", name="Predicted standard deviations: table")).to_contain_text("base[")
    with Client(service.url) as client:
        told = (client.plan(page.url.rpartition("/")[2]).found or {})["told"]
    for kind in ("base", "joint"):
        count = told[f"{kind} parameters"].partition(" will")[0]
        expect(page.get_by_text("will be decided by the data")).to_contain_text(f"{count} {kind} parameters")
    screenshot("motion-excite-plan")


def test_a_standing_motion_that_identifies_is_watched_cancelled_made_and_drawn(
    page: Page, robot: str, screenshot: Callable[[str], None]
) -> None:
    """Ten seconds, as the page proposes them, are cancelled while they are planned; three are made."""
    listen(page)
    for seconds, whole in (("10", False), ("3", True)):
        page.goto("/motions")
        page.get_by_role("link", name="Plan a motion that identifies").click()
        choose(page, "Robot", robot)
        page.get_by_label("Seconds of the motion itself").fill(seconds)
        page.get_by_role("button", name="Plan it").click()
        page.wait_for_url(A_PLAN)
        expect(page.get_by_role("status").filter(has_text="nearest bound")).to_be_visible(timeout=3 * PLANNED_MS)
        screenshot("motion-excite-standing-planned")
        if not whole:
            page.get_by_role("button", name="Cancel").click()
            expect(page.get_by_role("button", name="Try again")).to_be_visible(timeout=3 * PLANNED_MS)
    expect(page.get_by_text("Every bound holds")).to_be_visible(timeout=3 * PLANNED_MS)
    expect(page.get_by_text("will be decided by the data")).to_be_visible()
    expect(page.locator("tr[data-bound=torque]")).to_contain_text("%")
    screenshot("motion-excite-standing")
    drawn_at = []
    for at in (0.1, 4.0):
        page.goto(f"{page.url.split('?')[0]}?at={at}&show=margin.pressure_inside&robot=yes")
        wait_until_drawn(page)
        page.locator("iframe").scroll_into_view_if_needed()
        drawn_at.append(picture(page))
    assert changed(*drawn_at) > 0.002
    screenshot("motion-excite-standing-3d")


@pytest.mark.skipif(not CMU.is_dir(), reason="the recordings do not lie beside the repository")
def test_a_recorded_bend_is_planned_from_its_page(page: Page, robot: str) -> None:
    files = {"02.asf": (CMU / "02.asf").read_bytes(), "02_06.amc": gzip.decompress((CMU / "02_06.amc.gz").read_bytes())}
    page.goto("/motions")
    drop(page, files)
    page.wait_for_url(A_MOTION, timeout=120_000)
    page.get_by_text("How", exact=True).click()
    page.get_by_label("To [s]").fill("4")
    choose(page, "Robot", robot)
    page.get_by_role("button", name="Plan it").click()
    page.wait_for_url(A_PLAN)
    trunk = page.get_by_role("region", name="Trunk: table")
    expect(trunk).to_be_visible(timeout=PLANNED_MS)
