"""What a request needs: one table, first line that fits. What no line names is of a lab, and needs `read` or `write` by
its method, so that a new endpoint is closed before anybody thinks of it.

    open      nobody has to say who they are
    session   a browser that is signed in, of whichever lab or of none
    read      any role in the lab of the session or token
    write     member or admin; a token with the scope `write`
    admin     an admin, by a session: a token administers nothing
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal, final

from exogauge.storage.callers import RANK, Caller

Right = Literal["open", "session", "read", "write", "admin"]
SAFE = ("GET", "HEAD", "OPTIONS")
ANY = (*SAFE, "POST", "PUT", "PATCH", "DELETE", "WEBSOCKET")


@final
@dataclass(frozen=True)
class Rule:
    """path: a pattern of all of it."""

    methods: tuple[str, ...]
    path: re.Pattern[str]
    right: Right


def rule(methods: tuple[str, ...] | str, path: str, right: Right) -> Rule:
    return Rule((methods,) if isinstance(methods, str) else methods, re.compile(path), right)


RULES = (
    rule(SAFE, r"/(icon\.svg|healthz|readyz|metrics|assets/[^/]*)?", "open"),
    rule(
        SAFE,
        r"/(sign-in|set-up|invited|account|lab|studies|import|robots|devices|payloads|motions|plans|compare|published)(/.*)?",
        "open",
    ),
    rule(SAFE, r"/api/v1/scenes/player", "open"),  # the page of a frame, which holds no data
    rule(("GET", "HEAD", "POST", "DELETE"), r"/api/v1/session", "open"),  # who asks; sign in; sign out
    rule(SAFE, r"/api/v1/published/.*", "open"),  # what a lab has published, and nothing else
    rule("POST", r"/api/v1/oidc/begin", "open"),  # goes to the provider, and comes back with its word
    rule("GET", r"/api/v1/oidc/callback", "open"),
    rule("POST", r"/api/v1/set-up", "open"),  # proves itself by its code, as the next two do
    rule("POST", r"/api/v1/invitations/(look|accept)", "open"),
    rule(ANY, r"/api/v1/(session/.*|sessions|account(/.*)?|labs)", "session"),
    rule(SAFE, r"/api/v1/lab(/members)?", "read"),
    rule(ANY, r"/api/v1/lab(/.*)?", "admin"),
    rule(ANY, r"/api/v1/webhooks(/.*)?", "admin"),
    rule(ANY, r"/api/v1/tokens(/.*)?", "session"),
    rule("POST", r"/api/v1/studies/[^/]+/whatif", "read"),  # questions, which change nothing
    rule("WEBSOCKET", r"/api/v1/live/payload/[^/]+/watch", "read"),
)


def right_of(method: str, path: str) -> Right:
    """path: below the root path."""
    found = (each.right for each in RULES if method in each.methods and each.path.fullmatch(path))
    return next(found, "read" if method in SAFE else "write")


def refusal(caller: Caller | None, right: Right) -> tuple[int, str] | None:
    """Status and reason; None where it may."""
    if right == "open":
        return None
    if caller is None:
        return 401, "sign in, or send a token: `Authorization: Bearer exg_…`"
    if right in ("session", "admin") and caller.token_id is not None:
        return 403, "a token may not do this; sign in"
    if right == "session":
        return None
    if caller.lab_id is None or caller.role is None:
        return 403, "you are of no lab; ask an admin of one to invite you"
    needed = {"read": "viewer", "write": "member", "admin": "admin"}[right]
    if RANK[caller.role] < RANK[needed]:
        return 403, f"this takes the role {needed}, and yours is {caller.role}"
    return None
