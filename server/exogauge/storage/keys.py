"""Idempotency keys: which POST a key was used for, and what was answered."""

from __future__ import annotations

import os
import socket
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import timedelta
from typing import Any, final
from uuid import uuid4

import sqlalchemy as sa
from sqlalchemy.exc import IntegrityError

from exogauge.storage.rows import Lab
from exogauge.storage.tables import IdempotencyKey, utc_now

KEPT = timedelta(days=1)
STALE = timedelta(hours=1)
BOOT = uuid4().hex


def owner() -> str:
    """This process, so that another can tell whether it still lives."""
    return f"{socket.gethostname()}/{os.getpid()}/{BOOT}"


def owner_is_gone(text: str) -> bool:
    """True when the owner was a process of this machine that runs no more, or this one (which asks only for keys
    that it is not serving)."""
    host, pid, _boot = text.split("/")
    if host != socket.gethostname():
        return False
    if int(pid) == os.getpid():
        return True
    try:
        os.kill(int(pid), 0)
    except ProcessLookupError:
        return True
    except PermissionError:
        return False
    return False


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

    def reserve(self, key: str) -> UsedKey | None:
        """Take the key for a new request (None), or say what it was used for. Keys are forgotten after a day.

        Not to be called for a key that this process is serving at the moment.
        """
        self._forget()
        try:
            with self.lab.session.begin_nested():
                self.lab.session.add(IdempotencyKey(lab_id=self.lab.lab_id, key=key, owner=owner()))
        except IntegrityError:
            row = self.lab.session.scalars(self._select(key)).first()
            if row is None:
                return UsedKey(None, None)  # just released by another request: in flight, as far as we know
            if row.answer is None and owner_is_gone(row.owner):
                return None if self._take_over(key, row.owner) else UsedKey(None, None)
            return UsedKey(row.request_hash, row.answer)
        return None

    def answer(self, key: str, request_hash: str, answer: Mapping[str, Any]) -> None:
        """Keep the answer of a finished request."""
        mine = sa.update(IdempotencyKey).where(*self._mine(key))
        self.lab.session.execute(mine.values(request_hash=request_hash, answer=dict(answer)))

    def release(self, key: str) -> None:
        """Forget a request that had no final answer, so that it can be tried again."""
        self.lab.session.execute(sa.delete(IdempotencyKey).where(*self._mine(key)))

    def _take_over(self, key: str, from_owner: str) -> bool:
        statement = sa.update(IdempotencyKey).where(
            IdempotencyKey.lab_id == self.lab.lab_id, IdempotencyKey.key == key, IdempotencyKey.owner == from_owner
        )
        done: Any = self.lab.session.execute(statement.values(owner=owner(), created_at=utc_now()))
        return bool(done.rowcount == 1)

    def _mine(self, key: str) -> tuple[sa.ColumnElement[bool], ...]:
        table = IdempotencyKey
        return table.lab_id == self.lab.lab_id, table.key == key, table.owner == owner(), table.answer.is_(None)

    def _select(self, key: str) -> sa.Select[Any]:
        return self.lab.select(IdempotencyKey).where(IdempotencyKey.key == key)

    def _forget(self) -> None:
        now, table = utc_now(), IdempotencyKey
        abandoned = sa.and_(table.answer.is_(None), table.created_at < now - STALE)
        old = sa.or_(table.created_at < now - KEPT, abandoned)
        self.lab.session.execute(sa.delete(table).where(table.lab_id == self.lab.lab_id, old))
