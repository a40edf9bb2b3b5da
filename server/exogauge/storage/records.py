"""What the store hands out: frozen copies of rows. Nothing outside `storage` holds a database row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Generic, TypeVar, final

Record = TypeVar("Record")


@final
@dataclass(frozen=True)
class Page(Generic[Record]):
    """One page of a list, newest first; `after` continues it, None at its end."""

    items: tuple[Record, ...]
    after: tuple[datetime, str] | None


@dataclass(frozen=True)
class BundleRecord:
    """Files that were handed in together. content_hash: over all of them; summary: what their check found."""

    id: str
    created_at: datetime
    name: str
    content_hash: str
    summary: Mapping[str, Any]


@final
@dataclass(frozen=True)
class RobotRecord(BundleRecord):
    version: int


@final
@dataclass(frozen=True)
class DeviceRecord(BundleRecord):
    """robot_id: the robot it was checked against."""

    version: int
    robot_id: str


@final
@dataclass(frozen=True)
class LogRecord:
    id: str
    created_at: datetime
    name: str
    content_hash: str
    sha256: str
    size: int
    mapping_sha256: str | None
    summary: Mapping[str, Any]


@final
@dataclass(frozen=True)
class StudyRecord(BundleRecord):
    """Has no versions: a study under a name that is taken is another study."""


@final
@dataclass(frozen=True)
class PayloadRecord(BundleRecord):
    version: int


@final
@dataclass(frozen=True)
class MotionRecord(BundleRecord):
    version: int


@final
@dataclass(frozen=True)
class PlanRecord(BundleRecord):
    """robot_id: for which; motion_id: what is retargeted; study_id: whose logs are known already."""

    robot_id: str
    motion_id: str | None
    study_id: str | None


@final
@dataclass(frozen=True)
class LiveStreamRecord:
    """job_id: whose results compensated it. sha256, size: of the raw stream, None while it is open."""

    id: str
    created_at: datetime
    payload_id: str
    job_id: str | None
    state: str
    started_at: datetime
    ended_at: datetime | None
    samples: int
    dropped: int
    late: int
    last_sequence: int | None
    summary: Mapping[str, Any]
    sha256: str | None
    size: int | None


@final
@dataclass(frozen=True)
class LatestJobRecord:
    """Where what a job is of stands, as far as a list tells. Fields as of JobRecord."""

    id: str
    kind: str
    state: str
    progress: float
    message: str
    reason: str | None
    failure: Mapping[str, Any] | None
    created_at: datetime
    started_at: datetime | None
    finished_at: datetime | None


@dataclass(frozen=True)
class ListedJobRecord:
    """study_id, payload_id, motion_id, plan_id: one of them is what the job is of. progress: 0..1. reason: why it
    failed.

    failure: {class, faults, defect} of the error that ended it; defect: exogauge itself is to blame, not what was
    handed in. stage: of an evaluation, what it is at. lab_id: whose it is; a worker works for all labs.
    requested_code_version: of the server that took the request; code_version: of the worker that took the job.
    crashes: attempts in which its computation died alone. cpu_s: CPU seconds of all attempts."""

    id: str
    lab_id: str
    created_at: datetime
    kind: str
    study_id: str | None
    payload_id: str | None
    motion_id: str | None
    plan_id: str | None
    request_hash: str
    settings: Mapping[str, Any]
    requested_code_version: str
    code_version: str | None
    state: str
    progress: float
    message: str
    stage: str | None
    reason: str | None
    failure: Mapping[str, Any] | None
    attempts: int
    crashes: int
    cpu_s: float
    cancel_requested: bool
    started_at: datetime | None
    finished_at: datetime | None
    worker: str | None
    revision: int


@final
@dataclass(frozen=True)
class JobRecord(ListedJobRecord):
    """steps: {message, progress, stage, at} of the present attempt. log: the last lines of what the worker said. They
    are most of what a job is, so that lists go without."""

    steps: Sequence[Mapping[str, Any]] | None
    log: str


@final
@dataclass(frozen=True)
class UploadRecord:
    """size: bytes the file will have."""

    id: str
    created_at: datetime
    name: str
    size: int
    expires_at: datetime


@final
@dataclass(frozen=True)
class MappingRecord:
    """content: as in mapping.yaml."""

    id: str
    created_at: datetime
    robot_id: str
    content: Mapping[str, Any]
    content_hash: str
    changed_at: datetime


@final
@dataclass(frozen=True)
class ContactsRecord:
    """content: {left, right: [[begin, end] [s]]}, when each foot stands."""

    id: str
    created_at: datetime
    motion_id: str
    content: Mapping[str, Any]
    content_hash: str
    changed_at: datetime


@final
@dataclass(frozen=True)
class MapRecord:
    """content: {own name: known name} of labels or bones."""

    id: str
    created_at: datetime
    name: str
    content: Mapping[str, Any]
    content_hash: str
    changed_at: datetime


@final
@dataclass(frozen=True)
class ResultRecord:
    id: str
    created_at: datetime
    job_id: str
    study_id: str | None
    payload_id: str | None
    motion_id: str | None
    plan_id: str | None
    sha256: str
    size: int


@final
@dataclass(frozen=True)
class ArtifactRecord:
    id: str
    created_at: datetime
    job_id: str
    name: str
    sha256: str
    size: int
    media_type: str


@final
@dataclass(frozen=True)
class LabRecord:
    """closed_at: since when nobody comes in."""

    id: str
    created_at: datetime
    name: str
    closed_at: datetime | None


@final
@dataclass(frozen=True)
class AccountRecord:
    """email: in small letters. operator: may found labs."""

    id: str
    created_at: datetime
    email: str
    name: str
    operator: bool
    disabled_at: datetime | None


@final
@dataclass(frozen=True)
class IdentityRecord:
    id: str
    created_at: datetime
    issuer: str
    subject: str


@final
@dataclass(frozen=True)
class MemberRecord:
    """role: viewer, member or admin. since: when it became one."""

    account_id: str
    email: str
    name: str
    role: str
    since: datetime
    disabled_at: datetime | None


@final
@dataclass(frozen=True)
class TokenRecord:
    """scope: read or write. account_id: whose; None for a robot. hint: its first letters."""

    id: str
    created_at: datetime
    name: str
    scope: str
    account_id: str | None
    made_by: str | None
    hint: str
    expires_at: datetime | None
    revoked_at: datetime | None
    used_at: datetime | None


@final
@dataclass(frozen=True)
class InvitationRecord:
    """Of whom, as what; open until one of the three times."""

    id: str
    lab_id: str
    created_at: datetime
    email: str
    role: str
    made_by: str | None
    expires_at: datetime
    accepted_at: datetime | None
    revoked_at: datetime | None


@final
@dataclass(frozen=True)
class AuditRecord:
    id: str
    created_at: datetime
    actor: str
    action: str
    subject_kind: str
    subject_id: str
    before_hash: str | None
    after_hash: str | None
    said: str


@final
@dataclass(frozen=True)
class ShareRecord:
    """to_lab, lab: id and name of who may read; None for every lab."""

    id: str
    created_at: datetime
    to_lab: str | None
    lab: str | None


@final
@dataclass(frozen=True)
class SharedStudy:
    """lab: whose it is."""

    study_id: str
    name: str
    lab: str
    since: datetime


@final
@dataclass(frozen=True)
class PublicationRecord:
    """A snapshot. manifest: [{path, sha256, size, media_type}], also of one that was revoked."""

    id: str
    lab_id: str
    created_at: datetime
    key: str
    series_id: str
    version: int
    study_id: str
    job_id: str
    content_hash: str
    manifest: Sequence[Mapping[str, Any]]
    about: Mapping[str, Any]
    lab_name: str
    revoked_at: datetime | None
    revoked_because: str | None


@final
@dataclass(frozen=True)
class WebhookRecord:
    id: str
    created_at: datetime
    url: str
    events: Sequence[str]
    disabled_at: datetime | None
    disabled_because: str | None


@final
@dataclass(frozen=True)
class DeliveryRecord:
    """state: waiting, delivered or failed. status, said: of the last try."""

    id: str
    created_at: datetime
    webhook_id: str
    event: str
    state: str
    attempts: int
    due_at: datetime
    ended_at: datetime | None
    status: int | None
    said: str


@final
@dataclass(frozen=True)
class PublishedFile:
    path: str
    sha256: str
    size: int
    media_type: str
