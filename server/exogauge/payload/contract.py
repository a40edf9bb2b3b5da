"""payload.yaml (version 1), key by key."""

from __future__ import annotations

from typing import Annotated, Literal, Self, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator, model_validator

from exogauge.studies.intake.contract import Name, NotNegative, Number, Positive, RelativePath, Vector

Role = Literal["postures", "excitation", "test", "contact"]


def _as_tuple(value: object) -> object:
    return tuple(value) if isinstance(value, list) else value


def _as_names(value: object) -> object:
    return (value,) if isinstance(value, str) else _as_tuple(value)


Six = Annotated[tuple[Name, Name, Name, Name, Name, Name], BeforeValidator(_as_tuple)]
Nine = Annotated[tuple[Name, ...], BeforeValidator(_as_tuple), Field(min_length=9, max_length=9)]
Four = Annotated[tuple[Name, Name, Name, Name], BeforeValidator(_as_tuple)]
Three = Annotated[tuple[Name, Name, Name], BeforeValidator(_as_tuple)]
Pair = Annotated[tuple[Number, Number], BeforeValidator(_as_tuple)]
Limits = Annotated[tuple[Positive, Positive, Positive], BeforeValidator(_as_tuple)]


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


Part = TypeVar("Part", bound=_Part)


def _distinct(part: Part, key: str, columns: tuple[str, ...]) -> Part:
    twice = next((each for each in columns if columns.count(each) > 1), None)
    if twice is not None:
        raise ValueError(f"`{key}` names the column {twice!r} twice")
    return part


class WrenchNoise(_Part):
    """Standard deviation of one sample."""

    force_n: Positive
    moment_nm: Positive


class RatedRange(_Part):
    """Per axis, of either sign."""

    force_n: Limits
    moment_nm: Limits


class SensorEntry(_Part):
    """frame: of the URDF, where pose is from joint angles. axes: in which the wrench's columns are written."""

    frame: Name | None = None
    sees: Literal["payload_on_sensor", "sensor_on_payload"] | None = None
    axes: Literal["sensor", "base"] = "sensor"
    wrench: Six
    force_unit: Name = "N"
    moment_unit: Name = "Nm"
    noise: WrenchNoise
    range: RatedRange | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        return _distinct(self, "wrench", self.wrench)


class PoseEntry(_Part):
    """Joint angles with a URDF, or a logged rotation R_base_sensor (row by row, or a quaternion) and position.

    noise_rad, noise_m: standard deviation of a sample of the angles or the rotation, and of the position.
    """

    urdf: RelativePath | None = None
    base_link: Name | None = None
    joints: Annotated[dict[Name, Name], Field(min_length=1, max_length=100)] | None = None
    angle_unit: Name = "rad"
    rotation: Nine | None = None
    quaternion: Four | None = None
    quaternion_order: Literal["xyzw", "wxyz"] | None = None
    position: Three | None = None
    position_unit: Name = "m"
    noise_rad: Positive
    noise_m: Positive = 1e-4

    @model_validator(mode="after")
    def _check(self) -> Self:
        ways = [name for name in ("joints", "rotation", "quaternion") if getattr(self, name) is not None]
        if len(ways) != 1:
            raise ValueError("a pose is one of `joints`, `rotation`, `quaternion`")
        if self.joints is not None and (self.urdf is None or self.base_link is None):
            raise ValueError("joint angles need `urdf` and `base_link`")
        if self.quaternion is not None and self.quaternion_order is None:
            raise ValueError("a quaternion needs `quaternion_order`: xyzw or wxyz")
        return _distinct(
            self, ways[0], tuple(getattr(self, ways[0])) if self.joints is None else (*self.joints.values(),)
        )


class ImuEntry(_Part):
    """An accelerometer fixed to the sensor; its axes are found from the postures. delay_s: how late its stamps are."""

    acceleration: Three
    unit: Name = "m/s^2"
    delay_s: Number | None = None


class TimeEntry(_Part):
    """Every file that has this column has a clock of its own; all clocks count from the same instant."""

    column: Name = "t"
    unit: Name = "s"


class LogEntry(_Part):
    """file: one, or several that hold the columns between them. span: (from, to) [s] since the log's first sample.
    each_row: every row is the mean of one posture, and there is no time."""

    file: Annotated[tuple[RelativePath, ...], BeforeValidator(_as_names), Field(min_length=1, max_length=10)]
    role: Role
    span: Annotated[tuple[NotNegative, NotNegative], BeforeValidator(_as_tuple)] | None = None
    each_row: bool = False

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.each_row and self.role != "postures":
            raise ValueError("only a log of postures can have one row for each")
        if self.each_row and (self.span is not None or len(self.file) > 1):
            raise ValueError("a table with one row for each posture is one file, and has no span")
        if self.span is not None and self.span[0] >= self.span[1]:
            raise ValueError("span must be [from, to] with from < to")
        return self


