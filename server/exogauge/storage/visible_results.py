"""Results of all studies that a lab may see: its own, those that others share with it, those that were published."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from typing import Literal, final

import sqlalchemy as sa
from sqlalchemy.orm import Session

from exogauge.storage.account_tables import LabRow, Share
from exogauge.storage.callers import is_open
from exogauge.storage.jobs import RESULTS
from exogauge.storage.tables import Artifact, Job, Publication, PublicationFile, Study

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
