"""What a job made can be read, in part too, and can do nothing in a browser."""

from __future__ import annotations

import hashlib

import pytest
from fastapi.testclient import TestClient

V1 = "/api/v1"


def test_results_are_found_by_job_and_by_study(client: TestClient, study_id: str, finished_job: str) -> None:
    for path in (f"jobs/{finished_job}/results", f"studies/{study_id}/results"):
        answer = client.get(f"{V1}/{path}")
        assert answer.json() == {"version": 1}
        assert answer.headers["content-type"] == "application/json"
        same = client.get(f"{V1}/{path}", headers={"If-None-Match": answer.headers["etag"]})
        assert (same.status_code, same.content) == (304, b"")
    study = client.get(f"{V1}/studies/{study_id}").json()
    assert study["latest_job"]["state"] == "succeeded"


def test_a_study_without_a_finished_job_has_no_results(client: TestClient, study_id: str) -> None:
    answer = client.get(f"{V1}/studies/{study_id}/results")
    assert answer.status_code == 404
    assert "succeeded yet" in answer.json()["detail"]


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_an_artifact_is_served_whole_and_in_ranges(client: TestClient, finished_job: str) -> None:
    items = client.get(f"{V1}/jobs/{finished_job}/artifacts").json()["items"]
    assert [item["name"] for item in items] == ["report.html", "results.json", "series/id.parquet"]
    content = bytes(range(256)) * 8
    series = f"{V1}/{items[2]['href']}"
    whole = client.get(series)
    assert whole.content == content
    assert whole.headers["etag"] == f'"{hashlib.sha256(content).hexdigest()}"' == f'"{items[2]["sha256"]}"'
    assert whole.headers["content-disposition"] == 'attachment; filename="id.parquet"'
    part = client.get(series, headers={"Range": "bytes=100-199"})
    assert (part.status_code, part.content) == (206, content[100:200])
    for asked, status in (("bytes=9999-", 416), ("lines=1-2", 400)):
        refused = client.get(series, headers={"Range": asked})
        assert (refused.status_code, refused.headers["content-type"]) == (status, "application/problem+json")
    stale = client.get(series, headers={"Range": "bytes=0-9", "If-Range": '"another"'})
    assert (stale.status_code, len(stale.content)) == (200, len(content))


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_a_report_may_neither_run_script_nor_ask_anyone(client: TestClient, finished_job: str) -> None:
    report = client.get(f"{V1}/jobs/{finished_job}/artifacts/report.html")
    assert report.headers["content-type"].startswith("text/html")
    policy = report.headers["content-security-policy"]
    for rule in ("default-src 'none'", "script-src 'none'", "form-action 'none'", "sandbox"):
        assert rule in policy
    assert "allow-scripts" not in policy
    assert report.headers["x-content-type-options"] == "nosniff"


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
@pytest.mark.parametrize(
    "name",
    [
        "../report.html",
        "..%2F..%2Fexogauge.sqlite",
        "%2Fetc%2Fpasswd",
        "series%2F..%2Freport.html",
        "series",
        "a%00b",
        "%ff",
    ],
)
def test_no_name_leads_out_of_the_artifacts(client: TestClient, finished_job: str, name: str) -> None:
    answer = client.get(f"{V1}/jobs/{finished_job}/artifacts/{name}")
    assert answer.status_code in (404, 422)
    assert answer.headers["content-type"] == "application/problem+json"
