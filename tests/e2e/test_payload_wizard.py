"""A lab's own files become a payload in the browser: sensor, workspace, postures, excitation, result."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml
from playwright.sync_api import expect
from tests.e2e.test_studies_page import drop
from tests.payload.planned import plan_yaml

from exogauge.synthetic import payload as generator
from exogauge.synthetic import write_payload_sample

if TYPE_CHECKING:
    from playwright.sync_api import Page

HOME = yaml.safe_load(plan_yaml())["plan"]["home"]
NOISE = {"Noise of an angle [rad]": "2e-5", "Noise of a force [N]": "0.5", "Noise of a moment [N·m]": "0.05"}


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """The sample's logs as another controller writes them: milliseconds, degrees, names of its own."""
    folder = tmp_path_factory.mktemp("lab") / "sample"
    write_payload_sample(folder, 1)
    found = {"arm.urdf": (folder / "arm.urdf").read_bytes()}
    for name in ("postures", "excitation", "fast"):
        found[f"{name}.csv"] = foreign(folder / "logs" / f"{name}.parquet")
    return found


def foreign(path: Path) -> bytes:
    table = pq.read_table(path)
    force = [f"force_{axis} [N]" for axis in "xyz"] + [f"torque_{axis} [Nm]" for axis in "xyz"]
    head = ["stamp_ms", *(f"{joint}_pos [deg]" for joint in generator.JOINTS), *force]
    columns = [1e3 * table["t"].to_numpy()]
    columns += [np.degrees(table[f"q.{joint}"].to_numpy()) for joint in generator.JOINTS]
    columns += [table[name].to_numpy() for name in ("fx", "fy", "fz", "mx", "my", "mz")]
    rows = (",".join(f"{x:.9g}" for x in row) for row in np.column_stack(columns))
    return "\n".join([",".join(head), *rows]).encode()


def step(page: Page, name: str) -> None:
    page.get_by_role("navigation", name="Steps").get_by_role("button", name=name).click()
    expect(page.get_by_role("heading", name=name, exact=True, level=2)).to_be_visible()


def open_new(page: Page) -> None:
    page.goto("/payloads/new")
    page.get_by_role("heading", name="New payload", level=1).wait_for()


def say_sensor(page: Page, name: str) -> None:
    page.get_by_label("Name of the payload").fill(name)
    for label, value in NOISE.items():
        page.get_by_label(label).fill(value)


def test_a_new_lab_gets_its_result_from_its_own_files(
    page: Page, logs: dict[str, bytes], screenshot: Callable[..., None]
) -> None:
    page.goto("/payloads")
    page.get_by_role("link", name="New payload, step by step").click()
    page.get_by_role("heading", name="New payload", level=1).wait_for()
    drop(page, {name: logs[name] for name in ("arm.urdf", "postures.csv")})
    expect(page.locator("tr[data-file='arm.urdf']")).to_contain_text("6 joints")
    expect(page.get_by_label("Frame of the sensor")).to_have_value("ft")
    expect(page.get_by_label("Base link")).to_have_value("base")
    expect(page.get_by_role("combobox", name="Column of time", exact=True)).to_have_value("stamp_ms")
    expect(page.get_by_role("combobox", name="Column of force z", exact=True)).to_have_value("force_z [N]")
    expect(page.get_by_role("combobox", name="Column of angle of a6", exact=True)).to_have_value("a6_pos [deg]")
    expect(page.get_by_label("Unit: joint angle")).to_have_value("deg")
    page.get_by_role("button", name="Next: Workspace").click()
    page.get_by_role("button", name="Back: Sensor").click()
    expect(page.get_by_test_id("open")).to_contain_text("the noise of force and moment")
    expect(page.get_by_text("Not said yet.").first).to_be_visible()
    say_sensor(page, "Door of a lab")
    expect(page.get_by_test_id("open")).to_have_count(0)
    screenshot("payload-new-sensor")

    step(page, "Workspace")
    page.get_by_label("Plan what to record").check()
    for joint, angle in HOME.items():
        page.get_by_label(f"Home [rad] of {joint}").fill(str(angle))
    for joint in ("a4", "a5", "a6"):
        page.get_by_label(f"Lowest [rad] of {joint}").fill("-2.8")
        page.get_by_label(f"Highest [rad] of {joint}").fill("2.8")
    page.get_by_label("Mass [kg]").fill("40")
    for axis, size in zip("xyz", ("1.1", "0.4", "0.1"), strict=True):
        page.get_by_label(f"Size of a box about it [m]: {axis}").fill(size)
    page.get_by_role("button", name="Add a range").click()
    expect(page.get_by_test_id("open")).to_have_count(0)
    screenshot("payload-new-workspace")

    step(page, "Postures")
    page.get_by_label("Postures", exact=True).fill("8")
    ask = page.get_by_role("button", name="Plan postures")
    expect(ask).to_be_enabled()
    ask.click()
    plan = page.locator("[data-plan=postures]")
    expect(plan.get_by_text("Done")).to_be_visible(timeout=180_000)
    expect(page.frame_locator("iframe").locator("canvas").first).to_be_visible(timeout=120_000)
    expect(page.get_by_role("group", name="What is shown")).to_contain_text("planned postures")
    page.get_by_role("button", name="Take logs/postures.csv").click()
    expect(page.get_by_label("Role of logs/postures.csv")).to_have_value("postures")
    page.wait_for_timeout(1500)
    screenshot("payload-new-postures", without=("iframe",))

    step(page, "Excitation")
    drop(page, {"excitation.csv": logs["excitation.csv"]})
    expect(page.get_by_label("Role of logs/excitation.csv")).to_be_visible()
    page.go_back()
    expect(page.get_by_label("Role of logs/postures.csv")).to_be_visible()
    page.go_forward()
    expect(page.get_by_label("Role of logs/excitation.csv")).to_be_visible()

    step(page, "Result")
    drop(page, {"fast.csv": logs["fast.csv"]})
    expect(page.get_by_label("Role of logs/fast.csv")).to_have_value("test")
    expect(page.get_by_text("Nothing to find fault with.")).to_be_visible(timeout=120_000)
    screenshot("payload-new-result")
    with page.expect_download() as download:
        page.get_by_role("link", name="Download payload.yaml").click()
    written = yaml.safe_load(download.value.path().read_text(encoding="utf-8"))
    assert written["pose"]["joints"]["a1"] == "a1_pos [deg]"
    assert written["plan"]["workspace"][0]["axis"] == "z"
    page.get_by_role("button", name="Identify").click()
    page.wait_for_url(re.compile(r"/payloads/[0-9a-f-]{36}$"))
    expect(page.get_by_role("heading", name="What was identified")).to_be_visible(timeout=120_000)
    expect(page.locator("tr[data-value=m]")).to_contain_text("40.17")
    page.go_back()
    expect(page.get_by_label("Role of logs/fast.csv")).to_have_value("test")


