"""What the API answers: pydantic models, each made from a record of the store in one visible place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any, ClassVar, Literal, Self, final

from pydantic import BaseModel, ConfigDict, Field, model_validator

from exogauge.api.problems import Problem, of_failure
from exogauge.storage.files import PinnedFile
from exogauge.storage.records import ArtifactRecord, LatestJobRecord

State = Literal["queued", "running", "succeeded", "failed", "cancelled"]
Role = Literal["identification", "validation", "without_device", "with_device"]


class Answer(BaseModel):
    model_config = ConfigDict(from_attributes=True)


@final
class FileOut(Answer):
    """A pinned file: its path in the bundle, the SHA-256 of its bytes, its size in bytes."""

    path: str
    sha256: str
    size: int


class Kept(Answer):
    """What was handed in as files and is stored. content_hash covers every file; files, and of the summary what is
    `long`, are given when one is asked for."""

    long: ClassVar[tuple[str, ...]] = ()
    id: str
    name: str
    created_at: datetime
    content_hash: str
    summary: dict[str, Any]
    files: list[FileOut] | None = None

    @classmethod
    def told(
        cls, record: Any, job: LatestJobRecord | None = None, files: Sequence[PinnedFile] | None = None
    ) -> dict[str, Any]:
        """What it answers. record: of the store; job: its newest; files: of one that is asked for, None in a list."""
        said = {**vars(record), "latest_job": None if job is None else told_of(job), "files": files}
        if files is None and cls.long:
            said["summary"] = {key: value for key, value in record.summary.items() if key not in cls.long}
        return said

    @classmethod
    def of(cls, *told: Any, **more: Any) -> Self:
        """As `told`."""
        return cls.model_validate(cls.told(*told, **more))


@final
class RobotOut(Kept):
    """One version of a robot. content_hash covers every file. files, and of the summary `model` (joints, links and
    their places): given when one is asked for."""

    long = ("model",)
    version: int


@final
class DeviceOut(Kept):
    """One version of a device, as checked against one robot. summary: bands, groups, joints that they act on; lengths,
    moment arms and torques with all joints at zero; warnings. content_hash covers every file; files: given when one is
    asked for."""

    version: int
    robot_id: str


@final
class LawValueOut(Answer):
    """A value of a law of bands, in `law_values` of device.yaml. typical: of ordinary size, to begin with. low, high:
    its range, ends included; high null: no end. default: what it is where it is left out; null: it must be given."""

    name: str
    unit: str
    words: str
    typical: float
    low: float
    high: float | None
    default: float | None


@final
class LawOut(Answer):
    """A law of device.yaml. sentence: what a band does that pulls so."""

    name: str
    sentence: str
    values: list[LawValueOut]


@final
class LawsOut(Answer):
    """Every law of bands; several are one law with + between their names."""

    laws: list[LawOut]


@final
class LogOut(Answer):
    """A stored log. sha256: of its bytes as uploaded; summary: what its reading found."""

    id: str
    name: str
    created_at: datetime
    sha256: str
    size: int
    mapping_sha256: str | None
    summary: dict[str, Any]


@final
class LatestJob(Answer):
    """A study's newest job, in short. progress: 0..1; reason: why it failed; problem: place by place."""

    id: str
    kind: str
    state: State
    progress: float
    message: str
    reason: str | None
    problem: Problem | None = None
    created_at: datetime
    started_at: datetime | None
    finished_at: datetime | None


def told_of(job: LatestJobRecord) -> dict[str, Any]:
    """What it answers (`LatestJob`)."""
    return {**vars(job), "problem": of_failure(job.failure, job.reason)}


@final
class StudyOut(Kept):
    """content_hash covers every file; files: given when one is asked for. shared_by: the lab whose it
    is, which lets one's own read it; null: it is one's own."""

    latest_job: LatestJob | None = None
    shared_by: str | None = None


