"""Robots: bundles of robot.yaml and URDF, versioned by name and pinned by content."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, final

import sqlalchemy as sa

from exogauge.storage import tables
from exogauge.storage.files import PinnedFile, content_hash, file_at
from exogauge.storage.records import Page, RobotRecord
from exogauge.storage.rows import Lab
from exogauge.storage.search import found_by, words_of


@final
@dataclass(frozen=True)
class Robots:
    lab: Lab

    def add(self, name: str, files: Sequence[PinnedFile], summary: Mapping[str, Any]) -> tuple[RobotRecord, bool]:
        """The robot with this name and content, and whether it is new; other content makes a new version."""
        pinned = content_hash(files)
        same = self.lab.select(tables.Robot).where(tables.Robot.name == name, tables.Robot.content_hash == pinned)

        def make() -> list[tables.Base]:
            key = tables.new_id()
            robot = tables.Robot(
                id=key, lab_id=self.lab.lab_id, name=name, version=self._newest_version(name) + 1,
                content_hash=pinned, summary=dict(summary), words=words_of(name, summary),
            )  # fmt: skip
            return [robot, *(self._file(key, file) for file in files)]

        robot, new = self.lab.find_or_add(lambda: self.lab.one(RobotRecord, same), make, "robot")
        if new:
            self.lab.audit("add", "robot", robot.id, after=pinned)
        return robot, new

    def get(self, key: str) -> RobotRecord:
        return self.lab.get(RobotRecord, tables.Robot, key, "robot")

    def page(self, after: tuple[datetime, str] | None, limit: int, *, search: str = "") -> Page[RobotRecord]:
        """search: words that all are found."""
        query = self.lab.select(tables.Robot).where(found_by(tables.Robot, search))
        return self.lab.page(RobotRecord, tables.Robot, query, after, limit)

    def files(self, key: str) -> tuple[PinnedFile, ...]:
        query = self.lab.select(tables.RobotFile).where(tables.RobotFile.robot_id == key)
        rows = self.lab.session.scalars(query.order_by(tables.RobotFile.path))
        return tuple(PinnedFile(row.path, row.sha256, row.size) for row in rows)

    def file(self, key: str, path: str) -> PinnedFile:
        self.get(key)
        return file_at(self.files(key), path, f"robot {key}")

    def _newest_version(self, name: str) -> int:
        robot = tables.Robot
        mine = sa.select(sa.func.max(robot.version)).where(robot.lab_id == self.lab.lab_id, robot.name == name)
        return self.lab.session.scalar(mine) or 0

    def _file(self, robot_id: str, file: PinnedFile) -> tables.RobotFile:
        return tables.RobotFile(
            lab_id=self.lab.lab_id, robot_id=robot_id, path=file.path, sha256=file.sha256, size=file.size
        )
