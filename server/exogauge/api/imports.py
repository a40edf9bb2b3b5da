"""Import of foreign logs: a first look at an uploaded file, what its columns may be, the mapping that a robot keeps.

The file and the mapping are read in a child process (`opening_log`). Nothing is guessed in silence: what is not sure
says what it rests on, and what cannot be named is left to the mapping's author.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import datetime
from hashlib import sha256
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import Any, Literal, final
from uuid import UUID

import yaml
from fastapi import HTTPException, Response
from pydantic import BaseModel, ConfigDict

from exogauge.api.dependencies import Id, IfMatch, ReaderDep, SettingsDep, StorageDep, refuse_changed
from exogauge.api.from_uploads import MappingGiven, mapping_text
from exogauge.api.logs import lay_out_robot
from exogauge.api.problems import ProblemError, of_fault
from exogauge.api.routing import Router
from exogauge.api.uploads import Allowance, scratch_folder, write
from exogauge.api.uploads_resumable import FilesDep, whole
from exogauge.errors import BadInput, BadLog, BadStudy, Fault, NotFound, TooLarge
from exogauge.sandbox.asking import ask
from exogauge.sandbox.limits import Limits
from exogauge.settings import Settings
from exogauge.storage.files import safe_path
from exogauge.storage.records import MappingRecord
from exogauge.storage.store import Storage, Store

router = Router(tags=["import"])
CHILD, MAPPING = "exogauge.api.opening_log", "mapping.yaml"


@final
class PreviewRequest(BaseModel):
    """mapping: to be judged; without one, columns and suggestions are given alone. robot_id: whose joints and sensors
    the columns may name."""

    model_config = ConfigDict(extra="forbid")
    upload_id: UUID
    robot_id: UUID | None = None
    mapping: MappingGiven | None = None


@final
class SuggestionOut(BaseModel):
    """channel: contract name, `t` for the time. sure: nothing else fits; why: what it rests on."""

    channel: str
    unit: str
    sign: Literal[1, -1]
    side: Literal["joint", "motor"]
    sure: bool
    why: str


@final
class ColumnOut(BaseModel):
    """samples: the first rows, null where a value is missing. advice: why there is no suggestion, and what to do."""

    name: str
    dtype: Literal["number", "whole", "text", "array"]
    shape: list[int]
    min: float | None
    max: float | None
    missing: int
    samples: list[float | None]
    suggestion: SuggestionOut | None
    advice: str | None


@final
class AroundOut(BaseModel):
    """t [s]; values [unit], SI, joint side; null: missing."""

    unit: str
    t: list[float]
    values: list[float | None]


@final
class FindingOut(BaseModel):
    """index: sample from 0 and t: its time [s], where a finding has a place. row: the same, counted from 1. around:
    the channel's samples there."""

    severity: Literal["error", "warning", "note"]
    channel: str
    rule: str
    detail: str
    advice: str
    row: int | None
    index: int | None
    t: float | None
    value: float | None
    around: AroundOut | None


@final
class ClockOut(BaseModel):
    """Of the log that the given mapping makes; rate_hz: median."""

    samples: int
    duration_s: float
    rate_hz: float


@final
class PreviewOut(BaseModel):
    """header: whether the file names its columns. mapping: of what is sure; proposal: of every suggestion; remembered:
    the robot's, made to fit this file's name. complete: the given mapping makes a log, of these channels, and findings
    are the doctor's; else errors say what is missing. clock: wherever the columns could be read."""

    upload_id: str
    file: str
    rows: int
    header: bool
    columns: list[ColumnOut]
    mapping: dict[str, Any]
    proposal: dict[str, Any]
    remembered: dict[str, Any] | None
    complete: bool
    channels: list[str]
    clock: ClockOut | None
    errors: list[ProblemError]
    findings: list[FindingOut]


@final
class MappingIn(BaseModel):
    model_config = ConfigDict(extra="forbid")
    mapping: MappingGiven


@final
class MappingOut(BaseModel):
    """robot_id: of the version of the robot for which it was kept. yaml: the same, as a file to hand in."""

    robot_id: str
    mapping: dict[str, Any]
    yaml: str
    changed_at: datetime