@final
class ArtifactOut(Answer):
    """A file that a job made; href is relative to the API's root `/api/v1/`."""

    name: str
    sha256: str
    size: int
    media_type: str
    href: str

    @staticmethod
    def told(artifact: ArtifactRecord) -> dict[str, Any]:
        """What it answers."""
        return {**vars(artifact), "href": f"jobs/{artifact.job_id}/artifacts/{artifact.name}"}

    @classmethod
    def of(cls, artifact: ArtifactRecord) -> Self:
        return cls.model_validate(cls.told(artifact))


class ListOf(Answer):
    """One page; next_cursor continues it and is null at the end."""

    next_cursor: str | None = None


@final
class RobotList(ListOf):
    items: list[RobotOut]


@final
class DeviceList(ListOf):
    items: list[DeviceOut]


@final
class LogList(ListOf):
    items: list[LogOut]


@final
class StudyList(ListOf):
    items: list[StudyOut]


@final
class ArtifactList(ListOf):
    items: list[ArtifactOut]


@final
class Health(BaseModel):
    """status: ok; degraded: fewer workers live than wanted; unavailable (503): database or blobs do not answer."""

    status: Literal["ok", "degraded", "unavailable"]
    version: str
    database: str
    blobs: str
    workers_wanted: int
    workers_alive: int


class Part(BaseModel):
    model_config = ConfigDict(extra="forbid")


@final
class LogPart(Part):
    """One uploaded log and its role. rows: [start, stop], data rows from 0, stop not included.

    motion: logs of one motion are compared. device_id: what was worn, where it is not the study's device. started: [s]
    when it began, on one clock for all of them: drift of motors is found from it.
    """

    log_id: str = Field(min_length=1, max_length=64)
    role: Role
    motion: str | None = Field(default=None, max_length=200)
    device_id: str | None = Field(default=None, min_length=1, max_length=64)
    rows: tuple[int, int] | None = None
    started: float | None = Field(default=None, allow_inf_nan=False)
    name: str | None = Field(default=None, max_length=100)

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.device_id is not None and self.role != "with_device":
            raise ValueError(f"a log with role {self.role} wears no device: leave device_id out, or say with_device")
        return self


@final
class StudyFromParts(Part):
    """A study made of a robot, devices and logs that were uploaded before; the service writes its study.yaml.

    device_id: what the logs with role with_device were recorded with, unless they say otherwise. known: as in
    study.yaml, weighed loads that some of the logs carry; these by their names there.
    """

    name: str = Field(min_length=1, max_length=200)
    robot_id: str = Field(min_length=1, max_length=64)
    device_id: str | None = Field(default=None, min_length=1, max_length=64)
    logs: list[LogPart] = Field(min_length=1, max_length=1000)
    steps: list[str] | None = Field(default=None, max_length=20)
    settings: dict[str, Any] | None = None
    known: list[dict[str, Any]] | None = Field(default=None, max_length=50)

    @property
    def device_ids(self) -> tuple[str, ...]:
        """Every device that is named, once."""
        named = (self.device_id, *(part.device_id for part in self.logs))
        return tuple(dict.fromkeys(key for key in named if key is not None))

    def study_yaml(self, log_files: Sequence[Mapping[str, str]], device_files: Mapping[str, str]) -> dict[str, Any]:
        """The content of study.yaml. log_files: `file` (and `mapping`) of each log in the bundle; device_files: device
        id -> its file there."""
        logs = []
        for part, files in zip(self.logs, log_files, strict=True):
            said = part.model_dump(exclude_none=True, exclude={"log_id", "device_id"}, mode="json")
            worn = {} if part.device_id is None else {"device": device_files[part.device_id]}
            logs.append({**files, **said, **worn})
        content: dict[str, Any] = {"version": 1, "name": self.name, "robot": "robot.yaml", "logs": logs}
        device = None if self.device_id is None else device_files[self.device_id]
        optional = {"device": device, "steps": self.steps, "settings": self.settings, "known": self.known}
        return content | {key: value for key, value in optional.items() if value is not None}
