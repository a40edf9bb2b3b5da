"""What a lab hands in: robots, devices, logs, studies, payloads, motions, plans, and how they are read."""

from __future__ import annotations

from datetime import datetime
from typing import Any, final

import sqlalchemy as sa
from sqlalchemy.orm import Mapped, mapped_column

from exogauge.storage.database import UtcDateTime
from exogauge.storage.table_kinds import (
    NAME,
    SHA256,
    UUID,
    Base,
    Named,
    Owned,
    PinnedRow,
    Remembered,
    one_of,
    referred,
    utc_now,
    within_lab,
)

STREAM_STATES = ("open", "ended", "lost")  # lost: whoever sent or took it went without a word


@final
class Robot(Named, Base):
    """One version of a robot bundle."""

    __tablename__ = "robots"
    __table_args__ = (
        referred(),
        sa.UniqueConstraint("lab_id", "name", "version"),
        sa.UniqueConstraint("lab_id", "name", "content_hash"),
        sa.Index(None, "lab_id", "created_at", "id"),
    )
    version: Mapped[int]


@final
class RobotFile(PinnedRow, Base):
    """One file of a robot bundle."""

    __tablename__ = "robot_files"
    __table_args__ = (
        sa.UniqueConstraint("robot_id", "path"),
        within_lab("robot_id", "robots"),
    )
    robot_id: Mapped[str] = mapped_column(UUID, index=True)


@final
class RobotMapping(Remembered, Base):
    """How the logs of a robot are read, remembered from the last import. content: as in mapping.yaml."""

    __tablename__ = "robot_mappings"
    __table_args__ = (
        sa.UniqueConstraint("robot_id"),
        within_lab("robot_id", "robots"),
    )
    robot_id: Mapped[str] = mapped_column(UUID)


@final
class Device(Named, Base):
    """One version of a device bundle, checked against one robot.

    The same files checked against another robot are another version: what the check found belongs to both.
    """

    __tablename__ = "devices"
    __table_args__ = (
        within_lab("robot_id", "robots", None),
        referred(),
        sa.UniqueConstraint("lab_id", "name", "version"),
        sa.UniqueConstraint("lab_id", "name", "robot_id", "content_hash"),
        sa.Index(None, "lab_id", "created_at", "id"),
    )
    version: Mapped[int]
    robot_id: Mapped[str] = mapped_column(UUID, index=True)


@final
class DeviceFile(PinnedRow, Base):
    """One file of a device bundle: device.yaml, bench tests."""

    __tablename__ = "device_files"
    __table_args__ = (
        sa.UniqueConstraint("device_id", "path"),
        within_lab("device_id", "devices"),
    )
    device_id: Mapped[str] = mapped_column(UUID, index=True)


@final
class Log(Owned, Base):
    """An uploaded log, byte for byte, with what its reading said of it. mapping_sha256: the mapping it is read with."""

    __tablename__ = "logs"
    __table_args__ = (
        sa.UniqueConstraint("lab_id", "name", "content_hash"),
        sa.Index(None, "lab_id", "created_at", "id"),
    )
    name: Mapped[str] = mapped_column(NAME)
    content_hash: Mapped[str] = mapped_column(SHA256)
    sha256: Mapped[str] = mapped_column(SHA256, index=True)
    size: Mapped[int] = mapped_column(sa.BigInteger)
    mapping_sha256: Mapped[str | None] = mapped_column(SHA256, index=True)
    summary: Mapped[dict[str, Any]] = mapped_column(sa.JSON)


@final
class Study(Named, Base):
    """A study as it was handed in; its files are pinned by hash and never change."""

    __tablename__ = "studies"
    __table_args__ = (
        referred(),
        sa.UniqueConstraint("lab_id", "content_hash"),
        sa.Index(None, "lab_id", "created_at", "id"),
    )


@final
class StudyFile(PinnedRow, Base):
    """One pinned file of a study: study.yaml, the robot bundle, logs, mappings, device."""

    __tablename__ = "study_files"
    __table_args__ = (
        sa.UniqueConstraint("study_id", "path"),
        within_lab("study_id", "studies"),
    )
    study_id: Mapped[str] = mapped_column(UUID, index=True)


@final
class Payload(Named, Base):
    """One version of what hangs on a wrist sensor, as it was handed in; its files are pinned by hash."""

    __tablename__ = "payloads"
    __table_args__ = (
        referred(),
        sa.UniqueConstraint("lab_id", "name", "version"),
        sa.UniqueConstraint("lab_id", "name", "content_hash"),
        sa.Index(None, "lab_id", "created_at", "id"),
    )
    version: Mapped[int]


