"""How the service and the process of a stream talk: length, kind, content."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import final

HEAD = struct.Struct("<IB")
CLIENT_TEXT, CLIENT_BYTES, CONTROL = range(3)
"""Kinds: to or from the client; between service and process."""


def framed(kind: int, content: bytes) -> bytes:
    return HEAD.pack(len(content), kind) + content


@final
class Frames:
    """Whole frames of bytes as they come."""

    def __init__(self) -> None:
        self._left = bytearray()

    def of(self, data: bytes) -> Iterator[tuple[int, bytes]]:
        self._left += data
        at = 0
        while len(self._left) - at >= HEAD.size:
            length, kind = HEAD.unpack_from(self._left, at)
            if len(self._left) - at - HEAD.size < length:
                break
            at += HEAD.size
            yield kind, bytes(self._left[at : at + length])
            at += length
        del self._left[:at]
