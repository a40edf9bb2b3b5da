"""`exogauge.Client` against a real service."""

from __future__ import annotations

import subprocess
import sys
import zipfile

import httpx
import pytest

import exogauge
from exogauge.client import Client, ClientProblem, transport

pytestmark = pytest.mark.slow


def test_the_package_is_light_until_the_client_is_asked_for():
    code = "import sys, exogauge; assert 'httpx' not in sys.modules; exogauge.Client; assert 'httpx' in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)
    assert exogauge.Client is Client


def test_a_study_goes_in_and_a_result_comes_out(client, study, study_folder, tmp_path, capfd):
    assert study.name == "Arm"
    assert client.upload_study(study_folder / "study.yaml") == study  # the same files are the same study
    assert study.id in [each.id for each in client.studies()]
    settings = {"ledger": str(tmp_path / "ledger"), "seconds": 0.5}
    job = client.submit(study, "burn", settings)
    done = client.wait(job)
    assert done.state == "succeeded"
    assert "succeeded" in capfd.readouterr().err
    assert client.submit(study, "burn", settings).id == job.id
    seen = client.results(job)["files"]
    assert set(seen) == {"study.yaml", "robot.yaml", "robot.urdf", "logs/id.csv", "logs/val.csv"}  # and no truth.json
    written = client.download(job, tmp_path / "out")
    assert [path.relative_to(tmp_path / "out").as_posix() for path in written] == ["results.json", "series/a.csv"]
    assert [each.id for each in client.jobs(study)] == [job.id]


def test_a_zip_a_robot_and_logs_are_accepted_too(client, study, study_folder, tmp_path):
    with zipfile.ZipFile(tmp_path / "study.zip", "w") as bundle:
        for path in sorted(study_folder.rglob("*")):
            if path.is_file() and path.name != "truth.json":
                bundle.write(path, path.relative_to(study_folder))
    assert client.upload_study(tmp_path / "study.zip") == study
    robot = client.upload_robot(study_folder / "robot.yaml")
    log = client.upload_log(study_folder / "logs" / "id.csv")
    put_together = client.create_study("From parts", robot, [{"log_id": log.id, "role": "identification"}])
    assert client.study(put_together).name == "From parts"


DEVICE = """version: 1
name: Elbow strap
bands:
  - name: front
    via_points: [{link: base, xyz: [0.05, 0, 0]}, {link: arm, xyz: [0.05, 0, 0.1]}]
    stiffness_n_per_m: 200
    bench: {file: bench/front.csv}
"""


def test_a_device_is_handed_in_with_what_it_names_and_nothing_else(client, study, study_folder):
    suit = study_folder / "strap.yaml"  # under any name
    suit.write_text(DEVICE)
    (study_folder / "bench").mkdir()
    (study_folder / "bench" / "front.csv").write_text("length_m,force_n\n0.25,0\n0.30,10\n0.35,20\n")
    robot = client.upload_robot(study_folder / "robot.yaml")
    device = client.upload_device(suit, robot)
    assert (device.name, device.version, device.robot_id) == ("Elbow strap", 1, robot.id)
    assert device.summary["reads"] == ["bench/front.csv", "device.yaml"]
    assert client.device(device) == client.device(device.id) == device
    suit.write_text(DEVICE.replace("200", "190"))
    newer = client.upload_device(suit, robot.id)
    assert [(each.id, each.version) for each in client.devices(name="Elbow strap")] == [(newer.id, 2), (device.id, 1)]
    assert list(client.devices(robot=study.id)) == []
    plain, worn = (client.upload_log(study_folder / "logs" / name).id for name in ("id.csv", "val.csv"))
    logs = [{"log_id": plain, "role": "identification"}, {"log_id": worn, "role": "with_device", "motion": "lift"}]
    put_together = client.create_study("Strap", robot, logs, device=device)
    assert put_together.summary["devices"][0]["name"] == "Elbow strap"
    suit.write_text(DEVICE.replace("arm", "amr").replace("200", "-200"))
    with pytest.raises(ClientProblem) as problem:
        client.upload_device(suit, robot)
    assert "row 5" in str(problem.value)
    assert "Did you mean 'arm'" in str(problem.value)
    assert {error["value"] for error in problem.value.errors} == {"amr", "-200"}
    suit.write_text("name: [")
    with pytest.raises(ClientProblem, match="not readable as YAML"):
        client.upload_device(suit, robot)


