"""Payloads in the browser: handed in, identified, read, exported, planned."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from playwright.sync_api import expect
from tests.api.small_payload import payload_files
from tests.e2e.arm import zipped
from tests.e2e.test_studies_page import drop
from tests.payload.planned import plan_yaml

from exogauge.cli import main
from exogauge.client import Client, ClientProblem
from exogauge.synthetic import payload as generator
from exogauge.synthetic import write_payload_sample

if TYPE_CHECKING:
    from playwright.sync_api import Page
    from tests.e2e.conftest import Service

A_PAYLOAD = re.compile(r"/payloads/[0-9a-f-]{36}$")
NUMBER = r"[-+]?\d+\.\d+"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sample payload, with a plan."""
    out = tmp_path_factory.mktemp("payload") / "sample"
    write_payload_sample(out, 1)
    plan = plan_yaml(postures={"count": 8}).partition("\nplan:\n")[2]
    file = out / "payload.yaml"
    file.write_text(file.read_text() + "plan:\n" + plan)
    return out


@pytest.fixture(scope="module")
def identified(service: Service, folder: Path) -> str:
    """The path of the sample payload's page, identified."""
    with Client(service.url) as client:
        payload = client.upload_payload(folder)
        client.wait(client.identify_payload(payload), progress=False)
    return f"/payloads/{payload.id}"


def test_an_empty_list_says_what_a_payload_is(page: Page, screenshot: Callable[[str], None]) -> None:
    page.goto("/payloads")
    expect(page.get_by_role("heading", name="No payloads yet")).to_be_visible()
    screenshot("payloads-empty")


def test_a_dropped_payload_is_identified_and_exported(page: Page) -> None:
    page.goto("/payloads")
    drop(page, {"gripper.zip": zipped(payload_files())})
    page.wait_for_url(A_PAYLOAD)
    expect(page.get_by_role("heading", name="Gripper", level=1)).to_be_visible()
    expect(page.get_by_role("heading", name="What was identified")).to_be_visible(timeout=120_000)
    row = page.locator("tr[data-value=m]")
    expect(row).to_contain_text("3.2")
    expect(page.get_by_test_id("export")).to_contain_text("set_target_payload(3.")
    expect(page.get_by_text("This controller takes it to be in the flange")).to_be_visible()
    page.get_by_label("Format").select_option("urdf")
    expect(page.get_by_role("alert")).to_contain_text("the data decide none")
    page.get_by_role("link", name="Payloads", exact=True).click()
    expect(page.get_by_role("listitem").filter(has_text="Gripper").get_by_text("Done")).to_be_visible()


def test_files_without_payload_yaml_are_not_sent_and_broken_ones_are_told_with_their_place(page: Page) -> None:
    page.goto("/payloads")
    page.locator("input[type=file]").nth(1).wait_for(state="attached")
    drop(page, {"poses.csv": b"t\n0\n"})
    expect(page.get_by_role("alert")).to_contain_text("payload.yaml is not among these files")
    files = payload_files()
    files["logs/poses.csv"] = files["logs/poses.csv"].replace(b",fx,", b",f_x,")
    drop(page, {"gripper.zip": zipped(files)})
    alert = page.get_by_role("alert")
    expect(alert).to_contain_text("logs/poses.csv, row 0, column fx")
    expect(alert).to_contain_text("Did you mean 'f_x'?")


