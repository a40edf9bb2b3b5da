"""The whole of results.json.

By which numbers it was decided.
"""

from __future__ import annotations

from typing import Literal, final

from pydantic import Field

from exogauge.studies.results.schema.device import BandStiffness, DoubtSource, StiffnessCheck, StiffnessFit, Support
from exogauge.studies.results.schema.discrepancy import Discrepancy
from exogauge.studies.results.schema.identification import Identification
from exogauge.studies.results.schema.scope import Configuration, Scope, Settings
from exogauge.studies.results.schema.values import Number, Part, later, maybe


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


@final
class InputFile(Part):
    """A file that was read."""

    file: str = Field(description="relative to the study")
    sha256: str = Field(description="of its bytes")
    bytes: int = Field(description="its size")


@final
class StepDone(Part):
    """One step of the evaluation."""

    step: str = Field(description="identify, discrepancy, support or stiffness")
    status: Literal["done", "skipped", "failed"] = Field(description="what became of it")
    reason: str = maybe("why it was skipped, or failed")


@final
class SignalDoubt(Part):
    """One thing that the doctor saw in a log."""

    log: str = Field(description="its name")
    severity: Literal["error", "warning", "note"] = Field(
        description="error: results would be wrong; warning: they may be; note: good to know"
    )
    channel: str | None = Field(description="`t` for the clock, `ft.*` for all contact sensors")
    rule: str = Field(description="a stable short code")
    detail: str = Field(description="what was seen, in words")
    advice: str = Field(description="what to do, in words")
    row: int | None = Field(description="data row from 1")
    value: Number = Field(description="the number behind it; its unit is in the detail")


@final
class Reading(Part):
    """Sentences on how to read numbers."""

    steady: str = Field(description="the column of steady motion")
    steady_seconds: str = Field(description="the table of steady seconds")
    support_table: str = Field(description="the tables of supporting torque")
    support_interval: str = Field(description="a range at rest")


@final
class Notice(Part):
    """What has to be kept in mind."""

    code: str = Field(description="what it is about")
    sentence: str = Field(description="with all names")
    short: str = later("the same, of more than six names with the first few")
    names: list[str] = Field(description="joints, links, logs, bands or parameters that it is about")
    each: list[list[Number]] = Field(description="numbers of each name that its sentence tells; may be empty")
    beside: list[str] = Field(description="other names of its sentence")
    numbers: list[Number] = Field(description="other numbers of its sentence")


@final
class StudyResults(Part):
    """results.json: all that an evaluation found."""

    version: Literal[1] = Field(description="of this form")
    name: str = Field(description="of the study")
    robot: str = Field(description="its name")
    scope: Scope = later("for what the results hold")
    configuration: Configuration = later("with what they were obtained")
    software: dict[str, str] = Field(description="versions that may change a number")
    inputs: list[InputFile] = Field(description="every file that was read")
    steps: list[StepDone] = Field(description="in order")
    settings: Settings = Field(description="as study.yaml has them")
    criteria: list[Criterion] = later("by which numbers it was decided")
    warnings: list[str] = Field(description="in sentences")
    notices: list[Notice] = later("the same with what they are about, in the same order")
    plans: list[PlanFollowed] = later("planned motions that study.yaml names or the service knows, and their logs")
    doctor: list[SignalDoubt] = Field(description="worst first, log by log")
    identification: Identification = Field(description="the robot")
    support: list[Support] = Field(description="by device, motion and joint; empty without a device")
    stiffness: list[BandStiffness] = Field(description="by device, approach and band; empty without a device")
    cross_checks: list[StiffnessCheck] = later("what ought to agree, by device and approach")
    doubt_sources: list[DoubtSource] = later("what doubts are made of, in words")
    stiffness_details: list[StiffnessFit] = Field(description="by device and approach")
    discrepancy: Discrepancy | None = Field(description="null where the step was skipped or failed")
    reading: Reading = later("how to read numbers")
    files: dict[str, str] = Field(description="that stand beside it, by what they are")


@final
class Criterion(Part):
    """A number that decides a name, a verdict, a doubt or a warning."""

    name: str = Field(description="its part, and what it is there")
    value: float | list[float] = Field(description="[unit]")
    unit: str = Field(description="`1` for a ratio or a factor")
    why: str = Field(description="what it is for, in words")
    source: Literal["derived", "measured", "convention", "judgement"] = Field(
        description="derived of an equation or a distribution; measured on recordings or cases; a convention of the "
        "field; the judgement of who made the rule"
    )
    where: str = Field(description="what it follows from or was measured on, or the document of its rule")
