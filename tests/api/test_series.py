"""Series of a job over HTTP: what there is, what is drawn, what is taken away."""

from __future__ import annotations

import io
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow.parquet as pq
import pytest

from exogauge.studies.series.write import Columns

if TYPE_CHECKING:
    from fastapi.testclient import TestClient

    from exogauge.storage.store import Storage

V1 = "/api/v1"
TAU, REST = "measured.tau.waist", "support_rest.waist"
pytestmark = pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)


@pytest.fixture
def job(client: TestClient) -> str:
    """A job that has made one series of 1000 samples at 100 Hz, the fifth of them missing."""
    from exogauge.storage.tables import Artifact, Job

    columns = Columns(np.arange(1000) / 100)
    values = np.arange(1000.0)
    values[4] = np.nan
    columns.add(TAU, values, "N·m")
    columns.add_truth(REST, values > 500)
    sink = io.BytesIO()
    pq.write_table(columns.table({"log": "lift"}), sink)
    storage: Storage = client.app.state.installation.of_lab("local")  # type: ignore[attr-defined]
    sha256 = storage.blobs.put(sink.getvalue())
    with storage.transaction() as store:
        study, _ = store.studies.add("s", [], {})
        now = datetime.now(UTC)
        job = Job(kind="evaluate", study_id=study.id, request_hash="0", state="succeeded", finished_at=now)
        store.session.add(job)
        store.session.flush()
        common = {"job_id": job.id, "sha256": sha256, "size": 1, "media_type": "application/vnd.apache.parquet"}
        store.session.add(Artifact(name="series/lift.parquet", **common))
        key: str = job.id
    return key


def get(client: TestClient, job: str, path: str, **asked: Any) -> Any:
    return client.get(f"{V1}/jobs/{job}/series{path}", params=asked)


def test_a_list_says_what_can_be_drawn(client: TestClient, job: str) -> None:
    (series,) = get(client, job, "").json()["items"]
    assert series["rate_hz"] == pytest.approx(100.0)
    assert {key: series[key] for key in ("name", "log", "samples", "start", "end")} == {
        "name": "lift", "log": "lift", "samples": 1000, "start": 0.0, "end": 9.99,
    }  # fmt: skip
    assert [(each["name"], each["unit"], each["kind"]) for each in series["channels"]] == [
        (TAU, "N·m", "number"),
        (REST, "", "truth"),
    ]


def test_one_series_can_be_asked_for_by_name(client: TestClient, job: str) -> None:
    assert [each["name"] for each in get(client, job, "", name="lift").json()["items"]] == ["lift"]
    assert get(client, job, "", name="lower").json()["items"] == []


def test_tiles_cover_the_whole_by_default_and_a_missing_value_is_null(client: TestClient, job: str) -> None:
    whole = get(client, job, "/lift/tiles", channels=[TAU, REST], width=100)
    assert whole.status_code == 200, whole.text
    body = whole.json()
    assert (body["start"], body["end"], body["samples"], len(body["t"])) == (0.0, 9.99, 1000, 100)
    assert (min(body["channels"][TAU]["min"]), max(body["channels"][TAU]["max"])) == (0.0, 999.0)
    assert body["channels"][REST]["max"][-1] == 1.0
    assert "immutable" in whole.headers["cache-control"]
    near = get(client, job, "/lift/tiles", channels=TAU, start=0.035, end=0.055).json()
    assert near["t"] == [0.03, 0.04, 0.05, 0.06]
    assert near["channels"][TAU]["min"] == [3.0, None, 5.0, 6.0]


def test_a_window_is_a_file_of_all_its_samples(client: TestClient, job: str) -> None:
    csv = get(client, job, "/lift/window", channels=TAU, start=0.02, end=0.05)
    assert csv.text == f'"t","{TAU}"\n0.02,2\n0.03,3\n0.04,\n0.05,5\n'
    assert csv.headers["content-type"].startswith("text/csv")
    assert csv.headers["content-disposition"] == 'attachment; filename="lift.csv"'
    parquet = get(client, job, "/lift/window", format="parquet")
    table = pq.read_table(io.BytesIO(parquet.content))
    assert (table.num_rows, table.column_names) == (1000, ["t", TAU, REST])


@pytest.mark.parametrize(
    ("path", "asked", "status", "text"),
    [
        ("/other/tiles", {"channels": TAU}, 404, "it has lift"),
        ("/lift/tiles", {"channels": "measured.tau.hip"}, 422, TAU),
        ("/lift/tiles", {}, 422, "query/channels"),
        ("/lift/tiles", {"channels": TAU, "start": 5, "end": 1}, 422, "start <= end"),
        ("/lift/tiles", {"channels": TAU, "start": "nan"}, 422, "query/start"),
        ("/lift/tiles", {"channels": TAU, "width": 0}, 422, "query/width"),
        ("/lift/window", {"format": "xlsx"}, 422, "query/format"),
        ("/..%2Freport/window", {}, 404, ""),
    ],
)
def test_what_is_not_there_is_refused_with_what_is(
    client: TestClient, job: str, path: str, asked: dict[str, Any], status: int, text: str
) -> None:
    answer = get(client, job, path, **asked)
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    assert text in answer.text