class SettingsEntry(_Part):
    """inclination: `auto` asks postures that were left out. moments, zero: whether m c and the sensor's zero are those
    of the postures, or found anew in motion. cutoff_hz: one zero-phase low-pass on every column and on the wrench.
    jerk_density: None chooses by likelihood. false_alarms_per_hour: of the contact alarm."""

    inclination: Literal["auto", "fit", "ignore"] = "auto"
    method: Literal["ls", "tls", "gtls"] = "gtls"
    moments: Literal["from_postures", "from_motion"] = "from_postures"
    zero: Literal["as_in_postures", "drifted"] = "as_in_postures"
    cutoff_hz: Positive | None = None
    jerk_density: Positive | None = None
    false_alarms_per_hour: Positive = 1.0


class SensorUncertainty(_Part):
    """Standard deviations, as shares, of what no log shows; None: the defaults. ft_gain: of each axis for itself;
    ft_gain_common: of all alike, as after one calibration; ft_crosstalk: of each axis in each other one, moments by
    forces in the ratio of their noise."""

    ft_gain: NotNegative | None = None
    ft_gain_common: NotNegative | None = None
    ft_crosstalk: NotNegative | None = None


class GroundTruth(_Part):
    """Never fitted: for the comparison alone."""

    mass_kg: Positive | None = None


class CapEntry(_Part):
    """Where an axis of the sensor may point, in the base: theta from +z, phi about it from +x; phi may pass 180."""

    axis: Literal["x", "y", "z"]
    phi_deg: Pair = (-180.0, 180.0)
    theta_deg: Pair = (0.0, 180.0)

    @model_validator(mode="after")
    def _check(self) -> Self:
        if not 0.0 <= self.theta_deg[0] < self.theta_deg[1] <= 180.0:
            raise ValueError("theta_deg must be [from, to] with 0 <= from < to <= 180")
        if not 0.0 < self.phi_deg[1] - self.phi_deg[0] <= 360.0:
            raise ValueError("phi_deg must be [from, to] with from < to, not more than a turn apart")
        return self


class ComponentEntry(_Part):
    """What is believed of the payload: a box about its centre of mass, in the sensor's axes."""

    mass_kg: Positive
    centre_m: Vector
    size_m: Limits


class PostureChoice(_Part):
    """K: of `algorithm_1`."""

    count: Annotated[int, Field(ge=3, le=100)] = 21
    hold_s: Positive = 1.0
    choice: Literal["least_std", "algorithm_1"] = "least_std"
    K: Number = -0.2


class ExcitationChoice(_Part):
    duration_s: Annotated[Positive, Field(ge=1.0, le=60.0)] = 10.0
    rate_hz: Annotated[Positive, Field(ge=50.0, le=1000.0)] = 250.0
    harmonics: Annotated[int, Field(ge=3, le=10)] = 5
    starts: Annotated[int, Field(ge=1, le=50)] = 4


class PlanEntry(_Part):
    """What may be planned. joints: that move; the others stay at `home` [rad]. position, velocity, torque: instead of
    the URDF's limits. acceleration [rad/s²]: of every joint that moves."""

    joints: Annotated[tuple[Name, ...], BeforeValidator(_as_names), Field(min_length=1, max_length=20)]
    home: dict[Name, Number]
    acceleration: dict[Name, Positive]
    payload: ComponentEntry
    position: dict[Name, Pair] = Field(default_factory=dict)
    velocity: dict[Name, Positive] = Field(default_factory=dict)
    torque: dict[Name, Positive] = Field(default_factory=dict)
    workspace: Annotated[tuple[CapEntry, ...], BeforeValidator(_as_tuple), Field(max_length=20)] = ()
    postures: PostureChoice = PostureChoice()
    excitation: ExcitationChoice = ExcitationChoice()


class PayloadFile(_Part):
    """payload.yaml. gravity: in the base frame, as if it stood level. uncertainty `none`: of a simulated sensor, which
    is exact."""

    version: Literal[1]
    name: Name
    gravity: Vector = (0.0, 0.0, -9.80665)
    sensor: SensorEntry
    pose: PoseEntry
    time: TimeEntry = TimeEntry()
    imu: ImuEntry | None = None
    logs: Annotated[tuple[LogEntry, ...], BeforeValidator(_as_tuple), Field(max_length=100)] = ()
    settings: SettingsEntry = SettingsEntry()
    plan: PlanEntry | None = None
    uncertainty: SensorUncertainty | Literal["none"] = SensorUncertainty()
    ground_truth: GroundTruth = GroundTruth()

    @field_validator("gravity")
    @classmethod
    def _of_this_planet(cls, gravity: Vector) -> Vector:
        size = sum(x * x for x in gravity) ** 0.5
        if not 9.7 < size < 9.9:
            raise ValueError(
                f"gravity has the size {size:.4g} m/s², on this planet it has 9.76 to 9.84: give it in m/s² in the "
                "base's axes, as [0, 0, -9.81]"
            )
        return gravity

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.pose.joints is not None and self.sensor.frame is None:
            raise ValueError("joint angles need `sensor.frame`, a link or frame of the URDF")
        return self
