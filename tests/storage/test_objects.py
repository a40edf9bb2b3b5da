"""Blobs in an object store: the same as in a folder, on every machine; what the store lacks or spoils is told."""

from __future__ import annotations

import hashlib
import io
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import obstore
import pytest
from obstore.store import LocalStore
from tests.object_store import BUCKET, KEYS, Line, s3_server

from exogauge.errors import NotFound, TooLarge, Unavailable
from exogauge.settings import Settings
from exogauge.storage.blobs import copy_out
from exogauge.storage.held_files import OwnFolder
from exogauge.storage.objects import PART, ObjectBlobs, Stores, key_of
from exogauge.storage.store import blobs_of

ROOM = 40_000_000


@pytest.fixture
def away(tmp_path: Path) -> Any:
    """The place where objects are: a folder that is asked as an object store is."""
    return LocalStore(str(tmp_path / "away"), mkdir=True)


def machine(tmp_path: Path, away: Any, name: str = "here", kept_bytes: int = ROOM) -> ObjectBlobs:
    return ObjectBlobs(
        Stores(away, away), tmp_path / name / "copies", kept_bytes, OwnFolder(tmp_path / name / "sending")
    )


def files_below(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file() and path.name != ".held")


def test_what_one_machine_puts_another_reads(tmp_path: Path, away: Any) -> None:
    content = os.urandom(3_000_000)
    (tmp_path / "file").write_bytes(content)
    here, there = machine(tmp_path, away), machine(tmp_path, away, "there")
    names = {here.put(content), here.put(tmp_path / "file"), here.put(io.BytesIO(content))}
    assert names == {hashlib.sha256(content).hexdigest()}
    (name,) = names
    for blobs in (here, there):
        assert blobs.exists(name)
        assert blobs.size(name) == len(content)
        assert list(blobs.iterate()) == list(blobs.iterate(name[:1])) == list(blobs.iterate(name[:2])) == [name]
        for opened in (blobs.open(name), blobs.stored(name)):
            with opened:
                assert opened.read() == content
    copy_out(there, name, tmp_path / "a" / "copy")
    assert (tmp_path / "a" / "copy").read_bytes() == content
    assert there.lacking([name, "0" * 64]) == {"0" * 64}
    here.delete(name)
    here.delete(name)
    assert not there.exists(name)
    with pytest.raises(NotFound):
        machine(tmp_path, away, "third").open(name)
    assert files_below(tmp_path / "here") == []


def test_a_file_is_fetched_once(tmp_path: Path, away: Any) -> None:
    name = machine(tmp_path, away).put(b"some")
    there = machine(tmp_path, away, "there")
    path = there.path_for(name)
    obstore.delete(away, key_of(name))  # whoever would fetch it again found nothing
    assert there.path_for(name) == path
    assert path is not None
    assert path.read_bytes() == b"some"


def test_copies_keep_to_their_room_and_a_larger_file_is_read_where_it_is(tmp_path: Path, away: Any) -> None:
    here, there = machine(tmp_path, away), machine(tmp_path, away, "there", 4000)
    names = [here.put(os.urandom(900)) for _ in range(9)]
    for name in names:
        with there.open(name) as stream:
            assert hashlib.sha256(stream.read()).hexdigest() == name
        assert sum(path.stat().st_size for path in files_below(tmp_path / "there")) <= 4000
    large = here.put(os.urandom(5000))
    assert there.path_for(large) is None
    with there.open(large) as stream:
        assert hashlib.sha256(stream.read()).hexdigest() == large


def test_a_full_disk_of_copies_keeps_nobody_from_reading(
    tmp_path: Path, away: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    name, there = machine(tmp_path, away).put(b"some"), machine(tmp_path, away, "there")

    def full(_descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    assert there.path_for(name) is None
    with there.open(name) as stream:
        assert stream.read() == b"some"
    with pytest.raises(Unavailable, match="disk is full"):
        there.put(b"other")
    assert files_below(tmp_path / "there") == []


def test_a_damaged_object_is_no_file(tmp_path: Path, away: Any) -> None:
    name = machine(tmp_path, away).put(b"some")
    obstore.put(away, key_of(name), b"same")
    there = machine(tmp_path, away, "there")
    with pytest.raises(Unavailable, match="damaged"):
        there.path_for(name)
    assert files_below(tmp_path / "there") == []


def test_too_much_is_refused_and_leaves_nothing(tmp_path: Path, away: Any) -> None:
    here = machine(tmp_path, away)
    with pytest.raises(TooLarge):
        here.put(bytes(1001), limit=1000)
    assert list(here.iterate()) == files_below(tmp_path) == []


@pytest.mark.parametrize("name", ["0" * 64, "../../etc/passwd", "", "A" * 64, "0" * 63 + "/"])
def test_a_name_that_is_no_blob_opens_nothing(tmp_path: Path, away: Any, name: str) -> None:
    here = machine(tmp_path, away)
    for ask in (here.open, here.stored, here.size, here.path_for):
        with pytest.raises(NotFound):
            ask(name)


@pytest.fixture(scope="module")
def line() -> Iterator[Line]:
    with s3_server() as port:
        line = Line(port)
        yield line
        line.close()


def settings_for(line: Line, folder: Path, **more: Any) -> Settings:
    return Settings(data_dir=folder, blob_url=f"s3://{BUCKET}/lab", s3_endpoint=line.endpoint, **KEYS, **more)


@pytest.mark.slow  # starts a server
def test_s3_keeps_small_and_large_files_whole(line: Line, tmp_path: Path) -> None:
    here, there = (blobs_of(settings_for(line, tmp_path / name)) for name in ("here", "there"))
    for size in (0, 1, PART, PART + 1, 3 * PART + 17):
        content = os.urandom(size)
        name = here.put(content)
        assert here.put(io.BytesIO(content)) == name
        with there.open(name) as stream:
            assert hashlib.sha256(stream.read()).hexdigest() == name
        assert there.size(name) == size
        assert name in list(there.iterate(name[:2]))
        here.delete(name)
        assert there.lacking([name]) == {name}


@pytest.mark.slow  # starts a server
def test_a_store_that_is_cut_off_is_told_soon_and_works_again(line: Line, tmp_path: Path) -> None:
    here = blobs_of(settings_for(line, tmp_path / "here"))
    name = here.put(b"kept")
    line.cut()
    started = time.monotonic()
    for ask in (
        lambda: here.put(b"other"),
        lambda: here.exists(name),
        here.refuse_if_full,
        lambda: list(here.iterate()),
    ):
        with pytest.raises(Unavailable, match="object store"):
            ask()
    assert time.monotonic() - started < 40.0
    assert here.path_for(name) is not None  # what lies here already is read
    line.mend()
    here.refuse_if_full()
    assert here.exists(here.put(b"other"))


@pytest.mark.slow  # starts a server
def test_a_bucket_that_is_not_there_is_told(line: Line, tmp_path: Path) -> None:
    settings = Settings(data_dir=tmp_path, blob_url="s3://no-such-bucket", s3_endpoint=line.endpoint, **KEYS)
    blobs = blobs_of(settings)
    for ask in (lambda: blobs.put(b"some"), blobs.refuse_if_full):
        with pytest.raises(Unavailable, match="bucket"):
            ask()
