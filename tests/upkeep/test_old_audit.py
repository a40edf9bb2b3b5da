"""Old entries of the audit go into a file, and out of the database only where it is said, and that is told."""

from __future__ import annotations

import hashlib
import json
from datetime import timedelta
from pathlib import Path

import pytest
import sqlalchemy as sa

from exogauge.cli import main
from exogauge.errors import Conflict
from exogauge.settings import Settings
from exogauge.storage.store import Installation, Storage
from exogauge.storage.tables import AuditEntry, utc_now
from exogauge.upkeep import old_audit
from exogauge.upkeep.old_audit import archive_audit

DAY = timedelta(days=1)
YEARS = 3650 * DAY


@pytest.fixture
def installation(storage: Storage, settings: Settings) -> Installation:
    """Of two labs, entries that are a day younger and a day older than ten years; more than one statement deletes."""
    opened = Installation(storage.engine, storage.blobs)
    for lab, count in (("north", 3), ("south", 600)):
        with opened.session() as session:
            for k in range(count):
                age = YEARS + DAY if k % 3 else YEARS - DAY
                session.add(entry(lab, f"{lab} {k} ✓", utc_now() - age))
    return opened


def entry(lab: str, said: str, at) -> AuditEntry:
    given = {"actor": "account:a", "action": "add", "subject_kind": "study", "subject_id": "s", "after_hash": "0" * 64}
    return AuditEntry(lab_id=lab, created_at=at, said=said, **given)


def said(installation: Installation, lab: str) -> list[str]:
    with installation.reading() as session:
        mine = sa.select(AuditEntry.said).where(AuditEntry.lab_id == lab).order_by(AuditEntry.created_at)
        return list(session.scalars(mine))


def test_what_is_old_is_written_whole_and_stays_until_it_is_said_to_go(
    installation: Installation, settings: Settings, tmp_path: Path
) -> None:
    before = {lab: said(installation, lab) for lab in ("north", "south")}
    done = archive_audit(settings.database_url, tmp_path / "kept", YEARS)
    assert (done.entries, done.removed) == ({"north": 2, "south": 400}, False)
    assert {lab: said(installation, lab) for lab in before} == before
    content = done.file.read_bytes()
    assert hashlib.sha256(content).hexdigest() == done.sha256
    rows = [json.loads(line) for line in content.splitlines()]
    assert {row["said"] for row in rows} == {each for lab in before for each in before[lab] if int(each.split()[1]) % 3}
    assert rows == sorted(rows, key=lambda row: (row["created_at"], row["id"]))
    assert set(rows[0]) == {column.name for column in AuditEntry.__table__.columns}
    with pytest.raises(Conflict, match="is there already"):
        archive_audit(settings.database_url, tmp_path / "kept", YEARS, remove=True)
    assert {lab: said(installation, lab) for lab in before} == before


def test_what_is_removed_is_told_in_each_lab_and_nothing_else_goes_then_or_later(
    installation: Installation, settings: Settings, tmp_path: Path
) -> None:
    done = archive_audit(settings.database_url, tmp_path, YEARS, remove=True)
    assert done.removed
    (young, told) = said(installation, "north")
    assert young == "north 0 ✓"
    assert told.startswith("2 entries from before ")
    assert told.endswith(f"written to {done.file.name}, SHA-256 {done.sha256}")
    assert len(said(installation, "south")) == 201
    for change in (sa.update(AuditEntry).values(actor="nobody"), sa.delete(AuditEntry)):
        with pytest.raises(sa.exc.DBAPIError, match="only ever added to"), installation.session() as session:
            session.execute(change)
    again = archive_audit(settings.database_url, tmp_path / "again", YEARS, remove=True)
    assert (again.file, again.count, list((tmp_path / "again").iterdir())) == (None, 0, [])


def test_what_fails_on_the_way_removes_nothing_and_leaves_the_guard_where_it_was(
    installation: Installation, settings: Settings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = said(installation, "south")

    def fails(*_: object, **__: object) -> None:
        raise RuntimeError("killed here")

    monkeypatch.setattr(old_audit, "record", fails)
    with pytest.raises(RuntimeError):
        archive_audit(settings.database_url, tmp_path, YEARS, remove=True)
    assert said(installation, "south") == before
    with pytest.raises(sa.exc.DBAPIError, match="only ever added to"), installation.session() as session:
        session.execute(sa.delete(AuditEntry))


def test_the_command_takes_the_stated_age_and_none_under_a_month(
    installation: Installation, settings: Settings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    monkeypatch.setenv("EXOGAUGE_DATABASE_URL", settings.database_url)
    monkeypatch.setenv("EXOGAUGE_DATA_DIR", str(settings.data_dir))
    assert main(["audit", str(tmp_path / "one")]) == 0
    assert "402 entries of 2 labs" in capsys.readouterr().out
    assert main(["audit", str(tmp_path / "two"), "--older-than", "3648"]) == 0
    assert "603 entries of 2 labs" in capsys.readouterr().out
    assert main(["audit", str(tmp_path / "three"), "--older-than", "29", "--remove"]) != 0
    assert len(said(installation, "north")) == 3
    monkeypatch.setenv("EXOGAUGE_AUDIT_KEPT_DAYS", "3652")
    assert main(["audit", str(tmp_path / "four")]) == 0
    assert "no entry is from before" in capsys.readouterr().out
