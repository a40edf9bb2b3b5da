"""Jobs over HTTP, without a worker: what is asked for is recorded, once, and said honestly."""

from __future__ import annotations

import json
import threading
from uuid import uuid4

import pytest
import sqlalchemy as sa

from exogauge.jobs import claims, recipes
from exogauge.jobs.leases import Lease
from exogauge.storage.files import PinnedFile

pytestmark = pytest.mark.usefixtures("without_bytes")

BURN = recipes.Recipe("burn", "nowhere:burn", timeout_s=60.0)


@pytest.fixture
def study(app, monkeypatch):
    """The id of a study in the store."""
    monkeypatch.setitem(recipes.RECIPES, "burn", BURN)
    storage = app.state.installation.of_lab("local")
    blob = storage.blobs.put(b"version: 1\n")
    with storage.transaction() as store:
        return store.studies.add("burning", [PinnedFile("study.yaml", blob, 11)], {})[0].id


def ask(client, study, **more):
    return client.post("/api/v1/jobs", json={"study_id": study, "kind": "burn", **more})


def test_a_new_job_is_accepted_and_an_equal_request_finds_it(client, study):
    first = ask(client, study, settings={"seconds": 1})
    assert first.status_code == 202
    assert first.json()["state"] == "queued"
    assert "none is running" in first.json()["place"]
    assert client.get(first.headers["location"]).json()["id"] == first.json()["id"]
    second = ask(client, study, settings={"seconds": 1})
    assert (second.status_code, second.json()["id"]) == (200, first.json()["id"])
    other = ask(client, study, settings={"seconds": 2})
    assert other.json()["id"] != first.json()["id"]
    listed = client.get("/api/v1/jobs", params={"limit": 1}).json()
    rest = client.get("/api/v1/jobs", params={"cursor": listed["next_cursor"]}).json()
    assert [job["id"] for job in [*listed["items"], *rest["items"]]] == [other.json()["id"], first.json()["id"]]
    assert "1 job ahead" not in listed["items"][0]["place"]  # there is no worker: that is what the user must know


def test_a_request_sent_twice_under_one_key_is_answered_twice_with_the_same(client, study):
    key = {"Idempotency-Key": "once"}
    first = client.post("/api/v1/jobs", json={"study_id": study, "kind": "burn"}, headers=key)
    again = client.post("/api/v1/jobs", json={"study_id": study, "kind": "burn"}, headers=key)
    assert (again.status_code, again.json()) == (202, first.json())
    assert again.headers["location"] == first.headers["location"]
    assert again.headers["idempotency-replayed"] == "true"


def test_what_cannot_be_run_is_refused_by_name(client, study):
    unknown = ask(client, study, kind="cook")
    assert unknown.status_code == 422
    assert unknown.json()["errors"][0]["column"] == "kind"
    assert "evaluate" in unknown.json()["errors"][0]["advice"]
    wrong = ask(client, study, kind="evaluate", settings={"cutoff": 3, "solver": "magic"})
    assert wrong.status_code == 422
    assert {error["column"] for error in wrong.json()["errors"]} == {"settings.cutoff", "settings.solver"}
    assert ask(client, str(uuid4())).status_code == 404
    assert client.get(f"/api/v1/jobs/{uuid4()}").status_code == 404
    assert client.get(f"/api/v1/jobs/{uuid4()}/events").headers["content-type"] == "application/problem+json"
    assert client.post(f"/api/v1/jobs/{uuid4()}/cancel").status_code == 404


@pytest.mark.parametrize("kind", ["support", "stiffness"])
def test_what_needs_a_worn_device_is_refused_where_the_summary_shows_none(client, app, study, kind):
    logs = [{"name": "id_1", "role": "identification"}, {"name": "val_1", "role": "validation"}]
    with app.state.installation.of_lab("local").transaction() as store:
        plain = store.studies.add("plain", [PinnedFile("study.yaml", "1" * 64, 1)], {"logs": logs})[0].id
        worn = [*logs, {"name": "bend", "role": "with_device"}]
        full = store.studies.add("worn", [PinnedFile("study.yaml", "2" * 64, 1)], {"logs": worn})[0].id
    refused = ask(client, plain, kind=kind)
    assert refused.status_code == 422
    assert refused.json()["type"] == "urn:exogauge:problem:bad-study"
    (error,) = refused.json()["errors"]
    assert (error["code"], error["file"], error["value"]) == ("no_worn_log", "study.yaml", "identification, validation")
    assert "`evaluate`" in error["advice"]
    assert client.get("/api/v1/jobs").json()["items"] == []
    assert ask(client, full, kind=kind).status_code == 202
    assert ask(client, study, kind=kind).status_code == 202  # its summary tells nothing: the computation will
    assert ask(client, plain, kind="evaluate").status_code == 202


