"""The review beyond results: logs as they were read without a job, zeros of sensors, versions of the model in words."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import pytest
import yaml
from playwright.sync_api import expect
from tests.e2e.arm import arm_study, zipped
from tests.sensor_arm import COMPONENTS, describe, record, truth, wrist

from exogauge import Client

if TYPE_CHECKING:
    from pathlib import Path

    from playwright.sync_api import Page
    from tests.e2e.conftest import Service

READ_MS = 120_000  # a child reads the log, on a busy machine


def hand_in(service: Service, files: dict[str, bytes], folder: Path) -> str:
    (folder / "study.zip").write_bytes(zipped(files))
    with Client(service.url) as client:
        return client.upload_study(folder / "study.zip").id


def test_logs_of_a_study_without_a_job_are_plotted_and_a_link_brings_them_back(
    page: Page, service: Service, tmp_path: Path, screenshot: Callable[[str], None]
) -> None:
    study = hand_in(service, arm_study("Not run"), tmp_path)
    page.goto(f"/studies/{study}")
    expect(page.get_by_text("Not evaluated yet")).to_be_visible()
    page.get_by_role("button", name="Plot the logs as they were read").click()
    position = page.get_by_role("region", name="Position of elbow")
    expect(position.get_by_role("slider")).to_be_visible(timeout=READ_MS)
    expect(page.get_by_role("region", name="Torque of elbow")).to_be_visible()
    position.get_by_role("slider").focus()
    page.keyboard.press("End")
    expect(position.get_by_role("table")).to_contain_text("At 19.990 s")
    shown = position.get_by_role("row", name="As logged").get_by_role("cell").inner_text().replace("−", "-")
    assert abs(float(shown) - (0.8 * math.sin(2 * 19.99) + 0.3 * math.sin(5 * 19.99))) < 1e-3
    screenshot("review-raw-logs")
    page.get_by_role("combobox", name="Log to plot").click()
    page.get_by_role("option", name="val").click()
    expect(page).to_have_url(re.compile(r"raw_log=val"))
    page.reload()
    expect(page.get_by_role("combobox", name="Log to plot")).to_have_value("val")
    expect(position.get_by_role("slider")).to_be_visible(timeout=READ_MS)


def test_zeros_of_a_sensor_inside_the_robot_are_shown_and_are_the_true_ones(
    page: Page, service: Service, tmp_path: Path, screenshot: Callable[[str], None]
) -> None:
    sensors = [wrist()]
    robot = describe(tmp_path, sensors)
    logs = {"a": "identification", "b": "identification", "c": "validation"}
    about = {"version": 1, "name": "Wrist", "robot": "robot.yaml", "steps": ["identify"],
             "logs": [{"file": f"{name}.csv", "role": role} for name, role in logs.items()]}  # fmt: skip
    files = {"study.yaml": yaml.safe_dump(about).encode()}
    files |= {name: (tmp_path / name).read_bytes() for name in ("robot.yaml", "robot.urdf")}
    files |= {f"{name}.csv": as_csv(record(k, sensors)) for k, name in enumerate(logs)}
    study = hand_in(service, files, tmp_path)
    with Client(service.url) as client:
        client.wait(client.submit(study))
    page.goto(f"/studies/{study}/identification")
    row = page.get_by_role("region", name="Zeros of the force/torque sensors").get_by_role("row", name="wrist")
    true = truth(robot, sensors)
    for k, axis in enumerate(COMPONENTS):
        shown = row.get_by_role("cell").nth(k).inner_text().replace("−", "-")
        value, std = (float(part) for part in re.findall(r"-?\d+\.?\d*", shown)[:2])
        assert abs(value - true[f"zero.{axis}[wrist]"]) < 4 * std, shown
        assert shown.endswith("N" if axis.startswith("f") else "N·m")
    screenshot("review-zeros")


def as_csv(log: Any) -> bytes:
    names = ["t", *log.channels]
    columns = [log.time, *log.channels.values()]
    rows = (",".join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True))
    return "\n".join([",".join(names), *rows, ""]).encode()


@pytest.mark.usefixtures("sample_service")
def test_versions_of_the_model_are_told_in_words(page: Page, sample_service: Service) -> None:
    with Client(sample_service.url) as client:
        job = next(each for each in client.jobs() if each.state == "succeeded")
        found = client.results(job)["discrepancy"]
    page.goto(f"/studies/{job.study_id}/disagreement")
    table = page.get_by_role("region", name="Versions of the model")
    rows = table.get_by_role("row")
    expect(rows).to_have_count(1 + len(found["lineage"]))
    heads = [row.get_by_role("rowheader").inner_text() for row in rows.all()[1:]]
    assert heads[0] == "Nothing: the robot as identified"
    named = {each["title"].lower() for each in found["findings"]}
    assert {re.sub("^(own curve|remainder) of ", "", head.lower()) for head in heads[1:]} == named
    assert not any(re.search(r"[@+]", head) for head in heads)
    expect(rows.nth(1)).to_contain_text("fitted to")
    expect(rows.nth(2)).to_contain_text("judged on")
