"""Whether the service can serve: database, blobs, workers."""

from __future__ import annotations

import logging
from typing import Literal, final

from fastapi import Response
from pydantic import BaseModel

from exogauge import __version__
from exogauge.api.dependencies import InstallationDep, SettingsDep
from exogauge.api.routing import Router
from exogauge.api.shapes import Health
from exogauge.errors import Unavailable
from exogauge.storage.store import Installation

log = logging.getLogger(__name__)
router = Router(root="", tags=["health"])


@final
class Alive(BaseModel):
    """The process answers; whether it can serve, /readyz says."""

    status: Literal["ok"]
    version: str


@router.get("/healthz", operation_id="getHealth")
async def get_health() -> Alive:
    """Asks nothing of anybody: for whoever starts a process again that does not answer."""
    return Alive(status="ok", version=__version__)


@router.get(
    "/readyz",
    operation_id="getReadiness",
    responses={503: {"model": Health, "description": "Database or blobs do not answer"}},
)
def get_readiness(installation: InstallationDep, settings: SettingsDep, response: Response) -> Health:
    database, alive = ask_database(installation)
    blobs = ask_blobs(installation)
    serving = database == blobs == "ok"
    response.status_code = 200 if serving else 503
    return Health(
        status="unavailable" if not serving else "ok" if alive >= max(settings.workers, 1) else "degraded",
        version=__version__,
        database=database,
        blobs=blobs,
        workers_wanted=settings.workers,
        workers_alive=alive,
    )


def ask_database(installation: Installation) -> tuple[str, int]:
    """`ok` or `unavailable`, and how many workers live; the reason stays in the log, it may hold addresses."""
    try:
        return "ok", installation.workers_alive()
    except Unavailable as error:
        log.warning("health: %s", error)
        return "unavailable", 0


def ask_blobs(installation: Installation) -> str:
    try:
        installation.blobs.refuse_if_full()
    except Unavailable as error:
        log.warning("health: %s", error)
        return "unavailable"
    return "ok"
