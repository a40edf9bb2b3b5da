"""A store that says nothing holds up few of those who ask, and the others are told at once."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import final

import pytest
from obstore.exceptions import AlreadyExistsError, GenericError
from tests.object_store import BUCKET, KEYS

from exogauge.errors import Away, NotFound
from exogauge.settings import Settings
from exogauge.storage.reach import MOST_WAITING, SILENT_S, Reach
from exogauge.storage.store import blobs_of


@final
class Clock:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@final
class Callers:
    """Each as of a thread of its own: calls that have begun, and wait."""

    def __init__(self, reach: Reach) -> None:
        self.reach, self.waiting, self.let_in = reach, ExitStack(), 0

    def one_more(self) -> None:
        self.waiting.enter_context(self.reach.room("read the file"))
        self.reach._mine.has = False
        self.let_in += 1


@pytest.fixture
def callers(clock: Clock) -> Iterator[Callers]:
    found = Callers(Reach(clock))
    with found.waiting:
        yield found


def test_of_a_store_that_answers_however_many_may_ask(callers: Callers, clock: Clock) -> None:
    for _ in range(3 * MOST_WAITING):
        callers.one_more()
        clock.now += SILENT_S / 2
        with callers.reach("read the file"):
            pass
    assert callers.let_in == 3 * MOST_WAITING


def test_a_burst_after_a_long_quiet_time_is_let_in(callers: Callers, clock: Clock) -> None:
    clock.now += 3600.0
    for _ in range(3 * MOST_WAITING):
        callers.one_more()
    assert callers.let_in == 3 * MOST_WAITING


def test_of_a_silent_store_so_many_wait_and_the_next_is_told_at_once(callers: Callers, clock: Clock) -> None:
    for _ in range(MOST_WAITING):
        callers.one_more()
    clock.now += 2 * SILENT_S
    with pytest.raises(Away, match="does not answer"):
        callers.one_more()
    callers.waiting.close()
    with callers.reach("read the file"):
        pass


def test_after_one_has_waited_in_vain_the_next_is_told_at_once_and_soon_one_asks_again(
    callers: Callers, clock: Clock
) -> None:
    def in_vain() -> None:
        with callers.reach("read the file"):
            clock.now += 2 * SILENT_S
            raise GenericError("timed out")

    with pytest.raises(Away):
        in_vain()
    before = clock.now
    with pytest.raises(Away):
        in_vain()
    assert clock.now == before
    clock.now += 2 * SILENT_S
    with callers.reach("read the file"):
        pass
    in_vain_again = pytest.raises(Away)
    with in_vain_again:
        in_vain()
    clock.now += 0.1
    callers.reach._answered = clock.now  # of a call that began before
    with callers.reach("read the file"):
        pass


@pytest.mark.parametrize(
    ("said", "sha256", "told"),
    [
        (FileNotFoundError("no key"), "0" * 64, NotFound),
        (FileNotFoundError("no bucket"), None, Away),
        (AlreadyExistsError("there"), None, AlreadyExistsError),
        (GenericError("500"), "0" * 64, Away),
        (ConnectionResetError(), None, Away),
    ],
)
def test_what_a_store_says_is_told(
    callers: Callers, said: Exception, sha256: str | None, told: type[Exception]
) -> None:
    with pytest.raises(told), callers.reach("read the file", sha256):
        raise said
    with callers.reach("read the file"):  # said at once, so the next is asked
        pass


@pytest.mark.slow  # waits for it
def test_a_store_that_takes_calls_and_says_nothing_is_told_in_seconds(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0), backlog=100) as silent:
        endpoint = f"http://127.0.0.1:{silent.getsockname()[1]}"
        blobs = blobs_of(Settings(data_dir=tmp_path, blob_url=f"s3://{BUCKET}/x", s3_endpoint=endpoint, **KEYS))
        began = time.monotonic()
        with pytest.raises(Away, match="does not answer"):
            blobs.path_for("0" * 64)
        assert time.monotonic() - began < 30.0  # three times the silence of one try
        began = time.monotonic()
        for _ in range(50):
            with pytest.raises(Away, match="does not answer"):
                blobs.exists("0" * 64)
        assert time.monotonic() - began < 2.0
