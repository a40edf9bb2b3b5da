"""A list that is made whole, given page by page: those after the last one that was shown, in the list's own order.

The cursor holds the key of that one, so that a list which changes between two pages neither repeats nor leaves out what
was there all the time. Lists of rows, newest first, have their own (`dependencies.Cursor`): the database turns their
pages.
"""

from __future__ import annotations

import base64
import binascii
import json
from collections.abc import Callable, Iterable
from typing import Annotated, TypeVar

from fastapi import Depends, Query
from fastapi.exceptions import RequestValidationError

Item = TypeVar("Item")
Key = tuple[str | float, ...]


async def decoded_mark(
    cursor: Annotated[str | None, Query(max_length=2000, description="`next_cursor` of the page before")] = None,
) -> Key | None:
    if cursor is None:
        return None
    try:
        found = json.loads(base64.urlsafe_b64decode(cursor.encode("ascii")))
    except (ValueError, RecursionError, binascii.Error) as error:
        raise no_cursor() from error
    if not isinstance(found, list) or not all(isinstance(part, str | int | float) for part in found):
        raise no_cursor()
    return tuple(found)


def no_cursor() -> RequestValidationError:
    fault = {"type": "cursor_invalid", "loc": ("query", "cursor"), "msg": "not a cursor of this list"}
    return RequestValidationError([fault])


def part(
    items: Iterable[Item], key: Callable[[Item], Key], after: Key | None, limit: int
) -> tuple[list[Item], str | None]:
    """The next page of the items in the order of their keys, which no two share, and its `next_cursor`."""
    ordered = sorted(items, key=key)
    try:
        left = ordered if after is None else [item for item in ordered if key(item) > after]
    except TypeError as error:  # of another list
        raise no_cursor() from error
    shown = left[:limit]
    if len(left) <= limit:
        return shown, None
    return shown, base64.urlsafe_b64encode(json.dumps(key(shown[-1])).encode()).decode()


Mark = Annotated[Key | None, Depends(decoded_mark)]
