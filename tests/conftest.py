"""Databases and an app for tests. The same tests run on SQLite and on PostgreSQL."""

from __future__ import annotations

import gc
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Generator, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING
from uuid import uuid4

import psycopg
import pytest
from tests.own_postgres import own_server

if TYPE_CHECKING:  # imported where used: most tests need no web and no database
    from fastapi import FastAPI
    from fastapi.testclient import TestClient

    from exogauge.settings import Settings
    from exogauge.storage.store import Storage

KINDS = ("sqlite", "postgresql")
QUICK_S, CPU_S = 2.0, "CPU seconds"  # what takes more than a sixth of it is slow, where nothing else runs
LONG = (  # CPU seconds of each: 80 to 30; the last one waits for most of its time
    "discrepancy/test_band_effects.py", "support/test_band_doubt.py", "synthetic/test_lab.py",
    "discrepancy/test_band_limit.py", "support/test_stiffness.py", "upkeep/test_backup.py",
    "support/declared/test_common_inputs.py", "discrepancy/test_sensor_effects.py", "motion/test_plan.py",
    "motion/test_other_robots.py", "api/test_live.py",
)  # fmt: skip
LOCAL = [
    f"postgresql://{user}@127.0.0.1:5432/postgres" for user in ("postgres", os.environ.get("USER", "root"), "root")
]


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """What is imported and collected stays to the end: looking through it for garbage again and again took a fifth of
    the CPU of collecting, and a twentieth of that of tests."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Quick tests run on SQLite; the slow ones hold the same on PostgreSQL. What is thorough is slow, too. What stands
    beside this file, whole samples above all, begins first, and what takes a minute or more: of the longest none is
    left for the end, when the other processes have nothing to do."""
    here, turn = Path(__file__).parent, {name: place for place, name in enumerate(LONG)}
    items.sort(
        key=lambda item: -1 if item.path.parent == here else turn.get(item.path.relative_to(here).as_posix(), len(LONG))
    )
    for item in items:
        values = item.callspec.params.values() if hasattr(item, "callspec") else ()
        if any(isinstance(each, str) and each == "postgresql" for each in values):
            item.add_marker(pytest.mark.slow)
        if item.get_closest_marker("thorough"):
            item.add_marker(pytest.mark.slow)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, object, object]:
    begun = time.process_time()
    try:
        return (yield)
    finally:
        if not item.get_closest_marker("slow"):
            item.user_properties.append((CPU_S, time.process_time() - begun))


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Nothing fails by its time: another machine, or one that has much else to do, is no fault."""
    for report in terminalreporter.getreports("passed"):
        taken = dict(report.user_properties).get(CPU_S, 0.0)
        if taken > QUICK_S:
            terminalreporter.write_line(
                f"{report.nodeid} took {taken:.1f} s of a processor: shorten it, or mark it slow"
            )


@pytest.fixture(scope="session")
def postgres_server() -> Iterator[str]:
    """The address of a PostgreSQL server: the one named in EXOGAUGE_TEST_POSTGRES_URL, one on this machine, or one
    started for this test run."""
    named = os.environ.get("EXOGAUGE_TEST_POSTGRES_URL")
    for url in [named] if named else LOCAL:
        if can_create_databases(url):
            yield url
            return
    if named:
        pytest.fail("EXOGAUGE_TEST_POSTGRES_URL names a server that cannot be used")
    with tempfile.TemporaryDirectory(prefix="exogauge-pg-") as folder, own_server(Path(folder)) as server:
        yield server.url()


def can_create_databases(url: str) -> bool:
    try:
        with psycopg.connect(url, connect_timeout=2) as connection:
            row = connection.execute(
                "SELECT rolcreatedb OR rolsuper FROM pg_roles WHERE rolname = current_user"
            ).fetchone()
            return bool(row and row[0])
    except psycopg.Error:
        return False


@pytest.fixture(scope="session")
def throw_away_database(postgres_server: str) -> Callable[..., AbstractContextManager[str]]:
    """(name of a database to copy) -> a context with the address of a new PostgreSQL database, empty without a name."""

    @contextmanager
    def create(copied: str = "template1") -> Iterator[str]:
        name = f"exogauge_test_{uuid4().hex[:12]}"
        with psycopg.connect(postgres_server, autocommit=True) as connection:
            connection.execute(f'CREATE DATABASE "{name}" TEMPLATE "{copied}"')
        yield postgres_server.rsplit("/", 1)[0] + f"/{name}"
        with psycopg.connect(postgres_server, autocommit=True) as connection:
            connection.execute(f'DROP DATABASE "{name}" WITH (FORCE)')

    return create


@pytest.fixture
def postgres_url(throw_away_database: Callable[..., AbstractContextManager[str]]) -> Iterator[str]:
    with throw_away_database() as url:
        yield url


@pytest.fixture(params=KINDS)
def empty_database_url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """The address of a new, empty database, on each kind in turn."""
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'test.sqlite'}"
    url: str = request.getfixturevalue("postgres_url")
    return url


@pytest.fixture(params=KINDS)
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """The address of a database with every table and no row, on each kind in turn."""
    return _migrated(request, tmp_path, "used_postgres_url")


@pytest.fixture(params=KINDS)
def own_database_url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """The same, of a test that changes tables."""
    return _migrated(request, tmp_path, "own_postgres_url")


def _migrated(request: pytest.FixtureRequest, folder: Path, on_postgres: str) -> str:
    """A copy of what was migrated once."""
    if request.param == "sqlite":
        shutil.copy(request.getfixturevalue("migrated_sqlite"), folder / "test.sqlite")
        return f"sqlite:///{folder / 'test.sqlite'}"
    url: str = request.getfixturevalue(on_postgres)
    return url


@pytest.fixture(scope="session")
def migrated_sqlite(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("migrated") / "test.sqlite"
    migrate_all(f"sqlite:///{path}")
    assert [each.name for each in path.parent.iterdir()] == ["test.sqlite"]  # nothing is left in a log beside it
    return path


@pytest.fixture(scope="session")
def migrated_postgres(throw_away_database: Callable[..., AbstractContextManager[str]]) -> Iterator[str]:
    """The name of a database to copy, which nobody else may be connected to."""
    with throw_away_database() as url:
        migrate_all(url)
        yield url.rsplit("/", 1)[1]


@pytest.fixture(scope="session")
def used_postgres(
    throw_away_database: Callable[..., AbstractContextManager[str]], migrated_postgres: str
) -> Iterator[str]:
    """The address of the copy that tests use one after the other: to make and drop one for each takes seconds."""
    with throw_away_database(migrated_postgres) as url:
        yield url


@pytest.fixture
def own_postgres_url(
    throw_away_database: Callable[..., AbstractContextManager[str]], migrated_postgres: str
) -> Iterator[str]:
    with throw_away_database(migrated_postgres) as url:
        yield url


@pytest.fixture
def used_postgres_url(request: pytest.FixtureRequest, used_postgres: str) -> str:
    own: str = used_postgres if emptied(used_postgres) else request.getfixturevalue("own_postgres_url")
    return own


def emptied(url: str) -> bool:
    """Take every row out of a migrated database and end whoever is still connected to it; only a superuser may, past
    the triggers that keep rows."""
    with psycopg.connect(url) as connection:
        try:
            connection.execute("SET session_replication_role = replica")
        except psycopg.errors.InsufficientPrivilege:
            return False
        connection.execute(
            "SELECT pg_terminate_backend(pid) FROM pg_stat_activity"
            " WHERE datname = current_database() AND pid <> pg_backend_pid()"
        )
        tables = connection.execute(
            "SELECT format('%I.%I', schemaname, tablename) FROM pg_tables WHERE schemaname IN ('public', 'dbos')"
            " AND tablename NOT IN ('alembic_version', 'dbos_migrations')"
        ).fetchall()
        connection.execute(";".join(f"DELETE FROM {table}" for (table,) in tables))
    return True


def migrate_all(url: str) -> None:
    """Our tables and the queue's."""
    from exogauge.jobs.engine import migrate_engine
    from exogauge.storage.migrate import upgrade

    upgrade(url)
    migrate_engine(url)


