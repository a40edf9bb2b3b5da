"""Passwords: what one may be, its hash, and how often somebody may try.

Argon2id with the parameters of RFC 9106's second recommendation (64 MiB, three passes, four lanes), which pwdlib has as
its own. A try costs that memory, so few are made at once. Unknown addresses cost the same time as known ones.
"""

from __future__ import annotations

import hashlib
import threading
import unicodedata
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import timedelta
from functools import cache

from pwdlib import PasswordHash
from starlette.exceptions import HTTPException

from exogauge.api.rate import place_of
from exogauge.errors import BadInput, Fault, Unavailable
from exogauge.storage.accounts import Accounts
from exogauge.storage.store import Installation

SHORTEST, LONGEST = 15, 256  # letters; NIST SP 800-63B-4, 3.1.1.2: at least 15 where a password is all that is asked
AT_ONCE = threading.BoundedSemaphore(2)
PATIENCE_S = 5.0  # of a sign-in for its turn to hash, which takes 0.18 CPU s
WINDOW = timedelta(minutes=15)
MOST_TRIES = {"both": 5, "address": 50, "account": 100}  # within it: of one account from one place, …


def checked(password: str, *words: str) -> str:
    """As it is hashed (NFKC). BadInput where it is short or easily thought of. words: its owner's name and address."""
    normal = unicodedata.normalize("NFKC", password)
    if not SHORTEST <= len(normal) <= LONGEST:
        advice = "Several words make a good one; blanks count."
        raise BadInput(
            Fault(f"a password has {SHORTEST} to {LONGEST} letters", "password_length", advice, column="password")
        )
    left = normal.casefold()
    for word in ("password", "exogauge", *(part for each in words for part in (each, *each.split("@")))):
        left = left.replace(word.casefold(), "") if len(word) > 3 else left
    if len(set(left)) < 6 or len(left) < SHORTEST // 2:
        advice = "Take several words that have nothing to do with you."
        raise BadInput(Fault("this password is too easily thought of", "password_weak", advice, column="password"))
    return normal


@cache
def hasher() -> PasswordHash:
    return PasswordHash.recommended()


@cache
def nobody() -> str:
    """The hash that an unknown address is compared with."""
    return hasher().hash("nobody has this password")


@contextmanager
def few_at_once() -> Iterator[None]:
    if not AT_ONCE.acquire(timeout=PATIENCE_S):
        raise Unavailable("too many sign in at once; try again in a moment")
    try:
        yield
    finally:
        AT_ONCE.release()


def hash_of(password: str) -> str:
    with few_at_once():
        return hasher().hash(password)


def fits(password: str, kept: str | None) -> bool:
    """Takes as long where there is none."""
    normal = unicodedata.normalize("NFKC", password)[: LONGEST + 1]
    with few_at_once():
        right = hasher().verify(normal, kept or nobody())
    return right and kept is not None


def signed_in(installation: Installation, email: str, password: str, address: str) -> str:
    """The account's id. 403 for a wrong address as for a wrong password, 429 after too many of them."""
    keys = count_try(installation, email, address)
    with installation.reading() as session:
        found = Accounts(session).password_hash(email=email)
    if not fits(password, None if found is None else found[1]) or found is None:
        raise HTTPException(403, "the e-mail address or the password is wrong")
    with installation.session() as session:
        Accounts(session).forget_tries(keys[:1], WINDOW)
    return found[0]


def count_try(installation: Installation, account: str, address: str) -> list[str]:
    """Of this account from this place, from this place, of this account: counted before the password is looked at, so
    that guesses made at once are all counted. 429 where one is too many."""
    place = place_of(address)
    keys = [key_of("both", account, place), key_of("address", place), key_of("account", account)]
    with installation.session() as session:
        tries = Accounts(session).count_tries(keys, WINDOW)
    if any(count > most for count, most in zip(tries, MOST_TRIES.values(), strict=True)):
        wait = int(WINDOW.total_seconds())
        raise HTTPException(429, f"too many tries; wait {wait // 60} minutes", {"Retry-After": str(wait)})
    return keys


def key_of(*parts: str) -> str:
    return hashlib.sha256("\0".join(parts).encode("utf-8", "surrogatepass")).hexdigest()
