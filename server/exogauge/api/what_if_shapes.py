"""A what-if as it is asked and answered over HTTP."""

from __future__ import annotations

from typing import Annotated, Any, final

from pydantic import BaseModel, ConfigDict, Field

from exogauge.studies.device_pages.change_entries import ChangeEntries
from exogauge.studies.intake.contract import Name, RelativePath


@final
class WhatIfRequest(BaseModel):
    """log: of the study. device: a file of the study to start from; default what the log wears. changes: one after
    another. main: joints that the device is for; default the one with the largest rms torque. series: sample by sample
    too."""

    model_config = ConfigDict(extra="forbid")
    log: Name
    device: RelativePath | None = None
    changes: ChangeEntries = []
    main: Annotated[list[Name], Field(max_length=50)] = []
    series: Annotated[bool, Field(strict=True)] = False


@final
class TorqueOut(BaseModel):
    """peak: of the largest size, with its sign; mean, rms: over time [unit]; integral [unit·s]; work: on the joint
    [J]."""

    peak: float
    mean: float
    rms: float
    integral: float
    work: float


@final
class PercentOut(BaseModel):
    """100 (after / before - 1): 100 is twice as much, -100 nothing left, less is the other way round; null where before
    is 0."""

    peak: float | None
    mean: float | None
    rms: float | None
    integral: float | None
    work: float | None


@final
class JointOut(BaseModel):
    """Torque of all bands together on one joint, positive along it. unit: N·m, N for a prismatic joint."""

    joint: str
    unit: str
    before: TorqueOut
    after: TorqueOut
    percent: PercentOut


@final
class InterferenceOut(BaseModel):
    """A joint that is not main: its rms as a share of that of the main joints; null where theirs is 0."""

    joint: str
    before: float | None
    after: float | None


@final
class BandLoadOut(BaseModel):
    """stretch_max: of the natural length, a ratio; slack_share: of the time."""

    tension_max_n: float
    length_min_m: float
    length_max_m: float
    stretch_max: float
    slack_share: float


@final
class BandOut(BaseModel):
    """null: the band is not there, or (before) its values are not known."""

    band: str
    before: BandLoadOut | None
    after: BandLoadOut | None


@final
class DeviceNameOut(BaseModel):
    file: str
    name: str


@final
class BeforeAfter(BaseModel):
    before: list[float]
    after: list[float]


@final
class BandSeries(BaseModel):
    tension_n: list[float]
    length_m: list[float]


@final
class BandSeriesPair(BaseModel):
    before: BandSeries | None
    after: BandSeries | None


@final
class SeriesOut(BaseModel):
    """t [s]; torque by joint; tension and length by band."""

    t: list[float]
    joints: dict[str, BeforeAfter]
    bands: dict[str, BandSeriesPair]


@final
class WhatIfOut(BaseModel):
    """samples: of the answer, every `every`-th of the log's `of_samples`, low-passed at cutoff_hz before. changed: the
    changed device as the content of a device.yaml. elapsed_ms: for the answer; opening_ms: for reading the log, 0 where
    it was at hand."""

    log: str
    device: DeviceNameOut
    samples: int
    of_samples: int
    every: int
    duration_s: float
    cutoff_hz: float | None
    joints: list[JointOut]
    main: list[str]
    interference: list[InterferenceOut]
    bands: list[BandOut]
    notes: list[str]
    changed: dict[str, Any]
    series: SeriesOut | None
    elapsed_ms: float
    opening_ms: float
