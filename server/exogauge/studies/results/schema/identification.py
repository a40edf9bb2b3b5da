"""`identification` of results.json: how well the robot's model predicts, and its parameters."""

from __future__ import annotations

from typing import Literal, final

from pydantic import ConfigDict, Field

from exogauge.studies.results.schema.values import Decided, DoubtPart, Number, Part, later, maybe

ErrorKind = Literal["base_moment", "trunk_torque", "joint_torque", "joint_force", "sensor_force", "sensor_moment"]


@final
class PooledError(Part):
    """RMSE over several channels and logs, pooled over samples."""

    kind: ErrorKind = Field(description="joint_force: of joints that slide")
    channels: list[str] = Field(description="pooled, as in `validation`")
    logs: list[str] = Field(description="pooled")
    unit: str = Field(description="N·m or N")
    held_out: bool = Field(description="false where no log was held out: then of fitted ones")
    rmse_prior: Number = Field(description="with the maker's numbers [unit]")
    rmse_identified: Number = Field(description="with the identified ones [unit]")
    noise_floor: Number = Field(description="that the sensors' own noise leaves [unit]")


@final
class ChannelError(Part):
    """RMSE of one channel on one log."""

    channel: str = Field(description="`base.fx` … `base.mz`, `tau.<joint>` or `ft.<sensor>.fx` …")
    unit: str = Field(description="N·m or N")
    log: str = Field(description="its name")
    held_out: bool = Field(description="whether the log was held out of the fit")
    rmse_prior: Number = Field(description="with the maker's numbers [unit]")
    rmse_identified: Number = Field(description="with the identified ones, all samples [unit]")
    noise_floor: Number = Field(description="what a model that lacks nothing leaves in steady motion [unit]")
    rest_share: Number = later("samples at which the joint stands still, 0…1")
    rmse_moving: Number = later("in steady motion, above the cut-off the sensors' noise alone [unit]")
    rmse_at_rest: Number = later("at rest [unit]")
    noise_beyond_band: Number = later("of the noise floor, what is above the cut-off [unit]")
    steady_s: Number = later("in steady motion [s]")
    moved_s: Number = later("not at rest [s]")
    channel_words: str = later("the channel in words")


@final
class SteadySeconds(Part):
    """How long one joint moves steadily, which alone is fitted and judged."""

    joint: str = Field(description="its name")
    fitted_s: Number = Field(description="in steady motion in fitted logs [s]")
    fitted_of_s: Number = Field(description="in motion in fitted logs [s]")
    held_out_s: Number = Field(description="in steady motion in held-out logs [s]")
    held_out_of_s: Number = Field(description="in motion in held-out logs [s]")
    both_directions: bool = Field(description="whether what is fitted goes both ways, or the joint does not")


@final
class IdentifiedParameter(Decided):
    """One parameter of the robot."""

    name: str = Field(description="`m[link]`, `k_T[joint]`, `base[<leading name>]` …")
    prior_std: Number = Field(description="standard deviation of the prior [unit]")
    budget: list[DoubtPart] = maybe("of one that the data decide: what the doubt is made of, the largest part first")
    combination: dict[str, float] = maybe("of a base parameter: the coefficient of every standard parameter in it")


@final
class JointNumbers(Part):
    """The numbers of one joint that were in the model; other keys are those of effects in the model."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Decided] = Field(init=False)

    joint: str = Field(description="its name")
    k_T: Decided = maybe("torque per ampere [N·m/A]")
    k_d: Decided = maybe("viscous friction [N·m·s/rad]")
    tau_c: Decided = maybe("Coulomb friction [N·m]")
    tau_s: Decided = maybe("static friction [N·m]")
    tau_o: Decided = maybe("offset [N·m]")
    J_r: Decided = maybe("reflected rotor inertia [kg·m²]")


@final
class SensorZero(Part):
    """A sensor inside the robot."""

    sensor: str = Field(description="its name")
    carries: list[str] = Field(description="bodies beyond it")
    zero: dict[str, Decided] = Field(description="by component `fx` … `mz`, in the log's own sign [N, N·m]")


@final
class PriorScore(Part):
    """One strength of the prior that was tried."""

    factor: Number = Field(description="on the prior's weight")
    score: Number = Field(description="mean squared weighted error on held-out blocks")


@final
class RestLimit(Part):
    """Below which speed a joint is told to be at rest."""

    joint: str = Field(description="its name")
    value: Number = Field(description="[unit]")
    unit: Literal["rad/s", "m/s"] = Field(description="m/s of a joint that slides")


@final
class KnownLoad(Part):
    """A weighed load that some logs carry."""

    load: str = Field(description="link or frame that it is fixed to")
    logs: list[str] = Field(description="that carry it")
    mass_kg: Number = Field(description="as stated [kg]")
    std_kg: Number = Field(description="as stated [kg]")
    found_kg: Number = Field(description="with the logs [kg]; null where it is not in the model")
    found_std_kg: Number = Field(description="of that [kg]")
    part_of_its_link: bool = Field(description="every fitted log carries it: it cannot be told from its link")


@final
class WeighedMass(Part):
    """The whole robot's mass by the contact sensors, against its maker's: two numbers that ought to be one."""

    found_kg: Number = Field(description="by the logs")
    found_std_kg: Number = Field(description="of that, gains of the sensors in it")
    stated_kg: Number = Field(description="by the maker")
    stated_std_kg: Number = Field(description="of that")
    z: Number = Field(description="difference over its standard deviation")
    limit: Number = Field(description="of |z|")
    agrees: bool = Field(description="within the limit")


@final
class CommonFactor(Part):
    """The one factor on all torques, masses and friction that currents alone leave open."""

    measured: bool = Field(description="whether a force or torque fixes it")
    known: bool = Field(description="whether that or a known load does")
    std: Number = Field(description="of the factor, relative; null where it is measured")
    unweighed: Number = Field(description="the same without the known loads; null where it is measured")


@final
class Identification(Part):
    """What identification found of the robot."""

    summary: list[PooledError] = Field(description="errors, pooled")
    validation: list[ChannelError] = Field(description="errors by channel and log")
    parameters: list[IdentifiedParameter] = Field(description="standard, base and joint parameters")
    joints: list[JointNumbers] = Field(description="the joints' numbers once more, by joint")
    sensors: list[SensorZero] = later("each sensor with `role: cut`")
    unidentifiable: list[str] = Field(
        description="parameters that the prior decides more than the data, or that are only bounded"
    )
    consistent_links: dict[str, bool] = Field(description="by link: whether a body can have its inertia")
    prior_strength: Number = Field(description="factor on the prior's weight that was used")
    prior_curve: list[PriorScore] = Field(description="all that were tried")
    rank: int = Field(description="of the equations")
    condition: Number = Field(description="condition number of the equations")
    samples: int = Field(description="fitted")
    cutoff_hz: Number = Field(description="of the low-pass on every signal [Hz]")
    steady: list[SteadySeconds] = later("by joint")
    known_loads: list[KnownLoad] = later("each load of `known` in study.yaml")
    total_mass: WeighedMass | None = later("null where no contact sensor bears the robot")
    common_factor: CommonFactor = later("whether the scale of torques is known")
    velocity_threshold: list[RestLimit] = Field(description="by joint")
