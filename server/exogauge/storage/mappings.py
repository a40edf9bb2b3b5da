"""Mappings that are remembered per robot, so that the next log of it need not be explained again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

import sqlalchemy as sa

from exogauge.errors import NotFound
from exogauge.storage.records import MappingRecord, RobotRecord
from exogauge.storage.remembered import Remembered
from exogauge.storage.rows import Lab
from exogauge.storage.tables import Robot, RobotMapping


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

    def own_hash(self, robot_id: str) -> str | None:
        """content_hash of the robot's own mapping."""
        own = self._kept.find(robot_id)
        return None if own is None else own.content_hash

    def keep(self, robot_id: str, content: Mapping[str, Any], content_hash: str) -> tuple[MappingRecord, bool]:
        """The mapping as it is now kept, and whether it is the robot's first."""
        self.lab.get(RobotRecord, Robot, robot_id, "robot")
        return self._kept.keep(robot_id, content, content_hash)

    @property
    def _kept(self) -> Remembered[MappingRecord]:
        return Remembered(self.lab, MappingRecord, RobotMapping, "robot_id", "mapping")
