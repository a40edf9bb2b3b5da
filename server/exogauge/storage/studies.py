"""Studies: folders of files, pinned by hash when they are handed in and never changed after."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any, final

import sqlalchemy as sa

from exogauge.errors import NotFound
from exogauge.storage import tables
from exogauge.storage.blobs import BlobStore, copy_out
from exogauge.storage.files import PinnedFile, content_hash, file_at
from exogauge.storage.jobs import latest_state
from exogauge.storage.records import JobRecord, Page, StudyRecord
from exogauge.storage.rows import Lab
from exogauge.storage.search import found_by, words_of

NONE = "none"
DESCRIPTION = "robot.yaml"


@final
@dataclass(frozen=True)
class Studies:
    lab: Lab
    blobs: BlobStore

    def add(self, name: str, files: Sequence[PinnedFile], summary: Mapping[str, Any]) -> tuple[StudyRecord, bool]:
        """The study made of these files, and whether it is new; the same files are the same study."""
        pinned = content_hash(files)
        same = self.lab.select(tables.Study).where(tables.Study.content_hash == pinned)

        def make() -> list[tables.Base]:
            key = tables.new_id()
            study = tables.Study(
                id=key, lab_id=self.lab.lab_id, name=name, content_hash=pinned, summary=dict(summary),
                words=words_of(name, summary),
            )  # fmt: skip
            return [study, *(self._file(key, file) for file in files)]

        study, new = self.lab.find_or_add(lambda: self.lab.one(StudyRecord, same), make, "study")
        if new:
            self.lab.audit("add", "study", study.id, after=pinned)
        return study, new

    def get(self, key: str) -> StudyRecord:
        return self.lab.get(StudyRecord, tables.Study, key, "study")

    def of(self, job: JobRecord) -> StudyRecord:
        """NotFound for a job of a payload."""
        if job.study_id is None:
            raise NotFound(f"job {job.id} is of a payload, not of a study")
        return self.get(job.study_id)

    def page(
        self,
        after: tuple[datetime, str] | None,
        limit: int,
        *,
        search: str = "",
        state: str | None = None,
        robot_id: str | None = None,
    ) -> Page[StudyRecord]:
        """search: words that all are found; state: of the study's latest job, `none` where it has none; robot_id: with
        the very files of this robot, `none`: of no robot on its own."""
        query = self.lab.select(tables.Study).where(found_by(tables.Study, search))
        if robot_id is not None:
            robots = self.lab.select(tables.Robot).where(_is_of(tables.Study, tables.Robot))
            mine = robots if robot_id == NONE else robots.where(tables.Robot.id == robot_id)
            query = query.where(~mine.exists() if robot_id == NONE else mine.exists())
        if state is not None:
            query = query.where(sa.func.coalesce(latest_state(tables.Study.id), NONE) == state)
        return self.lab.page(StudyRecord, tables.Study, query, after, limit)

    def files(self, key: str) -> tuple[PinnedFile, ...]:
        query = self.lab.select(tables.StudyFile).where(tables.StudyFile.study_id == key)
        rows = self.lab.session.scalars(query.order_by(tables.StudyFile.path))
        return tuple(PinnedFile(row.path, row.sha256, row.size) for row in rows)

    def file(self, key: str, path: str) -> PinnedFile:
        self.get(key)
        return file_at(self.files(key), path, f"study {key}")

    def write_to(self, key: str, folder: Path) -> StudyRecord:
        """Lay the study's files out below `folder`, as they were handed in."""
        study = self.get(key)
        for file in self.files(key):
            copy_out(self.blobs, file.sha256, folder / file.path)
        return study

    def _file(self, study_id: str, file: PinnedFile) -> tables.StudyFile:
        return tables.StudyFile(
            lab_id=self.lab.lab_id, study_id=study_id, path=file.path, sha256=file.sha256, size=file.size
        )


def _is_of(study: type[tables.Study], robot: type[tables.Robot]) -> sa.ColumnElement[bool]:
    """The study holds robot.yaml and the URDF that it names, byte for byte, under whatever paths; names say nothing."""
    needed, held = tables.RobotFile, tables.StudyFile
    of_robot = sa.and_(
        needed.robot_id == robot.id,
        sa.or_(needed.path == DESCRIPTION, needed.path == robot.summary["urdf"].as_string()),
    )
    has = sa.exists().where(held.study_id == study.id, held.sha256 == needed.sha256).correlate(study, needed)
    lacks = sa.exists().where(of_robot, ~has).correlate(study, robot)
    return sa.and_(sa.exists().where(of_robot).correlate(robot), ~lacks)
