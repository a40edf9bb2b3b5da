"""An object store that does not answer, in the program's own words."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from obstore.exceptions import AlreadyExistsError, BaseError

from exogauge.errors import Away, NotFound


@contextmanager
def reached(what: str, sha256: str | None = None) -> Iterator[None]:
    """A store that cannot be reached, or refuses, is `Away`. sha256: of what it may lack, which is NotFound."""
    try:
        yield
    except AlreadyExistsError:
        raise
    except (BaseError, OSError) as error:
        if isinstance(error, FileNotFoundError) and sha256 is not None:
            raise NotFound(f"no blob {sha256}") from error
        lacks = isinstance(error, FileNotFoundError) or "NoSuchBucket" in str(error)
        why = "has no such bucket" if lacks else "does not answer, or refuses"
        raise Away(f"cannot {what} now: the object store {why}") from error
