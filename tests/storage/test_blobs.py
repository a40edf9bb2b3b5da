"""A hash that is there holds all its bytes, whoever was killed when."""

from __future__ import annotations

import hashlib
import io
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from exogauge.errors import BadStudy, NotFound, TooLarge, Unavailable
from exogauge.storage.blobs import FolderBlobs, copy_out
from exogauge.storage.files import PinnedFile, content_hash, keep_folder, safe_path

WRITER = """
import sys
from pathlib import Path
from exogauge.storage.blobs import FolderBlobs
blobs, acknowledged = FolderBlobs(Path(sys.argv[1])), open(sys.argv[2], "a")
for k in range(100_000):
    print(blobs.put(bytes([k % 251]) * 300_000 + str(k).encode()), file=acknowledged, flush=True)
"""


@pytest.fixture
def blobs(tmp_path: Path) -> FolderBlobs:
    return FolderBlobs(tmp_path / "blobs")


def test_what_is_put_comes_back_under_its_hash(blobs: FolderBlobs, tmp_path: Path) -> None:
    content = os.urandom(3_000_000)
    (tmp_path / "file").write_bytes(content)
    names = {blobs.put(content), blobs.put(tmp_path / "file"), blobs.put(io.BytesIO(content))}
    assert names == {hashlib.sha256(content).hexdigest()}
    (name,) = names
    assert read(blobs, name) == content
    assert blobs.size(name) == len(content)
    assert list(blobs.iterate()) == [name]
    assert list(blobs.incoming.iterdir()) == []
    copy_out(blobs, name, tmp_path / "a" / "copy")
    assert (tmp_path / "a" / "copy").read_bytes() == content
    blobs.delete(name)
    assert not blobs.exists(name)


@pytest.mark.parametrize("name", ["0" * 64, "../../etc/passwd", "", "A" * 64, "0" * 63 + "/"])
def test_a_name_that_is_no_blob_opens_no_file(blobs: FolderBlobs, name: str) -> None:
    for ask in (blobs.open, blobs.size, blobs.path_for):
        with pytest.raises(NotFound):
            ask(name)


def test_too_much_is_refused_and_leaves_nothing(blobs: FolderBlobs) -> None:
    with pytest.raises(TooLarge):
        blobs.put(bytes(1001), limit=1000)
    assert list(blobs.iterate()) == list(blobs.incoming.iterdir()) == []


def test_a_full_disk_is_unavailable_and_leaves_nothing(blobs: FolderBlobs, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(Unavailable, match="disk is full"):
        blobs.put(b"some")
    assert list(blobs.iterate()) == list(blobs.incoming.iterdir()) == []


def test_kill_9_loses_and_corrupts_nothing(blobs: FolderBlobs, tmp_path: Path) -> None:
    acknowledged = tmp_path / "acknowledged"
    for round_ in range(4):
        writer = subprocess.Popen([sys.executable, "-c", WRITER, str(blobs.folder), str(acknowledged)])
        started = time.monotonic()
        while not (acknowledged.exists() and acknowledged.read_text().count("\n") > 5 * round_):
            assert time.monotonic() - started < 30
            time.sleep(0.01)
        time.sleep(0.003 * round_)
        writer.send_signal(signal.SIGKILL)
        writer.wait()
    promised = [line for line in acknowledged.read_text().splitlines() if len(line) == 64]
    there = set(blobs.iterate())
    assert len(promised) > 10  # the same contents again and again: a slow disk repeats its first ones
    assert set(promised) <= there
    for name in there:
        assert hashlib.sha256(read(blobs, name)).hexdigest() == name


def test_the_content_hash_depends_on_paths_and_bytes_and_not_on_order() -> None:
    a, b = PinnedFile("a", "1" * 64, 1), PinnedFile("b", "2" * 64, 2)
    assert content_hash([a, b]) == content_hash([b, a])
    assert content_hash([a, b]) != content_hash([PinnedFile("a", "2" * 64, 2), PinnedFile("b", "1" * 64, 1)])


def test_a_folder_is_kept_without_its_links(blobs: FolderBlobs, tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    (folder / "in").mkdir(parents=True)
    (folder / "in" / "file").write_bytes(b"1")
    (folder / "link").symlink_to("/etc/passwd")
    assert [file.path for file in keep_folder(blobs, folder)] == ["in/file"]


@pytest.mark.parametrize("path", ["", "/a", "../a", "a/..", "a/./b", "a//b", "a\\b", "C:a", "a\0b", "a\nb", "a/" * 20])
def test_an_unsafe_path_is_refused(path: str) -> None:
    with pytest.raises(BadStudy):
        safe_path(path)


def read(blobs: FolderBlobs, name: str) -> bytes:
    with blobs.open(name) as stream:
        return stream.read()
