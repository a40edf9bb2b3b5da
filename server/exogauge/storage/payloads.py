"""Payloads: payload.yaml, its URDF and logs, versioned by name and pinned by content."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any, final

import sqlalchemy as sa

from exogauge.storage import tables
from exogauge.storage.blobs import BlobStore, copy_out
from exogauge.storage.files import PinnedFile, content_hash, file_at
from exogauge.storage.records import Page, PayloadRecord
from exogauge.storage.rows import Lab
from exogauge.storage.search import found_by, words_of


@final
@dataclass(frozen=True)
class Payloads:
    lab: Lab
    blobs: BlobStore

    def add(self, name: str, files: Sequence[PinnedFile], summary: Mapping[str, Any]) -> tuple[PayloadRecord, bool]:
        """The payload with this name and content, and whether it is new; other content makes a new version."""
        table, pinned = tables.Payload, content_hash(files)
        same = self.lab.select(table).where(table.name == name, table.content_hash == pinned)

        def make() -> list[tables.Base]:
            key = tables.new_id()
            payload = table(
                id=key, lab_id=self.lab.lab_id, name=name, version=self._newest_version(name) + 1,
                content_hash=pinned, summary=dict(summary), words=words_of(name, summary),
            )  # fmt: skip
            return [payload, *(self._file(key, file) for file in files)]

        payload, new = self.lab.find_or_add(lambda: self.lab.one(PayloadRecord, same), make, "payload")
        if new:
            self.lab.audit("add", "payload", payload.id, after=pinned)
        return payload, new

    def get(self, key: str) -> PayloadRecord:
        return self.lab.get(PayloadRecord, tables.Payload, key, "payload")

    def page(
        self, after: tuple[datetime, str] | None, limit: int, *, search: str = "", name: str | None = None
    ) -> Page[PayloadRecord]:
        """search: words that all are found; name: all versions of one payload, where given."""
        query = self.lab.select(tables.Payload).where(found_by(tables.Payload, search))
        if name is not None:
            query = query.where(tables.Payload.name == name)
        return self.lab.page(PayloadRecord, tables.Payload, query, after, limit)

    def files(self, key: str) -> tuple[PinnedFile, ...]:
        """Sorted by path."""
        query = self.lab.select(tables.PayloadFile).where(tables.PayloadFile.payload_id == key)
        rows = self.lab.session.scalars(query.order_by(tables.PayloadFile.path))
        return tuple(PinnedFile(row.path, row.sha256, row.size) for row in rows)

    def file(self, key: str, path: str) -> PinnedFile:
        self.get(key)
        return file_at(self.files(key), path, f"payload {key}")

    def write_to(self, key: str, folder: Path) -> PayloadRecord:
        """Lay the payload's files out below `folder`, as they were handed in."""
        payload = self.get(key)
        for file in self.files(key):
            copy_out(self.blobs, file.sha256, folder / file.path)
        return payload

    def _newest_version(self, name: str) -> int:
        table = tables.Payload
        mine = sa.select(sa.func.max(table.version)).where(table.lab_id == self.lab.lab_id, table.name == name)
        return self.lab.session.scalar(mine) or 0

    def _file(self, payload_id: str, file: PinnedFile) -> tables.PayloadFile:
        return tables.PayloadFile(
            lab_id=self.lab.lab_id, payload_id=payload_id, path=file.path, sha256=file.sha256, size=file.size
        )
