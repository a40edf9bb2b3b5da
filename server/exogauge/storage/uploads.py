"""Resumable uploads: what will arrive, and until when it is waited for. The bytes are `partial_files`' business."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import timedelta
from typing import final

import sqlalchemy as sa
from sqlalchemy.orm import Session

from exogauge.errors import NotFound
from exogauge.storage import tables
from exogauge.storage.database import database_now
from exogauge.storage.records import UploadRecord
from exogauge.storage.rows import Lab, as_record
from exogauge.storage.tables import Upload


@final
@dataclass(frozen=True)
class Uploads:
    lab: Lab

    def add(self, key: str, name: str, size: int, kept: timedelta) -> UploadRecord:
        """kept: how long it is waited for, on the database's clock, which all servers share."""
        expires_at = database_now(self.lab.session) + kept
        row = Upload(id=key, lab_id=self.lab.lab_id, name=name, size=size, expires_at=expires_at)
        self.lab.session.add(row)
        self.lab.session.flush()
        return as_record(UploadRecord, row)

    def get(self, key: str) -> UploadRecord:
        """NotFound for one whose time has run out, too."""
        found = self.lab.get(UploadRecord, Upload, key, "upload")
        if found.expires_at <= database_now(self.lab.session):
            raise NotFound(f"upload {key} was given up at {found.expires_at:%Y-%m-%d %H:%M} UTC; begin it again")
        return found

    def wait_longer(self, key: str, kept: timedelta) -> bool:
        """From now on; False where it is gone."""
        expires_at = database_now(self.lab.session) + kept
        done = self.lab.session.execute(sa.update(Upload).where(*self._mine(key)).values(expires_at=expires_at))
        return bool(getattr(done, "rowcount", 0))

    def delete(self, key: str) -> None:
        self.lab.session.execute(sa.delete(Upload).where(*self._mine(key)))

    def _mine(self, key: str) -> tuple[sa.ColumnElement[bool], ...]:
        return tables.Upload.lab_id == self.lab.lab_id, tables.Upload.id == key


def take_expired(session: Session) -> list[str]:
    """Forget those whose time has run out, of all labs, and return their ids."""
    gone = sa.delete(Upload).where(Upload.expires_at <= database_now(session)).returning(Upload.id)
    return list(session.scalars(gone, execution_options={"synchronize_session": False}))