def test_what_the_doctor_finds_stands_on_the_page_and_is_printed(
    page: Page, service: Service, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for path, content in payload_files().items():
        (tmp_path / path).parent.mkdir(exist_ok=True)
        (tmp_path / path).write_bytes(content)
    yaml = tmp_path / "payload.yaml"
    rated = "sensor:\n  range: {force_n: [10, 10, 10], moment_nm: [9, 9, 9]}\n"
    yaml.write_text(yaml.read_text().replace("sensor:\n", rated).replace("Gripper", "Too heavy"))
    assert main(["payload", "doctor", str(tmp_path), "--server", service.url]) == 1
    said = capsys.readouterr().out
    assert "saturated" in said
    page.goto(f"/payloads/{said.split()[1].rstrip(',')}")
    found = page.locator("tr[data-finding=saturated]").first
    expect(found).to_contain_text("the sensor is rated for 10")
    expect(found).to_contain_text("Error")


def test_what_was_identified_is_told_with_its_doubt(
    page: Page, identified: str, screenshot: Callable[[str], None]
) -> None:
    page.goto(identified)
    mass = page.locator("tr[data-value=m]")
    expect(mass).to_contain_text("40.173")
    expect(page.locator("tr[data-value=Ixx]")).to_contain_text("3.254")
    expect(page.locator("tr[data-value=U]")).to_contain_text("1.825")
    table = page.get_by_role("region", name="Identified values: table")
    for head in ("Reference", "Postures alone", "LS", "TLS", "GTLS", "Used ± std", "95 % interval", "Error"):
        expect(table.get_by_role("columnheader", name=head, exact=True)).to_be_visible()
    ignored, all_out = (
        float(page.locator(f"tr[data-left='fast|{way}']").get_by_role("cell").nth(2).inner_text())
        for way in ("static", "all")
    )
    assert ignored > 10 * all_out
    expect(page.locator("tr[data-contact=contact]")).to_have_count(2)
    screenshot("payload")
    for name in ("report.html", "summary.html"):
        with page.context.expect_page() as opened:
            page.get_by_role("link", name=name).click()
        expect(opened.value.get_by_role("heading", level=1)).to_contain_text("SYNTHETIC component")
        expect(opened.value.get_by_role("row").filter(has_text="mass m")).to_contain_text("40.173")
        opened.value.close()


def test_a_job_that_fails_says_at_which_stage_and_what_to_change(
    page: Page, service: Service, folder: Path, tmp_path: Path, screenshot: Callable[[str], None]
) -> None:
    shutil.copytree(folder, tmp_path / "turned")
    file = tmp_path / "turned" / "payload.yaml"
    file.write_text(
        file.read_text().replace("sees: payload_on_sensor", "sees: sensor_on_payload").replace("seed 1", "turned round")
    )
    with Client(service.url) as client:
        payload = client.upload_payload(tmp_path / "turned")
        with pytest.raises(ClientProblem):
            client.wait(client.identify_payload(payload), progress=False)
    page.goto(f"/payloads/{payload.id}")
    steps = page.get_by_role("list", name="Steps")
    for name, state in (("Reading", "done"), ("Postures", "failed"), ("Excitation", "unreached")):
        expect(steps.get_by_role("listitem").filter(has_text=re.compile(f"^{name}"))).to_have_attribute(
            "data-state", state
        )
    expect(page.get_by_role("alert").filter(has_text="sees: payload_on_sensor").first).to_be_visible()
    screenshot("payload-failed")


def test_what_the_model_lacks_is_told_with_its_size(
    page: Page, service: Service, tmp_path: Path, screenshot: Callable[[str], None]
) -> None:
    write_payload_sample(tmp_path / "hidden", 11, ["crosstalk@my_fx"])
    with Client(service.url) as client:
        payload = client.upload_payload(tmp_path / "hidden")
        client.wait(client.identify_payload(payload), progress=False)
    page.goto(f"/payloads/{payload.id}")
    section = page.get_by_role("region", name="What the model lacks")
    expect(section).to_contain_text("Missing: crosstalk: my of fx")
    told = re.compile(r"share −0\.00\d+ ± \S+ m\. What was not fitted goes from 3")
    expect(section.get_by_role("listitem")).to_contain_text(told)
    screenshot("payload-missing")


def test_what_the_sensors_calibration_was_found_to_be_is_told_with_its_doubt(
    page: Page, service: Service, identified: str, tmp_path: Path, screenshot: Callable[[str], None]
) -> None:
    """Of a sensor of which nothing is stated; a simulated one is stated to be exact."""
    write_payload_sample(tmp_path / "sensor", 12, ["crosstalk@my_fx", "gain@fz"])
    file = tmp_path / "sensor" / "payload.yaml"
    file.write_text(re.sub(r"\nuncertainty: .*", "", file.read_text()))
    with Client(service.url) as client:
        payload = client.upload_payload(tmp_path / "sensor")
        job = client.wait(client.identify_payload(payload), progress=False)
        found = client.results(job)["calibration"]
    page.goto(f"/payloads/{payload.id}")
    section = page.get_by_role("region", name="Calibration of the sensor")
    expect(section).to_contain_text("1 % of each axis, 1 % that all share, 1 % of crosstalk (not stated;")
    expect(section).to_contain_text("is taken out of every wrench")
    cell = section.locator("tr[data-channel=τ_y]").get_by_role("cell").first
    told, doubt = (float(each.replace("−", "-")) for each in cell.inner_text().split(" ± "))
    assert told == pytest.approx(found["taken_out"][4][0], abs=0.06 * found["std"][4][0])
    assert doubt == pytest.approx(found["std"][4][0], rel=0.06)
    expect(cell).to_have_attribute("data-sure", "true")
    mass = section.locator("tr[data-doubt=m]").get_by_role("cell")
    assert float(mass.nth(3).inner_text()) > 3.0  # times as doubtful as with an exact sensor
    screenshot("payload-calibration")
    page.goto(identified)
    expect(page.get_by_role("heading", name="What the model lacks")).to_be_visible()
    expect(section).to_have_count(0)


def test_an_export_moves_into_the_flange_as_it_is_typed(page: Page, identified: str) -> None:
    page.goto(identified)
    shown = page.get_by_test_id("export")
    before = cog(shown.inner_text())
    page.get_by_label("In the flange’s frame").check()
    page.get_by_label("z [m]").fill("0.04")
    expect(shown).to_contain_text("the sensor stands in it at 0 0 0.04 0 0 0")
    assert cog(shown.inner_text()) == pytest.approx([before[0], before[1], before[2] + 0.04], abs=1e-8)
    page.get_by_label("Format").select_option("kuka")
    expect(shown).to_contain_text("LOAD_DATA[1]={M 40.17")
    with page.expect_download() as download:
        page.get_by_role("link", name="Download").click()
    assert download.value.path().read_text(encoding="utf-8") == shown.inner_text().rstrip("\n") + "\n"
    page.get_by_label("z [m]").fill("four")
    expect(page.get_by_text("This is no number.")).to_be_visible()
    expect(page.get_by_text("The pose needs all six numbers.")).to_be_visible()
    page.get_by_label("z [m]").fill("0,05")
    expect(shown).to_contain_text("LOAD_DATA[1]={M 40.17")
    page.get_by_label("z [m]").fill("40")
    expect(page.get_by_role("alert")).to_contain_text("Give x y z in m")


def cog(text: str) -> list[float]:
    found = re.search(rf"set_target_payload\({NUMBER}, \[({NUMBER}), ({NUMBER}), ({NUMBER})\]", text)
    assert found is not None, text
    return [float(x) for x in found.groups()]


def test_postures_are_planned_and_told(page: Page, identified: str, screenshot: Callable[[str], None]) -> None:
    page.goto(identified)
    page.get_by_role("button", name="Plan postures").click()
    plan = page.locator("[data-plan=postures]")
    expect(plan.get_by_text("Done")).to_be_visible(timeout=180_000)
    expect(plan).to_contain_text("Condition")
    with page.expect_download() as download:
        plan.get_by_role("link", name="postures.csv").click()
    assert len(download.value.path().read_text(encoding="utf-8").splitlines()) == 9
    screenshot("payload-planned")


def test_the_payload_is_shown_on_its_robot(page: Page, identified: str, screenshot: Callable[..., None]) -> None:
    page.goto(identified)
    page.get_by_role("button", name="Show it on its robot").click()
    frame = page.frame_locator("iframe")
    expect(frame.locator("canvas").first).to_be_visible(timeout=120_000)
    shown = page.get_by_role("group", name="What is shown")
    for words in ("axes of the sensor (ft)", "where z may point", "centre of mass, 3 std", "solid ellipsoid"):
        expect(shown).to_contain_text(words)
    shown.get_by_label("where z may point").uncheck()
    page.wait_for_timeout(1500)
    screenshot("payload-3d", without=("iframe",))


def test_a_payload_that_only_plans_offers_no_identification(page: Page, service: Service, tmp_path: Path) -> None:
    (tmp_path / "payload.yaml").write_text(plan_yaml())
    (tmp_path / "arm.urdf").write_text(generator.arm_urdf())
    with Client(service.url) as client:
        payload = client.upload_payload(tmp_path)
    page.goto(f"/payloads/{payload.id}")
    expect(page.get_by_role("button", name="Plan excitation")).to_be_visible()
    expect(page.get_by_role("button", name="Identify")).to_have_count(0)
