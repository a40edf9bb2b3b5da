"""Studies that other labs may read: of the lab that shares, and seen from the lab that may read;
and the results of all that a lab may see: its own, what others share with it, what was published.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Literal, final

import sqlalchemy as sa
from sqlalchemy.engine import Connection
from sqlalchemy.orm import Session

from exogauge.errors import NotFound
from exogauge.storage.account_tables import LabRow, Share
from exogauge.storage.callers import is_open
from exogauge.storage.jobs import RESULTS
from exogauge.storage.records import Page, SharedStudy, ShareRecord, StudyRecord
from exogauge.storage.rows import Lab
from exogauge.storage.tables import Artifact, Job, Publication, PublicationFile, Study


@final
@dataclass(frozen=True)
class Shares:
    """What the lab shares."""

    lab: Lab

    def of(self, study_id: str) -> list[ShareRecord]:
        """Oldest first."""
        self._study(study_id)
        query = sa.select(Share.id, Share.created_at, Share.to_lab, LabRow.name)
        query = query.outerjoin(LabRow, LabRow.id == Share.to_lab)
        query = query.where(Share.lab_id == self.lab.lab_id, Share.study_id == study_id)
        rows = self.lab.session.execute(query.order_by(Share.created_at, Share.id))
        return [ShareRecord(*row) for row in rows]

    def add(self, study_id: str, lab_name: str | None) -> ShareRecord:
        """None: with every lab. The same again is the same. NotFound where there is no such lab, or it is one's own."""
        alone = self.lab.select(Study).where(Study.id == study_id).with_for_update()  # nobody else shares or deletes it
        self.lab.session.execute(alone)
        study, to_lab = self._study(study_id), None
        if lab_name is not None:
            find = sa.select(LabRow.id).where(LabRow.name == lab_name, LabRow.id != self.lab.lab_id)
            to_lab = self.lab.session.scalar(find)
            if to_lab is None:
                raise NotFound(f"there is no other lab {lab_name!a}")
        found = next((each for each in self.of(study_id) if each.to_lab == to_lab), None)
        if found is not None:
            return found
        row = Share(lab_id=self.lab.lab_id, study_id=study_id, to_lab=to_lab)
        self.lab.session.add(row)
        self.lab.session.flush()
        self.lab.audit("share", "study", study_id, after=study.content_hash, said=f"with {lab_name or 'every lab'}")
        return next(each for each in self.of(study_id) if each.id == row.id)

    def end(self, study_id: str, key: str) -> None:
        found = next((each for each in self.of(study_id) if each.id == key), None)
        if found is None:
            raise NotFound(f"there is no share {key!a}")
        self.lab.session.execute(sa.delete(Share).where(Share.lab_id == self.lab.lab_id, Share.id == key))
        self.lab.audit("end share", "study", study_id, said=f"with {found.lab or 'every lab'}")

    def _study(self, key: str) -> StudyRecord:
        return self.lab.get(StudyRecord, Study, key, "study")


_share, _job = Share.__table__.c, Job.__table__.c
_key, _reader = sa.bindparam("key", type_=sa.String()), sa.bindparam("reader", type_=sa.String())


def _host(study: Any) -> sa.Select[Any]:
    """Whose study it is, where that lab lets the reader's read it."""
    let_in = sa.or_(_share.to_lab == _reader, _share.to_lab.is_(None))
    mine = _share.study_id == study, _share.lab_id != _reader
    return sa.select(_share.lab_id).where(*mine, let_in, is_open(_share.lab_id)).limit(1)


HOST = {"studies": _host(_key), "jobs": _host(sa.select(_job.study_id).where(_job.id == _key).scalar_subquery())}


def host_of(connection: Connection, lab_id: str, thing: str, key: str) -> str | None:
    """Whose study, or job of a study, this is, where that lab lets this one read it. thing: studies or jobs. Of
    all labs."""
    found: str | None = connection.scalar(HOST[thing], {"key": key, "reader": lab_id})
    return found


