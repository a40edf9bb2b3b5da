"""A device goes through the real service: from files to the stiffness of its band, and to the reason why not."""

from __future__ import annotations

import pytest

from exogauge.client import ClientProblem

pytestmark = pytest.mark.slow

TRUE_STIFFNESS, TRUE_LENGTH = 200.0, 0.25  # of `worn_arm`


@pytest.mark.slow
def test_the_service_finds_the_stiffness_of_a_worn_band(client, worn_study, tmp_path):
    study = client.upload_study(worn_study(True))
    assert [device["name"] for device in study.summary["devices"]] == ["Elbow strap"]
    job = client.wait(client.submit(study, "stiffness"), progress=False)
    result = client.results(job)
    done = {step["step"]: step["status"] for step in result["steps"]}
    assert (done["support"], done["stiffness"]) == ("done", "done")
    found = {entry["approach"]: entry for entry in result["stiffness"]}
    for approach in "AB":
        stiffness, length = found[approach]["stiffness_n_per_m"], found[approach]["natural_length_m"]
        assert abs(stiffness["value"] - TRUE_STIFFNESS) < max(4.0 * stiffness["std"], 2.0)
        assert abs(length["value"] - TRUE_LENGTH) < max(4.0 * length["std"], 1e-3)
    (support,) = result["support"]
    assert (support["motion"], support["joint"]) == ("bend", "elbow")
    assert support["rmse_a"] < support["rmse_prior"]
    kinds = {artifact.name: artifact.media_type for artifact in client.artifacts(job)}
    assert kinds.keys() >= {"results.json", "report.html", "support.csv", "stiffness.csv", "series/worn.parquet"}
    assert kinds["summary.html"].startswith("text/html")
    assert kinds["summary.pdf"] == "application/pdf"
    (written,) = client.download(job, tmp_path, ["stiffness.csv"])
    assert written.read_text().startswith("device,approach,band")


def test_a_motion_that_is_another_with_the_device_is_named_with_what_to_do(client, worn_study):
    study = client.upload_study(worn_study(False))
    job = client.submit(study, "support")
    with pytest.raises(ClientProblem, match="the job failed") as problem:
        client.wait(job, progress=False)
    (error,) = problem.value.errors
    assert (error["code"], error["column"]) == ("motions_differ", "q.elbow")
    assert error["file"].startswith(("worn", "logs/worn"))
    assert float(error["value"]) > 0.5
    assert "the same motion" in error["advice"]
    assert "plain" in error["detail"]
    told = client.job(job).problem
    assert (told["type"], told["status"], told["errors"]) == ("urn:exogauge:problem:bad-study", 422, [error])