@final
class PayloadFile(PinnedRow, Base):
    """One file of a payload: payload.yaml, the URDF, logs."""

    __tablename__ = "payload_files"
    __table_args__ = (
        sa.UniqueConstraint("payload_id", "path"),
        within_lab("payload_id", "payloads"),
    )
    payload_id: Mapped[str] = mapped_column(UUID, index=True)


@final
class Motion(Named, Base):
    """One version of what was captured of a person, as it was handed in: motion.yaml and the files that it names."""

    __tablename__ = "motions"
    __table_args__ = (
        referred(),
        sa.UniqueConstraint("lab_id", "name", "version"),
        sa.UniqueConstraint("lab_id", "name", "content_hash"),
        sa.Index(None, "lab_id", "created_at", "id"),
    )
    version: Mapped[int]


@final
class MotionFile(PinnedRow, Base):
    """One file of a motion: motion.yaml, the capture, its skeleton, a static trial."""

    __tablename__ = "motion_files"
    __table_args__ = (
        sa.UniqueConstraint("motion_id", "path"),
        within_lab("motion_id", "motions"),
    )
    motion_id: Mapped[str] = mapped_column(UUID, index=True)


@final
class MotionContacts(Remembered, Base):
    """When each foot of a motion stands, as somebody said it. content: {left, right: [[begin, end] [s]]}."""

    __tablename__ = "motion_contacts"
    __table_args__ = (
        sa.UniqueConstraint("motion_id"),
        within_lab("motion_id", "motions"),
    )
    motion_id: Mapped[str] = mapped_column(UUID)


@final
class MotionMap(Remembered, Base):
    """What a lab's own labels or bones are called elsewhere. content: {own name: known name}."""

    __tablename__ = "motion_maps"
    __table_args__ = (sa.UniqueConstraint("lab_id", "name"), sa.Index(None, "lab_id", "created_at", "id"))
    name: Mapped[str] = mapped_column(NAME)


@final
class Plan(Named, Base):
    """A motion that was asked for of a robot: plan.yaml says how. motion_id: what is retargeted; study_id: whose logs
    are known already. What they name stays as long as the plan does."""

    __tablename__ = "plans"
    __table_args__ = (
        within_lab("robot_id", "robots", None),
        within_lab("motion_id", "motions", None),
        within_lab("study_id", "studies", None),
        referred(),
        sa.UniqueConstraint("lab_id", "content_hash"),
        sa.Index(None, "lab_id", "created_at", "id"),
    )
    robot_id: Mapped[str] = mapped_column(UUID, index=True)
    motion_id: Mapped[str | None] = mapped_column(UUID, index=True)
    study_id: Mapped[str | None] = mapped_column(UUID, index=True)


@final
class PlanFile(PinnedRow, Base):
    """One file of a plan: plan.yaml."""

    __tablename__ = "plan_files"
    __table_args__ = (
        sa.UniqueConstraint("plan_id", "path"),
        within_lab("plan_id", "plans"),
    )
    plan_id: Mapped[str] = mapped_column(UUID, index=True)


@final
class LiveStream(Owned, Base):
    """What arrived live from the sensor of a payload.

    job_id: whose results compensated it, and stay as long as it does. samples: taken; dropped: refused or never
    arrived; late: taken, behind their time. last_sequence: number of the last sample taken, None before the first.
    sha256, size: of the raw stream, kept as a blob, None while it is open.
    """

    __tablename__ = "live_streams"
    __table_args__ = (
        within_lab("payload_id", "payloads"),
        within_lab("job_id", "jobs", None),
        sa.CheckConstraint(one_of("state", STREAM_STATES), name="state"),
        sa.CheckConstraint("samples >= 0 AND dropped >= 0 AND late >= 0", name="counts"),
        sa.Index(None, "lab_id", "created_at", "id"),
    )
    payload_id: Mapped[str] = mapped_column(UUID, index=True)
    job_id: Mapped[str | None] = mapped_column(UUID, index=True)
    state: Mapped[str] = mapped_column(sa.String(16), default="open")
    started_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    ended_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    samples: Mapped[int] = mapped_column(sa.BigInteger, default=0)
    dropped: Mapped[int] = mapped_column(sa.BigInteger, default=0)
    late: Mapped[int] = mapped_column(sa.BigInteger, default=0)
    last_sequence: Mapped[int | None] = mapped_column(sa.BigInteger)
    summary: Mapped[dict[str, Any]] = mapped_column(sa.JSON, default=dict)
    sha256: Mapped[str | None] = mapped_column(SHA256, index=True)
    size: Mapped[int | None] = mapped_column(sa.BigInteger)
