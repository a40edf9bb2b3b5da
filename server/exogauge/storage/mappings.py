"""Mappings that are remembered per robot, so that the next log of it need not be explained again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

import sqlalchemy as sa

from exogauge.errors import Conflict, NotFound
from exogauge.storage.records import MappingRecord, RobotRecord
from exogauge.storage.rows import Lab
from exogauge.storage.tables import Base, Robot, RobotMapping, utc_now


@final
@dataclass(frozen=True)
class Mappings:
    lab: Lab

    def of_robot(self, robot_id: str) -> MappingRecord:
        """The robot's own, or else the last that was kept for another version of it (its robot_id tells)."""
        robot = self.lab.get(RobotRecord, Robot, robot_id, "robot")
        found = self._own(robot_id)
        if found is None:
            versions = sa.select(Robot.id).where(Robot.lab_id == self.lab.lab_id, Robot.name == robot.name)
            query = self.lab.select(RobotMapping).where(RobotMapping.robot_id.in_(versions))
            found = self.lab.one(MappingRecord, query.order_by(RobotMapping.changed_at.desc(), RobotMapping.id))
        if found is None:
            raise NotFound(f"no mapping is kept for robot {robot_id}")
        return found

    def own_hash(self, robot_id: str) -> str | None:
        """content_hash of the robot's own mapping."""
        own = self._own(robot_id)
        return None if own is None else own.content_hash

    def keep(self, robot_id: str, content: Mapping[str, Any], content_hash: str) -> tuple[MappingRecord, bool]:
        """The mapping as it is now kept, and whether it is the robot's first."""
        self.lab.get(RobotRecord, Robot, robot_id, "robot")
        values = {"content": dict(content), "content_hash": content_hash}

        def make() -> list[Base]:
            return [RobotMapping(lab_id=self.lab.lab_id, robot_id=robot_id, **values)]

        kept, new = self.lab.find_or_add(lambda: self._own(robot_id), make, "mapping")
        if not new and kept.content_hash != content_hash:
            mine = [RobotMapping.robot_id == robot_id, RobotMapping.content_hash == kept.content_hash]
            statement = sa.update(RobotMapping).where(*mine).values(**values, changed_at=utc_now())
            if not getattr(self.lab.session.execute(statement), "rowcount", 0):
                raise Conflict("the robot's mapping is being changed by someone else; try again")
        if new or kept.content_hash != content_hash:
            before = None if new else kept.content_hash
            self.lab.audit("keep", "mapping", robot_id, before=before, after=content_hash)
        return self._own(robot_id) or kept, new

    def _own(self, robot_id: str) -> MappingRecord | None:
        return self.lab.one(MappingRecord, self.lab.select(RobotMapping).where(RobotMapping.robot_id == robot_id))
