"""The database engine: one factory for SQLite and PostgreSQL, and the facts that make both behave alike.

SQLite: write-ahead log, `BEGIN IMMEDIATE` (a deferred BEGIN fails at once when it turns into a write), foreign keys on,
30 s of patience, synchronous=FULL because an acknowledged upload must survive a power cut. A connection or session with
the execution option `readonly=True` begins deferred and never waits for the writer.
Neither database protects a read-modify-write: change rows with `UPDATE … WHERE <what must still hold>`.
"""

from __future__ import annotations

import logging
import math
import select
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, final

import sqlalchemy as sa
from pydantic_core import from_json
from sqlalchemy import event
from sqlalchemy.engine import URL, Connection, Dialect, Engine, make_url
from sqlalchemy.exc import DBAPIError, DisconnectionError, InterfaceError, OperationalError
from sqlalchemy.orm import Session
from sqlalchemy.types import TypeDecorator

from exogauge.errors import DiskFull, Unavailable
from exogauge.storage.row_security import ALL, ROLE, SETTING, seeing

log = logging.getLogger(__name__)

NAMING = {
    "ix": "ix_%(table_name)s_%(column_0_N_name)s",
    "uq": "uq_%(table_name)s_%(column_0_N_name)s",
    "ck": "ck_%(table_name)s_%(constraint_name)s",
    "fk": "fk_%(table_name)s_%(column_0_N_name)s_%(referred_table_name)s",
    "pk": "pk_%(table_name)s",
}
PRAGMAS = ("journal_mode=WAL", "synchronous=FULL", "busy_timeout=30000", "foreign_keys=ON")
DISK_FULL, NO_SUCH_ROW = "53100", "23503"  # PostgreSQL's SQLSTATE
READONLY, LAB = "readonly", "lab"  # execution options of a transaction: it does not write; whose rows it sees
TRUSTED_S = 5.0  # judgement: a connection that answered so lately is not asked whether it still does
# judgement: how soon either end sees that the line between them was cut, longer than a network stumbles; by itself the
# system waits 15 minutes for an answer, and the server keeps a dead client's locks for two hours
CUT_S = 20
KEPT_ALIVE = {"idle": 10, "interval": 3, "count": 3}


@final
class UtcDateTime(TypeDecorator[datetime]):
    """Aware UTC in Python on both databases; a naive value is refused instead of guessed."""

    impl = sa.DateTime(timezone=True)
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        if value is None:
            return None
        if value.tzinfo is None:
            raise ValueError("a time needs its zone; use datetime.now(UTC)")
        value = value.astimezone(UTC)
        return value.replace(tzinfo=None) if dialect.name == "sqlite" else value

    def result_processor(self, dialect: Dialect, coltype: object) -> Callable[[Any], datetime | None]:
        """One call for each value: there are hundreds of them in a list."""
        return _of_text if dialect.name == "sqlite" else _in_utc


def _of_text(text: str | None) -> datetime | None:
    return None if text is None else datetime.fromisoformat(f"{text}+00:00")


def _in_utc(value: datetime | None) -> datetime | None:
    return None if value is None else value.astimezone(UTC)


@final
class FiniteFloat(TypeDecorator[float]):
    """A float that is a number: SQLite would store NaN as NULL, PostgreSQL would keep it."""

    impl = sa.Float(53)
    cache_ok = True

    def process_bind_param(self, value: float | None, dialect: Dialect) -> float | None:
        if value is not None and not math.isfinite(value):
            raise ValueError("not a finite number; store its absence instead")
        return value


def database_url(text: str) -> URL:
    """The SQLAlchemy address of `sqlite:///…` or `postgresql://…` (psycopg 3)."""
    url = make_url(text)
    if url.drivername in ("postgres", "postgresql"):
        url = url.set(drivername="postgresql+psycopg")
    if url.get_backend_name() not in ("sqlite", "postgresql"):
        raise ValueError(f"database {url.get_backend_name()!r} is not supported; use sqlite or postgresql")
    if url.get_backend_name() == "sqlite" and url.database in (None, "", ":memory:"):
        raise ValueError("an in-memory SQLite database cannot be shared with workers; name a file")
    return url


