"""What is old goes where somebody has said so, and nothing else does, on both databases."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from datetime import timedelta
from typing import Any

import pytest
import sqlalchemy as sa
from pydantic import ValidationError

from exogauge.settings import Settings
from exogauge.storage.files import PinnedFile
from exogauge.storage.retention import Ages, Retired, retire
from exogauge.storage.store import Installation, Storage
from exogauge.storage.sweeping import sweep_installation
from exogauge.storage.tables import (
    AuditEntry,
    Delivery,
    IdempotencyKey,
    Job,
    Log,
    Plan,
    Publication,
    Study,
    Webhook,
    utc_now,
)
from exogauge.upkeep.hourly import AGED, Housekeeping

DAY = timedelta(days=1)
OLD, YOUNG = 11 * DAY, 9 * DAY
LABS = ("local", "north")
TEN = {
    "unused_logs_kept_days": 10,
    "job_logs_kept_days": 10,
    "deliveries_kept_days": 10,
    "studies_kept_days": {"north": 10},
}


@pytest.fixture
def installation(storage: Storage) -> Installation:
    return Installation(storage.engine, storage.blobs)


class Of:
    """What a lab has, of which each thing is as old as is said."""

    def __init__(self, installation: Installation, lab: str) -> None:
        self.storage, self.lab = installation.of_lab(lab), lab

    def _put(self, *rows: Any) -> None:
        with self.storage.transaction() as store:
            for row in rows:
                store.session.add(row)
                store.session.flush()

    def log(self, name: str, age: timedelta) -> PinnedFile:
        content = f"{self.lab} {name}".encode()
        file = PinnedFile(name, self.storage.blobs.put(content), len(content))
        with self.storage.transaction() as store:
            store.logs.add(file, None, {})
        with self.storage.transaction() as store:
            store.session.execute(sa.update(Log).where(Log.name == name).values(created_at=utc_now() - age))
        return file

    def study(self, name: str, age: timedelta, *files: PinnedFile) -> str:
        content = f"{self.lab} {name}".encode()
        file = PinnedFile("study.yaml", self.storage.blobs.put(content), len(content))
        with self.storage.transaction() as store:
            study, _ = store.studies.add(name, [file, *files], {})
        with self.storage.transaction() as store:
            store.session.execute(sa.update(Study).where(Study.id == study.id).values(created_at=utc_now() - age))
        return study.id

    def job(self, study: str, state: str, age: timedelta) -> str:
        ended = None if state in ("queued", "running") else utc_now() - age
        row = Job(
            kind="evaluate", study_id=study, request_hash=f"{study}{state}{age}".encode().hex()[:64], state=state,
            finished_at=ended, reason="because", log="words", steps=[{"message": "reading"}],
            created_at=utc_now() - age,
        )  # fmt: skip
        self._put(row)
        return row.id

    def publication(self, study: str, *, revoked: bool) -> None:
        row = Publication(
            key=study[:16], series_id=study, version=1, study_id=study, job_id=study, content_hash="0" * 64,
            manifest=[], about={}, lab_name=self.lab,
        )  # fmt: skip
        self._put(row)
        if revoked:
            with self.storage.transaction() as store:
                store.session.execute(sa.update(Publication).values(revoked_at=utc_now()))

    def deliveries(self) -> None:
        hook = Webhook(url="https://a.example", events=[], secret="")
        self._put(hook)
        for state, ended in (("delivered", OLD), ("failed", YOUNG), ("waiting", None)):
            at = None if ended is None else utc_now() - ended
            due = {"due_at": utc_now(), "attempts": 1, "data": {}, "event": "ping"}
            self._put(Delivery(webhook_id=hook.id, state=state, ended_at=at, created_at=utc_now() - 2 * OLD, **due))

    def names(self, table: Any) -> set[str]:
        with self.storage.reading() as store:
            return {row.name for row in store.session.scalars(store.lab.select(table))}

    def said(self) -> list[tuple[str, str, str]]:
        with self.storage.reading() as store:
            mine = store.lab.select(AuditEntry).where(AuditEntry.actor == "housekeeping")
            return sorted((row.action, row.subject_kind, row.said) for row in store.session.scalars(mine))


def fill(of: Of) -> dict[str, str]:
    of.log("unused old", OLD)
    of.log("unused young", YOUNG)
    used = of.log("used", OLD)
    ids = {name: of.study(name, OLD, used) for name in ("old", "busy", "lately", "published", "revoked", "planned")}
    ids["young"] = of.study("young", YOUNG)
    of.publication(ids["revoked"], revoked=True)
    of.publication(ids["published"], revoked=False)
    ids |= {f"{name} job": of.job(ids[name], "succeeded", OLD) for name in ("old", "published")}
    ids["running job"] = of.job(ids["busy"], "running", OLD)
    ids["young job"] = of.job(ids["lately"], "failed", YOUNG)
    with of.storage.transaction() as store:
        blob = store.blobs.put(b"name: r\n")
        robot, _ = store.robots.add("r", [PinnedFile("robot.yaml", blob, 8)], {})
    of._put(Plan(name="p", content_hash="0" * 64, summary={}, robot_id=robot.id, study_id=ids["planned"]))
    of.deliveries()
    of._put(IdempotencyKey(key="old", owner=ids["old"], expires_at=utc_now() - DAY))
    of._put(IdempotencyKey(key="new", owner=ids["old"], expires_at=utc_now() + DAY))
    return ids


def jobs_with_words(of: Of) -> set[str]:
    with of.storage.reading() as store:
        return {row.id for row in store.session.scalars(store.lab.select(Job)) if row.log or row.steps is not None}


def counts(installation: Installation) -> dict[str, int]:
    with installation.reading() as session:
        return {
            table.__tablename__: session.scalar(sa.select(sa.func.count(table.id))) or 0
            for table in (Log, Study, Job, Delivery, IdempotencyKey, Publication)
        }


def test_only_what_is_older_than_was_said_goes_and_only_studies_of_labs_that_are_named(
    installation: Installation, settings: Settings
) -> None:
    local, north = (Of(installation, lab) for lab in LABS)
    ids = {of.lab: fill(of) for of in (local, north)}
    before = counts(installation)
    ages = Ages.of(settings.model_copy(update=TEN | {"studies_kept_days": {"north": 10.0}}))

    words = [jobs_with_words(of) for of in (local, north)]
    dry = retire(installation, ages, dry=True)
    assert (counts(installation), local.said(), north.said()) == (before, [], [])
    assert words == [jobs_with_words(of) for of in (local, north)]
    done = retire(installation, ages)
    assert dry == done == Retired(logs=2, job_logs=4, deliveries=2, keys=2, studies=2, studies_needed=1)
    for of in (local, north):
        assert of.names(Log) == {"unused young", "used"}
        assert {ids[of.lab][key] for key in ("running job", "young job")} == jobs_with_words(of)
    kept = {"old", "busy", "lately", "published", "revoked", "planned", "young"}
    assert (local.names(Study), north.names(Study)) == (kept, kept - {"old", "revoked"})
    with local.storage.reading() as store:
        ended = store.jobs.get(ids["local"]["old job"])
        assert (ended.state, ended.reason, ended.log, ended.steps, ended.revision) == (
            "succeeded", "because", "", None, 0,
        )  # fmt: skip
    after = counts(installation)
    gone = {name: before[name] - after[name] for name in before}
    assert gone == {
        "logs": 2, "studies": 2, "jobs": 1, "deliveries": 2, "idempotency_keys": 2, "publications": 0,
    }  # fmt: skip
    told = [("delete", "log", ""), ("forget", "lab", "logs of 2 ended jobs")]
    assert local.said() == told
    assert north.said() == [told[0], *[("delete", "study", "")] * 2, told[1]]
    assert retire(installation, ages) == Retired(studies_needed=1)
    sweep_installation(installation, timedelta(0))
    with installation.of_lab("local").reading() as store:
        assert all(store.blobs.exists(file.sha256) for file in store.studies.files(ids["local"]["old"]))


def test_by_default_all_that_users_handed_in_and_see_stays_however_old(
    installation: Installation, settings: Settings
) -> None:
    of = Of(installation, "local")
    fill(of)
    with of.storage.transaction() as store:
        for table in (Log, Study, Job):
            store.session.execute(sa.update(table).values(created_at=utc_now() - 5000 * DAY))
        store.session.execute(sa.update(Job).where(Job.state == "succeeded").values(finished_at=utc_now() - 5000 * DAY))
        store.session.execute(
            sa.update(Delivery).where(Delivery.state != "waiting").values(ended_at=utc_now() - 31 * DAY)
        )
    assert retire(installation, Ages.of(settings)) == Retired(deliveries=2, keys=1)


def test_the_service_does_it_by_itself_and_once_for_all_servers(installation: Installation, settings: Settings) -> None:
    of = Of(installation, "local")
    of.log("unused old", OLD)
    told = settings.model_copy(update=TEN | {"studies_kept_days": {}})
    one, other = Housekeeping(installation, told), Housekeeping(installation, told)
    for each in (one, other):
        each._chore(AGED, each._retire)
    assert of.names(Log) == set()
    with installation.reading() as session:
        (chore,) = session.execute(sa.text("SELECT outcome FROM chores WHERE name = 'what is old'")).scalars()
    outcome = json.loads(chore) if isinstance(chore, str) else chore
    assert outcome["logs"] == 1  # of the first; the second found it done, and not due


@pytest.mark.slow
def test_the_command_says_what_would_go_and_then_lets_it_go(installation: Installation, settings: Settings) -> None:
    of = Of(installation, "north")
    of.study("old", OLD)
    said = {name.upper(): json.dumps(value) for name, value in TEN.items()}
    environment = {
        **os.environ,
        "EXOGAUGE_DATA_DIR": str(settings.data_dir),
        "EXOGAUGE_DATABASE_URL": settings.database_url,
        **{f"EXOGAUGE_{name}": value for name, value in said.items()},
    }
    found = []
    for options in (["--dry-run"], [], ["--dry-run"]):
        command = [sys.executable, "-m", "exogauge.cli", "gc", "--json", *options]
        told = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60, check=True).stdout
        found.append((json.loads(told)["aged"]["studies"], len(of.names(Study))))
    assert found == [(1, 1), (1, 0), (0, 0)]


@pytest.mark.parametrize("said", ['{"north": 0}', '{"north": -1}', '["north"]', "30"])
def test_an_age_of_studies_is_said_by_lab_and_never_none(said: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A lab's studies are not to go because somebody meant "never" by a zero."""
    monkeypatch.setenv("EXOGAUGE_STUDIES_KEPT_DAYS", said)
    with pytest.raises(ValidationError, match="studies_kept_days"):
        Settings()
