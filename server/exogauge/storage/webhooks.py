"""Addresses that a lab wants to be told at, and what they are told: an outbox, written with what it tells of.

A delivery is a row in the transaction of the event, so none is lost and none tells of what did not happen. Whoever
sends it (`exogauge.upkeep.postman`) says how it went; what was not taken comes again, later each time, and an address
that takes nothing for three days is told nothing more.
"""

from __future__ import annotations

import base64
import secrets
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any, final

import sqlalchemy as sa
from sqlalchemy.orm import Session

from exogauge.errors import Conflict
from exogauge.storage.database import database_now
from exogauge.storage.records import DeliveryRecord, Page, WebhookRecord
from exogauge.storage.rows import Lab, as_record, record
from exogauge.storage.tables import Delivery, Webhook

EVENTS = ("job.ended", "publication.published", "publication.revoked")
PING = "ping"
MOST = 20  # addresses of a lab
AGAIN = tuple(  # after the first try, the second …: about three days, as Standard Webhooks recommends
    timedelta(seconds=each) for each in (5, 300, 1800, 7200, 18000, 36000, 50400, 72000, 86400)
)
HELD = timedelta(minutes=2)  # for which one that is being sent is not sent by another
QUIET = {"synchronize_session": False}


@final
@dataclass(frozen=True)
class Due:
    """A delivery to send now."""

    id: str
    lab_id: str
    webhook_id: str
    url: str
    secret: str
    event: str
    created_at: datetime
    data: Mapping[str, Any]
    attempts: int


@final
@dataclass(frozen=True)
class Webhooks:
    lab: Lab

    def page(self, after: tuple[datetime, str] | None, limit: int) -> Page[WebhookRecord]:
        return self.lab.page(WebhookRecord, Webhook, after, limit)

    def get(self, key: str) -> WebhookRecord:
        return self.lab.get(WebhookRecord, Webhook, key, "webhook")

    def add(self, url: str, events: Sequence[str]) -> tuple[WebhookRecord, str]:
        """And its secret, which is shown once; it is kept, since each delivery is signed with it."""
        if len(self.page(None, MOST).items) >= MOST:
            raise Conflict(f"a lab has at most {MOST} webhooks")
        secret = f"whsec_{base64.b64encode(secrets.token_bytes(32)).decode()}"
        row = Webhook(lab_id=self.lab.lab_id, url=url, events=sorted(set(events)), secret=secret)
        self.lab.session.add(row)
        self.lab.session.flush()
        self.lab.audit("add", "webhook", row.id, said=f"{url}: {', '.join(row.events)}")
        return as_record(WebhookRecord, row), secret

    def enable(self, key: str) -> WebhookRecord:
        """Told again what comes from now on."""
        found = self.get(key)
        mine = sa.update(Webhook).where(Webhook.lab_id == self.lab.lab_id, Webhook.id == key)
        self.lab.session.execute(mine.values(disabled_at=None, disabled_because=None), execution_options=QUIET)
        self.lab.audit("enable", "webhook", key, said=found.url)
        return self.get(key)

    def delete(self, key: str) -> None:
        found = self.get(key)
        mine = sa.delete(Webhook).where(Webhook.lab_id == self.lab.lab_id, Webhook.id == key)
        self.lab.session.execute(mine, execution_options=QUIET)
        self.lab.audit("delete", "webhook", key, said=found.url)

    def deliveries(self, key: str, after: tuple[datetime, str] | None, limit: int) -> Page[DeliveryRecord]:
        self.get(key)
        return self.lab.page(DeliveryRecord, Delivery, after, limit, Delivery.webhook_id == key)

    def tell(self, event: str, data: Mapping[str, Any]) -> None:
        """Whoever wants to know; in the transaction of what happened."""
        wanting = self.lab.select(Webhook).where(Webhook.disabled_at.is_(None))
        for hook in self.lab.session.scalars(wanting):
            if event in hook.events:
                self._add(hook.id, event, data)

    def ping(self, key: str) -> DeliveryRecord:
        """One delivery, to see whether it arrives. Conflict where the webhook is disabled."""
        if self.get(key).disabled_at is not None:
            raise Conflict("this webhook is disabled; enable it first")
        return as_record(DeliveryRecord, self._add(key, PING, {"webhook_id": key}))

    def _add(self, webhook_id: str, event: str, data: Mapping[str, Any]) -> Delivery:
        now = database_now(self.lab.session)
        row = Delivery(
            lab_id=self.lab.lab_id, webhook_id=webhook_id, event=event, data=dict(data), state="waiting", attempts=0,
            due_at=now,
        )  # fmt: skip
        self.lab.session.add(row)
        self.lab.session.flush()
        return row


