"""Where several servers see what has arrived of an upload, as those who receive it ask for it."""

from __future__ import annotations

from typing import BinaryIO, Protocol, final


@final
class InUse(Exception):
    """Another request writes to the file, at this server or another."""


class Pieces(Protocol):
    """Of all uploads."""

    def of(self, key: str) -> list[tuple[int, int]]:
        """Begin and size of each, from the file's begin on, without a gap."""
        ...

    def end(self, key: str) -> int:
        """Bytes that have arrived."""
        ...

    def send(self, key: str, file: BinaryIO, begin: int) -> None:
        """All of the file from there on. InUse where another was quicker."""
        ...

    def read(self, key: str, begin: int) -> bytes: ...
    def drop(self, key: str) -> None: ...

    def keys(self) -> list[str]:
        """Of uploads of which anything is there."""
        ...
