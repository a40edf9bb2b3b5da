"""Snapshots of what jobs found, which anybody may read: as their lab has them, and as everybody sees them.

A snapshot names its files itself, so it outlives its study. Revoked, its rows of files go, and with them, in time, what
nothing else needs of them; what it was, with the hash of every file, stays for whoever cites it.
"""

from __future__ import annotations

import json
import secrets
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import datetime
from typing import Any, final

import sqlalchemy as sa
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from exogauge.errors import Conflict, Gone, NotFound
from exogauge.storage.account_tables import LabRow
from exogauge.storage.files import PinnedFile, content_hash
from exogauge.storage.records import Page, PublicationRecord, PublishedFile
from exogauge.storage.rows import Lab, as_record
from exogauge.storage.tables import Publication, PublicationFile, Study, new_id, utc_now

LETTERS = "0123456789abcdefghjkmnpqrstvwxyz"  # of base 32 as Crockford wrote it down: none looks like another
NEWEST_FIRST = Publication.created_at.desc(), Publication.id.desc()
KEY = 10  # letters: 50 bits, so that no two are alike


@final
@dataclass(frozen=True)
class Publications:
    lab: Lab

    def get(self, key: str) -> PublicationRecord:
        return self.lab.get(PublicationRecord, Publication, key, "publication")

    def page(
        self, after: tuple[datetime, str] | None, limit: int, study_id: str | None = None
    ) -> Page[PublicationRecord]:
        wanted = () if study_id is None else (Publication.study_id == study_id,)
        return self.lab.page(PublicationRecord, Publication, after, limit, *wanted)

    def standing(
        self,
        study_id: str,
        job_id: str,
        files: Sequence[PublishedFile],
        about: Mapping[str, Any],
        follows: str | None = None,
    ) -> PublicationRecord | None:
        """The newest that says the same and was not revoked: these files of this job, about them the same; follows: as
        a later version of that one, else as a first. Until the transaction ends nobody else publishes of the study."""
        mine = Study.lab_id == self.lab.lab_id, Study.id == study_id
        self.lab.session.execute(sa.select(Study.id).where(*mine).with_for_update())
        same = (
            Publication.study_id == study_id,
            Publication.job_id == job_id,
            Publication.content_hash == hash_of(files),
            Publication.revoked_at.is_(None),
            Publication.version == 1
            if follows is None
            else sa.and_(Publication.series_id == self.get(follows).series_id, Publication.version > 1),
        )
        said = json.loads(json.dumps(dict(about)))  # as a row keeps it
        rows = self.lab.session.scalars(self.lab.select(Publication).where(*same).order_by(*NEWEST_FIRST))
        return next((as_record(PublicationRecord, row) for row in rows if row.about == said), None)

    def add(
        self,
        study_id: str,
        job_id: str,
        files: Sequence[PublishedFile],
        about: Mapping[str, Any],
        follows: str | None = None,
    ) -> PublicationRecord:
        """follows: id of an earlier publication, of which it is the next version."""
        key, series, version = new_id(), None, 1
        if follows is not None:
            series = self.get(follows).series_id
            newest = sa.select(sa.func.max(Publication.version)).where(Publication.series_id == series)
            version = (self.lab.session.scalar(newest) or 0) + 1
        files = sorted(files, key=lambda file: file.path)
        row = Publication(
            id=key, lab_id=self.lab.lab_id, key="".join(secrets.choice(LETTERS) for _ in range(KEY)),
            series_id=series or key, version=version, study_id=study_id, job_id=job_id,
            content_hash=hash_of(files),
            manifest=[asdict(file) for file in files], about=dict(about), lab_name=self._lab_name(),
        )  # fmt: skip
        try:
            with self.lab.session.begin_nested():
                self.lab.session.add(row)
                self.lab.session.flush()
        except IntegrityError:
            raise Conflict("another version is being published; try again") from None
        self.lab.session.add_all(
            PublicationFile(lab_id=self.lab.lab_id, publication_id=key, **asdict(file)) for file in files
        )
        said = f"{about.get('title', '')}, version {version}, as {row.key}"
        self.lab.audit("publish", "publication", key, after=row.content_hash, said=said)
        return as_record(PublicationRecord, row)

    def revoke(self, key: str, because: str) -> PublicationRecord:
        """Its files go, at once; the rest stays. Revoked again it stays as it is."""
        found = self.get(key)
        if found.revoked_at is not None:
            return found
        mine = Publication.lab_id == self.lab.lab_id, Publication.id == key, Publication.revoked_at.is_(None)
        done = self.lab.session.execute(
            sa.update(Publication).where(*mine).values(revoked_at=utc_now(), revoked_because=because)
        )
        if getattr(done, "rowcount", 0):
            files = PublicationFile.lab_id == self.lab.lab_id, PublicationFile.publication_id == key
            self.lab.session.execute(sa.delete(PublicationFile).where(*files))
            said = f"{found.key}: {because}"
            self.lab.audit("revoke", "publication", key, before=found.content_hash, said=said)
        return self.get(key)

    def _lab_name(self) -> str:
        named = sa.select(LabRow.name).where(LabRow.id == self.lab.lab_id)
        return self.lab.session.scalar(named) or self.lab.lab_id


def hash_of(files: Sequence[PublishedFile]) -> str:
    """Over their paths and hashes."""
    return content_hash(PinnedFile(file.path, file.sha256, file.size) for file in files)


def published(session: Session, key: str) -> PublicationRecord:
    """By the key of its address, of whichever lab. In a session of all labs, as the next two."""
    row = session.scalars(sa.select(Publication).where(Publication.key == key)).first()
    if row is None:
        raise NotFound(f"nothing is published as {key[:64]!a}")
    return as_record(PublicationRecord, row)


def versions_of(session: Session, series_id: str) -> list[PublicationRecord]:
    """Oldest first."""
    query = sa.select(Publication).where(Publication.series_id == series_id).order_by(Publication.version)
    return [as_record(PublicationRecord, row) for row in session.scalars(query)]


def published_file(session: Session, key: str, path: str) -> PublishedFile:
    """Gone where the publication was revoked."""
    found = published(session, key)
    if found.revoked_at is not None:
        raise Gone(f"what was published as {key!a} was revoked; its record says why")
    query = sa.select(PublicationFile).where(PublicationFile.publication_id == found.id, PublicationFile.path == path)
    row = session.scalars(query).first()
    if row is None:
        raise NotFound(f"the publication {key!a} has no file of this path")
    return as_record(PublishedFile, row)
