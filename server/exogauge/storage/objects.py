"""Blobs in an S3-compatible store, with a shelf of copies on this machine.

An object is put whole or not at all, under the hash of its bytes, so that putting it twice changes nothing. What is
read is fetched once onto the shelf, and compared with its hash there. Parts of an upload that was killed are not
listed by the store: a lifecycle rule of the bucket removes them.

What has arrived of an upload, where several servers see it, is an object per piece, named by where it begins: there
whole or not at all and never replaced, so that of two who send the same place one is told so.
"""

from __future__ import annotations

import io
import math
import os
from collections.abc import Collection, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import TYPE_CHECKING, BinaryIO, cast, final

import obstore
from obstore.exceptions import AlreadyExistsError
from obstore.store import S3Store

from exogauge.errors import NotFound, Unavailable
from exogauge.settings import Settings
from exogauge.storage.blobs import CHUNK, SHA256_HEX, InUse, copy_hashed, disk, refuse_full
from exogauge.storage.held_files import OwnFolder
from exogauge.storage.reach import Reach
from exogauge.storage.shelf import Shelf

if TYPE_CHECKING:
    from obstore.store import ClientConfig, S3Config

PART = 8 << 20  # bytes of one part of an upload; what is smaller is put at once, unless it is there
PARTS_AT_ONCE = 4  # judgement: with PART, 32 MB of memory for one upload
ASKED_AT_ONCE = 16  # judgement: whether blobs are there, a round trip each
LARGEST_SHARE = 0.25  # judgement: of the shelf that one blob may take; a larger one is read where it is
DIGITS = "0123456789abcdef"
COPY = ".blob"


@final
@dataclass(frozen=True)
class Stores:
    """One place, reached in two ways. asked: what it says comes piece by piece, and silence ends the call soon, however
    much there is. sent: it says nothing until it has all that was sent, so the whole call has a time."""

    asked: S3Store
    sent: S3Store


def store_of(settings: Settings) -> Stores:
    """A request is tried three times within ten seconds: whoever asked is told, and workers try again by themselves."""
    silence, whole, ever = "5s", "60s", "1day"  # judgement: 32 MiB, the most that is sent in one, at 4 Mbit/s
    return Stores(
        asked=_store(settings, {"read_timeout": silence, "timeout": ever}), sent=_store(settings, {"timeout": whole})
    )


def _store(settings: Settings, times: dict[str, str]) -> S3Store:
    given: S3Config = {
        "endpoint": settings.s3_endpoint,
        "region": settings.s3_region,
        "access_key_id": settings.s3_access_key_id,
        "secret_access_key": settings.s3_secret_access_key,
    }
    return S3Store.from_url(
        settings.blob_url,
        config=cast("S3Config", {name: value for name, value in given.items() if value}),
        client_options=cast(
            "ClientConfig",
            {"allow_http": settings.s3_endpoint.startswith("http://"), "connect_timeout": "2s", **times},
        ),
        retry_config={
            "max_retries": 2,
            "retry_timeout": timedelta(seconds=10),
            "backoff": {"init_backoff": timedelta(milliseconds=100), "max_backoff": timedelta(seconds=1), "base": 2},
        },
    )


