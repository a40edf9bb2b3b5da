"""Routers of the service: what an endpoint does with the store happens in one thread, from its first statement to the
commit. As a dependency of the framework's the transaction would begin in one thread and end in another, and for an
endpoint that is no coroutine the framework goes to a thread once more, to look at what it answered: each hand-over
costs more than most statements. Routes stand at their whole path from the start: included below a prefix, each would
be made a second time for every app."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable
from functools import wraps
from typing import Any, final

from fastapi import APIRouter
from starlette._utils import get_route_path
from starlette.concurrency import run_in_threadpool
from starlette.routing import BaseRoute, Match
from starlette.types import Scope

from exogauge.api.reading import AnyQuery, Route
from exogauge.api.threads import SHORT, in_short_thread
from exogauge.storage.store import Store, whole

PREFIX = "/api/v1"


@final
class Router(APIRouter):
    """A `store` that an endpoint asks for is its transaction (`storage.store.whole`). root: below which its paths
    are; what is not the API's takes any query. asks_anything: so do these."""

    def __init__(self, *, root: str = PREFIX, prefix: str = "", asks_anything: bool = False, **options: Any) -> None:
        route = Route if root and not asks_anything else AnyQuery
        super().__init__(prefix=root + prefix, route_class=route, **options)

    def add_api_route(self, path: str, endpoint: Callable[..., Any], **options: Any) -> None:
        super().add_api_route(path, in_one_transaction(endpoint), **options)


def in_one_transaction(endpoint: Callable[..., Any]) -> Callable[..., Any]:
    if "store" not in inspect.signature(endpoint).parameters:
        return endpoint
    if inspect.iscoroutinefunction(endpoint):
        raise TypeError(f"{endpoint.__name__} would wait for the database in the event loop")

    run = in_short_thread if getattr(endpoint, SHORT, False) else run_in_threadpool

    def within(store: Store, given: dict[str, Any]) -> Any:
        with whole(store):
            return endpoint(store=store, **given)

    @wraps(endpoint)
    async def answer(*, store: Store, **given: Any) -> Any:
        return await run(within, store, given)

    return answer


def methods_at(routes: Iterable[BaseRoute], scope: Scope) -> list[str]:
    """What may be done at the request's path, whichever of them it asks for. HEAD goes with GET (`api.heads`)."""
    found = set[str]()
    for route in routes:
        if route.matches(scope)[0] is not Match.NONE:
            found |= getattr(route, "methods", None) or set()
    return sorted(found | {"HEAD"} if "GET" in found else found)


def meant(routes: Iterable[BaseRoute], scope: Scope) -> str | None:
    """The path that a request probably means, whose own has a slash too many; below the root path."""
    path = get_route_path(scope)
    plain = re.sub("/+", "/", path).rstrip("/")
    if plain == path or not methods_at(routes, {**scope, "path": plain, "root_path": ""}):
        return None
    return plain
