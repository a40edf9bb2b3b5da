"""Bundles: files that were handed in together, pinned by their content and never changed after.

Robots, devices, studies, payloads, motions and plans are bundles; a `Sort` says in what they differ.

Words by which they are found are folded here, once when a thing is added and once when they are asked for: neither
database folds the case of every script alike.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any, Generic, TypeVar, final

import sqlalchemy as sa
from sqlalchemy.orm import aliased

from exogauge.errors import Conflict
from exogauge.storage import tables
from exogauge.storage.blobs import BlobStore, copy_out
from exogauge.storage.files import PinnedFile, content_hash, file_at
from exogauge.storage.jobs import latest_state
from exogauge.storage.records import (
    BundleRecord,
    DeviceRecord,
    MotionRecord,
    Page,
    PayloadRecord,
    PlanRecord,
    RobotRecord,
    StudyRecord,
)
from exogauge.storage.rows import KEY, Lab, columns_in, of_lab, once
from exogauge.storage.tables import Named

Record = TypeVar("Record", bound=BundleRecord)
Filter = Callable[[Lab, str], sa.ColumnElement[bool]]
Needs = tuple[str, str] | None
NONE = "none"
DESCRIPTION = "robot.yaml"
PLANNED = "motion.csv"  # what a job of a plan writes: t and q.<joint>


@final
@dataclass(frozen=True)
class Sort(Generic[Record]):
    """noun: what one is called. of: its files' column that names it.

    same_by: columns that are alike in one and the same bundle. versioned: other content under a name is its next
    version. filters: what a page may be narrowed to. needed_by: what keeps one from being deleted, in words, and what
    can be done. gone_before: rows that refer to one and go with it, where the database does not let them. beside: sorts
    of what one may refer to by `<noun>_id`; its files are laid out below a folder of that name.
    """

    noun: str
    record: type[Record]
    table: type[tables.Named]
    files: Any
    same_by: tuple[str, ...]
    versioned: bool = True
    filters: Mapping[str, Filter] = field(default_factory=dict)
    needed_by: Callable[[Lab, str], Needs] = lambda *_: None
    gone_before: tuple[Any, ...] = ()
    beside: tuple[Sort[Any], ...] = ()

    @property
    def of(self) -> str:
        return f"{self.noun}_id"


@final
@dataclass(frozen=True)
class Bundles(Generic[Record]):
    """All of one sort, of one lab."""

    lab: Lab
    blobs: BlobStore
    sort: Sort[Record]

    def add(
        self, name: str, files: Sequence[PinnedFile], summary: Mapping[str, Any], **facts: str | None
    ) -> tuple[Record, bool]:
        """The one with this content, and whether it is new. facts: further columns, for a device its robot_id."""
        table, pinned = self.sort.table, content_hash(files)
        for sort in self.sort.beside:
            if (other := facts.get(sort.of)) is not None:
                self.lab.get(sort.record, sort.table, other, sort.noun)
        known = {"name": name, "content_hash": pinned, **facts}

        def make() -> list[tables.Base]:
            key: str = tables.new_id()
            version = {"version": self._newest(name) + 1} if self.sort.versioned else {}
            owned: Any = table  # `Named` is what all these tables share, and no table itself
            row = owned(
                id=key, lab_id=self.lab.lab_id, summary=dict(summary), words=words_of(name, summary), **known, **version
            )
            return [row, *(self._file(key, file) for file in files)]

        kept, new = self.lab.find_or_add(lambda: self.same(name, pinned, **facts), make, self.sort.noun)
        if new:
            self.lab.audit("add", self.sort.noun, kept.id, after=pinned)
        return kept, new

    def same(self, name: str, content_hash: str, **facts: str | None) -> Record | None:
        """The one that `add` would find."""
        table, known = self.sort.table, {"name": name, "content_hash": content_hash, **facts}
        mine = self.lab.select(table).where(*(getattr(table, each) == known[each] for each in self.sort.same_by))
        return self.lab.one(self.sort.record, mine)

    def get(self, key: str) -> Record:
        return self.lab.get(self.sort.record, self.sort.table, key, self.sort.noun)

    def page(
        self, after: tuple[datetime, str] | None, limit: int, *, search: str = "", **only: str | None
    ) -> Page[Record]:
        """search: words that all are found. only: by the sort's filters, where given."""
        wanted = [self.sort.filters[by](self.lab, value) for by, value in only.items() if value is not None]
        words = (holds(self.sort.table, word) for word in folded(search).split())
        return self.lab.page(self.sort.record, self.sort.table, after, limit, *words, *wanted)

    def files(self, key: str) -> tuple[PinnedFile, ...]:
        """Sorted by path."""
        return tuple(PinnedFile(*row) for row in self.lab.rows(files_of(self.sort.files, self.sort.of), key=key))

    def file(self, key: str, path: str) -> PinnedFile:
        self.lab.must_be(self.sort.table, key, self.sort.noun)
        return file_at(self.files(key), path, f"{self.sort.noun} {key}")

    def write_to(self, key: str, folder: Path) -> Record:
        """Lay the files out below `folder`, as they were handed in."""
        found = self.get(key)
        for file in self.files(key):
            copy_out(self.blobs, file.sha256, folder / file.path)
        return found

    def write_with_all(self, key: str, folder: Path) -> Record:
        """The same, and beside them what it refers to, each sort below a folder named by its noun."""
        found = self.write_to(key, folder)
        for sort in self.sort.beside:
            if (other := getattr(found, sort.of)) is not None:
                Bundles(self.lab, self.blobs, sort).write_to(other, folder / sort.noun)
        return found

    def delete(self, key: str) -> None:
        """With its files, jobs, results and streams. Conflict where something else needs it."""
        found, table = self.get(key), self.sort.table
        self.lab.session.execute(
            self.lab.select(table).where(table.id == key).with_for_update()
        )  # nothing is added now
        if (needs := self.sort.needed_by(self.lab, key)) is not None:
            raise Conflict(f"{self.sort.noun} {found.name!a} is needed: {needs[0]}. {needs[1]}")
        quiet = {"synchronize_session": False}
        for child in self.sort.gone_before:
            theirs = child.lab_id == self.lab.lab_id, getattr(child, self.sort.of) == key
            self.lab.session.execute(sa.delete(child).where(*theirs), execution_options=quiet)
        mine = sa.delete(table).where(table.lab_id == self.lab.lab_id, table.id == key)
        self.lab.session.execute(mine, execution_options=quiet)
        self.lab.audit("delete", self.sort.noun, key, before=found.content_hash)

    def _newest(self, name: str) -> int:
        table: Any = self.sort.table
        mine = sa.select(sa.func.max(table.version)).where(table.lab_id == self.lab.lab_id, table.name == name)
        return self.lab.session.scalar(mine) or 0

    def _file(self, key: str, file: PinnedFile) -> tables.Base:
        owner = {"lab_id": self.lab.lab_id, self.sort.of: key}
        made: tables.Base = self.sort.files(**owner, path=file.path, sha256=file.sha256, size=file.size)
        return made


