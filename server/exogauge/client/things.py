"""What the service answers, as frozen records. Keys that this version does not know are left aside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, TypeVar, final

from exogauge.errors import ExogaugeError

Thing = TypeVar("Thing")


class NotOurs(ExogaugeError):
    """An answer that lacks what exogauge says."""


@dataclass(frozen=True, kw_only=True)
class Bundle:
    """Files that were handed in together, pinned by content_hash. summary: what their check found."""

    id: str
    name: str
    content_hash: str
    summary: Mapping[str, Any] = field(default_factory=dict, repr=False)


@final
@dataclass(frozen=True, kw_only=True)
class Robot(Bundle):
    version: int


@final
@dataclass(frozen=True, kw_only=True)
class Device(Bundle):
    """Checked against robot_id."""

    version: int
    robot_id: str


@final
@dataclass(frozen=True)
class Log:
    """An uploaded log. summary: what its reading found."""

    id: str
    name: str
    sha256: str
    size: int
    summary: Mapping[str, Any] = field(default_factory=dict, repr=False)


@final
@dataclass(frozen=True, kw_only=True)
class Study(Bundle):
    """Has no versions. latest_job: {id, state, …}, where it has one."""

    created_at: str | None = field(default=None, compare=False)
    latest_job: Mapping[str, Any] | None = field(default=None, repr=False, compare=False)


@final
@dataclass(frozen=True, kw_only=True)
class Payload(Bundle):
    version: int


@final
@dataclass(frozen=True, kw_only=True)
class Motion(Bundle):
    """What was captured of a person."""

    version: int


@final
@dataclass(frozen=True)
class Plan:
    """A motion of a robot. kind: retarget or excite. latest_job: {id, state, …} that makes it. found: what became of
    it, as plan.json says, None until it is made; found_job_id: the job whose files it is."""

    id: str
    name: str
    kind: str
    robot_id: str
    motion_id: str | None
    latest_job: Mapping[str, Any] | None = field(default=None, repr=False)
    found: Mapping[str, Any] | None = field(default=None, repr=False)
    found_job_id: str | None = None


@final
@dataclass(frozen=True)
class Publication:
    """A snapshot that anybody reads at `url`. revoked_at: since when its files are gone."""

    id: str
    key: str
    url: str
    title: str
    version: int
    study_id: str
    content_hash: str
    files: Sequence[Mapping[str, Any]] = field(default=(), repr=False)
    revoked_at: str | None = None
    revoked_because: str | None = None


@final
@dataclass(frozen=True)
class Job:
    """study_id, payload_id, motion_id, plan_id: one of them is what it is of. state: queued, running, succeeded,
    failed or cancelled.

    progress: 0..1. place: where in the queue, in words; ahead: how many start before it. stage: of an evaluation,
    what it is at. steps: [{message, progress, stage, started_at, seconds}] of the present attempt.

    reason: why it did not succeed; problem: the same with `errors` (file, row, column, value, advice), where what was
    handed in is to blame; defect: exogauge itself is.
    """

    id: str
    study_id: str | None
    kind: str
    state: str
    progress: float
    message: str
    stage: str | None = None
    payload_id: str | None = None
    motion_id: str | None = None
    plan_id: str | None = None
    place: str | None = None
    ahead: int | None = None
    steps: Sequence[Mapping[str, Any]] = field(default=(), repr=False)
    reason: str | None = None
    problem: Mapping[str, Any] | None = field(default=None, repr=False)
    defect: bool = False
    attempts: int = 0
    revision: int = 0
    settings: Mapping[str, Any] = field(default_factory=dict, repr=False)
    log: str | None = field(default=None, repr=False)

    @property
    def ended(self) -> bool:
        return self.state in ("succeeded", "failed", "cancelled")


@final
@dataclass(frozen=True)
class Artifact:
    """A file that a job made; href below the API's root."""

    name: str
    sha256: str
    size: int
    media_type: str
    href: str


@final
@dataclass(frozen=True)
class WhatIf:
    """Supporting torque before and after a change of the device.

    joints: [{joint, unit, before, after: {peak, mean, rms, integral, work}, percent}]. interference: [{joint, before,
    after}], shares of the main joints' rms. bands: [{band, before, after: {tension_max_n, length_min_m, length_max_m,
    stretch_max, slack_share} or None}]. changed: the content of its device.yaml. series: {t, joints: {joint: {before,
    after}}, bands: {band: {before, after: {tension_n, length_m} or None}}}, None unless asked for.
    samples: of the answer, every `every`-th of the log's of_samples.
    """

    log: str
    device: Mapping[str, str]
    samples: int
    of_samples: int
    every: int
    duration_s: float
    joints: Sequence[Mapping[str, Any]]
    main: Sequence[str]
    interference: Sequence[Mapping[str, Any]]
    bands: Sequence[Mapping[str, Any]]
    notes: Sequence[str]
    changed: Mapping[str, Any] = field(repr=False)
    elapsed_ms: float
    opening_ms: float
    cutoff_hz: float | None = None
    series: Mapping[str, Any] | None = field(default=None, repr=False)


def thing(kind: type[Thing], answer: Mapping[str, Any]) -> Thing:
    """The record of an answer."""
    known = {each.name for each in fields(kind)}  # type: ignore[arg-type]
    try:
        return kind(**{key: value for key, value in answer.items() if key in known})
    except TypeError as error:  # of another program, or of a release long gone
        raise NotOurs(f"this is no answer of exogauge: {error}") from error