DIFFER = {
    "detail": "the motions of 'worn' and 'plain' differ",
    "rule": "motions_differ",
    "advice": "Record the same motion with and without the device.",
    "file": "logs/worn.csv",
    "row": None,
    "column": "q.elbow",
    "value": "31 % of the joint's own velocity",
}


@pytest.mark.parametrize(
    ("failure", "status", "slug"),
    [
        ({"class": "BadStudy", "faults": [DIFFER]}, 422, "bad-study"),
        ({"class": "NotIdentifiable", "faults": []}, 422, "not-identifiable"),
        ({"class": "SomethingNewer", "faults": []}, None, None),
        ({"class": "BadStudy", "faults": [], "defect": True}, None, None),
        (None, None, None),
    ],
)
def test_a_failed_job_says_what_was_wrong_as_a_refused_upload_would(client, app, study, failure, status, slug):
    storage = app.state.installation.of_lab("local")
    job = ask(client, study).json()["id"]
    Lease(storage.engine, "w", 60.0).take()
    with storage.transaction() as store:
        claims.claim(store.session, job, "w")
        assert claims.fail(store.session, job, "w", "they differ \0", failure)
    shown = client.get(f"/api/v1/jobs/{job}").json()
    assert shown["state"] == "failed"
    assert shown["defect"] is bool(failure and failure.get("defect"))
    assert client.get(f"/api/v1/studies/{study}").json()["latest_job"]["problem"] == shown["problem"]
    if status is None:
        assert shown["problem"] is None
        return
    assert (shown["problem"]["status"], shown["problem"]["type"]) == (status, f"urn:exogauge:problem:{slug}")
    if failure["faults"]:
        (error,) = shown["problem"]["errors"]
        expected = {key: value for key, value in DIFFER.items() if key != "rule"}
        assert error == {**expected, "code": "motions_differ", "pointer": None}
    else:
        assert "they differ" in shown["problem"]["detail"]


def test_a_cancelled_job_stays_cancelled_and_can_be_tried_again_as_a_new_one(client, study):
    job = ask(client, study).json()["id"]
    refused = client.post(f"/api/v1/jobs/{job}/retry")
    assert refused.status_code == 409
    assert client.post(f"/api/v1/jobs/{job}/cancel").json()["state"] == "cancelled"
    assert client.post(f"/api/v1/jobs/{job}/cancel").json()["state"] == "cancelled"
    again = client.post(f"/api/v1/jobs/{job}/retry")
    assert again.status_code == 202
    assert again.json()["id"] != job
    assert again.json()["state"] == "queued"
    assert client.get(f"/api/v1/jobs/{job}").json()["state"] == "cancelled"


def events(client, job, **headers):
    text = client.get(f"/api/v1/jobs/{job}/events", headers=headers).text
    blocks = [dict(line.split(": ", 1) for line in block.splitlines()) for block in text.strip().split("\n\n")]
    return [(int(block["id"]), json.loads(block["data"])) for block in blocks if "data" in block]


def test_events_tell_every_look_until_the_end_and_resume(client, study, app):
    storage = app.state.installation.of_lab("local")
    job = ask(client, study).json()["id"]
    Lease(storage.engine, "w", 60.0).take()
    told = []
    watcher = threading.Thread(target=lambda: told.extend(events(client, job)))
    watcher.start()
    with storage.transaction() as store:
        assert claims.claim(store.session, job, "w").state == "running"
        assert claims.report(store.session, job, "w", 0.5, "half")
    with storage.transaction() as store:
        assert claims.fail(store.session, job, "w", "out of wood")
    watcher.join(timeout=30.0)
    ids = [number for number, _ in told]
    assert ids == sorted(set(ids))
    assert told[-1][1]["state"] == "failed"
    assert told[-1][1]["reason"] == "out of wood"
    again = events(client, job, **{"Last-Event-ID": str(ids[-1])})
    assert again == told[-1:]
    assert events(client, job, **{"Last-Event-ID": "not a number"}) == told[-1:]


