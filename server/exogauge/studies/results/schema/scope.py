"""`scope` and `configuration` of results.json: for what the results hold, and with what they were obtained."""

from __future__ import annotations

from typing import Annotated, Literal, final

from pydantic import ConfigDict, Field

from exogauge.studies.results.schema.values import PAIR, TRIPLE, Number, Part, later

Told = dict[str, str | None]


class Reach(Part):
    """How far and how fast one joint went; low-passed as for the fit."""

    joint: str = Field(description="its name")
    moved: bool = Field(description="faster than the limit of rest for 1 % of a log or more")
    lowest: Number = Field(description="[unit]")
    highest: Number = Field(description="[unit]")
    top_speed: Number = Field(description="[unit/s]")
    unit: Literal["rad", "m"] = Field(description="m of a joint that slides")


@final
class WornReach(Reach):
    """The same with the device."""

    main: bool = Field(description="as in `support`")


@final
class MotionScope(Part):
    """One motion with one device."""

    device: str = Field(description="its name")
    motion: str = Field(description="its name")
    logs: list[str] = Field(description="with the device")
    joints: list[WornReach] = Field(description="on which its bands act")


@final
class Scope(Part):
    """For what the results hold."""

    sentence: str = Field(description="in one sentence")
    clauses: list[str] = later("its two halves: for what, and that nothing is claimed beyond")
    synthetic: bool = Field(description="whether any file says so of itself")
    robot: str = Field(description="its name")
    devices: list[str] = Field(description="that were worn in a log")
    identified: list[Reach] = Field(description="every joint over the fitted logs")
    not_moved: list[str] = Field(description="joints that no fitted log moves")
    motions: list[MotionScope] = Field(description="with a device")
    not_said: list[str] = Field(description="what these data do not hold, in sentences")


@final
class ConfiguredJoint(Part):
    """As robot.yaml says."""

    joint: str = Field(description="its name")
    actuation: Literal["current", "torque", "none"] = Field(description="what was logged of its drive")
    gear_ratio: Number = Field(description="motor turns per joint turn; null where not stated")


@final
class ConfiguredSensor(Part):
    """As robot.yaml says."""

    name: str = Field(description="of the sensor")
    role: Literal["contact", "cut"] = Field(description="what it is for")
    frame: str = Field(description="link in whose origin and axes it measures")


@final
class ConfiguredRobot(Part):
    """The robot as it was evaluated."""

    name: str = Field(description="its name")
    base: Literal["floating", "fixed"] = Field(description="whether it moves")
    moving_links: int = Field(description="how many")
    joints: list[ConfiguredJoint] = Field(description="in the order of the description")
    sensors: list[ConfiguredSensor] = Field(description="force/torque sensors")


@final
class ViaPoint(Part):
    """Where a band runs."""

    link: str = Field(description="that it moves with")
    xyz: Annotated[list[float], TRIPLE] = Field(description="in the link's axes [m]")


@final
class StatedBand(Part):
    """A band as its file says, before any data."""

    band: str = Field(description="its name")
    group: str = Field(description="of bands that share stiffness and law")
    via_points: list[ViaPoint] = Field(description="in order")
    stiffness_n_per_m: Number = Field(description="[N/m]; null where not stated")
    natural_length_m: Number = Field(description="[m]; null where not stated")
    ground_truth: bool = Field(description="whether both are true")
    law: str = Field(description="force law, as docs/device.md lists them")
    law_values: dict[str, float] = Field(description="its other numbers, units as docs/device.md says")
    bench: bool = Field(description="whether it was measured on a bench")


@final
class ConfiguredDevice(Part):
    """A wear as its file says."""

    device: str = Field(description="its name")
    file: str = Field(description="of the study")
    logs: list[str] = Field(description="in which it was worn")
    record: Told = Field(description="the specimen in words, null where not stated")
    bands: list[StatedBand] = Field(description="in the file's order")
    tied: list[str] = Field(description="groups whose bands have one natural length")


@final
class ConfiguredLog(Part):
    """A log as study.yaml says, and what it holds."""

    log: str = Field(description="its name")
    files: list[str] = Field(description="that it was read from")
    mapping: str | None = Field(description="file of the mapping; null for none")
    rows: Annotated[list[int], PAIR] | None = Field(description="[start, stop) of data rows from 0; null for all")
    role: Literal["identification", "validation", "without_device", "with_device"] = Field(description="what it is for")
    motion: str | None = Field(description="null without a name")
    device: str | None = Field(description="what was worn; null for nothing")
    duration_s: Number = Field(description="[s]")
    samples: int = Field(description="how many")
    rate_hz: Number = Field(description="[Hz]")


class Settings(Part):
    """Settings of an identification, as study.yaml has them; one that is not described here is told all the same."""

    model_config = ConfigDict(extra="allow")

    cutoff_hz: Number = Field(description="of the low-pass on every signal [Hz]; null: the data choose")
    effects: list[str] = Field(description="in the model from the start")
    prior: Literal["per_parameter", "as_printed"] = Field(description="how the prior is weighted")
    prior_strength: Number = Field(description="factor on the prior's weight; null: the data choose")
    consistency: Literal["free", "physical"] = Field(description="whether every link must be a possible body")
    creeping: dict[str, float] = later(
        "joint: speed below which it is not in steady motion, though not at rest either [rad/s or m/s]"
    )
    solver: Literal["statistics", "rows"] = Field(description="of the equations")


@final
class SettingsUsed(Settings):
    """The same as used, also where the data chose them."""

    motion_doubtful: float = Field(description="share of the rms velocity above which equal motion is doubtful")
    motion_different: float = Field(description="share above which approach A is refused")


@final
class Configuration(Part):
    """With what the results were obtained; what nobody stated is null."""

    synthetic: list[str] = Field(description="files that say of themselves that they are")
    conditions: Told = Field(description="as study.yaml states them")
    robot: ConfiguredRobot = Field(description="as evaluated")
    devices: list[ConfiguredDevice] = Field(description="the study's own first")
    logs: list[ConfiguredLog] = Field(description="in the order of study.yaml")
    settings: SettingsUsed = Field(description="as used")
    inputs_sha256: str = Field(description="of the list of all inputs' hashes")