@pytest.fixture
def settings(database_url: str, tmp_path: Path) -> Settings:
    from exogauge.settings import Settings

    return Settings(data_dir=tmp_path / "data", database_url=database_url, workers=0, max_upload_bytes=2_000_000)


@pytest.fixture
def storage(settings: Settings) -> Iterator[Storage]:
    """What one lab has in a migrated database and an empty blob store."""
    from exogauge.storage.store import open_installation

    opened = open_installation(settings)
    yield opened.of_lab(settings.lab)
    opened.close()


@pytest.fixture
def without_bytes(monkeypatch: pytest.MonkeyPatch) -> None:
    """For tests of rows alone: a row may name a blob that was never written."""
    from exogauge.storage.blobs import FolderBlobs

    monkeypatch.setattr(FolderBlobs, "exists", lambda *_: True)


@pytest.fixture
def app(settings: Settings) -> FastAPI:
    from exogauge.api.app import create_app

    return create_app(settings)


@pytest.fixture
def client(app: FastAPI) -> Iterator[TestClient]:
    from fastapi.testclient import TestClient

    with TestClient(app, raise_server_exceptions=False) as opened:
        yield opened


class SmallDisk:
    """A file system of its own that is full, or not, as a test wants it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.ballast = folder / "ballast"

    def fill(self, but: int = 0) -> None:
        """Leave only so many bytes (whole pages)."""
        with self.ballast.open("wb") as file:
            free = shutil.disk_usage(self.folder).free
            os.posix_fallocate(file.fileno(), 0, free - but)

    def empty(self) -> None:
        self.ballast.unlink()


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[SmallDisk]:
    """A megabyte; only root may mount one."""
    folder = tmp_path / "small_disk"
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(folder)]
    if shutil.which("mount") is None or subprocess.run(command, capture_output=True).returncode != 0:
        pytest.skip("no small disk can be mounted here")
    yield SmallDisk(folder)
    subprocess.run(["umount", "--lazy", str(folder)], check=True)


def pytest_configure(config: pytest.Config) -> None:
    """Children of tests find no settings of the developer's own."""
    config.addinivalue_line("filterwarnings", "ignore:Using `httpx` with `starlette.testclient`")
    for name in [name for name in os.environ if name.startswith("EXOGAUGE_") and "TEST" not in name]:
        del os.environ[name]
    if "PYTEST_XDIST_WORKER" in os.environ:  # others have the other processors: threads cost a tenth, looks ahead more
        os.environ["EXOGAUGE_CORES"] = "1"
    assert sys.version_info >= (3, 11)
