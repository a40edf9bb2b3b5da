"""Labs with people in them, and browsers and programs that ask in their names."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from typing import TYPE_CHECKING

from fastapi.testclient import TestClient

from exogauge.storage.accounts import Accounts
from exogauge.storage.store import Installation

if TYPE_CHECKING:
    from fastapi import FastAPI

ORIGIN = "https://exo.example"
PAGE = {"Origin": ORIGIN}  # as a browser says it of our own page
COOKIE = "__Host-exogauge"
PASSWORD = "three old lamps glow"


class People:
    """Of an installation."""

    def __init__(self, app: FastAPI) -> None:
        self.app = app
        self.installation: Installation = app.state.installation

    def person(self, email: str, lab: str | None = None, role: str = "member", *, password: str | None = None) -> str:
        """Its account's id."""
        from exogauge.api.passwords import hash_of

        hashed = None if password is None else hash_of(password)
        with self.installation.session() as session:
            accounts = Accounts(session)
            account = accounts.add(email, email.split("@")[0], hashed)
            if lab is not None:
                accounts.join(account.id, accounts.found_lab(lab, lab).id, role, "test", "")
        return account.id

    def session(self, account_id: str) -> str:
        """What the cookie of a browser holds that is signed in."""
        with self.installation.session() as session:
            return Accounts(session).begin_session(account_id)

    def token(
        self, lab: str, scope: str = "write", account_id: str | None = None, expires_at: datetime | None = None
    ) -> tuple[str, str]:
        """Its id, and itself."""
        with self.installation.of_lab(lab).transaction() as store:
            made, secret = store.tokens.add(
                "of a test", scope, made_by=None, account_id=account_id, expires_at=expires_at
            )
        return made.id, secret

    @contextmanager
    def browser(self, key: str | None = None) -> Iterator[TestClient]:
        """On our own page; nobody without a key."""
        cookies = {} if key is None else {COOKIE: key}
        opened = TestClient(self.app, base_url=ORIGIN, cookies=cookies, headers=PAGE, raise_server_exceptions=False)
        yield opened
        opened.close()

    @contextmanager
    def program(self, token: str) -> Iterator[TestClient]:
        headers = {"Authorization": f"Bearer {token}"}
        opened = TestClient(self.app, base_url=ORIGIN, headers=headers, raise_server_exceptions=False)
        yield opened
        opened.close()