@router.post("/imports/preview", operation_id="previewLog")
def preview_log(wanted: PreviewRequest, storage: StorageDep, settings: SettingsDep, files: FilesDep) -> PreviewOut:
    """What an uploaded log holds and what its columns may be; with a mapping, whether it makes a log, and how sound."""
    ((upload, path),) = whole([str(wanted.upload_id)], storage, files)
    robot_id = None if wanted.robot_id is None else str(wanted.robot_id)
    name = safe_path(PurePosixPath(upload.name).name)
    text = None if wanted.mapping is None else mapping_text(wanted.mapping)
    with scratch_folder(settings) as scratch:
        robot = None if robot_id is None else lay_out_robot(robot_id, storage, scratch / "robot")
        with path.open("rb") as source:
            write(source, scratch / "log" / name, Allowance.of(settings))
        mapping = None if text is None else lay_out_mapping(text, scratch, settings)
        looked = asked("look", scratch, BadLog, file=name, robot=robot, mapping=mapping)
    given = looked.pop("given")
    return PreviewOut(
        upload_id=upload.id,
        **looked,
        remembered=remembered(robot_id, name, storage),
        complete=given is not None and not given["faults"],
        channels=given["channels"] if given else [],
        clock=given["clock"] if given else None,
        errors=[of_fault(Fault(**fault)) for fault in given["faults"]] if given else [],
        findings=given["findings"] if given else [],
    )


@router.get("/robots/{robot_id}/mapping", operation_id="getRobotMapping")
def get_robot_mapping(robot_id: Id, store: ReaderDep, response: Response) -> MappingOut:
    """The mapping kept for the robot, or else the last one kept for another version of it."""
    return shown(store.mappings.of_robot(str(robot_id)), response)


@router.put(
    "/robots/{robot_id}/mapping",
    operation_id="putRobotMapping",
    responses={201: {"model": MappingOut, "description": "The robot's first"}},
)
def put_robot_mapping(
    robot_id: Id,
    wanted: MappingIn,
    storage: StorageDep,
    settings: SettingsDep,
    response: Response,
    if_match: IfMatch = None,
) -> MappingOut:
    """Keep a mapping for the robot's next logs, once it has been found to be one of this robot."""
    content = checked_mapping(mapping_text(wanted.mapping), str(robot_id), storage, settings)
    pinned = sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()

    def replaced(present: str) -> None:
        refuse_changed(if_match, f'"{present}"', "the robot's mapping")

    with storage.transaction() as store:
        if if_match is not None:
            replaced(hash_shown(store, str(robot_id)))
        kept, new = store.mappings.keep(str(robot_id), content, pinned, replaced)
    response.status_code = 201 if new else 200
    return shown(kept, response)


def hash_shown(store: Store, robot_id: str) -> str:
    """Of the mapping that a reader sees, be it another version's. 412 where there is none to be replaced."""
    try:
        return store.mappings.of_robot(robot_id).content_hash
    except NotFound:
        raise HTTPException(412, "no mapping is kept for this robot yet") from None


def checked_mapping(text: bytes, robot_id: str, storage: Storage, settings: Settings) -> dict[str, Any]:
    """The mapping's content. Raises BadStudy where it is none, or names joints that the robot has not."""
    with storage.reading() as store:
        joints = store.robots.get(robot_id).summary.get("joints")
    with scratch_folder(settings) as scratch:
        file = lay_out_mapping(text, scratch, settings)
        answer = asked("mapping", scratch, BadStudy, file=file, joints=joints)
    content: dict[str, Any] = answer["content"]
    return content


def lay_out_mapping(text: bytes, folder: Path, settings: Settings) -> str:
    if len(text) > settings.max_description_bytes:
        raise TooLarge(
            Fault(f"a mapping may have {settings.max_description_bytes} bytes", "too_many_bytes", "", MAPPING)
        )
    (folder / MAPPING).write_bytes(text)
    return MAPPING


def asked(task: str, folder: Path, error: type[BadInput], **options: Any) -> dict[str, Any]:
    limits = Limits.for_bytes(sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()))
    with TemporaryDirectory(prefix="exogauge-") as own:
        return ask(CHILD, task, {"folder": str(folder), **options}, Path(own), limits, error, what="log")


def remembered(robot_id: str | None, file: str, storage: Storage) -> dict[str, Any] | None:
    """The robot's mapping with the name of this file, where it reads one file."""
    if robot_id is None:
        return None
    with storage.reading() as store:
        try:
            kept = store.mappings.of_robot(robot_id)
        except NotFound:
            return None
    parts: list[Mapping[str, Any]] = kept.content["files"]
    content = dict(kept.content)
    if len(parts) == 1:
        content["files"] = [{**parts[0], "file": file}]
    return content


def shown(kept: MappingRecord, response: Response) -> MappingOut:
    response.headers["ETag"] = f'"{kept.content_hash}"'
    text = yaml.safe_dump(dict(kept.content), allow_unicode=True, sort_keys=False)
    return MappingOut(robot_id=kept.robot_id, mapping=dict(kept.content), yaml=text, changed_at=kept.changed_at)
