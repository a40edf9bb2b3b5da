"""What motion.yaml and plan.yaml may hold: a capture and how it is read; a motion that is asked of a robot."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal, final

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from exogauge.criteria.motion_plan import USUAL
from exogauge.errors import BadMotion, Fault

Axis = Literal["x", "y", "z", "-x", "-y", "-z"]
Unit = Literal["m", "cm", "mm", "in", "cmu"]
Angle = Literal["deg", "rad"]
Span = Annotated[list[Annotated[float, Field(ge=0.0, allow_inf_nan=False)]], Field(min_length=2, max_length=2)]
Spans = Annotated[list[Span], Field(max_length=10_000)]


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


@final
class CaptureFile(_Part):
    """motion.yaml. file: C3D, TRC, TSV, CSV, MVNX, MOT, STO, BVH or AMC; skeleton: ASF of an AMC; static: the same
    person and markers, standing straight. up, unit, angle (of turns): where the file is silent or wrong. subject:
    prefix of one of several people. names: own label or bone -> the name it is known by."""

    version: Literal[1] = 1
    name: str = Field(default="", max_length=200)
    file: str = Field(min_length=1, max_length=400)
    skeleton: str | None = Field(default=None, max_length=400)
    static: str | None = Field(default=None, max_length=400)
    up: Axis | None = None
    unit: Unit | None = None
    angle: Angle | None = None
    subject: str | None = Field(default=None, max_length=200)
    names: dict[str, str] = Field(default_factory=dict, max_length=1000)


@final
class ContactsEntry(_Part):
    """Stretches [begin, end] [s] in which each foot stands."""

    left: Spans
    right: Spans

    @field_validator("left", "right")
    @classmethod
    def in_order(cls, spans: list[list[float]]) -> list[list[float]]:
        """Each ends after it begins, and before the next."""
        flat = [moment for span in spans for moment in span]
        if any(b < a for a, b in pairwise(flat)):
            raise ValueError("stretches must follow each other, each ending after it begins")
        return spans

    def within(self, seconds: float, rate_hz: float) -> ContactsEntry:
        """The same, of a motion that takes so long; one that ends half a frame beyond its last is rounded.

        Raises BadMotion where a stretch goes on past the motion's end."""
        faults = [
            Fault("the stretch goes on past the motion's end", "past_the_end",
                  f"The last frame is {round(seconds * rate_hz) + 1}, at {seconds:g} s: end the stretch there",
                  column=f"{foot}.{k}", value=f"{begin:g} to {end:g} s")
            for foot, spans in (("left", self.left), ("right", self.right))
            for k, (begin, end) in enumerate(spans) if end > seconds + 0.5 / rate_hz
        ]  # fmt: skip
        if faults:
            raise BadMotion(faults)
        return self


@final
class RetargetEntry(_Part):
    """begin, end: of the capture [s]. slow: times the time. repeat: times. share: of the trunk's angle. without: of
    what nothing is asked. margin_m: by which the centre of pressure keeps inside the soles. what_would_do: where it
    cannot be had, find what can, which may take minutes. rate_hz: at which it is judged and written."""

    begin: float = Field(default=0.0, ge=0.0)
    end: float | None = Field(default=None, gt=0.0)
    slow: float = Field(default=1.0, ge=0.1, le=20.0)
    repeat: int = Field(default=1, ge=1, le=50)
    mirror: bool = False
    share: float = Field(default=1.0, ge=0.0, le=2.0)
    without: list[Literal["arms", "pelvis"]] = Field(default_factory=list, max_length=2)
    margin_m: float = Field(default=USUAL.margin_m, ge=0.005, le=0.2)
    what_would_do: bool = True
    rate_hz: float = Field(default=200.0, ge=20.0, le=2000.0)

    @model_validator(mode="after")
    def something_is_left(self) -> RetargetEntry:
        """The cut ends after it begins."""
        if self.end is not None and self.end <= self.begin:
            raise ValueError(f"the end, {self.end:g} s, must come after the begin, {self.begin:g} s")
        return self


@final
class ExciteEntry(_Part):
    """seconds: of the motion itself. seed: of the random motions that the search begins from."""

    seconds: float = Field(default=10.0, ge=3.0, le=120.0)
    seed: int = Field(default=0, ge=0, le=2**31)


Kind = Literal["retarget", "excite"]


@final
class PlanFile(_Part):
    """plan.yaml: one of `retarget` and `excite`. robot, motion, study: content of what the plan is made of, by hash.
    contacts: of the motion, where they were said by hand."""

    version: Literal[1] = 1
    robot: str
    motion: str | None = None
    study: str | None = None
    contacts: ContactsEntry | None = None
    retarget: RetargetEntry | None = None
    excite: ExciteEntry | None = None

    @property
    def kind(self) -> Kind:
        return "retarget" if self.retarget is not None else "excite"
