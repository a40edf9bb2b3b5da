"""What a lab has is its own: no query sees another's, and nothing is written into another's."""

from __future__ import annotations

from datetime import timedelta
from pathlib import Path

import pytest
import sqlalchemy as sa
from sqlalchemy.orm import aliased

from exogauge.errors import NotFound
from exogauge.storage import bundles, jobs, records, rows
from exogauge.storage.files import PinnedFile
from exogauge.storage.scope import OF_ALL_LABS
from exogauge.storage.store import Installation, Storage
from exogauge.storage.tables import OWNERS, Artifact, AuditEntry, Job, Study, StudyFile
from exogauge.storage.uploads import take_expired


@pytest.fixture
def installation(storage: Storage) -> Installation:
    return Installation(storage.engine, storage.blobs)


@pytest.fixture
def studies(installation: Installation) -> dict[str, str]:
    """lab -> the id of a study that it has; both labs handed in the same bytes."""
    file = PinnedFile("study.yaml", installation.blobs.put(b"version: 1"), 10)
    made = {}
    for lab in ("north", "south"):
        with installation.of_lab(lab).transaction() as store:
            made[lab] = store.studies.add("s", [file], {})[0].id
            store.session.add(Job(kind="evaluate", study_id=made[lab], request_hash="h"))
    return made


def test_a_query_that_forgets_the_lab_sees_its_own_lab_alone(
    installation: Installation, studies: dict[str, str]
) -> None:
    other = aliased(Study)
    of_files = sa.select(StudyFile.study_id)
    with installation.of_lab("north").reading() as store:
        look = store.session
        assert look.scalars(sa.select(Study.id)).all() == [studies["north"]]
        assert [row.id for row in look.scalars(sa.select(Study))] == [studies["north"]]
        assert look.scalar(sa.select(sa.func.count()).select_from(Job)) == 1
        assert look.scalars(sa.select(other.id)).all() == [studies["north"]]
        assert look.scalars(sa.select(Study.id).join(Job, Job.kind == "evaluate")).all() == [studies["north"]]
        assert look.scalars(sa.select(Job.id).where(Job.study_id.in_(sa.select(Study.id)))).all()
        assert look.scalars(of_files.union_all(of_files)).all() == [studies["north"]] * 2
        assert sorted(look.scalars(sa.select(Study.id), execution_options=OF_ALL_LABS)) == sorted(studies.values())


def test_a_statement_that_is_made_once_sees_the_lab_that_asks(
    installation: Installation, studies: dict[str, str]
) -> None:
    """Each in turn, by the very same statements, also for what the other has."""
    theirs = dict[str, str]()
    for lab in studies:
        with installation.of_lab(lab).transaction() as store:
            (theirs[lab],) = (job.id for job in store.jobs.page(None, 9).items)
            sha256 = store.blobs.put(lab.encode())
            store.session.add(Artifact(job_id=theirs[lab], name="a", sha256=sha256, size=5, media_type="text/plain"))
    for lab, other in (("north", "south"), ("south", "north"), ("north", "south")):
        with installation.of_lab(lab).reading() as store:
            assert [study.id for study in store.studies.page(None, 9).items] == [studies[lab]]
            assert [job.id for job in store.jobs.page(None, 9, state="queued").items] == [theirs[lab]]
            assert [study.id for study in store.studies.page(None, 9, state="queued").items] == [studies[lab]]
            latest = store.jobs.latest("study", list(studies.values()))
            assert {study: job.id for study, job in latest.items()} == {studies[lab]: theirs[lab]}
            assert [len(store.studies.files(studies[each])) for each in (lab, other)] == [1, 0]
            assert [file.job_id for file in store.results.artifacts(theirs[lab])] == [theirs[lab]]
            for ask, key in (
                (store.studies.get, studies[other]),
                (store.jobs.get, theirs[other]),
                (store.results.artifacts, theirs[other]),
            ):
                with pytest.raises(NotFound):
                    ask(key)


def test_every_statement_that_is_made_once_names_its_lab() -> None:
    made = [rows.newest(records.ListedJobRecord, Job, goes_on) for goes_on in (False, True)]
    made += [rows.by_id(records.JobRecord, Job), jobs.artifacts_of(), bundles.files_of(StudyFile, "study_id")]
    made += [jobs.latest_of(noun) for noun in OWNERS]
    assert all("lab" in statement.compile().params for statement in made)


def test_a_change_that_forgets_the_lab_changes_its_own_lab_alone(
    installation: Installation, studies: dict[str, str]
) -> None:
    with installation.of_lab("north").transaction() as store:
        store.session.execute(sa.update(Job).values(message="north was here"))
        store.session.execute(sa.update(Study).where(Study.id == studies["south"]).values(name="taken"))
        store.session.execute(sa.delete(StudyFile))
    with installation.of_lab("south").reading() as store:
        assert store.jobs.page(None, 9).items[0].message == ""
        assert store.studies.get(studies["south"]).name == "s"
        assert [file.path for file in store.studies.files(studies["south"])] == ["study.yaml"]
    with installation.of_lab("north").reading() as store:
        assert store.jobs.page(None, 9).items[0].message == "north was here"
        assert store.studies.files(studies["north"]) == ()


def test_a_row_is_added_to_its_own_lab_or_not_at_all(installation: Installation, studies: dict[str, str]) -> None:
    with installation.of_lab("north").transaction() as store:
        store.session.add(Study(name="unsaid", content_hash="c", summary={}))
    with installation.session() as session:
        assert session.scalar(sa.select(Study.lab_id).where(Study.name == "unsaid")) == "north"
    other = pytest.raises(ValueError, match="'south' in a session of lab 'north'")
    with other, installation.of_lab("north").transaction() as store:
        store.session.add(Study(lab_id="south", name="t", content_hash="c", summary={}))


def test_a_row_without_a_lab_is_refused(installation: Installation) -> None:
    with pytest.raises(sa.exc.IntegrityError), installation.session() as session:
        session.add(Study(name="s", content_hash="c", summary={}))


def test_the_same_content_is_each_lab_s_own_and_so_is_what_is_said_of_it(
    installation: Installation, studies: dict[str, str], tmp_path: Path
) -> None:
    assert studies["north"] != studies["south"]
    with installation.of_lab("south").reading() as store:
        assert set(store.session.scalars(sa.select(AuditEntry.subject_id))) == {studies["south"]}
        with pytest.raises(NotFound):
            store.studies.write_to(studies["north"], tmp_path)


def test_uploads_whose_time_has_run_out_are_forgotten_in_every_lab(installation: Installation) -> None:
    hour = timedelta(hours=1)
    for lab, late in (("north", hour), ("south", hour), ("west", -hour)):
        with installation.of_lab(lab).transaction() as store:
            store.uploads.add(f"of {lab}", "log.csv", 3, -late)
    with installation.session() as session:
        assert sorted(take_expired(session)) == ["of north", "of south"]
    with installation.session() as session:
        assert take_expired(session) == []
