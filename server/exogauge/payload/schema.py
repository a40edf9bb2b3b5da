"""The shape of a payload's results.json, and of the JSON beside a plan. Loads no numerics."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict

from exogauge import __version__


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class Value(_Part):
    """std: standard deviation; low, high: 95 % interval. identified: False where a belief decides it."""

    name: str
    unit: str
    value: float
    std: float
    low: float
    high: float
    identified: bool = True


class LeftOutErrors(_Part):
    """Root mean square in a posture that was not fitted."""

    force_n: float
    moment_nm: float


class Further(_Part):
    """gravity: its direction in the sensor's axes, of the posture that would tell most; std_then: by name."""

    gravity: tuple[float, float, float]
    std_then: dict[str, float]


class StaticResults(_Part):
    """covariance: of `values`, in their order and units."""

    postures: int
    condition_force: float
    condition_moment: float
    inclined: bool
    left_out_level: LeftOutErrors | None
    left_out_inclined: LeftOutErrors | None
    values: list[Value]
    covariance: list[list[float]]
    by_method: dict[str, dict[str, float]]
    further: Further
    residual_force_n: float
    residual_moment_nm: float


class DynamicResults(_Part):
    """covariance: of `values`, in their order and units. mu: residual over what the stated noise explains; None where
    that is not known. least_squares_would_do: None where only LS was run. possible: values of the likeliest body that
    can exist, where the estimate is none. level: values where the base is taken to be level, by TLS where the
    noise is known; None without postures."""

    method: str
    mu: float | None
    mu_std: float | None
    values: list[Value]
    covariance: list[list[float]]
    by_method: dict[str, dict[str, float]]
    recursion: dict[str, float]
    least_squares_would_do: bool | None
    mass_from_motion_alone: Value
    level: dict[str, float] | None = None
    possible: dict[str, float] | None
    cost_of_possible: float
    residual_rms: list[float]
    jerk_density: list[float]
    left_out_s: list[tuple[float, float]]


class FigureResults(_Part):
    """Force [N], then moment [N·m]: norm at t = 0, its mean and std; axes: at t = 0, mean, std of each axis with its
    sign; rms, most: of each axis, root mean square and largest size."""

    first: tuple[float, float]
    mean: tuple[float, float]
    std: tuple[float, float]
    axes: list[list[float]]
    rms: list[float]
    most: list[float]


class RemainderResults(FigureResults):
    """after_zero: the same after the secondary zero, where it helps; zero_helps: the share of time in which it does."""

    after_zero: FigureResults
    zero_helps: float


class CalibrationResults(_Part):
    """What a sensor's calibration adds to the doubt (GUM 4.3, type B): standard deviations, as shares, of the gain of
    each axis, of a gain that all share, of what an axis reads of another one. defaulted: which of them nobody stated.
    worse: by how many times gains and crosstalk are worse than that, as axes differ: taken so. taken_out: (6, 6) share
    that a channel reads of another one, forces then moments, N and N·m, that was taken out of all wrenches; None where
    none was. common: mean of the six gains that was taken out, and the standard deviation of what is left of it. std:
    (6, 6) the same of each share, of gains against their mean. std_without: of each number, what its standard deviation
    would be with an exact sensor. said: in a sentence."""

    ft_gain: float
    ft_gain_common: float
    ft_crosstalk: float
    defaulted: list[str]
    worse: tuple[float, float]
    taken_out: list[list[float]] | None
    std: list[list[float]] = []
    common: tuple[float, float] = (0.0, 0.0)
    std_without: dict[str, float]
    said: str


class ContactResults(_Part):
    """force_n: largest force on the payload, in the sensor's axes."""

    start_s: float
    end_s: float
    force_n: tuple[float, float, float]


class ImuResults(_Part):
    rotation_sensor_imu: list[list[float]]
    angle_deg: float
    bias: tuple[float, float, float]
    lag_ms: float
    lag_std_ms: float
    rms: float
    place_m: tuple[float, float, float]
    place_std_m: tuple[float, float, float]


class MissingParameter(_Part):
    name: str
    unit: str
    value: float
    std: float


class MissingEffect(_Part):
    """evidence: of the Bayesian information criterion. before, after: rms of what was not fitted, over its floor.
    rivals: (effect, place) that explain these data as well. parameters: none where their size cannot be told. said: in
    a sentence."""

    effect: str
    place: str
    parameters: list[MissingParameter]
    evidence: float
    before: float
    after: float
    rivals: list[tuple[str, str]]
    said: str


class ChannelRatios(_Part):
    """rms over the floor of noise, of fx, fy, fz, mx, my, mz: without and with what was found."""

    before: list[float]
    after: list[float]


class MissingResults(_Part):
    """verdict: effects, unexplained, undecided, none. found: what was named. suspected: what takes something off, while
    more is left that nothing explains. in_the_model: whether all other numbers are with what was found; without: then
    those of a rigid body behind an ideal sensor alone. reason: why it is undecided. said: in a sentence."""

    verdict: Literal["effects", "unexplained", "undecided", "none"]
    reason: str | None
    found: list[MissingEffect]
    suspected: list[MissingEffect]
    left: dict[str, ChannelRatios]
    in_the_model: bool
    without: list[Value]
    candidates: int
    said: str


class Deciding(_Part):
    """A number that decides. source: `derived`, `measured`, `convention` or `judgement`; where: of what, or in which
    document."""

    name: str
    value: float | list[float]
    unit: str
    why: str
    source: str
    where: str


class PayloadResults(_Part):
    """frame: of every vector. sees: told from the data. criteria: numbers that decided."""

    version: Literal[1]
    exogauge: str
    name: str
    frame: str
    sees: Literal["payload_on_sensor", "sensor_on_payload"]
    static: StaticResults | None
    dynamic: DynamicResults | None
    tests: dict[str, dict[str, RemainderResults]]
    contacts: dict[str, list[ContactResults]]
    contact_threshold_n: dict[str, float]
    imu: ImuResults | None
    missing: MissingResults
    calibration: CalibrationResults | None = None
    mass_error_kg: float | None
    warnings: list[str]
    criteria: list[Deciding] = []


class Certainty(_Part):
    """std: standard deviation with the plan's data; before: without it, None where nothing is known."""

    name: str
    unit: str
    std: float
    before: float | None
    decided: bool


class Found(_Part):
    """condition: of the force and the moment part, of postures. strain: largest share of a bound at 1 kHz, of motion;
    starts: mean ln of the standard deviations that each of them reached. undecided: names."""

    version: Literal[1] = 1
    exogauge: str = __version__
    name: str
    kind: Literal["postures", "excitation"]
    choice: str
    certainties: list[Certainty]
    undecided: list[str]
    seconds: float
    condition: tuple[float, float] | None = None
    strain: float | None = None
    starts: list[float] | None = None
    warnings: list[str]