def shared_with(session: Session, lab_id: str, after: tuple[datetime, str] | None, limit: int) -> Page[SharedStudy]:
    """What other labs let this one read, newest first. In a session of all labs."""
    since = sa.func.max(Share.created_at)
    query = sa.select(Study.id, Study.name, LabRow.name, since)
    query = query.join(Share, Share.study_id == Study.id).join(LabRow, LabRow.id == Share.lab_id)
    query = query.where(
        Share.lab_id != lab_id, sa.or_(Share.to_lab == lab_id, Share.to_lab.is_(None)), is_open(Share.lab_id)
    )
    query = query.group_by(Study.id, Study.name, LabRow.name).order_by(since.desc(), Study.id.desc())
    if after is not None:
        query = query.having(sa.or_(since < after[0], sa.and_(since == after[0], Study.id < after[1])))
    found = [SharedStudy(*row) for row in session.execute(query.limit(limit + 1))]
    shown = tuple(found[:limit])
    return Page(shown, (shown[-1].since, shown[-1].study_id) if len(found) > limit else None)


Seen = Literal["own", "shared", "published"]


@final
@dataclass(frozen=True)
class VisibleResult:
    """lab: the name of whose it is. study_id: where one may open the study; published: key of a publication of it.
    sha256: of results.json."""

    lab_id: str
    lab: str
    seen: Seen
    study_id: str | None
    job_id: str | None
    published: str | None
    at: datetime
    sha256: str


def visible_results(session: Session, lab_id: str, most: int) -> list[VisibleResult]:
    """Of each study and each series of publications the newest, newest first, at most so many of each sort. A
    publication of what one sees anyway is told with that. In a session of all labs."""
    public = {(row.lab_id, row.sha256): row for row in _published(session, most)}
    found = [
        VisibleResult(
            row.lab_id, row.lab or row.lab_id, "own" if row.lab_id == lab_id else "shared", row.study_id, row.id,
            getattr(public.pop((row.lab_id, row.sha256), None), "key", None), row.created_at, row.sha256,
        )
        for row in _of_studies(session, lab_id, most)
    ]  # fmt: skip
    found += [
        VisibleResult(row.lab_id, row.lab, "published", None, None, row.key, row.created_at, row.sha256)
        for row in public.values()
    ]
    return sorted(found, key=lambda each: each.at, reverse=True)


def _of_studies(session: Session, lab_id: str, most: int) -> Iterator[sa.Row[tuple[str, ...]]]:
    let_in = sa.select(Share.study_id).where(
        sa.or_(Share.to_lab == lab_id, Share.to_lab.is_(None)), is_open(Share.lab_id)
    )
    mine = sa.or_(Job.lab_id == lab_id, Job.study_id.in_(let_in))
    newest = sa.func.row_number().over(partition_by=Job.study_id, order_by=(Job.created_at.desc(), Job.id.desc()))
    columns = (Job.id, Job.lab_id, Job.study_id, Job.created_at, Artifact.sha256, LabRow.name.label("lab"))
    query = sa.select(*columns, newest.label("rank")).join(Artifact, Artifact.job_id == Job.id)
    query = query.join(Study, Study.id == Job.study_id).outerjoin(LabRow, LabRow.id == Job.lab_id)
    query = query.where(mine, Job.state == "succeeded", Artifact.name == RESULTS)
    ranked = query.subquery()
    chosen = sa.select(ranked).where(ranked.c.rank == 1).order_by(ranked.c.created_at.desc()).limit(most)
    yield from session.execute(chosen)


def _published(session: Session, most: int) -> Iterator[sa.Row[tuple[str, ...]]]:
    newest = sa.func.row_number().over(partition_by=Publication.series_id, order_by=Publication.version.desc())
    columns = (
        Publication.lab_id, Publication.key, Publication.created_at, Publication.lab_name.label("lab"),
        PublicationFile.sha256, newest.label("rank"),
    )  # fmt: skip
    query = sa.select(*columns).join(PublicationFile, PublicationFile.publication_id == Publication.id)
    query = query.where(Publication.revoked_at.is_(None), PublicationFile.path == f"results/{RESULTS}")
    ranked = query.subquery()
    chosen = sa.select(ranked).where(ranked.c.rank == 1).order_by(ranked.c.created_at.desc()).limit(most)
    yield from session.execute(chosen)
