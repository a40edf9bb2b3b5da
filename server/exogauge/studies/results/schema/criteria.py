"""By which numbers it was decided."""

from __future__ import annotations

from typing import Literal, final

from pydantic import Field

from exogauge.studies.results.schema.values import Part


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