@final
class ObjectBlobs:
    """folder: of this machine, for the shelf of at most `kept_bytes`. sending: for what is being sent, beside it."""

    def __init__(self, stores: Stores, folder: Path, kept_bytes: int, sending: OwnFolder) -> None:
        self._asked, self._sent = stores.asked, stores.sent
        self._largest, self._sending = LARGEST_SHARE * kept_bytes, sending
        self._shelf = Shelf(folder, kept_bytes, COPY, at_once=PARTS_AT_ONCE, most=math.inf)
        self._reached = Reach()
        self._pieces = SharedPieces(stores, self._reached)

    @property
    def pieces(self) -> SharedPieces:
        return self._pieces

    def put(self, source: bytes | Path | BinaryIO, limit: int | None = None) -> str:
        with disk("store the file"), NamedTemporaryFile(dir=self._sending.path, delete=False) as temporary:
            try:
                sha256 = copy_hashed(source, temporary, limit)
                temporary.flush()
                os.fsync(temporary.fileno())
                self._send(Path(temporary.name), sha256, temporary.tell())
                if temporary.tell() <= self._largest:
                    self._shelf.filled(sha256, lambda path: os.replace(temporary.name, path))
            finally:
                Path(temporary.name).unlink(missing_ok=True)
        return sha256

    def _send(self, path: Path, sha256: str, size: int) -> None:
        if self.exists(sha256):
            return
        with self._reached("store the file"), suppress(AlreadyExistsError):
            if size <= PART:
                obstore.put(self._sent, key_of(sha256), path, mode="create")
            else:
                obstore.put(self._sent, key_of(sha256), path, chunk_size=PART, max_concurrency=PARTS_AT_ONCE)

    def open(self, sha256: str) -> BinaryIO:
        if (path := self.path_for(sha256)) is not None:
            with suppress(FileNotFoundError):  # off the shelf again, for others
                return path.open("rb")
        return self.stored(sha256)

    def stored(self, sha256: str) -> BinaryIO:
        with self._reached("read the file", sha256):
            found = obstore.get(self._asked, key_of(sha256))
        return io.BufferedReader(Fetched(map(bytes, found.stream(min_chunk_size=CHUNK)), sha256, self._reached), CHUNK)

    def path_for(self, sha256: str) -> Path | None:
        """None where the shelf has no room for it."""
        key_of(sha256)
        if (there := self._shelf.found(sha256)) is not None:
            return there
        try:
            with self._reached.room("read the file"):
                return self._shelf.filled(sha256, lambda path: self._fetch(sha256, path))
        except NoRoom:
            return None

    def _fetch(self, sha256: str, path: Path) -> None:
        if self.size(sha256) > self._largest:
            raise NoRoom
        with self.stored(sha256) as source:
            try:
                with path.open("wb") as copy:
                    found = copy_hashed(source, copy)
                    copy.flush()
                    os.fsync(copy.fileno())
            except OSError as error:
                raise NoRoom from error
        if found != sha256:
            raise Unavailable(f"the file {sha256} is damaged in the object store: `exogauge check` says which are")

    def size(self, sha256: str) -> int:
        with self._reached("read the file", sha256):
            return obstore.head(self._asked, key_of(sha256))["size"]

    def exists(self, sha256: str) -> bool:
        try:
            self.size(sha256)
        except NotFound:
            return False
        return True

    def lacking(self, names: Collection[str]) -> set[str]:
        with ThreadPoolExecutor(ASKED_AT_ONCE) as several:
            return {name for name, there in zip(names, several.map(self.exists, names), strict=True) if not there}

    def delete(self, sha256: str) -> None:
        with self._reached("remove the file"), suppress(FileNotFoundError):
            obstore.delete(self._asked, key_of(sha256))
        self._shelf.drop(sha256)

    def refuse_if_full(self) -> None:
        with disk("store files"):
            refuse_full(self._sending.path)
        with self._reached("store files"):
            for _ in obstore.list(self._asked, "asked"):  # nothing is there; a bucket that is gone is told
                break

    def iterate(self, prefix: str = "") -> Iterator[str]:
        if len(prefix) < 2:
            for digit in DIGITS:
                yield from self.iterate(prefix + digit)
            return
        found = list[str]()
        with self._reached("list the files"):
            for some in obstore.list(self._asked, prefix):
                found += [each["path"].replace("/", "") for each in some]
        yield from sorted(name for name in found if SHA256_HEX.fullmatch(name))

    def left_over(self) -> list[str]:
        """Nothing: what a killed process was sending lies in its own folder."""
        return []

    def remove_left_over(self, name: str) -> None:
        raise NotFound(f"nothing is left over: {name}")


class NoRoom(Exception):
    """On the shelf."""


@final
class Fetched(io.RawIOBase):
    """The bytes of an object as they come."""

    def __init__(self, chunks: Iterator[bytes], sha256: str, reached: Reach) -> None:
        self._chunks, self._sha256, self._reached = chunks, sha256, reached
        self._left = memoryview(b"")

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: memoryview) -> int:  # type: ignore[override]  # any buffer, says typeshed
        while not self._left:
            with self._reached("read the file", self._sha256):
                chunk = next(self._chunks, None)
            if chunk is None:
                return 0
            self._left = memoryview(chunk)
        size = min(len(buffer), len(self._left))
        buffer[:size] = self._left[:size]
        self._left = self._left[size:]
        return size


def key_of(sha256: str) -> str:
    """As in a folder: `ab/cdef…`."""
    if not SHA256_HEX.fullmatch(sha256):
        raise NotFound("not the name of a blob")
    return f"{sha256[:2]}/{sha256[2:]}"


FOLDER = "uploads"
LARGEST = 32 << 20  # judgement: bytes of one object, which is sent from memory


@final
class SharedPieces:
    """Of all uploads in an object store."""

    def __init__(self, stores: Stores, reached: Reach) -> None:
        self._asked, self._sent, self._reached = stores.asked, stores.sent, reached

    def of(self, key: str) -> list[tuple[int, int]]:
        """Begin and size of each, from the file's begin on, without a gap."""
        with self._reached("read the upload"):
            listed = [each for some in obstore.list(self._asked, f"{FOLDER}/{key}") for each in some]
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
                with self._reached("store the upload"):
                    obstore.put(self._sent, name_of(key, begin), data, mode="create")
            except AlreadyExistsError as error:
                raise InUse(key) from error
            begin += len(data)

    def read(self, key: str, begin: int) -> bytes:
        with self._reached("read the upload"):
            return bytes(obstore.get(self._asked, name_of(key, begin)).bytes())

    def drop(self, key: str) -> None:
        with self._reached("remove the upload"):
            listed = [each["path"] for some in obstore.list(self._asked, f"{FOLDER}/{key}") for each in some]
            for path in listed:
                with suppress(FileNotFoundError):
                    obstore.delete(self._asked, path)

    def keys(self) -> list[str]:
        """Of uploads of which anything is there."""
        with self._reached("list the uploads"):
            found = obstore.list_with_delimiter(self._asked, FOLDER)["common_prefixes"]
        return [path.rpartition("/")[2] for path in found]


def name_of(key: str, begin: int) -> str:
    return f"{FOLDER}/{key}/{begin:015d}"
