"""A payload through the real service: handed in, identified by a worker, planned, exported; by client and command."""

from __future__ import annotations

import csv
import io
import json

import numpy as np
import pytest
from tests.api.small_payload import CENTRE, MASS, payload_files
from tests.payload.planned import plan_yaml

from exogauge.cli import main
from exogauge.client import ClientProblem
from exogauge.synthetic import payload as generator

pytestmark = pytest.mark.slow


def write(folder, files):
    for path, content in files.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(content if isinstance(content, bytes) else content.encode())
    return folder


@pytest.fixture
def gripper(tmp_path):
    return write(tmp_path / "gripper", payload_files() | {"truth.json": b"{}"})


@pytest.fixture
def planned(tmp_path):
    """Only a plan; postures of three joints, and a short motion."""
    text = plan_yaml(postures={"count": 8}, excitation={"starts": 1, "duration_s": 4.0, "harmonics": 3})
    return write(tmp_path / "planned", {"payload.yaml": text, "arm.urdf": generator.arm_urdf()})


def test_a_payload_goes_in_and_what_it_weighs_comes_out(client, gripper, tmp_path):
    payload = client.upload_payload(gripper / "payload.yaml")
    assert client.upload_payload(gripper) == payload
    assert payload.id in [each.id for each in client.payloads("Gripper")]
    job = client.wait(client.identify_payload(payload))
    assert (job.payload_id, job.study_id, job.kind) == (payload.id, None, "payload")
    values = {each["name"]: each for each in client.payload_results(payload)["static"]["values"]}
    assert client.results(job) == client.payload_results(payload)
    for name, truth in zip(("m", "cx", "cy", "cz"), (MASS, *CENTRE), strict=True):
        assert abs(values[name]["value"] - truth) < 4 * values[name]["std"]
    rows = csv.DictReader(io.StringIO(client.export_payload(payload, "csv", tmp_path / "payload.csv").read_text()))
    assert [float(row["value"]) for row in rows] == pytest.approx([values[n]["value"] for n in ("m", "cx", "cy", "cz")])
    flange = client.export_payload(payload, "ur", tmp_path / "payload.script", [0, 0, 0.05, 0, 0, 90]).read_text()
    cog = [float(x) for x in flange.splitlines()[-1].partition("[")[2].partition("]")[0].split(", ")]
    assert cog == pytest.approx([-values["cy"]["value"], values["cx"]["value"], values["cz"]["value"] + 0.05], abs=1e-8)
    assert [each.id for each in client.jobs(payload=payload)] == [job.id]


def test_what_is_planned_is_told_with_its_tables(client, planned, tmp_path):
    payload = client.upload_payload(planned)
    jobs = {what: client.wait(client.plan_payload(payload, what)) for what in ("postures", "excitation")}
    said = {step["message"] for step in jobs["excitation"].steps}  # looks are 0.2 s apart: not every step is seen
    assert said & {"reading the robot", "postures", "start 1 of 1", "rehearsal"}
    plans = {each["job"]["settings"]["what"]: each for each in client.payload_plans(payload)}
    assert {what: each["job"]["id"] for what, each in plans.items()} == {what: job.id for what, job in jobs.items()}
    assert plans["postures"]["found"]["certainties"][0]["name"] == "m"
    assert plans["excitation"]["found"]["seconds"] == 4.0
    (table,) = client.download(jobs["postures"], tmp_path, ["postures.csv"])
    rows = list(csv.DictReader(io.StringIO(table.read_text())))
    assert len(rows) == 8
    down = np.array([[float(row[f"gravity.{axis}"]) for axis in "xyz"] for row in rows])
    np.testing.assert_allclose(np.linalg.norm(down, axis=1), 1.0, atol=1e-9)
    assert {each.name for each in client.artifacts(jobs["excitation"])} == {"plan.json", "excitation.csv"}
    with pytest.raises(ClientProblem, match="no log identifies"):
        client.identify_payload(payload)
    with pytest.raises(ClientProblem, match="no job of payload"):
        client.payload_results(payload)


def test_a_fault_that_only_the_evaluation_finds_ends_the_job_with_its_place(client, tmp_path):
    files = payload_files()
    files["payload.yaml"] = files["payload.yaml"].replace(b"sensor:\n", b"sensor:\n  sees: sensor_on_payload\n")
    job = client.identify_payload(client.upload_payload(write(tmp_path / "turned", files)))
    with pytest.raises(ClientProblem, match="weight points the other way") as raised:
        client.wait(job)
    (error,) = raised.value.errors
    assert (error["file"], error["column"], error["value"]) == ("payload.yaml", "sensor.sees", "sensor_on_payload")
    assert "sees: payload_on_sensor" in error["advice"]
    assert client.job(job).problem["status"] == 422


def test_a_plan_can_be_cancelled_while_it_is_made(client, tmp_path):
    text = plan_yaml(excitation={"starts": 50, "duration_s": 60.0})
    folder = write(tmp_path / "long", {"payload.yaml": text, "arm.urdf": generator.arm_urdf()})
    job = client.plan_payload(client.upload_payload(folder), "excitation")
    while client.job(job).progress < 0.05:
        assert not client.job(job).ended
    client.cancel(job)
    with pytest.raises(ClientProblem, match="cancelled"):
        client.wait(job)


def test_the_commands_let_a_service_do_it(service, gripper, planned, tmp_path, capsys):
    url = service.url
    assert main(["payload", "run", str(gripper), "--out", str(tmp_path / "out"), "--server", url]) == 0
    told = capsys.readouterr().out
    found = json.loads((tmp_path / "out" / "results.json").read_text())
    key = told.split()[1].rstrip(",")
    assert main(["payload", "list", "--server", url]) == 0
    assert key in capsys.readouterr().out
    assert main(["payload", "export", key, "--format", "json", "--server", url]) == 0
    remote = json.loads(capsys.readouterr().out)
    assert main(["payload", "export", str(tmp_path / "out"), "--format", "json"]) == 0
    assert json.loads(capsys.readouterr().out) == remote
    assert remote["values"][0]["value"] == found["static"]["values"][0]["value"]
    assert main(["payload", "postures", str(planned), "--out", str(tmp_path / "plan"), "--server", url]) == 0
    assert {path.name for path in (tmp_path / "plan").iterdir()} == {"plan.json", "postures.csv"}
    assert main(["payload", "run", str(planned), "--out", str(tmp_path / "no"), "--server", url]) == 2
    assert "no log identifies the payload" in capsys.readouterr().err
