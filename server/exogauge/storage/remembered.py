"""What is kept one to a key and may change: how a robot's logs are read, when the feet of a motion stand, what a lab's
own labels are called elsewhere. The audit tells each change."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar, final

import sqlalchemy as sa

from exogauge.errors import Conflict, NotFound
from exogauge.storage import tables
from exogauge.storage.records import ContactsRecord, MappingRecord, MapRecord, RobotRecord
from exogauge.storage.rows import Lab
from exogauge.storage.tables import Robot, RobotMapping

Record = TypeVar("Record", bound=MappingRecord | ContactsRecord | MapRecord)
Seen = Callable[[str], None]


def whatever(_content_hash: str) -> None:
    pass


@final
@dataclass(frozen=True)
class Remembered(Generic[Record]):
    """by: the column that is the key, of which a lab has one row. noun: what one is called."""

    lab: Lab
    record: type[Record]
    table: Any
    by: str
    noun: str

    def find(self, key: str) -> Record | None:
        return self.lab.one(self.record, self.lab.select(self.table).where(getattr(self.table, self.by) == key))

    def get(self, key: str) -> Record:
        found = self.find(key)
        if found is None:
            raise NotFound(f"there is no {self.noun} {key[:64]!a}")
        return found

    def by_id(self, key: str) -> Record:
        return self.lab.get(self.record, self.table, key, self.noun)

    def all(self) -> tuple[Record, ...]:
        """In the order of their keys."""
        rows = self.lab.session.scalars(self.lab.select(self.table).order_by(getattr(self.table, self.by)))
        return tuple(found for row in rows if (found := self.find(getattr(row, self.by))) is not None)

    def keep(
        self, key: str, content: Mapping[str, Any], content_hash: str, replaced: Seen = whatever
    ) -> tuple[Record, bool]:
        """The content as it is now kept, and whether it is the first of its key. replaced: gets the hash of what was
        kept before, and raises where that may not go."""
        values = {"content": dict(content), "content_hash": content_hash}

        def make() -> list[tables.Base]:
            return [self.table(lab_id=self.lab.lab_id, **{self.by: key}, **values)]

        kept, new = self.lab.find_or_add(lambda: self.find(key), make, self.noun)
        if not new:
            replaced(kept.content_hash)
        if not new and kept.content_hash != content_hash:
            mine = [self._of(key), self.table.content_hash == kept.content_hash]
            statement = sa.update(self.table).where(*mine).values(**values, changed_at=tables.utc_now())
            if not getattr(self.lab.session.execute(statement), "rowcount", 0):
                raise Conflict(f"the {self.noun} is being changed by someone else; try again")
        if new or kept.content_hash != content_hash:
            self._audit("keep", kept, None if new else kept.content_hash, content_hash)
        return self.find(key) or kept, new

    def forget(self, key: str, replaced: Seen = whatever) -> None:
        kept = self.get(key)
        replaced(kept.content_hash)
        gone = sa.delete(self.table).where(self._of(key), self.table.content_hash == kept.content_hash)
        done = self.lab.session.execute(gone, execution_options={"synchronize_session": False})
        if not getattr(done, "rowcount", 0):
            raise Conflict(f"the {self.noun} is being changed by someone else; try again")
        self._audit("delete", kept, kept.content_hash, None)

    def _of(self, key: str) -> sa.ColumnElement[bool]:
        return sa.and_(self.table.lab_id == self.lab.lab_id, getattr(self.table, self.by) == key)

    def _audit(self, action: str, kept: Record, before: str | None, after: str | None) -> None:
        subject = getattr(kept, self.by) if self.by.endswith("_id") else kept.id
        self.lab.audit(action, self.noun, subject, before=before, after=after)


def contacts_of(lab: Lab) -> Remembered[ContactsRecord]:
    return Remembered(lab, ContactsRecord, tables.MotionContacts, "motion_id", "contacts")


def maps_of(lab: Lab) -> Remembered[MapRecord]:
    return Remembered(lab, MapRecord, tables.MotionMap, "name", "map")


@final
@dataclass(frozen=True)
class Mappings:
    lab: Lab

    def of_robot(self, robot_id: str) -> MappingRecord:
        """The robot's own, or else the last that was kept for another version of it (its robot_id tells)."""
        robot = self.lab.get(RobotRecord, Robot, robot_id, "robot")
        found = self._kept.find(robot_id)
        if found is None:
            versions = sa.select(Robot.id).where(Robot.lab_id == self.lab.lab_id, Robot.name == robot.name)
            query = self.lab.select(RobotMapping).where(RobotMapping.robot_id.in_(versions))
            found = self.lab.one(MappingRecord, query.order_by(RobotMapping.changed_at.desc(), RobotMapping.id))
        if found is None:
            raise NotFound(f"no mapping is kept for robot {robot_id}")
        return found

    def keep(
        self, robot_id: str, content: Mapping[str, Any], content_hash: str, replaced: Seen = whatever
    ) -> tuple[MappingRecord, bool]:
        """The mapping as it is now kept, and whether it is the robot's first."""
        self.lab.get(RobotRecord, Robot, robot_id, "robot")
        return self._kept.keep(robot_id, content, content_hash, replaced)

    @property
    def _kept(self) -> Remembered[MappingRecord]:
        return Remembered(self.lab, MappingRecord, RobotMapping, "robot_id", "mapping")
