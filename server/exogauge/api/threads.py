"""Threads for short looks at the database: who asks, a list, one thing of it.

Each takes a millisecond, nearly all of it Python's. As many as ask would contend for the interpreter, which costs more
than it brings; a few at a time answer sooner. What may wait for a file, a writer or a child has the framework's own
threads, so that nothing short waits behind it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from anyio import CapacityLimiter, to_thread
from anyio.lowlevel import RunVar

# Of how a server answers, not of what a run finds. docs/measured/capacity.md: as many as ask cost a sixth more; fewer
# wait in turn for a database that is away
AT_ONCE = 8
SHORT = "exogauge_short"  # attribute of an endpoint
Answer = TypeVar("Answer")
Endpoint = TypeVar("Endpoint", bound=Callable[..., object])
_limiter: RunVar[CapacityLimiter] = RunVar("exogauge.short")


def short(endpoint: Endpoint) -> Endpoint:
    """Decorator of an endpoint that reads a few rows, and no file."""
    setattr(endpoint, SHORT, True)
    return endpoint


async def in_short_thread(look: Callable[..., Answer], *given: object) -> Answer:
    try:
        limiter = _limiter.get()
    except LookupError:  # the first of this event loop
        _limiter.set(limiter := CapacityLimiter(AT_ONCE))
    return await to_thread.run_sync(look, *given, limiter=limiter)
