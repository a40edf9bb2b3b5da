"""What is asked of a robot and what is answered: a motion made of a person's, or one that identifies."""

from __future__ import annotations

from datetime import datetime
from typing import Any, Literal, Self, final

from pydantic import BaseModel, ConfigDict, Field

from exogauge.api.shapes import Answer, ArtifactOut, FileOut, LatestJob, ListOf, Part, told_of
from exogauge.errors import BadMotion, Fault
from exogauge.motion.contract import ExciteEntry, Kind, RetargetEntry
from exogauge.storage.records import LatestJobRecord, PlanRecord


@final
class PlanAsked(Part):
    """A motion for a robot: `retarget` of a motion, or `excite`. study_id: whose logs are known already."""

    name: str | None = Field(default=None, min_length=1, max_length=200)
    robot_id: str = Field(min_length=1, max_length=64)
    motion_id: str | None = Field(default=None, min_length=1, max_length=64)
    study_id: str | None = Field(default=None, min_length=1, max_length=64)
    retarget: RetargetEntry | None = None
    excite: ExciteEntry | None = None

    @property
    def kind(self) -> Kind:
        """BadMotion where what is asked does not fit together."""
        wrong: list[tuple[str, str, str]] = []
        if (self.retarget is None) == (self.excite is None):
            wrong.append(("one kind of plan is asked for at a time", "Give `retarget` or `excite`.", "retarget"))
        elif self.retarget is not None and self.motion_id is None:
            wrong.append(("nothing is there to retarget", "Give motion_id.", "motion_id"))
        elif self.retarget is not None and self.study_id is not None:
            wrong.append(("a study counts only for motions that identify", "Leave study_id out.", "study_id"))
        elif self.excite is not None and self.motion_id is not None:
            wrong.append(("a motion that identifies needs nobody", "Leave motion_id out.", "motion_id"))
        if wrong:
            raise BadMotion([Fault(detail, "wrong_request", advice, column=key) for detail, advice, key in wrong])
        return "retarget" if self.retarget is not None else "excite"


class _Found(BaseModel):
    model_config = ConfigDict(extra="ignore")


@final
class TrunkOut(_Found):
    """One joint of the torso. asked, given: least and most [rad]; bound: of the joint. beyond: share of nodes at which
    more is asked than it bears. rms, most: by how much it misses what it bears [rad]."""

    joint: str
    asked: list[float]
    given: list[float]
    bound: list[float]
    beyond: float
    rms: float | None
    most: float | None


@final
class BoundOut(_Found):
    """The joint that comes nearest to a kind of bound: by `share` of it, at `time` [s]."""

    kind: Literal["position", "velocity", "acceleration", "jerk", "torque"]
    joint: str
    share: float
    time: float


@final
class NearestOut(_Found):
    links: list[str]
    time: float


@final
class MarginsOut(_Found):
    """What is left at least; null where there is nothing of the kind. bounds: the nearest of each kind first."""

    pressure_inside_m: float | None
    weight_carried: float | None
    feet_m: float | None
    feet_rad: float | None
    apart_m: float | None
    nearest: NearestOut | None
    bounds: list[BoundOut]


@final
class MissedOut(_Found):
    """Of the trunk's turn, in directions in which the torso has no joint [rad]."""

    rms: float
    most: float


@final
class WouldDo(_Found):
    """slower: least number of times the time; share: of the trunk's angle. null: not even then."""

    slower: float | None
    share: float | None


@final
class FrameByFrameOut(_Found):
    """What would have become of the motion, had each frame been taken by itself and then smoothed. outside: share of
    samples in which the centre of pressure lies outside what the feet stand on. broken: bounds, in words."""

    outside: float
    margins: MarginsOut
    broken: list[str]


@final
class CertainOut(_Found):
    """One parameter: its standard deviation before the motion is recorded, and then. decided: by the data. kind: null
    of plans of earlier versions."""

    name: str
    unit: str
    before: float
    std: float
    decided: bool
    kind: Literal["base", "joint", "link", "added"] | None = None


@final
class CountOut(_Found):
    """How many parameters of a kind, of which something was left to know, the data will decide. left: median share of
    the doubt before."""

    kind: Literal["base", "joint"]
    decided: int
    of: int
    left: float


@final
class PlanFound(_Found):
    """plan.json. broken: bounds that do not hold, in words; empty where all do. told: the same in words, by key.
    counts: of base and joint parameters, to which those of links add nothing; empty in plans of earlier versions.
    frame_by_frame: null of plans of earlier versions, of those that excite, and where nothing was planned."""

    kind: Kind
    robot: str
    motion: str | None
    seconds: float
    rate_hz: float
    trunk: list[TrunkOut]
    missed: MissedOut | None
    margins: MarginsOut
    broken: list[str]
    would_do: WouldDo | None
    told: dict[str, str | float | list[str]]
    frame_by_frame: FrameByFrameOut | None = None
    parameters: list[CertainOut]
    counts: list[CountOut] = Field(default_factory=list)


@final
class MotionPlanOut(Answer):
    """request: as it was asked. latest_job: that makes it. found, artifacts: of the newest job that succeeded, given
    when one plan is asked for. studies: that hold its motion, by id and name."""

    id: str
    name: str
    created_at: datetime
    kind: Kind
    robot_id: str
    motion_id: str | None
    study_id: str | None
    content_hash: str
    request: dict[str, Any]
    robot: str
    motion: str | None
    latest_job: LatestJob | None = None
    found: PlanFound | None = None
    found_job_id: str | None = None
    artifacts: list[ArtifactOut] = Field(default_factory=list)
    files: list[FileOut] | None = None

    @classmethod
    def of(cls, plan: PlanRecord, job: LatestJobRecord | None) -> Self:
        said = {"kind": "retarget", "request": {}, "robot": "", "motion": None, **plan.summary}
        asked = {key: said[key] for key in ("kind", "request", "robot", "motion")}
        return cls.model_validate({**vars(plan), **asked, "latest_job": None if job is None else told_of(job)})


@final
class MotionPlanList(ListOf):
    items: list[MotionPlanOut]
