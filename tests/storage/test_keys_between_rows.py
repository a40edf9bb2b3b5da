"""Every reference of a lab's row is to a row of the same lab: by the tables of the code, as the database has them after
the migrations, and as it acts."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime
from itertools import count
from typing import Any

import pytest
import sqlalchemy as sa
from sqlalchemy.exc import IntegrityError

from exogauge.storage.database import UtcDateTime
from exogauge.storage.row_security import ALL, see
from exogauge.storage.scope import AllLabsSession
from exogauge.storage.store import Storage
from exogauge.storage.tables import OWNERS, Base

TABLES = Base.metadata.sorted_tables
TABLES_BY_NAME = Base.metadata.tables
OWNED = [table for table in TABLES if "lab_id" in table.columns]
KEYS = sorted(
    ((table, key) for table in OWNED for key in table.foreign_key_constraints if key.referred_table in OWNED),
    key=lambda each: str(each[1].name),
)
ONE_OWNER = ("jobs", "results")  # of a study or another of `OWNERS`: here of a study, unless another is what is tried
CHOICES = {"role": "viewer", "scope": "read"}  # where not any word will do
STATES = {"deliveries": "waiting"}
NUMBERS = count(1)


FREE = {  # what of no lab a lab's row may name; what may be gone of an audit or a publication; a worker's own name
    "memberships": {"account_id"}, "api_tokens": {"account_id"}, "sessions": {"account_id"},
    "identities": {"account_id"},
    "audit": {"subject_id"}, "worker_leases": {"worker_id"}, "publications": {"series_id", "study_id", "job_id"},
}  # fmt: skip


def names(key: sa.ForeignKeyConstraint) -> str:
    (column,) = set(key.column_keys) - {"lab_id"}
    return column


def test_every_key_between_rows_of_labs_holds_the_lab_in_the_code() -> None:
    assert len(KEYS) >= 14
    for table, key in KEYS:
        assert key.referred_table in OWNED
        pairs = {element.parent.name: element.column.name for element in key.elements}
        assert pairs == {"lab_id": "lab_id", names(key): "id"}, table.name


def test_every_key_between_rows_of_labs_holds_the_lab_in_the_database(storage: Storage) -> None:
    seen = sa.inspect(storage.engine)
    found = 0
    for table in OWNED:
        for key in seen.get_foreign_keys(table.name):
            if key["referred_table"] in ("labs", "accounts"):
                continue
            found += 1
            pairs = dict(zip(key["constrained_columns"], key["referred_columns"], strict=True))
            assert pairs.pop("lab_id", None) == "lab_id", (table.name, key)
            assert list(pairs.values()) == ["id"], (table.name, key)
    assert found == len(KEYS)


def test_a_column_that_names_a_row_is_a_key() -> None:
    """One that was forgotten would not be found above."""
    for table in TABLES:
        named = {column.name for column in table.columns if column.name.endswith("_id")} - {"lab_id"}
        keys = {names(key) for key in table.foreign_key_constraints if key.referred_table in OWNED}
        assert named - FREE.get(table.name, set()) == keys, table.name


@pytest.mark.parametrize(("table", "key"), KEYS, ids=lambda each: each.name)
def test_the_database_refuses_a_reference_into_another_lab(
    storage: Storage, table: sa.Table, key: sa.ForeignKeyConstraint
) -> None:
    with storage.engine.begin() as connection:
        see(connection, ALL)
        north, south = (filled(connection, lab) for lab in ("north", "south"))
        if table not in {each.referred_table for _, each in KEYS}:
            connection.execute(sa.delete(table))  # some are one to one
    right = row_of(table, "north", north, key)
    for wrong in ({names(key): south[key.referred_table.name]}, {"lab_id": "south"}):
        with pytest.raises(IntegrityError, match=r"(?i)foreign key"), AllLabsSession(storage.engine) as session:
            session.execute(sa.insert(table).values(right | wrong))
    with AllLabsSession(storage.engine) as session:
        session.execute(sa.insert(table).values(right))  # nothing else of it was wrong


def filled(connection: sa.Connection, lab: str) -> dict[str, str]:
    """table -> the id of a row of the lab, in every table."""
    made = dict[str, str]()
    person = {
        "id": f"{next(NUMBERS):036}",
        "email": lab,
        "name": lab,
        "operator": False,
        "created_at": datetime.now(UTC),
    }
    connection.execute(sa.insert(TABLES_BY_NAME["labs"]).values(id=lab, name=lab, created_at=datetime.now(UTC)))
    connection.execute(sa.insert(TABLES_BY_NAME["accounts"]).values(person))
    made["accounts"] = person["id"]
    for table in OWNED:
        row = row_of(table, lab, made)
        connection.execute(sa.insert(table).values(row))
        made[table.name] = row["id"]
    return made


def row_of(
    table: sa.Table, lab: str, have: Mapping[str, str], tried: sa.ForeignKeyConstraint | None = None
) -> dict[str, Any]:
    """Values that the table takes: what it must have, and a reference by each key, of which `tried` is one."""
    row = {column.name: value_of(column) for column in table.columns if not column.nullable and column.default is None}
    row |= {"id": f"{next(NUMBERS):036}", "lab_id": lab}
    row |= {names(key): have[key.referred_table.name] for each, key in KEYS if each is table}
    row |= {name: value for name, value in CHOICES.items() if name in row}
    row |= {"state": STATES[table.name]} if table.name in STATES else {}
    row |= {"account_id": have["accounts"]} if "account_id" in row else {}
    if table.name in ONE_OWNER:
        owners = {f"{noun}_id" for noun in OWNERS}
        kept = names(tried) if tried is not None and names(tried) in owners else "study_id"
        row = {name: value for name, value in row.items() if name == kept or name not in owners}
    return row


def value_of(column: sa.Column[Any]) -> Any:
    number = next(NUMBERS)
    if isinstance(column.type, sa.JSON):
        return {}
    if isinstance(column.type, UtcDateTime):
        return datetime.now(UTC)
    return f"{number}" if isinstance(column.type, sa.String) else number