def test_a_study_without_a_worn_device_has_no_supporting_torque(client, study):
    for kind in ("support", "stiffness"):
        with pytest.raises(ClientProblem, match="recorded with a device on") as problem:
            client.submit(study, kind)
        assert problem.value.errors[0]["code"] == "no_worn_log"


def test_motions_that_differ_are_told_joint_by_joint(client, study, tmp_path):
    job = client.submit(study, "burn", {"ledger": str(tmp_path / "ledger"), "mode": "differ"})
    with pytest.raises(ClientProblem, match="the job failed") as problem:
        client.wait(job, progress=False)
    assert [(error["column"], error["value"]) for error in problem.value.errors] == [
        ("dq.elbow", "31 %"),
        ("dq.knee", "44 %"),
    ]
    for error in problem.value.errors:
        assert (error["code"], error["file"]) == ("motions_differ", "worn.csv")
    assert "worn.csv, column 'dq.knee': the motions differ (value: 44 %). Record the same motion" in str(problem.value)
    assert client.job(job).problem["title"] == "What was handed in breaks a rule"


def test_a_problem_reads_like_advice(client, study_folder):
    (study_folder / "logs" / "id.csv").write_text("t,q.elbow,tau.elbow\n0.0,0.1,zero\n")
    with pytest.raises(ClientProblem) as problem:
        client.upload_study(study_folder)
    assert problem.value.status == 422
    assert "logs/id.csv" in str(problem.value)
    assert "'tau.elbow'" in str(problem.value)
    with pytest.raises(ClientProblem, match="Not found"):
        client.study("00000000-0000-0000-0000-000000000000")


def test_waiting_for_a_job_that_fails_says_why(client, study, tmp_path):
    job = client.submit(study, "burn", {"ledger": str(tmp_path / "ledger"), "mode": "bad"})
    with pytest.raises(ClientProblem, match="the job failed"):
        client.wait(job, progress=False)
    again = client.retry(job)
    assert again.id != job.id
    with pytest.raises(ClientProblem, match="Add it"):
        client.wait(again, progress=False)


def test_a_running_job_is_cancelled(client, study, tmp_path):
    job = client.submit(study, "burn", {"ledger": str(tmp_path / "ledger"), "seconds": 60.0})
    client.cancel(job)
    with pytest.raises(ClientProblem, match="the job cancelled"):
        client.wait(job, progress=False)


class Flaky(httpx.HTTPTransport):
    """Passes requests on, and loses every first answer."""

    def __init__(self) -> None:
        super().__init__()
        self.keys: list[str] = []

    def handle_request(self, request: httpx.Request) -> httpx.Response:
        response = super().handle_request(request)
        self.keys.append(request.headers.get("Idempotency-Key", ""))
        if len(self.keys) % 2 == 1:
            response.close()
            raise httpx.ReadError("the line broke")
        return response


def test_a_lost_answer_is_asked_for_again_under_the_same_key(service, study_folder):
    flaky = Flaky()
    with Client(service.url, transport=flaky) as client:
        client.upload_log(study_folder / "logs" / "id.csv")
    assert len(flaky.keys) == 2
    assert flaky.keys[0] == flaky.keys[1] != ""


def test_a_service_that_is_not_there_is_named(monkeypatch):
    monkeypatch.setattr(transport, "ATTEMPTS", 2)
    with Client("http://127.0.0.1:9") as client, pytest.raises(ClientProblem, match=r"no answer from .*127\.0\.0\.1:9"):
        client.health()
