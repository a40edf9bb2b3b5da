"""What can be made again is made once, and the oldest goes when there is no room."""

from __future__ import annotations

import os
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from exogauge.errors import Unavailable
from exogauge.storage.shelf import Shelf


def test_a_scene_is_made_once_however_many_ask(tmp_path: Path) -> None:
    shelf, made, together = Shelf(tmp_path / "scenes", 1000, ".scene"), list[int](), threading.Barrier(4)

    def make() -> bytes:
        made.append(1)
        return b"scene"

    def ask() -> None:
        together.wait()
        assert shelf.get("a", make).read_bytes() == b"scene"

    threads = [threading.Thread(target=ask) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert made == [1]


def test_the_scene_looked_at_longest_ago_goes_first(tmp_path: Path) -> None:
    shelf = Shelf(tmp_path, 25, ".scene")
    for age, key in ((300, "a"), (200, "b")):
        os.utime(shelf.get(key, lambda: b"x" * 10), (1e9 - age, 1e9 - age))
    shelf.get("a", lambda: b"")  # looked at again
    shelf.get("c", lambda: b"x" * 10)
    assert sorted(path.stem for path in tmp_path.iterdir()) == ["a", "c"]


def test_what_fails_is_not_kept(tmp_path: Path) -> None:
    shelf = Shelf(tmp_path, 1000, ".scene")

    def fail() -> bytes:
        raise ValueError("no")

    with pytest.raises(ValueError, match="no"):
        shelf.get("a", fail)
    assert shelf.get("a", lambda: b"now").read_bytes() == b"now"
    assert [path.name for path in tmp_path.iterdir()] == ["a.scene"]


def test_who_would_only_wait_for_others_is_sent_away_and_what_is_there_is_given(tmp_path: Path) -> None:
    shelf, begun, end = Shelf(tmp_path, 1000, ".scene", at_once=1, most=3), threading.Semaphore(0), threading.Event()
    shelf.get("there", lambda: b"scene")

    def slow() -> bytes:
        end.wait(30)
        return b"scene"

    def ask(key: str) -> None:
        begun.release()
        shelf.get(key, slow)

    with ThreadPoolExecutor(3) as pool:
        asked = [pool.submit(ask, key) for key in "abc"]
        for _ in asked:
            assert begun.acquire(timeout=30)
        until = time.monotonic() + 30
        while shelf._inside < 3 and time.monotonic() < until:
            time.sleep(0.01)
        with pytest.raises(Unavailable, match="try again"):
            shelf.get("d", lambda: b"scene")
        assert shelf.get("there", lambda: b"other").read_bytes() == b"scene"
        end.set()
        for each in asked:
            each.result()
    assert shelf.get("d", lambda: b"scene").read_bytes() == b"scene"
