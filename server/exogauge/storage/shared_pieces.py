"""What has arrived of uploads, where several servers see it: an object per piece, named by where it begins. An object
is there whole or not at all and is never replaced, so that of two who send the same place one is told so."""

from __future__ import annotations

from contextlib import suppress
from typing import BinaryIO, final

import obstore
from obstore.exceptions import AlreadyExistsError
from obstore.store import S3Store

from exogauge.storage.pieces import InUse
from exogauge.storage.reaching import reached

FOLDER = "uploads"
LARGEST = 32 << 20  # judgement: bytes of one object, which is sent from memory


@final
class SharedPieces:
    """Of all uploads in an object store."""

    def __init__(self, store: S3Store) -> None:
        self._store = store

    def of(self, key: str) -> list[tuple[int, int]]:
        """Begin and size of each, from the file's begin on, without a gap."""
        with reached("read the upload"):
            listed = [each for some in obstore.list(self._store, f"{FOLDER}/{key}") for each in some]
        found, end = list[tuple[int, int]](), 0
        for begin, size in sorted((int(each["path"].rpartition("/")[2]), each["size"]) for each in listed):
            if begin == end:
                found.append((begin, size))
                end += size
        return found

    def end(self, key: str) -> int:
        """Bytes that have arrived."""
        return sum(size for _, size in self.of(key))

    def send(self, key: str, file: BinaryIO, begin: int) -> None:
        """All of the file from there on. InUse where another was quicker."""
        file.seek(begin)
        while data := file.read(LARGEST):
            try:
                with reached("store the upload"):
                    obstore.put(self._store, name_of(key, begin), data, mode="create")
            except AlreadyExistsError as error:
                raise InUse(key) from error
            begin += len(data)

    def read(self, key: str, begin: int) -> bytes:
        with reached("read the upload"):
            return bytes(obstore.get(self._store, name_of(key, begin)).bytes())

    def drop(self, key: str) -> None:
        with reached("remove the upload"):
            listed = [each["path"] for some in obstore.list(self._store, f"{FOLDER}/{key}") for each in some]
            for path in listed:
                with suppress(FileNotFoundError):
                    obstore.delete(self._store, path)

    def keys(self) -> list[str]:
        """Of uploads of which anything is there."""
        with reached("list the uploads"):
            found = obstore.list_with_delimiter(self._store, FOLDER)["common_prefixes"]
        return [path.rpartition("/")[2] for path in found]


def name_of(key: str, begin: int) -> str:
    return f"{FOLDER}/{key}/{begin:015d}"
