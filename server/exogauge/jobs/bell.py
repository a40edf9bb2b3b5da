"""What a worker waits for: that a job was asked for. The queue's threads look when the bell has rung, at their own pace
for a little while after, and else seldom, in case that nobody heard it.

PostgreSQL rings by NOTIFY, in the transaction that writes the entry, so that it is heard once that has committed.
SQLite tells each connection whether another has written (`PRAGMA data_version`); one look at the entries that wait then
says whether it was that.
"""

from __future__ import annotations

import logging
import sqlite3
import threading
import time
from contextlib import closing
from typing import final

import psycopg
import sqlalchemy as sa
from sqlalchemy.engine import Engine
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session

log = logging.getLogger(__name__)
CHANNEL = "exogauge_jobs"
QUIET_S = 10.0  # judgement: between two looks while the bell is silent; the longest that a job waits if nobody heard it
BUSY_S = 5.0  # judgement: after it rang: another worker may have locked the queue in that very moment
LOOK_S = 0.25  # at SQLite's count of commits; docs/operations.md has what that costs
AGAIN_S = 5.0  # judgement: after the line broke
ASK_S = 60.0  # judgement: whether it still holds
WAITING = "SELECT 1 FROM workflow_status WHERE status = 'ENQUEUED' LIMIT 1"  # of the queue's own


@final
class Bell:
    """Rung by any thread; heard by all that wait, once each."""

    def __init__(self) -> None:
        self._rung = threading.Condition()
        self._times, self._last = 0, time.monotonic()
        self._heard = threading.local()

    def ring(self) -> None:
        with self._rung:
            self._times += 1
            self._last = time.monotonic()
            self._rung.notify_all()

    def wait(self, pace_s: float, stop: threading.Event) -> bool:
        """Until it rings, or the pace of whoever waits is over, or while all is quiet that of the bell; whether to
        stop, which nobody is in a hurry for: a worker ends with its process."""
        quiet = time.monotonic() - self._last > BUSY_S
        until = time.monotonic() + (max(pace_s, QUIET_S) if quiet else pace_s)
        heard = getattr(self._heard, "times", -1)
        with self._rung:
            while not stop.is_set() and self._times == heard and (left := until - time.monotonic()) > 0:
                self._rung.wait(left)
            self._heard.times = self._times
        return stop.is_set()


@final
class Patience:
    """The event by which DBOS tells its threads to stop, and on which they wait between two looks."""

    def __init__(self, stop: threading.Event, bell: Bell) -> None:
        self._stop, self._bell = stop, bell
        self.is_set, self.set = stop.is_set, stop.set

    def wait(self, timeout: float) -> bool:
        return self._bell.wait(timeout, self._stop)


def ring_when_committed(connection: sa.Connection | Session) -> None:
    """Of all workers, where the transaction ends well. SQLite's see that by themselves."""
    engine = connection.get_bind() if isinstance(connection, Session) else connection
    if engine.dialect.name == "postgresql":
        connection.execute(sa.select(sa.func.pg_notify(CHANNEL, "")))


def listen(engine: Engine, bell: Bell) -> None:
    """From now on, in a thread of its own; also after the database was away."""
    target = hear_notices if engine.dialect.name == "postgresql" else see_commits
    threading.Thread(target=target, args=(engine, bell), name="bell", daemon=True).start()


def hear_notices(engine: Engine, bell: Bell) -> None:
    while True:
        try:
            borrowed = engine.raw_connection()
            line = borrowed.driver_connection
            borrowed.detach()  # of the pool: it listens for as long as it lives
            assert isinstance(line, psycopg.Connection)
            with line:
                line.execute(f"LISTEN {CHANNEL}")
                bell.ring()  # for what came while nobody listened
                while True:
                    for _ in line.notifies(timeout=ASK_S):
                        bell.ring()
                    line.execute("SELECT 1")
        except (SQLAlchemyError, psycopg.Error) as error:
            log.warning("nobody tells of new jobs; the queue is looked at every %.0f s: %s", QUIET_S, error)
        time.sleep(AGAIN_S)


def see_commits(engine: Engine, bell: Bell) -> None:
    while True:
        try:
            with closing(engine.raw_connection()) as line:
                cursor, before = line.cursor(), None
                while True:
                    (now,) = cursor.execute("PRAGMA data_version").fetchone()
                    if now != before and cursor.execute(WAITING).fetchone() is not None:
                        bell.ring()
                    before = now
                    time.sleep(LOOK_S)
        except (SQLAlchemyError, sqlite3.Error) as error:
            log.warning("nobody tells of new jobs; the queue is looked at every %.0f s: %s", QUIET_S, error)
        time.sleep(AGAIN_S)
