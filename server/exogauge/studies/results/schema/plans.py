"""Planned motions in results.json: which logs are of which, and how far the robot strayed."""

from __future__ import annotations

from typing import Literal, final

from pydantic import Field

from exogauge.studies.results.schema.values import Number, Part


@final
class JointStray(Part):
    """One joint beside the plan."""

    joint: str = Field(description="its name")
    unit: Literal["rad", "m"] = Field(description="of rms and most")
    rms: Number = Field(description="[unit] from the plan")
    most: Number = Field(description="[unit] from the plan, where it is farthest")
    at_s: Number = Field(description="[s] of the log, when that is")
    later_s: Number = Field(
        description="[s] later than the plan as it was placed for all joints; null of a joint that rests in the plan"
    )


@final
class LogOfPlan(Part):
    """A log beside the plan that it is of, or may be of."""

    log: str = Field(description="its name")
    state: Literal["follows", "undecided"] = Field(
        description="undecided: farther away than what follows, or as near to another plan"
    )
    begins_s: Number = Field(description="[s] of the log, when the plan begins; the robot's delay is in it")
    share: Number = Field(description="rms by which the moving joints stray, of their motion in the plan")
    covered: Number = Field(description="share of the plan that the log holds, 0…1")
    or_plans: list[str] = Field(description="names of other plans that it may be of as well")
    joints: list[JointStray] = Field(description="farthest first")


@final
class PlanFollowed(Part):
    """One planned motion."""

    plan: str = Field(description="its name, unique")
    file: str | None = Field(description="as study.yaml names it; null of one that the service has")
    plan_id: str | None = Field(description="its id in the service; null where only the study has it")
    sha256: str = Field(description="of its table")
    seconds: Number = Field(description="[s] that it takes")
    logs: list[LogOfPlan] = Field(description="that are or may be of it; empty where none is")
    sentence: str = Field(description="what came of it, in words")