def test_what_does_not_fit_is_told_where_it_stands(page: Page, logs: dict[str, bytes]) -> None:
    open_new(page)
    drop(page, {name: logs[name] for name in ("arm.urdf", "postures.csv")})
    expect(page.get_by_role("combobox", name="Column of time", exact=True)).to_have_value("stamp_ms")
    say_sensor(page, "Badly said")
    page.get_by_label("Unit: joint angle").select_option("rad")
    page.get_by_label("Gravity [m/s²]: z").fill("-981")
    page.get_by_label("Noise of a force [N]").fill("-1")
    expect(page.get_by_text("Input should be greater than 0 (-1).", exact=True)).to_be_visible()
    page.get_by_label("Noise of a force [N]").fill("0.5")
    expect(page.get_by_role("alert")).to_contain_text("gravity has the size 981")
    page.get_by_label("Gravity [m/s²]: z").fill("-9,81")
    step(page, "Postures")
    page.get_by_role("button", name="Take logs/postures.csv").click()
    step(page, "Sensor")
    row = page.get_by_role("row").filter(has=page.get_by_role("rowheader", name="angle of a", exact=False))
    expect(row.filter(has_text="is more than a joint turns")).to_contain_text("pose.angle_unit: deg")
    expect(page.get_by_role("button", name="1 Sensor (does not fit)")).to_be_visible()
    page.get_by_label("Unit: joint angle").select_option("deg")
    expect(page.get_by_role("alert")).to_have_count(0)
    page.get_by_role("combobox", name="Column of force x", exact=True).fill("f_x")
    expect(page.locator("tr[data-quantity='sensor.wrench.0']")).to_contain_text("the file has no such column")


def test_a_broken_file_is_told_and_the_others_are_read(page: Page, logs: dict[str, bytes]) -> None:
    open_new(page)
    drop(page, {"arm.urdf": b"<robot", "postures.csv": logs["postures.csv"]})
    expect(page.locator("tr[data-file='arm.urdf']")).to_contain_text("cannot be read")
    expect(page.get_by_role("alert").filter(has_text="arm.urdf")).to_be_visible()
    expect(page.locator("tr[data-file='logs/postures.csv']")).to_contain_text("rows")


def test_a_reload_loses_nothing_and_a_new_start_does(page: Page, logs: dict[str, bytes]) -> None:
    open_new(page)
    drop(page, {"arm.urdf": logs["arm.urdf"]})
    page.get_by_label("Name of the payload").fill("Half done")
    expect(page.get_by_label("Frame of the sensor")).to_have_value("ft")
    page.reload()
    expect(page.get_by_label("Name of the payload")).to_have_value("Half done")
    expect(page.locator("tr[data-file='arm.urdf']")).to_contain_text("6 joints")
    page.get_by_role("button", name="Start anew").click()
    expect(page.get_by_label("Name of the payload")).to_have_value("")
    expect(page.locator("tr[data-file='arm.urdf']")).to_have_count(0)
