"""Idempotency keys: which POST of a lab a key was used for, and what was answered.

A key in flight is a lease: a row with an end, on the database's clock, that the request which serves it puts off while
it is served. So of all processes on one database one answers, and a key whose process was killed is free soon after.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import timedelta
from typing import Any, final

import sqlalchemy as sa
from sqlalchemy.exc import IntegrityError

from exogauge.storage.database import database_now
from exogauge.storage.rows import Lab
from exogauge.storage.tables import IdempotencyKey, new_id

KEPT = timedelta(days=1)


@final
@dataclass(frozen=True)
class Held:
    """The key is this request's; owner: what proves it."""

    key: str
    owner: str


@final
@dataclass(frozen=True)
class UsedKey:
    """request_hash, answer: None while the request is in flight."""

    request_hash: str | None
    answer: Mapping[str, Any] | None


@final
@dataclass(frozen=True)
class Keys:
    lab: Lab

    def reserve(self, key: str, lease: timedelta) -> Held | UsedKey:
        """Hold the key for a new request, or say what it was used for; a unique constraint decides any race."""
        now, held = database_now(self.lab.session), Held(key, new_id())
        self._forget(IdempotencyKey.expires_at <= now)
        try:
            with self.lab.session.begin_nested():
                row = IdempotencyKey(lab_id=self.lab.lab_id, key=key, owner=held.owner, expires_at=now + lease)
                self.lab.session.add(row)
        except IntegrityError:
            found = self.lab.session.scalars(self.lab.select(IdempotencyKey).where(IdempotencyKey.key == key)).first()
            # gone: just released by another request; in flight, as far as we know
            return UsedKey(None, None) if found is None else UsedKey(found.request_hash, found.answer)
        return held

    def hold_on(self, held: Held, lease: timedelta) -> bool:
        """Put the end of the lease off; False where it is another's by now."""
        return self._change(held, expires_at=database_now(self.lab.session) + lease)

    def answer(self, held: Held, request_hash: str, answer: Mapping[str, Any]) -> bool:
        """Keep the answer of a finished request; False where the key is another's by now."""
        until = database_now(self.lab.session) + KEPT
        return self._change(held, request_hash=request_hash, answer=dict(answer), expires_at=until)

    def release(self, held: Held) -> None:
        """Forget a request that had no final answer, so that it can be tried again."""
        self._forget(*self._of(held))

    def _change(self, held: Held, **values: Any) -> bool:
        done: Any = self.lab.session.execute(sa.update(IdempotencyKey).where(*self._of(held)).values(**values))
        return bool(done.rowcount == 1)

    def _forget(self, *which: sa.ColumnElement[bool]) -> None:
        self.lab.session.execute(sa.delete(IdempotencyKey).where(IdempotencyKey.lab_id == self.lab.lab_id, *which))

    def _of(self, held: Held) -> tuple[sa.ColumnElement[bool], ...]:
        table = IdempotencyKey
        mine = table.lab_id == self.lab.lab_id, table.key == held.key, table.owner == held.owner
        return (*mine, table.answer.is_(None))
