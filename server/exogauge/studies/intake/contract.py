"""The files a user hands in, key by key: study.yaml, robot.yaml, device.yaml (version 1)."""

from __future__ import annotations

from datetime import date
from pathlib import PurePosixPath
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, model_validator

PLANS_BESIDE, PLANS_LISTED = ".plans", "plans.json"  # what a service lays beside a study: {file: [id, name]}


def _as_day(value: Any) -> Any:
    """YAML makes a date of 2026-03-01."""
    return value.isoformat() if type(value) is date else value


def _as_text(value: Any) -> Any:
    """A serial number or size may be written as a number."""
    return str(value) if isinstance(value, int | float) and not isinstance(value, bool) else value


Text = Annotated[str, BeforeValidator(_as_text), Field(min_length=1, max_length=200, pattern=r"^[^\x00-\x1f\x7f]+$")]
Day = Annotated[str, BeforeValidator(_as_day), Field(pattern=r"^\d{4}-\d{2}-\d{2}$")]


class _Told(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class DeviceRecord(_Told):
    """`record` in device.yaml: which specimen was worn, and how."""

    model: Text | None = None
    size: Text | None = None
    serial: Text | None = None
    straps: Text | None = None
    pretension: Text | None = None
    garment: Text | None = None


class Conditions(_Told):
    """`conditions` in study.yaml: when and under what the logs were recorded."""

    recorded: Day | None = None
    place: Text | None = None
    temperature: Text | None = None
    robot_cover: Text | None = None
    payload: Text | None = None


Step = Literal["identify", "support", "stiffness", "discrepancy"]
STEPS: tuple[Step, ...] = ("identify", "support", "stiffness", "discrepancy")
Role = Literal["identification", "validation", "without_device", "with_device"]


def _inside(path: str) -> str:
    """A path below the study's folder, with forward slashes."""
    if path != path.strip() or not path or "\\" in path or "\0" in path:
        raise ValueError("a path is a name or names joined by '/', relative to the study's folder")
    pure = PurePosixPath(path)
    if pure.is_absolute() or ".." in pure.parts or (len(path) > 1 and path[1] == ":"):
        raise ValueError("the path leaves the study's folder; copy the file into it and name it relative to study.yaml")
    return str(pure)


def _number(value: Any) -> Any:
    """Whole numbers are numbers too, and text is not."""
    return float(value) if isinstance(value, int) and not isinstance(value, bool) else value


def _as_tuple(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def _as_names(value: Any) -> Any:
    """One name, or a list of names."""
    return (value,) if isinstance(value, str) else _as_tuple(value)


RelativePath = Annotated[str, Field(max_length=400), AfterValidator(_inside)]
Name = Annotated[str, Field(min_length=1, max_length=200, pattern=r"^[^\x00-\x1f]+$")]
FileName = Annotated[str, Field(min_length=1, max_length=100, pattern=r"^[A-Za-z0-9_][A-Za-z0-9_.+-]*$")]
Number = Annotated[float, BeforeValidator(_number), Field(allow_inf_nan=False, strict=True)]
Positive = Annotated[Number, Field(gt=0.0)]
Share = Annotated[Number, Field(gt=0.0, le=1.0)]
NotNegative = Annotated[Number, Field(ge=0.0)]
Vector = Annotated[tuple[Number, Number, Number], BeforeValidator(_as_tuple)]
Coordinate = Annotated[Number, Field(ge=-100.0, le=100.0)]
Place = Annotated[tuple[Coordinate, Coordinate, Coordinate], BeforeValidator(_as_tuple)]


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class LogEntry(_Part):
    """One log: a table in the contract's columns, or vendor files read through a mapping.

    rows: [start, stop], data rows from 0, stop not included. name: of the series file; default: the file's own stem.
    device: what was worn, where it is not the study's device; only with role with_device.
    started: [s] when it began, on one clock for all logs of the study.
    """

    file: Annotated[tuple[RelativePath, ...], BeforeValidator(_as_names), Field(min_length=1, max_length=50)]
    role: Role
    motion: Name | None = None
    mapping: RelativePath | None = None
    rows: Annotated[tuple[int, int], BeforeValidator(_as_tuple)] | None = None
    name: FileName | None = None
    device: RelativePath | None = None
    started: Number | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.device is not None and self.role != "with_device":
            raise ValueError(f"a log with role {self.role} wears no device: leave `device` out, or say with_device")
        if self.rows is not None and not 0 <= self.rows[0] < self.rows[1]:
            raise ValueError("rows must be [start, stop] with 0 <= start < stop")
        if len(self.file) > 1 and self.mapping is None:
            raise ValueError("a list of files needs a `mapping` that says what each file's columns are")
        return self


class KnownEntry(_Part):
    """A weighed load that is fixed to a link in some logs, and in no other.

    mass_kg, std_kg: what the scales say, and their standard deviation. logs: by name. com_m: centre of mass in the
    link's frame, default its origin; std_com_m: standard deviation of each of its coordinates, default 0.02, or 0.1
    where com_m is not given.
    """

    link: Name
    mass_kg: Number
    std_kg: Number
    logs: Annotated[tuple[Name, ...], BeforeValidator(_as_names), Field(min_length=1, max_length=1000)]
    com_m: Place | None = None
    std_com_m: Positive | None = None


class SettingsEntry(_Part):
    """Choices about the evaluation; a key that is not given takes its default.

    motion_doubtful, motion_different: rms of the velocities' difference between the runs with and without the device,
    as a share of the joint's own rms velocity: from there on the motions count as doubtful, or different.
    """

    cutoff_hz: Positive | None = None
    effects: Annotated[list[Name], Field(min_length=1, max_length=50)] | None = None
    prior: Literal["per_parameter", "as_printed"] | None = None
    prior_strength: Positive | None = None
    consistency: Literal["free", "physical"] | None = None
    solver: Literal["statistics", "rows"] | None = None
    motion_doubtful: Positive | None = None
    motion_different: Positive | None = None


class StudyFile(_Part):
    """study.yaml. plans: tables of motions (`t`, `q.<joint>`) that may have been played; logs are known again by
    their content."""

    version: Literal[1]
    name: Name
    robot: RelativePath
    device: RelativePath | None = None
    logs: Annotated[list[LogEntry], Field(min_length=1, max_length=1000)]
    plans: Annotated[list[RelativePath], Field(max_length=50)] = []
    steps: Annotated[list[Step], Field(min_length=1)] | None = None
    known: Annotated[list[KnownEntry], Field(max_length=50)] = []
    settings: SettingsEntry = SettingsEntry()
    conditions: Conditions = Conditions()


class Imu(_Part):
    """A frame of the URDF; or a pose in a link: xyz [m], then rpy as fixed-axis roll, pitch, yaw [rad]."""

    frame: Name | None = None
    parent: Name | None = None
    xyz: Vector | None = None
    rpy: Vector | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        if (self.frame is None) == (self.parent is None):
            raise ValueError("give either the IMU's frame, or its parent link with xyz and rpy")
        if self.frame is not None and (self.xyz is not None or self.rpy is not None):
            raise ValueError("xyz and rpy belong to a parent link; a frame of the URDF has its own pose")
        return self


class SensorEntry(_Part):
    name: Name
    frame: Name
    role: Literal["contact", "cut"]
    sees: Literal["world_on_robot", "robot_on_world", "payload_on_sensor", "sensor_on_payload"]


class JointPrior(_Part):
    """Joint-side: k_T [N·m/A] ([1] for torque), k_d [N·m·s/rad], tau_c, tau_s, tau_o [N·m], J_r [kg·m²]."""

    k_T: Number | None = None
    k_d: NotNegative | None = None
    tau_c: NotNegative | None = None
    tau_s: NotNegative | None = None
    tau_o: Number | None = None
    J_r: NotNegative | None = None


class JointPriorStd(_Part):
    k_T: Positive | None = None
    k_d: Positive | None = None
    tau_c: Positive | None = None
    tau_s: Positive | None = None
    tau_o: Positive | None = None
    J_r: Positive | None = None


class JointEntry(_Part):
    """actuation none: the joint moves, its position is logged, and neither its current nor its torque. sign_checked:
    somebody has looked that it turns in the logs as it does in the URDF."""

    name: Name
    actuation: Literal["current", "torque", "none"]
    gear_ratio: Number | None = None
    prior: JointPrior = JointPrior()
    prior_std: JointPriorStd = JointPriorStd()
    sign_checked: bool = False

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.gear_ratio == 0.0:
            raise ValueError("gear_ratio is motor turns per joint turn and cannot be 0")
        if self.actuation == "current" and not self.prior.k_T:
            raise ValueError(
                "a current-actuated joint needs prior.k_T, not 0: joint torque per ampere [N·m/A]; "
                "`actuation: torque` where torques are logged"
            )
        if self.prior.k_T is not None and self.prior.k_T < 0.0:
            raise ValueError("prior.k_T is positive: a current that drives its joint backwards is turned in a mapping")
        if self.actuation == "torque" and self.prior.k_T not in (None, 1.0):
            raise ValueError("a torque-actuated joint has k_T = 1, known: leave prior.k_T out")
        if self.actuation == "none" and self.prior.k_T is not None:
            raise ValueError("no current of this joint is logged, so k_T has no meaning: leave prior.k_T out")
        return self


class Transmission(_Part):
    """motor angle = matrix @ joint angle, joint torque = matrix.T @ motor torque; rows = the joints' own motors."""

    joints: Annotated[list[Name], Field(min_length=2, max_length=50)]
    matrix: Annotated[list[list[Number]], Field(min_length=2, max_length=50)]

    @model_validator(mode="after")
    def _check(self) -> Self:
        size = len(self.joints)
        if len(self.matrix) != size or any(len(row) != size for row in self.matrix):
            raise ValueError(f"the matrix must be {size} x {size}: one row (motor) and one column per joint")
        if any(self.matrix[i][i] == 0.0 for i in range(size)):
            raise ValueError(
                "a motor's own gear (the matrix's diagonal) cannot be 0; order the joints like their motors"
            )
        return self


class Noise(_Part):
    """Standard deviation of one sample, by kind of channel, in the channel's SI unit."""

    q: Positive | None = None
    i: Positive | None = None
    tau: Positive | None = None
    acc: Positive | None = None
    gyro: Positive | None = None
    force: Positive | None = None
    moment: Positive | None = None


class RobotUncertainty(_Part):
    """Standard uncertainties that no log shows; of a key that is left out, what is usual (`criteria.declaring`).

    zeros_taken: `session` where those of the force/torque sensors were taken once, before its first log; `log` where
    they were taken anew before every one.
    """

    ft_gain: NotNegative | None = None
    ft_gain_common: NotNegative | None = None
    ft_tilt: NotNegative | None = None
    ft_place: NotNegative | None = None
    ft_zero_force: NotNegative | None = None
    ft_zero_moment: NotNegative | None = None
    kt_drift: NotNegative | None = None
    viscous_drift: NotNegative | None = None
    coulomb_drift: NotNegative | None = None
    imu_tilt: NotNegative | None = None
    encoder_zero: NotNegative | None = None
    clock: NotNegative | None = None
    torque_zero: NotNegative | dict[Name, NotNegative] | None = None
    zeros_taken: Literal["session", "log"] | None = None


class DeviceUncertainty(_Part):
    """Standard uncertainties [m] that no log shows; of a key that is left out, what is usual."""

    via_points: NotNegative | None = None
    donning: NotNegative | None = None


class SoleEntry(_Part):
    """What a foot stands on: corners [m] in the frame of its link, in order around."""

    link: Name
    outline: Annotated[list[Place], Field(min_length=3, max_length=20)]


class MotionLimits(_Part):
    """Of joints, what the URDF does not say: one number for all, or joint by joint. acceleration [rad/s² or m/s²], jerk
    [rad/s³ or m/s³]. torque_share: of the URDF's effort that a motion may ask for."""

    acceleration: Positive | Annotated[dict[Name, Positive], Field(max_length=500)] = {}
    jerk: Positive | Annotated[dict[Name, Positive], Field(max_length=500)] = {}
    torque_share: Share | Annotated[dict[Name, Share], Field(max_length=500)] = {}


class ShapeEntry(_Part):
    """A convex shape in the frame of a link [m, rad]: edges of a box, radius of a sphere, (radius, length) of a
    cylinder, or of a capsule without its caps, both along z."""

    box: Annotated[tuple[Positive, Positive, Positive], BeforeValidator(_as_tuple)] | None = None
    sphere: Positive | None = None
    cylinder: Annotated[tuple[Positive, Positive], BeforeValidator(_as_tuple)] | None = None
    capsule: Annotated[tuple[Positive, Positive], BeforeValidator(_as_tuple)] | None = None
    xyz: Place = (0.0, 0.0, 0.0)
    rpy: Place = (0.0, 0.0, 0.0)

    @model_validator(mode="after")
    def _check(self) -> Self:
        if sum(size is not None for size in (self.box, self.sphere, self.cylinder, self.capsule)) != 1:
            raise ValueError("a shape is one of box, sphere, cylinder, capsule")
        return self


class Collision(_Part):
    """What must not touch. shapes: of a link, in place of the URDF's. left_out: pairs of links that may touch."""

    shapes: Annotated[dict[Name, Annotated[list[ShapeEntry], Field(max_length=50)]], Field(max_length=500)] = {}
    left_out: Annotated[list[Annotated[tuple[Name, Name], BeforeValidator(_as_tuple)]], Field(max_length=5000)] = []


class RobotFile(_Part):
    """robot.yaml. soles, limits, collision, human_map, home: for planning motions alone. human_map: part of the body ->
    link.

    home: posture [rad or m] in which planned motions begin and end, zero of joints that are not named.
    uncertainty `none`: of a simulated robot, which is what it is said to be.
    """

    version: Literal[1]
    name: Name | None = None
    urdf: RelativePath
    base: Literal["floating", "fixed"]
    base_link: Name | None = None
    imu: Imu | None = None
    ft_sensors: Annotated[list[SensorEntry], Field(max_length=50)] = []
    joints: Annotated[list[JointEntry], Field(min_length=1, max_length=500)]
    transmission: Transmission | None = None
    noise: Noise = Noise()
    inertial_prior_std: dict[str, Positive] = {}
    uncertainty: RobotUncertainty | Literal["none"] = RobotUncertainty()
    soles: Annotated[list[SoleEntry], Field(max_length=2)] = []
    limits: MotionLimits = MotionLimits()
    collision: Collision = Collision()
    human_map: Annotated[dict[Name, Name], Field(max_length=50)] = {}
    home: Annotated[dict[Name, Number], Field(max_length=500)] = {}

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.base == "floating" and self.base_link is None:
            raise ValueError("a floating base needs base_link: the link that carries the IMU")
        if self.base == "floating" and self.imu is None:
            raise ValueError("a floating base needs imu: the frame of the accelerometer and gyro")
        return self


class ViaPoint(_Part):
    """A point the band passes: xyz [m] in the frame of a link of the URDF."""

    link: Name
    xyz: Place


class BenchEntry(_Part):
    """A force-length test of the bare band: a table with columns length_m, force_n.

    is_truth: what estimates are compared with; otherwise the prior they start from.
    """

    file: RelativePath
    is_truth: bool = False


class Band(_Part):
    """group: bands of one group share their stiffness; default: the band is a group of its own.

    law: how the band pulls (`effects.band_laws`); law_values: that law's other parameters.
    ground_truth: stiffness and natural length are true, not nominal.
    """

    name: Name
    group: Name | None = None
    via_points: Annotated[list[ViaPoint], Field(min_length=2, max_length=50)]
    stiffness_n_per_m: Annotated[Positive, Field(le=1e7)] | None = None
    natural_length_m: Positive | None = None
    ground_truth: bool = False
    law: Name = "linear"
    law_values: Annotated[dict[Name, Number], Field(max_length=20)] = {}
    bench: BenchEntry | None = None


class DeviceFile(_Part):
    """device.yaml. tied: groups whose bands have one natural length."""

    version: Literal[1]
    name: Name
    bands: Annotated[list[Band], Field(min_length=1, max_length=200)]
    tied: Annotated[list[Name], Field(max_length=200)] = []
    record: DeviceRecord = DeviceRecord()
    uncertainty: DeviceUncertainty | Literal["none"] = DeviceUncertainty()
