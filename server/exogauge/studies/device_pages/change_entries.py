"""Changes of a device as plain values, in request bodies, jobs and YAML. `entry_changes` makes of them what is applied.

Light on purpose: the API reads them without loading the numerics.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self, final

from pydantic import BaseModel, ConfigDict, Field, model_validator

from exogauge.studies.intake.contract import Name, RelativePath

MOST_CHANGES = 200

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]  # the file's own `Number` is no match for 400 digits
Positive = Annotated[Number, Field(gt=0.0)]
Vector = tuple[Number, Number, Number]

Of = Annotated[Name, Field(description="a band, a group, or * for all bands")]
Point = Annotated[int, Field(strict=True, ge=0, le=49, description="number of the via point, from 0")]


class Entry(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


def exactly_one(entry: BaseModel, *keys: str) -> None:
    if sum(getattr(entry, key) is not None for key in keys) != 1:
        raise ValueError(f"give one of {', '.join(keys)}")


@final
class StiffnessEntry(Entry):
    """to [N/m], or times the present one."""

    change: Literal["stiffness"]
    of: Of
    to: Positive | None = None
    times: Positive | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        exactly_one(self, "to", "times")
        return self


@final
class NaturalLengthEntry(Entry):
    """to [m], longer by [m], or times the present one."""

    change: Literal["natural_length"]
    of: Of
    to: Positive | None = None
    by: Number | None = None
    times: Positive | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        exactly_one(self, "to", "by", "times")
        return self


@final
class PretensionEntry(Entry):
    """to [m]: length at zero posture minus natural length; negative = slack there."""

    change: Literal["pretension"]
    of: Of
    to: Number


@final
class LawEntry(Entry):
    """Name of a force law and its other values."""

    change: Literal["law"]
    of: Of
    law: Name
    values: Annotated[dict[Name, Number], Field(max_length=20)] = {}


@final
class MovePointEntry(Entry):
    """by [m], in the frame of the point's link."""

    change: Literal["move_point"]
    band: Name
    point: Point
    by: Vector


@final
class PlacePointEntry(Entry):
    """xyz [m] in the frame of link; what is not given stays."""

    change: Literal["place_point"]
    band: Name
    point: Point
    xyz: Vector | None = None
    link: Name | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.xyz is None and self.link is None:
            raise ValueError("give xyz, link or both")
        return self


@final
class AddPointEntry(Entry):
    """The new point is number `at`; those from there on move up by one."""

    change: Literal["add_point"]
    band: Name
    at: Point
    link: Name
    xyz: Vector


@final
class RemovePointEntry(Entry):
    change: Literal["remove_point"]
    band: Name
    point: Point


@final
class RemoveBandEntry(Entry):
    change: Literal["remove_band"]
    of: Of


@final
class NewPoint(Entry):
    """xyz [m] in the frame of link."""

    link: Name
    xyz: Vector


@final
class NewBand(Entry):
    """A band as in device.yaml, without its bench test."""

    name: Name
    group: Name | None = None
    via_points: Annotated[list[NewPoint], Field(min_length=2, max_length=50)]
    stiffness_n_per_m: Positive | None = None
    natural_length_m: Positive | None = None
    ground_truth: Annotated[bool, Field(strict=True)] = False
    law: Name = "linear"
    law_values: Annotated[dict[Name, Number], Field(max_length=20)] = {}


@final
class AddBandEntry(Entry):
    change: Literal["add_band"]
    band: NewBand


@final
class CopyBandEntry(Entry):
    """A second band like `band`, called `name`; group: default that of the first."""

    change: Literal["copy_band"]
    band: Name
    name: Name
    group: Name | None = None


@final
class MirrorBandEntry(Entry):
    """The band on the other side of the base link's x-z plane. links: link -> twin, where names do not tell."""

    change: Literal["mirror_band"]
    band: Name
    name: Name
    group: Name | None = None
    links: Annotated[dict[Name, Name], Field(max_length=100)] = {}


ChangeEntry = Annotated[
    StiffnessEntry
    | NaturalLengthEntry
    | PretensionEntry
    | LawEntry
    | MovePointEntry
    | PlacePointEntry
    | AddPointEntry
    | RemovePointEntry
    | RemoveBandEntry
    | AddBandEntry
    | CopyBandEntry
    | MirrorBandEntry,
    Field(discriminator="change"),
]
ChangeEntries = Annotated[list[ChangeEntry], Field(max_length=MOST_CHANGES)]


@final
class ChangesFile(Entry):
    """changes.yaml"""

    version: Literal[1]
    changes: ChangeEntries


@final
class WhatIfSettings(Entry):
    """What a job of kind `whatif` is asked. device: a file of the study; default what the log wears. main: the joints
    that the device is for; default the one with the largest torque."""

    log: Name
    device: RelativePath | None = None
    changes: ChangeEntries = []
    main: Annotated[list[Name], Field(max_length=50)] = []
