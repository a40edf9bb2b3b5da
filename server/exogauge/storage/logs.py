"""Logs: uploaded files, byte for byte, with the mapping they are read with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any, final

import sqlalchemy as sa

from exogauge.storage import tables
from exogauge.storage.files import PinnedFile, content_hash
from exogauge.storage.records import LogRecord, Page
from exogauge.storage.rows import Lab


@final
@dataclass(frozen=True)
class Logs:
    lab: Lab

    def add(self, file: PinnedFile, mapping: PinnedFile | None, summary: Mapping[str, Any]) -> tuple[LogRecord, bool]:
        """The log with this name, these bytes and this mapping, and whether it is new."""
        pinned = content_hash([file] if mapping is None else [file, mapping])
        same = self.lab.select(tables.Log).where(tables.Log.name == file.path, tables.Log.content_hash == pinned)

        def make() -> list[tables.Base]:
            return [
                tables.Log(
                    lab_id=self.lab.lab_id, name=file.path, content_hash=pinned, sha256=file.sha256, size=file.size,
                    mapping_sha256=None if mapping is None else mapping.sha256, summary=dict(summary),
                )
            ]  # fmt: skip

        log, new = self.lab.find_or_add(lambda: self.lab.one(LogRecord, same), make, "log")
        if new:
            self.lab.audit("add", "log", log.id, after=pinned)
        return log, new

    def get(self, key: str) -> LogRecord:
        return self.lab.get(LogRecord, tables.Log, key, "log")

    def delete(self, key: str) -> None:
        """Studies that were put together with it keep their own file."""
        found = self.get(key)
        mine = tables.Log.lab_id == self.lab.lab_id, tables.Log.id == key
        self.lab.session.execute(sa.delete(tables.Log).where(*mine), execution_options={"synchronize_session": False})
        self.lab.audit("delete", "log", key, before=found.content_hash)

    def page(self, after: tuple[datetime, str] | None, limit: int) -> Page[LogRecord]:
        return self.lab.page(LogRecord, tables.Log, after, limit)