@once
def files_of(table: Any, of: str) -> sa.Select[Any]:
    """For `Lab.rows`: files of the bundle that is `key`, sorted by path."""
    columns = columns_in(table)
    return of_lab(PinnedFile, table).where(columns[of] == KEY).order_by(columns.path)


def _with_files_of_robot(lab: Lab, robot_id: str) -> sa.ColumnElement[bool]:
    """Studies with the very files of this robot; `none`: of no robot on its own."""
    robots = lab.select(tables.Robot).where(_is_of(tables.Study, tables.Robot))
    return ~robots.exists() if robot_id == NONE else robots.where(tables.Robot.id == robot_id).exists()


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


def _with_motion_of_plan(lab: Lab, plan_id: str) -> sa.ColumnElement[bool]:
    """Studies that hold the motion that a job of this plan wrote, byte for byte, or whose results do: there a log was
    found to follow it."""
    written = sa.select(tables.Artifact.sha256).join(tables.Job, tables.Job.id == tables.Artifact.job_id)
    mine = written.where(
        tables.Job.lab_id == lab.lab_id, tables.Job.plan_id == plan_id, tables.Artifact.name == PLANNED
    )
    held, found, job = tables.StudyFile, aliased(tables.Artifact), aliased(tables.Job)
    follows = sa.exists().where(
        job.study_id == tables.Study.id, job.lab_id == lab.lab_id, found.job_id == job.id, found.sha256.in_(mine)
    )
    return sa.or_(sa.exists().where(held.study_id == tables.Study.id, held.sha256.in_(mine)), follows)


MOST_NAMED = 5  # of what still needs a thing, in one message


def _of_robot(lab: Lab, robot_id: str) -> Needs:
    found = lab.session.scalars(lab.select(tables.Device).where(tables.Device.robot_id == robot_id).limit(MOST_NAMED))
    worn = [f"{device.name!a} version {device.version}" for device in found]
    if worn:
        return f"it wears {', '.join(worn)}", "Delete these devices first."
    return _plans_of(lab, tables.Plan.robot_id == robot_id)


