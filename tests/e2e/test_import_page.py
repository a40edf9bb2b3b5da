"""A controller's own log: looked at, its columns named, the doctor heard, stored, and put into a study."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from playwright.sync_api import expect
from tests.e2e.arm import arm_study
from tests.e2e.test_studies_page import drop

if TYPE_CHECKING:
    from playwright.sync_api import Page


def vendor_log(frozen: bool) -> bytes:
    """Milliseconds, degrees, a commanded value and text; where `frozen`, the torque stands still from 8 to 9 s."""
    rows = ["stamp_ms,elbow_pos,elbow_trq [Nm],elbow_des_pos,note"]
    for k in range(2000):
        t = k / 100
        q, rate = 45.0 * math.sin(2 * t) + 15.0 * math.sin(5 * t), 1.6 * math.cos(2 * t)
        torque = 0.7 if frozen and 8.0 <= t < 9.0 else 0.3 * rate - 1.9 * math.sin(math.radians(q))
        rows.append(f"{10 * k},{q:.5f},{torque:.6f},{q:.2f},ok")
    return ("\n".join(rows) + "\n").encode()


def hand_in_arm(page: Page, home: str = "") -> None:
    page.goto(f"{home}/robots")
    page.get_by_role("button", name="Choose files").wait_for()
    files = arm_study()
    drop(page, {path: files[path] for path in ("robot.yaml", "robot.urdf")})
    expect(page.get_by_role("heading", name="One-joint arm", level=1)).to_be_visible()
    page.get_by_role("link", name="Import a log of it").click()
    expect(page.get_by_role("heading", name="Drop a log")).to_be_visible()


def test_what_cannot_be_named_is_refused_with_advice_and_the_doctor_marks_its_place(
    page: Page, screenshot: Callable[[str], None]
) -> None:
    hand_in_arm(page)
    drop(page, {"vendor.csv": vendor_log(frozen=True)})
    columns = page.get_by_role("region", name="Columns of the file: table")
    position = columns.get_by_role("row").filter(has=page.get_by_role("rowheader", name="elbow_pos", exact=True))
    expect(page.get_by_label("Unit of elbow_pos")).to_have_value("deg")
    expect(position).to_contain_text("only deg stays within the joint's limits")
    expect(page.get_by_text("Say what 2 columns measure, or ignore them: elbow_des_pos, note")).to_be_visible()
    expect(columns.get_by_role("row").filter(has_text="elbow_des_pos")).to_contain_text("commanded")
    expect(page.get_by_role("button", name="Store the log")).to_be_disabled()
    screenshot("import-open")
    page.get_by_role("button", name="Ignore the 2 open ones").click()
    expect(page.get_by_text("This makes a log of 2 channels")).to_be_visible()
    found = page.get_by_role("region", name="What the checks of the signals found: table").get_by_role("row")
    expect(found.filter(has_text="tau.elbow").first).to_contain_text("8.000")
    expect(page.get_by_role("img", name=re.compile(r"tau\.elbow around 8 s"))).to_be_visible()
    screenshot("import-findings")


def test_a_wrong_unit_is_told_and_no_unit_is_no_log(page: Page) -> None:
    hand_in_arm(page)
    drop(page, {"vendor.csv": vendor_log(frozen=False)})
    page.get_by_role("button", name="Ignore the 2 open ones").click()
    expect(page.get_by_text("This makes a log of 2 channels")).to_be_visible()
    page.get_by_label("Unit of elbow_pos").select_option("rad")
    expect(page.get_by_role("region", name="What the checks of the signals found: table")).to_contain_text("q.elbow")
    page.get_by_label("Unit of elbow_pos").select_option("")
    expect(page.get_by_text("Not a log yet")).to_be_visible()
    expect(page.get_by_role("button", name="Store the log")).to_be_disabled()


def test_two_logs_become_a_study_and_the_second_needs_no_mapping(page: Page) -> None:
    hand_in_arm(page)
    drop(page, {"first.csv": vendor_log(frozen=False)})
    page.get_by_role("button", name="Ignore the 2 open ones").click()
    page.get_by_role("button", name="Store the log").click()
    expect(page.get_by_text("first.csv is stored")).to_be_visible()
    drop(page, {"second.csv": vendor_log(frozen=False).replace(b",ok", b",fine")})
    expect(page.get_by_text("This makes a log of 2 channels")).to_be_visible()  # by the mapping that was kept
    page.get_by_role("button", name="Store the log").click()
    expect(page.get_by_text("second.csv is stored")).to_be_visible()
    page.get_by_label("Role of second.csv").select_option("validation")
    page.get_by_label("When second.csv began").fill("13:05:20")
    expect(page.get_by_text("Give the study a name.")).to_be_visible()
    page.get_by_label("Name of the study").fill("Arm from its controller")
    page.get_by_label("Evaluate at once").uncheck()
    page.get_by_role("button", name="Make the study").click()
    page.wait_for_url(re.compile(r"/studies/[0-9a-f-]{36}$"))
    expect(page.get_by_role("heading", name="Arm from its controller", level=1)).to_be_visible()
    kept = page.request.get(page.url.replace("/studies/", "/api/v1/studies/") + "/files/study.yaml").text()
    assert "started: 47120.0" in kept  # of the day


def test_a_mapping_can_be_written_as_text(page: Page) -> None:
    hand_in_arm(page)
    drop(page, {"vendor.csv": vendor_log(frozen=False)})
    page.get_by_role("button", name="Show it as mapping.yaml").click()
    text = page.get_by_label("mapping.yaml")
    text.fill(text.input_value().replace("ignore:", "ignore_:") + "nothing: 1\n")
    expect(page.get_by_text("Not a log yet")).to_be_visible()
    text.fill(
        "version: 1\nfiles:\n- file: vendor.csv\n  time: {column: stamp_ms, unit: ms}\n  ignore: rest\n"
        "  columns:\n    elbow_pos: {channel: q.elbow, unit: deg}\n"
    )
    expect(page.get_by_text("This makes a log of 1 channel")).to_be_visible()


def test_an_array_of_all_joints_is_taken_as_suggested(page: Page, screenshot: Callable[[str], None]) -> None:
    links = "".join(
        f'<joint name="{joint}" type="revolute"><parent link="{parent}"/><child link="of_{joint}"/>'
        '<origin xyz="0 0 0.3"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="9" effort="50"/></joint>'
        f'<link name="of_{joint}"><inertial><origin xyz="0.1 0 0.1"/><mass value="2"/>'
        '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial></link>'
        for joint, parent in (("upper", "base"), ("fore", "of_upper"))
    )
    robot = (
        "version: 1\nname: Two joints\nurdf: robot.urdf\nbase: fixed\nbase_link: base\n"
        "joints:\n- {name: upper, actuation: torque}\n- {name: fore, actuation: torque}\n"
    )
    t = np.arange(2000) / 100.0
    q = np.stack([np.sin(t), 0.7 * np.sin(2.1 * t)], axis=1)
    packed = io.BytesIO()
    np.savez(packed, t=t, joint_pos=q, joint_torques=(5.0 * np.sin(q)).T, joint_names=np.array(["upper", "fore"]))
    page.goto("/robots")
    page.get_by_role("button", name="Choose files").wait_for()
    urdf = f'<robot name="two"><link name="base"/>{links}</robot>'
    drop(page, {"robot.yaml": robot.encode(), "robot.urdf": urdf.encode()})
    page.get_by_role("link", name="Import a log of it").click()
    expect(page.get_by_role("heading", name="Drop a log")).to_be_visible()
    drop(page, {"run.npz": packed.getvalue()})
    page.get_by_role("button", name="Take 2 suggestions").click()
    expect(page.get_by_label("Unit of joint_pos")).to_have_value("rad")
    page.get_by_role("button", name="Ignore the open one").click()
    expect(page.get_by_text("This makes a log of 4 channels")).to_be_visible()
    screenshot("import-arrays")