def make_engine(text: str, *, migrating: bool = False) -> Engine:
    """An engine with the behaviour described above. migrating: foreign keys are off on SQLite, and on PostgreSQL the
    tables' owner works, and sees the rows of all labs."""
    url = database_url(text)
    if url.get_backend_name() == "postgresql":
        role = f"-c {SETTING}={ALL}" if migrating else f"-c role={ROLE}"
        sees_cuts = seeing_cuts()
        options = f"-c timezone=UTC -c idle_in_transaction_session_timeout=600000 {role} {sees_cuts.pop('options')}"
        engine = sa.create_engine(
            url, pool_size=10, json_deserializer=from_json,
            connect_args={"connect_timeout": 5, "options": options, **sees_cuts},
        )  # fmt: skip
        begin_in_one(engine)
        ask_the_idle(engine)
        return engine
    assert url.database is not None
    Path(url.database).absolute().parent.mkdir(parents=True, exist_ok=True)
    engine = sa.create_engine(url, pool_size=10, json_deserializer=from_json)
    pragmas = PRAGMAS if not migrating else tuple(p.replace("foreign_keys=ON", "foreign_keys=OFF") for p in PRAGMAS)

    @event.listens_for(engine, "connect")
    def configure(connection: Any, _record: Any) -> None:
        connection.isolation_level = None  # the driver's own implicit BEGIN is off; ours follows
        for pragma in pragmas:
            connection.execute(f"PRAGMA {pragma}")

    @event.listens_for(engine, "begin")
    def begin(connection: Connection) -> None:
        readonly = connection.get_execution_options().get(READONLY)
        connection.exec_driver_sql("BEGIN" if readonly else "BEGIN IMMEDIATE")

    return engine


def seeing_cuts() -> dict[str, str]:
    """Parameters of a connection to PostgreSQL by which client and server see soon that the line was cut."""
    alive = {f"keepalives_{name}": str(value) for name, value in KEPT_ALIVE.items()}
    alive["tcp_user_timeout"] = str(1000 * CUT_S)
    there = (f"-c {name if name.startswith('tcp') else 'tcp_' + name}={value}" for name, value in alive.items())
    return {**alive, "options": " ".join(there)}


def begin_in_one(engine: Engine) -> None:
    """PostgreSQL: BEGIN and what the transaction may see go there in one message; the driver would send each alone."""

    @event.listens_for(engine, "connect")
    def configure(connection: Any, _record: Any) -> None:
        connection.autocommit = True  # the driver's own implicit BEGIN is off; ours follows

    @event.listens_for(engine, "begin")
    def begin(connection: Connection) -> None:
        options, statements = connection.get_execution_options(), []
        if getattr(
            connection.connection.driver_connection, "autocommit", False
        ):  # off where an isolation level is asked
            statements.append("BEGIN READ ONLY" if options.get(READONLY) else "BEGIN")
        if LAB in options:
            statements.append(seeing(options[LAB]))
        if statements:
            connection.exec_driver_sql("; ".join(statements))


def ask_the_idle(engine: Engine) -> None:
    """Whether a connection is still there is asked where it was not used just now, or where its socket has something to
    say while nobody asked: a server that ends a connection says so, or the system does for it. One that is gone is
    replaced, and whoever wanted it learns nothing of that."""

    @event.listens_for(engine, "checkin")
    def note(_connection: Any, record: Any) -> None:
        record.info["used"] = time.monotonic()

    @event.listens_for(engine, "checkout")
    def ask(connection: Any, record: Any, _fairy: Any) -> None:
        if connection is None:
            return
        lately = time.monotonic() - record.info.get("used", -math.inf) < TRUSTED_S
        try:
            if not lately or not silent(connection.fileno()):
                engine.dialect.do_ping(connection)
        except engine.dialect.loaded_dbapi.Error as error:
            raise DisconnectionError("the connection was lost while nobody used it") from error


def silent(socket: int) -> bool:
    """Whether there is nothing to be read from it, not even its end."""
    looking = select.poll()
    looking.register(socket, select.POLLIN)
    return not looking.poll(0)


@contextmanager
def serving(what: str) -> Iterator[None]:
    """Turn a database that is away, locked or full into `Unavailable`; other database errors pass as they are."""
    try:
        yield
    except (OperationalError, InterfaceError) as error:
        raise away(error, what) from error
    except DBAPIError as error:
        if error.connection_invalidated:
            raise away(error, what) from error
        raise
    except sa.exc.TimeoutError as error:
        raise Unavailable(f"the database cannot {what} now: all connections are in use") from error


def away(error: DBAPIError, what: str = "answer") -> Unavailable:
    """What a user is told; the driver's words name hosts, ports and files, and go into the log alone."""
    words = (str(error.orig).strip().splitlines() or [type(error).__name__])[0]
    log.warning("the database cannot %s now: %s", what, words)
    if "disk is full" in words or getattr(error.orig, "sqlstate", None) == DISK_FULL:
        return DiskFull(f"the database cannot {what} now: the disk is full")
    return Unavailable(f"the database cannot {what} now")


def refers_to_nothing(error: DBAPIError) -> bool:
    """A row names another that is not there; where both were looked at before, that one was deleted just now."""
    return getattr(error.orig, "sqlstate", None) == NO_SUCH_ROW or "FOREIGN KEY constraint" in str(error.orig)


def database_now(session: Session) -> datetime:
    """The database's clock, aware UTC: the one clock that all processes share (leases need it)."""
    if session.get_bind().dialect.name == "sqlite":
        text = session.execute(sa.text("SELECT strftime('%Y-%m-%d %H:%M:%f', 'now')")).scalar_one()
        return datetime.fromisoformat(text).replace(tzinfo=UTC)
    now: datetime = session.execute(sa.text("SELECT clock_timestamp()")).scalar_one()
    return now.astimezone(UTC)
