"""Devices: bundles of device.yaml and bench tests, checked against a robot, versioned by name, pinned by content."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, final

import sqlalchemy as sa

from exogauge.storage import tables
from exogauge.storage.files import PinnedFile, content_hash, file_at
from exogauge.storage.records import DeviceRecord, Page
from exogauge.storage.robots import Robots
from exogauge.storage.rows import Lab
from exogauge.storage.search import found_by, words_of


@final
@dataclass(frozen=True)
class Devices:
    lab: Lab

    def add(
        self, name: str, robot_id: str, files: Sequence[PinnedFile], summary: Mapping[str, Any]
    ) -> tuple[DeviceRecord, bool]:
        """The device with this name and content, checked against this robot of the same lab, and whether it is new;
        other content, or another robot, makes a new version."""
        Robots(self.lab).get(robot_id)
        table, pinned = tables.Device, content_hash(files)
        named = self.lab.select(table).where(table.name == name)
        same = named.where(table.robot_id == robot_id, table.content_hash == pinned)

        def make() -> list[tables.Base]:
            key = tables.new_id()
            device = table(
                id=key, lab_id=self.lab.lab_id, name=name, version=self._newest_version(name) + 1, robot_id=robot_id,
                content_hash=pinned, summary=dict(summary), words=words_of(name, summary),
            )  # fmt: skip
            return [device, *(self._file(key, file) for file in files)]

        device, new = self.lab.find_or_add(lambda: self.lab.one(DeviceRecord, same), make, "device")
        if new:
            self.lab.audit("add", "device", device.id, after=pinned)
        return device, new

    def get(self, key: str) -> DeviceRecord:
        return self.lab.get(DeviceRecord, tables.Device, key, "device")

    def page(
        self,
        after: tuple[datetime, str] | None,
        limit: int,
        *,
        search: str = "",
        name: str | None = None,
        robot_id: str | None = None,
    ) -> Page[DeviceRecord]:
        """search: words that all are found; name: all versions of one device, where given."""
        query = self.lab.select(tables.Device).where(found_by(tables.Device, search))
        if name is not None:
            query = query.where(tables.Device.name == name)
        if robot_id is not None:
            query = query.where(tables.Device.robot_id == robot_id)
        return self.lab.page(DeviceRecord, tables.Device, query, after, limit)

    def files(self, key: str) -> tuple[PinnedFile, ...]:
        """Sorted by path."""
        query = self.lab.select(tables.DeviceFile).where(tables.DeviceFile.device_id == key)
        rows = self.lab.session.scalars(query.order_by(tables.DeviceFile.path))
        return tuple(PinnedFile(row.path, row.sha256, row.size) for row in rows)

    def file(self, key: str, path: str) -> PinnedFile:
        self.get(key)
        return file_at(self.files(key), path, f"device {key}")

    def _newest_version(self, name: str) -> int:
        device = tables.Device
        mine = sa.select(sa.func.max(device.version)).where(device.lab_id == self.lab.lab_id, device.name == name)
        return self.lab.session.scalar(mine) or 0

    def _file(self, device_id: str, file: PinnedFile) -> tables.DeviceFile:
        return tables.DeviceFile(
            lab_id=self.lab.lab_id, device_id=device_id, path=file.path, sha256=file.sha256, size=file.size
        )
