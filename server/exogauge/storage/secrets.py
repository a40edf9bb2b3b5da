"""Keys that are shown once and kept as a hash: of sessions, tokens and invitations.

A token is `exg_`, 32 random letters and digits (190 bits), and six that check them, so that a mistyped one is told from
one that is not known, and a secret scanner finds it. What is so random needs no slow hash.
"""

from __future__ import annotations

import hashlib
import re
import secrets
import string
import zlib

LETTERS = string.digits + string.ascii_letters
PREFIX = "exg_"
RANDOM, CHECK = 32, 6
TOKEN = re.compile(rf"{PREFIX}[0-9A-Za-z]{{{RANDOM + CHECK}}}")


def new_key() -> str:
    """Of a session or an invitation; nobody types it."""
    return secrets.token_urlsafe(32)


def new_token() -> str:
    body = "".join(secrets.choice(LETTERS) for _ in range(RANDOM))
    return f"{PREFIX}{body}{check_of(body)}"


def is_token(text: str) -> bool:
    """Whether it is whole; says nothing of whether it is known."""
    if not TOKEN.fullmatch(text):
        return False
    body = text.removeprefix(PREFIX)[:RANDOM]
    return text.endswith(check_of(body))


def check_of(body: str) -> str:
    number, digits = zlib.crc32(body.encode()), ""
    for _ in range(CHECK):
        number, digit = divmod(number, len(LETTERS))
        digits = LETTERS[digit] + digits
    return digits


def hashed(secret: str) -> str:
    """What is kept of it, and looked up by: who reads the table, or times the look-up, learns nothing to use."""
    return hashlib.sha256(secret.encode("utf-8", "surrogatepass")).hexdigest()
