"""The application: one factory, from settings to a FastAPI app that is ready to serve."""

from __future__ import annotations

import importlib
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import FastAPI
from starlette.concurrency import run_in_threadpool

from exogauge import __version__
from exogauge.api import (
    between_labs,
    compare,
    devices,
    events,
    from_uploads,
    health,
    imports,
    lab,
    live,
    logs,
    metrics,
    models,
    motions,
    oidc,
    openapi,
    page,
    payload_drafts,
    payloads,
    plans,
    problems,
    publications,
    published,
    raw_series,
    results,
    robots,
    scenes,
    series,
    session,
    shares,
    studies,
    uploads_resumable,
    webhooks,
    what_if,
)
from exogauge.api.access import Access
from exogauge.api.guard import BodyLimit, Guard
from exogauge.api.heads import Heads
from exogauge.api.idempotency import Idempotency
from exogauge.api.live_hub import Hub
from exogauge.api.metrics import OfInstallation
from exogauge.api.observed import Measures, Observed, quiet
from exogauge.api.openid import Provider
from exogauge.api.rate import Rate
from exogauge.api.routing import PREFIX, Router
from exogauge.api.uploads_resumable import Tus
from exogauge.sandbox.asking import at_once
from exogauge.settings import Settings
from exogauge.storage.accounts import Accounts
from exogauge.storage.held_files import own_folder
from exogauge.storage.migrate import prepare
from exogauge.storage.store import Installation, open_installation
from exogauge.upkeep.hourly import Housekeeping
from exogauge.upkeep.postman import Postman

ABOUT = "Identify a robot from its logs: hand in a study, run it, read the result. Errors are RFC 9457 problems."


def create_app(settings: Settings | None = None) -> FastAPI:
    """The service. A new database is created; one at another schema revision is refused (`WrongSchema`)."""
    settings = settings or Settings()
    prepare(settings.database_url)
    installation = open_installation(settings)
    at_once.bound(settings.readers)
    hub, housekeeping = Hub(installation, settings), Housekeeping(installation, settings)
    postman = Postman(installation, settings)

    @asynccontextmanager
    async def lifespan(_app: FastAPI) -> AsyncIterator[None]:
        hub.begin()
        housekeeping.start()
        postman.start()
        yield
        hub.close()
        await run_in_threadpool(housekeeping.stop)
        await run_in_threadpool(postman.stop)
        own_folder(settings.scratch).close()
        installation.close()

    app = FastAPI(
        title="exogauge",
        version=__version__,
        description=ABOUT,
        lifespan=lifespan,
        openapi_url=f"{PREFIX}/openapi.json",
        docs_url=None,  # it loads its code from elsewhere
        redoc_url=None,
        redirect_slashes=False,
        telemetry={"metrics": False, "logs": False, "operation_spans": False, "exclude": quiet},
    )
    app.state.settings = settings
    app.state.installation = installation
    app.state.accounts = settings.accounts or has_accounts(installation)
    app.state.live = hub
    app.state.oidc = Provider(settings) if settings.oidc_issuer else None
    app.state.extracts = between_labs.Extracts()
    app.state.watch = events.Watch(installation)
    app.state.measures = measures = Measures()
    measures.registry.register(OfInstallation(installation, settings))
    problems.install(app)
    app.openapi = lambda: openapi.document(app)  # type: ignore[method-assign]
    app.add_middleware(Heads)
    app.add_middleware(Idempotency)
    app.add_middleware(BodyLimit, limit=settings.max_upload_bytes, piece_limit=settings.max_bundle_bytes)
    app.add_middleware(Access)
    app.add_middleware(Guard, local_only=settings.local_only)
    app.add_middleware(Tus, prefix=f"{PREFIX}/uploads")
    app.add_middleware(Rate, per_s=settings.requests_per_s)
    app.add_middleware(Observed, measures=measures)
    for router in (  # those that are asked most come first: a request is held against one after the other
        *job_routers(),
        studies.router,
        series.router,
        results.router,
        robots.router,
        devices.router,
        logs.router,
        payload_drafts.router,
        payloads.router,
        motions.router,
        plans.router,
        live.router,
        what_if.router,
        raw_series.router,
        scenes.router,
        uploads_resumable.router,
        from_uploads.router,
        imports.router,
        compare.router,
        between_labs.router,
        models.router,
        session.router,
        oidc.router,
        lab.router,
        shares.router,
        publications.router,
        published.router,
        webhooks.router,
        health.router,
        metrics.router,
        page.router,
    ):
        app.router.routes.extend(router.routes)
    return app


def has_accounts(installation: Installation) -> bool:
    """Once there are some, they are asked for, whatever the settings say: a start that forgets one opens no door."""
    with installation.reading() as reading:
        return Accounts(reading).any()


def job_routers() -> list[Router]:
    """The job engine's own routers."""
    found = []
    for name in ("jobs", "events"):
        try:
            found.append(importlib.import_module(f"exogauge.api.{name}").router)
        except ModuleNotFoundError as missing:
            if missing.name != f"exogauge.api.{name}":
                raise
    return found