def any_due(session: Session) -> bool:
    """In a session of all labs, as all that follow."""
    due = Delivery.state == "waiting", Delivery.due_at <= database_now(session)
    return session.scalar(sa.select(Delivery.id).where(*due).limit(1)) is not None


def take_due(session: Session, most: int) -> list[Due]:
    """The oldest of each webhook, held for a while, so that no two are sent to one address at once."""
    now = database_now(session)
    rank = sa.func.row_number().over(partition_by=Delivery.webhook_id, order_by=(Delivery.due_at, Delivery.id))
    ranked = sa.select(Delivery.id, rank.label("rank")).where(Delivery.state == "waiting", Delivery.due_at <= now)
    chosen = ranked.subquery()
    query = sa.select(Delivery, Webhook).join(Webhook, Webhook.id == Delivery.webhook_id)
    query = query.where(
        Delivery.id.in_(sa.select(chosen.c.id).where(chosen.c.rank == 1)), Webhook.disabled_at.is_(None)
    )
    taken = []
    for row, hook in session.execute(query.order_by(Delivery.due_at).limit(most)):
        mine = Delivery.id == row.id, Delivery.state == "waiting", Delivery.attempts == row.attempts
        held = sa.update(Delivery).where(*mine).values(attempts=row.attempts + 1, due_at=now + HELD)
        if changed(session, held):
            taken.append(
                Due(
                    row.id, row.lab_id, hook.id, hook.url, hook.secret, row.event, row.created_at, row.data,
                    row.attempts + 1,
                )
            )  # fmt: skip
    return taken


def delivered(session: Session, due: Due, status: int) -> None:
    done = {"state": "delivered", "ended_at": database_now(session), "status": status, "said": ""}
    changed(session, sa.update(Delivery).where(Delivery.id == due.id).values(**done))


def not_delivered(session: Session, due: Due, status: int | None, said: str, jitter: float, gone: bool) -> None:
    """Again later, or never: then, and where the address says that it is gone, the webhook is told nothing more.
    jitter: by which factor the pause differs."""
    now, last = database_now(session), gone or due.attempts > len(AGAIN)
    change: dict[str, Any] = {"status": status, "said": said[:500]}
    change |= {"state": "failed", "ended_at": now} if last else {"due_at": now + AGAIN[due.attempts - 1] * jitter}
    changed(session, sa.update(Delivery).where(Delivery.id == due.id, Delivery.state == "waiting").values(**change))
    if last:
        disable(session, due, "it says that it is gone (410)" if gone else f"it took nothing for three days: {said}")


def disable(session: Session, due: Due, because: str) -> None:
    now = database_now(session)
    on = Webhook.id == due.webhook_id, Webhook.disabled_at.is_(None)
    if changed(session, sa.update(Webhook).where(*on).values(disabled_at=now, disabled_because=because[:500])):
        record(session, due.lab_id, "postman", "disable", "webhook", due.webhook_id, said=because[:500])
    waiting = Delivery.webhook_id == due.webhook_id, Delivery.state == "waiting"
    changed(session, sa.update(Delivery).where(*waiting).values(state="failed", ended_at=now, said="disabled"))


def changed(session: Session, statement: sa.Update) -> bool:
    return bool(session.execute(statement, execution_options=QUIET).rowcount)  # type: ignore[attr-defined]
