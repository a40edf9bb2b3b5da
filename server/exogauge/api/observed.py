"""What was asked for and how long it took: an id per request, counts and times for Prometheus, a line in the log. No
label holds a lab or an id."""

from __future__ import annotations

import logging
import re
import time
import uuid
from collections.abc import Mapping
from typing import Any, final

from opentelemetry.trace import get_current_span
from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from exogauge.api.routing import PREFIX
from exogauge.logbook import request_id

log = logging.getLogger(__name__)
GIVEN = re.compile(r"[A-Za-z0-9._-]{8,64}")
# Edges of the histogram: from an answer out of memory to a body that comes slowly.
SECONDS = (0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0, 120.0)


def quiet(scope: Mapping[str, Any]) -> bool:
    """Asked by whoever watches the service, every few seconds."""
    return scope["type"] == "http" and scope["path"] in ("/healthz", "/readyz", "/metrics")


@final
class Measures:
    """Of the requests of one server."""

    def __init__(self) -> None:
        self.registry = CollectorRegistry()
        labels = ("method", "route")
        self.requests = Counter(
            "exogauge_requests_total", "Requests answered", (*labels, "status"), registry=self.registry
        )
        self.seconds = Histogram(
            "exogauge_request_seconds", "Until the answer had ended", labels, buckets=SECONDS, registry=self.registry
        )
        self.under_way = Gauge("exogauge_requests_under_way", "Requests not yet answered", registry=self.registry)


@final
class Observed:
    """ASGI middleware around all others."""

    def __init__(self, app: ASGIApp, measures: Measures) -> None:
        self.app, self.measures = app, measures

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        given = Headers(scope=scope).get("x-request-id", "")
        key = given if GIVEN.fullmatch(given) else uuid.uuid4().hex
        get_current_span().set_attribute("exogauge.request", key)
        told, begun, status = request_id.set(key), time.perf_counter(), 0

        async def noted(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                MutableHeaders(scope=message)["X-Request-ID"] = key
            await send(message)

        self.measures.under_way.inc()
        try:
            await self.app(scope, receive, noted)
        finally:
            self.measures.under_way.dec()
            self._tell(scope, status, time.perf_counter() - begun)
            request_id.reset(told)

    def _tell(self, scope: Scope, status: int, seconds: float) -> None:
        """status: 0 where the line broke before an answer began."""
        method = scope["method"] if scope["method"] in ("GET", "POST", "PUT", "PATCH", "DELETE", "HEAD") else "other"
        route = getattr(scope.get("route"), "path", "none").removeprefix(PREFIX)
        self.measures.requests.labels(method, route, str(status)).inc()
        self.measures.seconds.labels(method, route).observe(seconds)
        if not quiet(scope):
            facts = {"method": method, "path": scope["path"], "status": status, "seconds": round(seconds, 4)}
            log.info("%s %s %d in %.3f s", method, scope["path"], status, seconds, extra={"facts": facts})
