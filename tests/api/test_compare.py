"""Jobs compared and models listed over HTTP, from what workers left behind."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from fastapi.testclient import TestClient

    from exogauge.storage.store import Storage

V1 = "/api/v1"
NOBODY = "00000000-0000-4000-8000-000000000000"
pytestmark = pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)


def number(value: float, std: float | None = 0.1, unit: str = "N·m") -> dict[str, Any]:
    return {"value": value, "std": std, "unit": unit}


def content(mean: float, cutoff: float, verdict: str | None) -> dict[str, Any]:
    """results.json by the contract, with one joint and one band."""
    effort = {"peak": number(2 * mean), "mean": number(mean), "integral": number(mean, None, "N·m·s"), "spread": None}
    entry = {
        "device": "strap", "motion": "bend", "joint": "waist", "unit": "N·m", "main": True, "rmse_a": 0.5,
        "rmse_b": None, "rmse_prior": None, "rmse_steady": {"a": 0.4}, "motion_equality": {"verdict": "doubtful"},
        "approaches": {"A": effort},
    }  # fmt: skip
    band = {
        "device": "strap", "approach": "A", "band": "left", "group": None,
        "stiffness_n_per_m": number(400.0, 3.0, "N/m"), "natural_length_m": number(0.5, 0.01, "m"),
        "truth_n_per_m": None, "error_percent": None, "identifiable": True,
    }  # fmt: skip
    kind = {"kind": "joint_torque", "unit": "N·m", "rmse_prior": 3.0, "rmse_identified": 1.0, "noise_floor": 0.6}
    found = {
        "verdict": verdict,
        "findings": [{"effect": "stribeck", "where": {"joint": "waist"}, "score": 0.8}],
        "lineage": [
            {"version": "identified", "parent": None, "added": ""},
            {"version": "identified+stribeck@waist", "parent": "identified", "added": "stribeck@waist"},
        ],
        "chain": [{"rmse": 1.5, "noise_floor": 0.6, "unit": "N·m"}, {"rmse": 0.7, "noise_floor": 0.6, "unit": "N·m"}],
    }
    return {
        "version": 1, "name": f"Study {mean}", "robot": "Small", "settings": {"cutoff_hz": cutoff},
        "software": {"numpy": "2"}, "inputs": [], "steps": [], "support": [entry], "stiffness": [band],
        "identification": {"summary": [kind | {"held_out": True}]}, "discrepancy": found if verdict else None,
    }  # fmt: skip


def finished(client: TestClient, study_id: str, result: dict[str, Any], kind: str = "evaluate") -> str:
    from exogauge.storage.tables import Artifact, Job, Result

    name = "what_if.json" if kind == "whatif" else "results.json"
    storage: Storage = client.app.state.installation.of_lab("local")  # type: ignore[attr-defined]
    sha256 = storage.blobs.put(json.dumps(result).encode())
    with storage.transaction() as store:
        now = datetime.now(UTC)
        count = len(store.jobs.page(None, 200).items)
        job = Job(kind=kind, study_id=study_id, request_hash=str(count), state="succeeded", finished_at=now)
        store.session.add(job)
        store.session.flush()
        store.session.add(Result(job_id=job.id, study_id=study_id, sha256=sha256, size=1))
        store.session.add(Artifact(job_id=job.id, name=name, sha256=sha256, size=1, media_type="application/json"))
        key: str = job.id
    return key


@pytest.fixture
def study(client: TestClient) -> str:
    with client.app.state.installation.of_lab("local").transaction() as store:  # type: ignore[attr-defined]
        key: str = store.studies.add("s", [], {})[0].id
    return key


@pytest.mark.parametrize("where", [{"joint": "waist"}, {"sensor": "wrist", "axis": "fx"}, {"base": True}])
def test_the_place_of_an_effect_comes_as_the_results_say_it(
    client: TestClient, study: str, where: dict[str, str | bool]
) -> None:
    results = content(3.0, 8.0, "effects")
    results["discrepancy"]["findings"][0] |= {"where": where, "title": "in words"}
    answer = client.get(f"{V1}/compare", params={"jobs": [finished(client, study, results)]})
    assert answer.status_code == 200, answer.text
    (effect,) = answer.json()["jobs"][0]["effects"]
    assert (effect["where"], effect["title"]) == (where, "in words")


def test_two_jobs_stand_side_by_side(client: TestClient, study: str) -> None:
    jobs = [finished(client, study, content(3.0, 8.0, "effects")), finished(client, study, content(4.0, 9.0, None))]
    answer = client.get(f"{V1}/compare", params={"jobs": [*jobs, jobs[0]]})
    assert answer.status_code == 200, answer.text
    found = answer.json()
    assert [(job["id"], job["name"], job["verdict"]) for job in found["jobs"]] == [
        (jobs[0], "Study 3.0", "effects"),
        (jobs[1], "Study 4.0", None),
    ]
    (row,) = found["support"]
    assert (row["device"], row["motion"], row["joint"], row["approach"]) == ("strap", "bend", "waist", "A")
    assert [cell["mean"] for cell in row["cells"]] == [number(3.0), number(4.0)]
    assert (row["cells"][0]["rmse"], row["cells"][0]["motion_equality"]) == (0.5, "doubtful")
    assert found["stiffness"][0]["cells"][1]["stiffness_n_per_m"]["value"] == 400.0
    assert found["settings"] == [{"name": "settings.cutoff_hz", "values": [8.0, 9.0]}]


def test_a_comparison_leaves_as_csv_and_as_latex(client: TestClient, study: str) -> None:
    job = finished(client, study, content(3.0, 8.0, "effects"))
    csv = client.get(f"{V1}/compare", params={"jobs": job, "format": "csv"})
    assert csv.headers["content-type"].startswith("text/csv")
    head, row = csv.text.splitlines()
    assert dict(zip(head.split(","), row.split(","), strict=True))["mean"] == "3.0"
    latex = client.get(f"{V1}/compare", params={"jobs": job, "format": "latex", "table": "stiffness"})
    assert latex.headers["content-disposition"] == 'attachment; filename="comparison-stiffness.tex"'
    assert r"$400.0 \pm 3.0$" in latex.text


def test_what_cannot_be_compared_is_named(client: TestClient, study: str) -> None:
    whatif = finished(client, study, {}, kind="whatif")
    refused = client.get(f"{V1}/compare", params={"jobs": whatif})
    assert (refused.status_code, refused.json()["errors"][0]["value"]) == (422, whatif)
    for asked, status in (({"jobs": NOBODY}, 404), ({}, 422), ({"jobs": "x"}, 422), ({"jobs": [NOBODY] * 21}, 422)):
        answer = client.get(f"{V1}/compare", params=asked)
        assert (answer.status_code, answer.headers["content-type"]) == (status, "application/problem+json")


def test_models_are_listed_with_what_was_added_and_what_it_brought(client: TestClient, study: str) -> None:
    assert client.get(f"{V1}/studies/{study}/models").json()["items"] == []
    finished(client, study, {}, kind="whatif")
    finished(client, study, content(3.0, 8.0, None))
    first = finished(client, study, content(3.0, 8.0, "effects"))
    second = finished(client, study, content(3.0, 9.0, "effects"))
    items = client.get(f"{V1}/studies/{study}/models").json()["items"]
    assert [(each["job_id"], each["version"], each["parent"]) for each in items] == [
        (second, "identified", None),
        (second, "identified+stribeck@waist", "identified"),
        (first, "identified", None),
        (first, "identified+stribeck@waist", "identified"),
    ]
    assert [each["rmse"] for each in items[:2]] == [1.5, 0.7]
    assert items[0]["settings_hash"] == items[1]["settings_hash"] != items[2]["settings_hash"]
    assert client.get(f"{V1}/studies/{NOBODY}/models").status_code == 404