def _plans_of(lab: Lab, theirs: sa.ColumnElement[bool]) -> Needs:
    found = [f"{plan.name!a}" for plan in lab.session.scalars(lab.select(tables.Plan).where(theirs).limit(MOST_NAMED))]
    return (f"plans were made of it: {', '.join(found)}", "Delete these plans first.") if found else None


def _jobs_of(lab: Lab, owner: sa.ColumnElement[bool]) -> Needs:
    going = tables.Job.state.in_(("queued", "running"))
    count = len(lab.session.scalars(lab.select(tables.Job).where(owner, going)).all())
    return (f"{count} of its jobs wait or run", "Cancel them first, or let them end.") if count else None


def _of_payload(lab: Lab, payload_id: str) -> Needs:
    stream = tables.LiveStream
    is_open = lab.select(stream).where(stream.payload_id == payload_id, stream.state == "open")
    if lab.session.scalars(is_open.limit(1)).first() is not None:
        return "a live stream of it is open", "End the stream first."
    return _jobs_of(lab, tables.Job.payload_id == payload_id)


ROBOTS = Sort("robot", RobotRecord, tables.Robot, tables.RobotFile, ("name", "content_hash"), needed_by=_of_robot)
DEVICES = Sort(
    "device",
    DeviceRecord,
    tables.Device,
    tables.DeviceFile,
    ("name", "robot_id", "content_hash"),
    filters={
        "name": lambda _, name: tables.Device.name == name,
        "robot_id": lambda _, robot_id: tables.Device.robot_id == robot_id,
    },
    beside=(ROBOTS,),
)
STUDIES = Sort(
    "study",
    StudyRecord,
    tables.Study,
    tables.StudyFile,
    ("content_hash",),
    versioned=False,
    filters={  # state: of the latest job, `none` where there is none
        "state": lambda _, state: sa.func.coalesce(latest_state("study"), NONE) == state,
        "robot_id": _with_files_of_robot,
        "plan_id": _with_motion_of_plan,
    },
    needed_by=lambda lab, study_id: (
        _jobs_of(lab, tables.Job.study_id == study_id) or _plans_of(lab, tables.Plan.study_id == study_id)
    ),
)
PAYLOADS = Sort(
    "payload",
    PayloadRecord,
    tables.Payload,
    tables.PayloadFile,
    ("name", "content_hash"),
    filters={"name": lambda _, name: tables.Payload.name == name},
    needed_by=_of_payload,
    gone_before=(tables.LiveStream,),
)
MOTIONS = Sort(
    "motion",
    MotionRecord,
    tables.Motion,
    tables.MotionFile,
    ("name", "content_hash"),
    filters={"name": lambda _, name: tables.Motion.name == name},
    needed_by=lambda lab, motion_id: (
        _jobs_of(lab, tables.Job.motion_id == motion_id) or _plans_of(lab, tables.Plan.motion_id == motion_id)
    ),
)
PLANS = Sort(
    "plan",
    PlanRecord,
    tables.Plan,
    tables.PlanFile,
    ("content_hash",),
    versioned=False,
    filters={
        "robot_id": lambda _, robot_id: tables.Plan.robot_id == robot_id,
        "motion_id": lambda _, motion_id: tables.Plan.motion_id == motion_id,
        "state": lambda _, state: sa.func.coalesce(latest_state("plan"), NONE) == state,
    },
    needed_by=lambda lab, plan_id: _jobs_of(lab, tables.Job.plan_id == plan_id),
    beside=(ROBOTS, MOTIONS, STUDIES),
)


BEGINNING = re.compile(r"[0-9a-f-]{6,64}")  # shorter ones would be found in hashes by chance


def folded(text: str) -> str:
    """Without case and without the width of letters: STRASSE is straße, Ｓｕｉｔ is suit."""
    return unicodedata.normalize("NFKC", unicodedata.normalize("NFKC", text).casefold())


def words_of(name: str, summary: Mapping[str, Any]) -> str:
    """What a thing is found by: its name, its robot's and its devices' names."""
    return "\n".join(dict.fromkeys(folded(each) for each in (name, *names_in(summary))))


def names_in(summary: Mapping[str, Any]) -> Iterator[str]:
    robot = summary.get("robot")
    named = (summary, robot if isinstance(robot, Mapping) else {"name": robot}, *summary.get("devices", ()))
    yield from (each["name"] for each in named if isinstance(each.get("name"), str))


def holds(table: type[Named], word: str) -> sa.ColumnElement[bool]:
    """The word stands in the thing's words, or begins its id or content hash."""
    in_words = table.words.contains(word, autoescape=True)
    if BEGINNING.fullmatch(word) is None:
        return in_words
    return sa.or_(in_words, table.id.startswith(word), table.content_hash.startswith(word))
