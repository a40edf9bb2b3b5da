"""Words by which robots, devices and studies are found.

Neither database folds the case of every script alike, so the words are folded here, once when a thing is added and once
when they are asked for, and the database only compares.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator, Mapping
from typing import Any

import sqlalchemy as sa

from exogauge.storage.tables import Named

KEY = re.compile(r"[0-9a-f-]{6,64}")  # shorter ones would be found in hashes by chance


def folded(text: str) -> str:
    """Without case and without the width of letters: STRASSE is straße, Ｓｕｉｔ is suit."""
    return unicodedata.normalize("NFKC", unicodedata.normalize("NFKC", text).casefold())


def words_of(name: str, summary: Mapping[str, Any]) -> str:
    """What a thing is found by: its name, its robot's and its devices' names."""
    return "\n".join(dict.fromkeys(folded(each) for each in (name, *names_in(summary))))


def names_in(summary: Mapping[str, Any]) -> Iterator[str]:
    robot = summary.get("robot")
    named = (summary, robot if isinstance(robot, Mapping) else {"name": robot}, *summary.get("devices", ()))
    yield from (each["name"] for each in named if isinstance(each.get("name"), str))


def found_by(table: type[Named], search: str) -> sa.ColumnElement[bool]:
    """Every word of `search` stands in the thing's words, or begins its id or content hash."""
    return sa.and_(sa.true(), *(holds(table, word) for word in folded(search).split()))


def holds(table: type[Named], word: str) -> sa.ColumnElement[bool]:
    in_words = table.words.contains(word, autoescape=True)
    if KEY.fullmatch(word) is None:
        return in_words
    return sa.or_(in_words, table.id.startswith(word), table.content_hash.startswith(word))
