"""What every part of results.json is made of: numbers that may be missing, with their doubt and unit."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

Number = Annotated[float | None, Field(description="null: not finite, or there is none")]
PAIR = Field(min_length=2, max_length=2)
TRIPLE = Field(min_length=3, max_length=3)
MotionEquality = Literal["equal", "doubtful", "different"]


class Part(BaseModel):
    """A part of results.json: a key that is not described here is a fault of the writer."""

    model_config = ConfigDict(extra="forbid")


def maybe(says: str) -> Any:
    """A key that is left out where there is nothing to say."""
    return Field(default=None, description=says, json_schema_extra=_without_default)


def later(says: str) -> Any:
    """A key that is always written, and that results which an earlier version wrote may lack."""
    return maybe(f"{says}; results of earlier versions lack it")


def _without_default(schema: dict[str, Any]) -> None:
    schema.pop("default", None)


class Measured(Part):
    """A number with its uncertainty."""

    value: Number = Field(description="[unit]")
    std: Number = Field(description="one standard deviation [unit]; 0 of what was chosen, null where nothing is known")
    unit: str = Field(description="SI, `1` for a ratio")


class DoubtPart(Part):
    """What one source alone does to a number. Squares of all add up to the square of its standard deviation."""

    source: str = Field(description="as in `doubt_sources`")
    std: Number = Field(description="[unit]")


class Doubted(Measured):
    """A number with what its doubt is made of."""

    interval_95: Annotated[list[Number], PAIR] | None = later("[low, high] [unit]")
    budget: list[DoubtPart] | None = later("the largest part first; empty where nothing is told of it")


class Decided(Measured):
    """A number that a prior and the data decide."""

    prior: Number = Field(description="what was believed before [unit]")
    identifiable: bool = Field(description="whether the data, not the prior, decide it")


class Consequence(Part):
    """A number without and with the effects that were named."""

    before: Measured = Field(description="without them")
    after: Measured = Field(description="with them")
    moves: bool = later("it changes by more than a tenth of its doubt")
