"""Live streams of a payload's sensor: what arrived, and where the raw stream is. An ended one never changes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import datetime
from typing import Any, Literal, cast, final

import sqlalchemy as sa
from sqlalchemy.orm import Session

from exogauge.storage import tables
from exogauge.storage.database import database_now
from exogauge.storage.records import LiveStreamRecord, Page, PayloadRecord
from exogauge.storage.rows import Lab, as_record
from exogauge.storage.scope import spare_blobs
from exogauge.storage.tables import LiveStream


@final
@dataclass(frozen=True)
class Counts:
    """samples: taken; dropped: refused or never arrived; late: taken, behind their time. last_sequence: number of the
    last one taken."""

    samples: int = 0
    dropped: int = 0
    late: int = 0
    last_sequence: int | None = None


@final
@dataclass(frozen=True)
class LiveStreams:
    lab: Lab

    def begin(
        self, payload_id: str, job_id: str | None = None, summary: Mapping[str, Any] | None = None
    ) -> LiveStreamRecord:
        """job_id: whose results compensate it. summary: what the sender said of itself."""
        self.lab.get(PayloadRecord, tables.Payload, payload_id, "payload")
        row = LiveStream(
            lab_id=self.lab.lab_id, payload_id=payload_id, job_id=job_id, summary=dict(summary or {}),
            started_at=database_now(self.lab.session),
        )  # fmt: skip
        self.lab.session.add(row)
        self.lab.session.flush()
        self.lab.audit("begin", "live_stream", row.id)
        return as_record(LiveStreamRecord, row)

    def get(self, key: str) -> LiveStreamRecord:
        return self.lab.get(LiveStreamRecord, LiveStream, key, "live stream")

    def page(
        self, after: tuple[datetime, str] | None, limit: int, *, payload_id: str | None = None
    ) -> Page[LiveStreamRecord]:
        wanted = () if payload_id is None else (LiveStream.payload_id == payload_id,)
        return self.lab.page(LiveStreamRecord, LiveStream, after, limit, *wanted)

    def count(self, key: str, counts: Counts) -> bool:
        """Say how far an open stream is; False where it is open no more."""
        return self._change(key, asdict(counts))

    def end(
        self,
        key: str,
        counts: Counts,
        state: Literal["ended", "lost"] = "ended",
        raw: tuple[str, int] | None = None,
        summary: Mapping[str, Any] | None = None,
    ) -> bool:
        """Close an open stream, once: False where it is closed already. raw: SHA-256 and size [bytes] of the stream as
        it came, in the blob store; summary: in place of the one it began with."""
        ended = {"state": state, "ended_at": database_now(self.lab.session), **asdict(counts)}
        if raw is not None:
            spare_blobs(self.lab.session, [raw[0]])
            ended |= {"sha256": raw[0], "size": raw[1]}
        if summary is not None:
            ended["summary"] = dict(summary)
        return self._change(key, ended)

    def _change(self, key: str, values: Mapping[str, Any]) -> bool:
        mine = (LiveStream.lab_id == self.lab.lab_id, LiveStream.id == key, LiveStream.state == "open")
        statement = sa.update(LiveStream).where(*mine).values(**values)
        done = self.lab.session.execute(statement, execution_options={"synchronize_session": False})
        return cast("sa.CursorResult[Any]", done).rowcount == 1


def lab_of_stream(session: Session, key: str) -> str | None:
    """Whose it is; None where there is none. For what a server finds on its own disk, not for what a request names."""
    return session.scalar(sa.select(LiveStream.lab_id).where(LiveStream.id == key))
