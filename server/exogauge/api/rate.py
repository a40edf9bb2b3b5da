"""How often one address may ask: a bucket of tokens, which fills as time goes on."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable
from ipaddress import IPv4Address, ip_address, ip_network
from typing import final

from starlette.types import ASGIApp, Receive, Scope, Send

from exogauge.api.problems import of_error
from exogauge.errors import TooMany

BURST_S = 10.0  # what was not asked for so long may be asked at once: a page with many plots
MOST_KNOWN = 10_000  # addresses; the one not seen for longest is forgotten
UNCOUNTED = ("/healthz", "/readyz", "/metrics")


@final
class Buckets:
    """per_s: in the mean."""

    def __init__(self, per_s: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._per_s, self._most, self._clock = per_s, max(1.0, per_s * BURST_S), clock
        self._known = OrderedDict[str, tuple[float, float]]()

    def wait_s(self, key: str) -> float:
        """Takes a token, and returns 0; or how long until there is one."""
        now = self._clock()
        left, since = self._known.pop(key, (self._most, now))
        left = min(self._most, left + (now - since) * self._per_s)
        wait = 0.0 if left >= 1.0 else (1.0 - left) / self._per_s
        self._known[key] = (left if wait else left - 1.0, now)
        if len(self._known) > MOST_KNOWN:
            self._known.popitem(last=False)
        return wait


def place_of(address: str) -> str:
    """Of IPv6 the network: whoever has one address has 2⁶⁴."""
    if ":" not in address:
        return address
    try:
        found = ip_address(address.partition("%")[0])
    except ValueError:
        return address
    if isinstance(found, IPv4Address):
        return str(found)
    return str(found.ipv4_mapped or ip_network((found, 64), strict=False))


@final
class Rate:
    """ASGI middleware. per_s: requests of one address in the mean; 0: as many as it likes."""

    def __init__(self, app: ASGIApp, per_s: float) -> None:
        self.app = app
        self.buckets = Buckets(per_s) if per_s > 0 else None

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if self.buckets is not None and scope["type"] == "http" and scope["path"] not in UNCOUNTED:
            address = (scope.get("client") or ("", 0))[0]
            if wait := self.buckets.wait_s(place_of(address)):
                error = TooMany("too many requests come from this address (EXOGAUGE_REQUESTS_PER_S)", wait)
                await of_error(error, scope["path"])(scope, receive, send)
                return
        await self.app(scope, receive, send)