def test_a_job_tells_its_steps_with_their_times_and_begins_them_anew_with_each_attempt(client, study, app):
    storage = app.state.installation.of_lab("local")
    job = ask(client, study).json()["id"]
    lease = Lease(storage.engine, "w", 60.0)
    lease.take()

    def steps():
        return client.get(f"/api/v1/jobs/{job}").json()["steps"]

    def claimed(worker):
        with storage.transaction() as store:
            assert claims.claim(store.session, job, worker)

    claimed("w")
    solving = [(share, "solving", "identify") for share in (0.1, 0.4)]
    said = ((0.0, "opening", "reading"), *solving, (0.9, "done", None))
    for each in said:
        with storage.transaction() as store:
            assert claims.report(store.session, job, "w", *each)
        assert client.get(f"/api/v1/jobs/{job}").json()["stage"] == each[2]
    told = steps()
    assert [(each["progress"], each["message"], each["stage"]) for each in told] == [said[0], said[1], said[3]]
    assert [each["seconds"] is None for each in told] == [False, False, True]
    assert all(each["seconds"] is None or 0.0 <= each["seconds"] < 60.0 for each in told)
    (listed,) = client.get("/api/v1/jobs").json()["items"]
    assert (listed["steps"], listed["log"]) == ([], None)  # most of what a job is, and given with it alone
    lease.give_back()
    Lease(storage.engine, "v", 60.0).take()
    claimed("v")
    assert steps() == []
    with storage.transaction() as store:
        assert claims.report(store.session, job, "v", 0.2, "reading")
        assert claims.fail(store.session, job, "v", "out of wood")
    assert [each["seconds"] is None for each in steps()] == [False]


def test_a_queued_job_knows_how_many_start_before_it(client, study):
    jobs = [ask(client, study, settings={"n": k}).json() for k in range(3)]
    assert [job["ahead"] for job in jobs] == [0, 1, 2]
    client.post(f"/api/v1/jobs/{jobs[0]['id']}/cancel")
    assert client.get(f"/api/v1/jobs/{jobs[2]['id']}").json()["ahead"] == 1
    assert client.get(f"/api/v1/jobs/{jobs[0]['id']}").json()["ahead"] is None


@pytest.mark.slow
def test_a_list_of_jobs_takes_as_many_statements_for_fifty_as_for_one(client, study, app):
    counted = []
    sa.event.listen(app.state.installation.engine, "before_cursor_execute", lambda *_: counted.append(1))

    def statements():
        fewest = []
        for _ in range(3):  # a connection that has rested is asked whether it is there
            counted.clear()
            answer = client.get("/api/v1/jobs", params={"limit": 100}).json()["items"]
            fewest.append(len(counted))
        return len(answer), min(fewest), answer

    ask(client, study)
    _, few, _ = statements()
    rest = [ask(client, study, settings={"n": k}).json()["id"] for k in range(49)]
    count, many, listed = statements()
    assert (count, many) == (50, few)
    assert [job["ahead"] for job in listed] == list(range(49, -1, -1))
    client.post(f"/api/v1/jobs/{rest[0]}/cancel")
    _, mixed, listed = statements()
    assert mixed == few
    shown = [client.get(f"/api/v1/jobs/{job['id']}").json() for job in listed[-3:]]
    assert [(job["ahead"], job["place"]) for job in listed[-3:]] == [(job["ahead"], job["place"]) for job in shown]


def test_only_the_living_may_change_a_job_and_only_while_they_hold_it(client, study, app):
    storage = app.state.installation.of_lab("local")
    job = ask(client, study).json()["id"]
    lease = Lease(storage.engine, "w", 60.0)
    with storage.transaction() as store:
        assert claims.claim(store.session, job, "w") is None  # no lease, no job
    lease.take()
    Lease(storage.engine, "v", 60.0).take()
    with storage.transaction() as store:
        assert claims.claim(store.session, job, "w").attempts == 1
        assert claims.claim(store.session, job, "v") is None
        assert not claims.report(store.session, job, "v", 0.5, "")
        assert claims.unattended(store.session) == []
    lease.give_back()
    with storage.transaction() as store:
        assert claims.unattended(store.session) == [job]
        taken = claims.claim(store.session, job, "v")
        assert (taken.worker, taken.attempts) == ("v", 2)
        assert not claims.fail(store.session, job, "w", "too late")
        assert claims.cancel_wanted(store.session, job, "w") is None
