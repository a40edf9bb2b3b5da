"""What is backed up is had back, row by row and byte by byte, on either database, from whatever revision."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import count
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa

from exogauge.errors import BadInput, Conflict
from exogauge.settings import Settings
from exogauge.storage import chores, migrate, orphans
from exogauge.storage.blobs import FolderBlobs
from exogauge.storage.checking import check
from exogauge.storage.store import Installation, open_installation
from exogauge.storage.tables import OWNERS
from exogauge.upkeep import backup
from exogauge.upkeep.backup import back_up, restore

REVISIONS = [script.revision for script in reversed(list(migrate.scripts().walk_revisions()))]
KINDS = ("sqlite", "postgresql")
Made = dict[str, str]
"""Table -> the key of the row that was put into it."""


@dataclass(frozen=True)
class Walked:
    """folder: of a backup at each revision. made: at each. rows: of all, at the newest."""

    folder: Path
    made: dict[str, Made]
    rows: dict[str, list[dict[str, Any]]]

    def there(self, name: str, row: dict[str, Any], revisions: list[str]) -> bool:
        """A row of a table that was made at one of them; accounts and what is theirs are of no lab."""
        lab = row["id"] if name == "labs" else row.get("lab_id")
        return lab in revisions if lab else row["id"] in [self.made[each].get(name) for each in revisions]


@pytest.fixture(params=KINDS)
def elsewhere(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """Another empty database."""
    if request.param == "sqlite":
        yield f"sqlite:///{tmp_path / 'elsewhere.sqlite'}"
        return
    make: Callable[..., AbstractContextManager[str]] = request.getfixturevalue("throw_away_database")
    with make() as url:
        yield url


@pytest.fixture
def filled(settings: Settings) -> Iterator[Installation]:
    """An installation with a row in every table of two labs."""
    installation = open_installation(settings, migrating=True)
    with installation.engine.begin() as connection:
        numbers = count(1)
        for lab in ("north", "south"):
            fill(connection, lab, installation.blobs, numbers)
    yield installation
    installation.close()


def fill(connection: sa.Connection, lab: str, blobs: Any, numbers: Iterator[int]) -> Made:
    """A row of the lab in every table that the database has, by what it says of its columns."""
    have, tables = Made(), backup.tables_in(connection)
    for table in tables:
        keys = {
            key.parent.name: key.column.table.name for each in table.foreign_key_constraints for key in each.elements
        }
        row = dict[str, Any]()
        for column in table.columns:
            if column.name in keys and column.name != "lab_id":
                row[column.name] = have[keys[column.name]]
            elif column.name == "lab_id" or (table.name, column.name) == ("labs", "id"):
                row[column.name] = lab
            elif orphans.names_a_blob(column.name):
                row[column.name] = blobs.put(f"{table.name} {lab}".encode())
            else:
                row[column.name] = value_of(column, next(numbers))
        if table.name in ("jobs", "results"):  # of a study, and of nothing else
            row |= {f"{noun}_id": None for noun in OWNERS if f"{noun}_id" in row and noun != "study"}
        if "size" in row and "sha256" in row:
            row["size"] = len(f"{table.name} {lab}")
        connection.execute(sa.insert(table).values(row))
        have[table.name] = row.get("id", "")
    return have


def value_of(column: sa.Column[Any], number: int) -> Any:
    named = {"state": "ended" if column.table.name == "live_streams" else "failed", "progress": 0.25, "attempts": 1}
    named |= {"role": "viewer", "scope": "read"}
    if column.name in named:
        return named[column.name]
    kind = column.type
    if isinstance(kind, sa.JSON):
        return {"of": [column.name, number, None, 0.1, {"at": "no time"}], "ä": "∑"}
    if isinstance(kind, sa.DateTime):
        when = datetime(2026, 3, 4, 5, 6, 7, 890_000 + number % 1000, tzinfo=UTC)
        return when if kind.timezone else when.replace(tzinfo=None)
    if isinstance(kind, sa.Boolean):
        return bool(number % 2)
    if isinstance(kind, sa.Integer | sa.BigInteger):
        return number
    if isinstance(kind, sa.Float):
        return 0.1 * number
    return f"{number} „ünïcode“\n"[: getattr(kind, "length", None) or 99]


def rows_of(installation: Installation) -> dict[str, list[dict[str, Any]]]:
    """Of all tables with data, as the code reads them."""
    from exogauge.storage.tables import Base

    with installation.engine.connect() as connection:
        return {
            table.name: [
                dict(row) for row in connection.execute(sa.select(table).order_by(*table.primary_key)).mappings()
            ]
            for table in Base.metadata.sorted_tables
            if table.name not in backup.OF_THIS_RUN
        }


def in_order(table: sa.Table) -> sa.Select[Any]:
    return sa.select(table).order_by(*table.primary_key)


@pytest.mark.slow
def test_everything_is_had_back_on_either_database(filled: Installation, elsewhere: str, tmp_path: Path) -> None:
    done = back_up(filled, tmp_path / "backup", "me")
    assert done.rows == sum(len(rows) for rows in rows_of(filled).values())
    assert done.blobs == done.copied == len(list(filled.blobs.iterate()))
    settings = Settings(data_dir=tmp_path / "elsewhere", database_url=elsewhere)
    there = open_installation(settings, migrating=True)
    assert restore(tmp_path / "backup", settings, there.blobs).rows == done.rows
    migrate.check(elsewhere)
    ours, theirs = rows_of(filled), rows_of(there)
    assert len(ours) > 12
    assert all(len(rows) == 2 for rows in ours.values())
    assert theirs == ours
    assert sorted(there.blobs.iterate()) == sorted(filled.blobs.iterate())
    assert check(there, settings).sound
    with pytest.raises(Conflict, match="the database holds rows"):
        restore(tmp_path / "backup", settings, there.blobs)
    there.close()


@pytest.mark.slow
def test_a_second_backup_copies_only_what_is_new(filled: Installation, tmp_path: Path) -> None:
    first = back_up(filled, tmp_path / "backup", "me")
    with filled.of_lab("north").transaction() as store:
        from exogauge.storage.files import PinnedFile

        store.studies.add("new", [PinnedFile("study.yaml", store.blobs.put(b"new"), 3)], {})
    second = back_up(filled, tmp_path / "backup", "me")
    assert (second.copied, second.blobs) == (1, first.blobs + 1)
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "thesis.doc").touch()
    with pytest.raises(Conflict, match="no backup"):
        back_up(filled, tmp_path / "other", "me")


def test_a_place_where_nothing_is_makes_no_backup_and_spares_the_one_that_is_there(
    filled: Installation, elsewhere: str, tmp_path: Path
) -> None:
    back_up(filled, tmp_path / "backup", "me")
    before = backup.read_manifest(tmp_path / "backup")
    mistyped = open_installation(Settings(data_dir=tmp_path / "typo", database_url=elsewhere), migrating=True)
    with pytest.raises(Conflict, match="nothing of exogauge"):
        back_up(mistyped, tmp_path / "backup", "me")
    mistyped.close()
    assert backup.read_manifest(tmp_path / "backup") == before


@pytest.mark.slow
@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_no_sweep_runs_beside_a_backup(filled: Installation, tmp_path: Path) -> None:
    with filled.session() as session:
        assert chores.take(session, "sweep", "sweeper")
    with pytest.raises(Conflict, match="sweep"):
        back_up(filled, tmp_path / "backup", "me")
    with filled.session() as session:
        chores.done(session, "sweep", "sweeper", backup.EVERY, {})
    with backup.without_sweeps(filled, "me"), filled.session() as session:
        assert not chores.take(session, "sweep", "sweeper", now_due=True)


@pytest.mark.slow
@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_what_is_damaged_is_refused_and_nothing_is_left(filled: Installation, tmp_path: Path) -> None:
    folder = tmp_path / "backup"
    back_up(filled, folder, "me")
    settings = Settings(data_dir=tmp_path / "elsewhere")
    blobs = FolderBlobs(settings.blobs)
    name = next(filled.blobs.iterate())
    rotten = folder / "blobs" / name[:2] / name[2:]
    whole = rotten.read_bytes()
    rotten.chmod(0o644)
    rotten.write_bytes(whole[::-1])
    with pytest.raises(BadInput, match="not what its name says"):
        restore(folder, settings, blobs)
    assert migrate.current(settings.database_url) is None
    rotten.unlink()
    with pytest.raises(BadInput, match="missing"):
        restore(folder, settings, blobs)
    rotten.write_bytes(whole)
    with (folder / "rows" / "studies.jsonl").open("ab") as file:
        file.write(b"\n")
    with pytest.raises(BadInput, match="not those that were written"):
        restore(folder, settings, blobs)
    (folder / "manifest.json").unlink()
    with pytest.raises(BadInput, match="no backup here"):
        restore(folder, settings, blobs)
    assert hashlib.sha256(whole).hexdigest() == name


def walk(url: str, folder: Path) -> Walked:
    """Through every revision; at each a lab gets a row in every table, and a backup is made."""
    installation = open_installation(Settings(data_dir=folder / "data", database_url=url), migrating=True)
    made, numbers = dict[str, Made](), count(1)
    for revision in REVISIONS:
        migrate.upgrade(url, revision)
        installation.engine.dispose()  # what a connection has learned of tables that have changed
        with installation.engine.begin() as connection:
            made[revision] = fill(connection, revision, installation.blobs, numbers)
        back_up(installation, folder / revision, "me")
    migrate.check(url)
    rows = rows_of(installation)
    installation.close()
    return Walked(folder, made, rows)


@pytest.fixture(scope="module")
def walked(tmp_path_factory: pytest.TempPathFactory) -> Walked:
    folder = tmp_path_factory.mktemp("walked")
    return walk(f"sqlite:///{folder / 'walked.sqlite'}", folder)


@pytest.mark.slow
@pytest.mark.parametrize("revision", REVISIONS)
def test_data_of_every_revision_come_up_to_this_one_by_upgrade_and_by_backup(
    walked: Walked, revision: str, tmp_path: Path
) -> None:
    folder = walked.folder / revision
    assert json.loads((folder / "manifest.json").read_text())["revision"] == revision
    own = [name for name, rows in walked.rows.items() if any(walked.there(name, row, [revision]) for row in rows)]
    assert len(own) >= len(walked.made[revision]) - 1  # keys in flight are not carried over
    until_then = REVISIONS[: REVISIONS.index(revision) + 1]
    upgraded = {
        name: [row for row in rows if walked.there(name, row, until_then)] for name, rows in walked.rows.items()
    }
    elsewhere = Settings(data_dir=tmp_path / "elsewhere")
    new = open_installation(elsewhere, migrating=True)
    restore(folder, elsewhere, new.blobs)
    assert rows_of(new) == upgraded
    assert check(new, elsewhere).sound
    new.close()


@pytest.mark.slow
def test_on_postgresql_the_same_data_come_up_and_their_backups_are_the_same(
    walked: Walked, postgres_url: str, tmp_path: Path
) -> None:
    """So what was restored above was theirs, too."""
    other = walk(postgres_url, tmp_path)
    assert other.rows == walked.rows
    for revision in REVISIONS:
        ours, theirs = (
            {path.name: path.read_text() for path in (each.folder / revision / "rows").iterdir()}
            for each in (walked, other)
        )
        assert len(ours) > 5
        assert theirs == ours
