"""Webhooks of a lab: who is told what happens, signed as Standard Webhooks has it, and how that went."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Literal, final

from fastapi import Response
from pydantic import BaseModel, Field, StringConstraints

from exogauge.api.dependencies import Cursor, Id, Limit, ReaderDep, SettingsDep, StoreDep, encoded_cursor
from exogauge.api.routing import Router
from exogauge.api.shapes import Answer, ListOf
from exogauge.errors import BadInput, Fault
from exogauge.upkeep.public_line import LONGEST_URL, Refused, checked, refuse_private_number

router = Router(tags=["webhooks"])
Event = Literal["job.ended", "publication.published", "publication.revoked"]
Url = Annotated[str, StringConstraints(max_length=LONGEST_URL, pattern=r"^[\x21-\x7e]+$")]


@final
class WebhookOut(Answer):
    """disabled_at: since when it is told nothing, and why; enable it again once it works."""

    id: str
    created_at: datetime
    url: str
    events: list[str]
    disabled_at: datetime | None
    disabled_because: str | None


@final
class WebhookList(ListOf):
    items: list[WebhookOut]


@final
class NewWebhook(BaseModel):
    """url: https, at a public address."""

    url: Url
    events: Annotated[list[Event], Field(min_length=1, max_length=10)]


@final
class MadeWebhook(BaseModel):
    """secret: `whsec_…`, shown this once; each delivery is signed with it."""

    webhook: WebhookOut
    secret: str


@final
class DeliveryOut(Answer):
    """id: the `webhook-id` of every try. due_at: of the next try, while it waits. status, said: of the last try."""

    id: str
    created_at: datetime
    event: str
    state: Literal["waiting", "delivered", "failed"]
    attempts: int
    due_at: datetime
    ended_at: datetime | None
    status: int | None
    said: str


@final
class DeliveryList(ListOf):
    items: list[DeliveryOut]


@router.get("/webhooks", operation_id="listWebhooks")
def list_webhooks(store: ReaderDep, cursor: Cursor, limit: Limit = 50) -> WebhookList:
    """Newest first."""
    page = store.webhooks.page(cursor, limit)
    items = [WebhookOut.model_validate(each) for each in page.items]
    return WebhookList(items=items, next_cursor=encoded_cursor(page.after))


@router.post("/webhooks", operation_id="addWebhook", status_code=201)
def add_webhook(wanted: NewWebhook, store: StoreDep, settings: SettingsDep) -> MadeWebhook:
    try:
        checked(wanted.url)
        refuse_private_number(wanted.url, settings.private_webhooks)
    except Refused as refused:
        advice = "Name a public https address without a password in it."
        raise BadInput(Fault(str(refused), "webhook_url", advice, column="url", value=wanted.url[:200])) from None
    webhook, secret = store.webhooks.add(wanted.url, wanted.events)
    return MadeWebhook(webhook=WebhookOut.model_validate(webhook), secret=secret)


@router.delete("/webhooks/{webhook_id}", operation_id="deleteWebhook", status_code=204, response_class=Response)
def delete_webhook(webhook_id: Id, store: StoreDep) -> Response:
    """With what it was told and what it was to be told."""
    store.webhooks.delete(str(webhook_id))
    return Response(status_code=204)


@router.post("/webhooks/{webhook_id}/enable", operation_id="enableWebhook")
def enable_webhook(webhook_id: Id, store: StoreDep) -> WebhookOut:
    """What happened while it was disabled is not told."""
    return WebhookOut.model_validate(store.webhooks.enable(str(webhook_id)))


@router.post("/webhooks/{webhook_id}/ping", operation_id="pingWebhook", status_code=202)
def ping_webhook(webhook_id: Id, store: StoreDep) -> DeliveryOut:
    """Send it something, within seconds, to see whether it arrives."""
    return DeliveryOut.model_validate(store.webhooks.ping(str(webhook_id)))


@router.get("/webhooks/{webhook_id}/deliveries", operation_id="listDeliveries")
def list_deliveries(webhook_id: Id, store: ReaderDep, cursor: Cursor, limit: Limit = 50) -> DeliveryList:
    """Of the last 30 days, newest first."""
    page = store.webhooks.deliveries(str(webhook_id), cursor, limit)
    items = [DeliveryOut.model_validate(each) for each in page.items]
    return DeliveryList(items=items, next_cursor=encoded_cursor(page.after))
