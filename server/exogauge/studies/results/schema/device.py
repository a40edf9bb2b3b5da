"""`support`, `stiffness` and `stiffness_details` of results.json: what the device does, and its bands."""

from __future__ import annotations

from typing import Annotated, Literal, final

from pydantic import Field

from exogauge.studies.results.schema.values import PAIR, Doubted, Measured, MotionEquality, Number, Part, later, maybe

Approach = Literal["A", "B", "paired", "prior", "band_model"]


@final
class Headline(Doubted):
    """One number of the whole motion, by the approach whose own null test says it is best."""

    approach: Approach = Field(description="`A`, `B` or `paired`")
    as_good: list[Approach] = later("whose null test differs by no more than chance; the approach among them")


class Effort(Part):
    """Torque of one approach; positive along the joint."""

    peak: Measured = Field(description="largest mean over 0.2 s, with its sign [N·m]")
    mean: Measured = Field(description="[N·m]")
    integral: Measured = Field(description="[N·m·s]")


@final
class WholeEffort(Effort):
    """The same over the whole motion."""

    peak: Doubted = Field(description="largest mean over 0.2 s, with its sign [N·m]")
    mean: Doubted = Field(description="[N·m]")
    integral: Doubted = Field(description="[N·m·s]")
    spread: Number = Field(description="standard deviation of the mean between trials [N·m]; null with one trial")


@final
class ByApproach(Part):
    """A: run without minus run with the device; B: model minus measurement; paired: B of the run with the device minus
    B of its partner without; prior: B with the maker's values; band_model: what the bands of the device file give."""

    A: WholeEffort = maybe("where a run without the device was compared")
    B: WholeEffort = maybe("model minus measurement")
    paired: WholeEffort = maybe("B of the run with minus B of its partner without, where there is one")
    prior: WholeEffort = maybe("B with the maker's values")
    band_model: WholeEffort = maybe("where the bands' values are known")


@final
class PhaseByApproach(Part):
    """As `ByApproach`, of one phase."""

    A: Effort = maybe("where a run without the device was compared")
    B: Effort = maybe("model minus measurement")
    paired: Effort = maybe("B of the run with minus B of its partner without, where there is one")
    prior: Effort = maybe("B with the maker's values")
    band_model: Effort = maybe("where the bands' values are known")


@final
class Phase(Part):
    """One part of a motion."""

    phase: str = Field(description="lowering, holding, raising or standing")
    duration_s: Number = Field(description="mean over the trials [s]")
    approaches: PhaseByApproach = Field(description="torque by approach")
    best: Approach | None = later("whose null test in such motion, or at rest, says it is best")


@final
class TrialEquality(Part):
    """How alike one run with the device and its reference are."""

    log: str = Field(description="with the device")
    reference: str = Field(description="without it")
    lag_s: Number = Field(description="how much later the same motion comes in the reference [s]")
    q_rms: Number = Field(description="of the difference [rad or m]")
    dq_rms: Number = Field(description="of the difference [rad/s or m/s]")
    dq_share: Number = Field(description="dq_rms over the joint's own rms velocity; 0 where it hardly moves")
    verdict: MotionEquality = Field(description="by the limits in `configuration.settings`")


@final
class EqualityUnits(Part):
    """Of a joint that turns; of one that slides m and m/s."""

    q_rms: str = Field(description="rad")
    dq_rms: str = Field(description="rad/s")


@final
class Equality(Part):
    """How alike the compared motions are, pooled over the trials."""

    q_rms: Number = Field(description="of the difference [rad or m]")
    dq_rms: Number = Field(description="of the difference [rad/s or m/s]")
    dq_share: Number = Field(description="dq_rms over the joint's own rms velocity")
    units: EqualityUnits = Field(description="of these")
    verdict: MotionEquality = Field(description="the worst of the trials'")
    lag_s: Number = Field(description="the largest of the trials' [s]")
    trials: list[TrialEquality] = Field(description="each")


@final
class OfNull(Part):
    """A number of A, of B and of the paired estimate."""

    a: Number = Field(description="[N·m]")
    b: Number = Field(description="[N·m]")
    paired: Number = later("[N·m]")


@final
class OfError(Part):
    """A number of A, of B, of the paired estimate, and of B with the maker's values."""

    a: Number = Field(description="[N·m]")
    b: Number = Field(description="[N·m]")
    paired: Number = later("[N·m]")
    prior: Number = Field(description="[N·m]")


@final
class Support(Part):
    """Supporting torque on one joint in one motion with one device, over all trials."""

    device: str = Field(description="its name")
    motion: str = Field(description="its name")
    joint: str = Field(description="its name")
    unit: str = Field(description="N·m")
    main: bool = Field(description="one of the one or two moving joints with the largest torque")
    logs: list[str] = Field(description="with the device")
    references: list[str] = Field(description="without it")
    rmse_a: Number = Field(description="of A against the band model, all samples [N·m]")
    rmse_b: Number = Field(description="of B against the band model, all samples [N·m]")
    rmse_paired: Number = later("of the paired estimate against the band model, all samples [N·m]")
    rmse_prior: Number = Field(description="of B with the maker's values against the band model, all samples [N·m]")
    rmse_steady: OfError = Field(description="the same where both runs move steadily [N·m]")
    motion_equality: Equality | None = Field(description="null without A")
    peak: Headline | None = Field(description="of the whole motion [N·m]")
    mean: Headline | None = Field(description="of the whole motion [N·m]")
    integral: Headline | None = Field(description="of the whole motion [N·m·s]")
    approaches: ByApproach = Field(description="the whole motion")
    phases: list[Phase] = Field(description="its parts")
    null: OfNull = Field(description="RMS of what an approach finds on logs without the device, where the truth is 0")
    masked_share: Number = Field(description="of A's samples not used, 0…1")
    rest_share: Number = Field(description="of samples at rest, 0…1")
    rest_half_width: Number = Field(description="half of B's interval at rest [N·m]")
    band_model: str | None = Field(description="where the values of the band model come from, in words")


@final
class BandIntervals(Part):
    """95 %, [low, high]; null where it is open."""

    stiffness_n_per_m: Annotated[list[Number], PAIR] = Field(description="[N/m]")
    natural_length_m: Annotated[list[Number], PAIR] = Field(description="[m]")


@final
class DoubtSource(Part):
    """One source of doubt."""

    source: str = Field(
        description="`scatter`, `robot`, `null_test`, `at_rest`, or what robot.yaml and device.yaml declare under "
        "`uncertainty`"
    )
    words: str = Field(description="the same in words")
    advice: str = Field(description="which measurement would make it smaller")


@final
class BandShare(Part):
    """What one source alone does to a band. Squares of all add up to the square of the standard deviation."""

    source: str = Field(
        description="`scatter`, `robot`, `null_test`, `unexplained` beside what was named, or what robot.yaml and "
        "device.yaml declare under `uncertainty`"
    )
    words: str = Field(description="the same in words")
    stiffness_std: Number = Field(description="[N/m]")
    natural_length_std: Number = Field(description="[m]; null of a length that the data do not decide")
    advice: str = Field(description="what would make it smaller")


@final
class BandStiffness(Part):
    """One band of one device by one approach."""

    device: str = Field(description="its name")
    approach: Literal["A", "B", "paired", "prior"] = Field(description="as in `support`")
    band: str = Field(description="its name")
    group: str = Field(description="of bands that share stiffness and law")
    stiffness_n_per_m: Measured = Field(description="[N/m]")
    natural_length_m: Measured = Field(description="[m]")
    interval_95: BandIntervals = Field(description="of both")
    truth_n_per_m: Number = Field(description="where `ground_truth: true` [N/m]")
    error_percent: Number = Field(description="of the stiffness against the truth [%]")
    identifiable: bool = Field(description="whether the data decide the stiffness")
    headline: bool = later("of the approach with the smallest doubt for its size, its null test in it")
    length_identifiable: bool = Field(description="whether the data decide the natural length")
    note: str = Field(description="why not, in words, or empty")
    budget: list[BandShare] = Field(description="what the doubt is made of, largest share of the stiffness first")


@final
class StiffnessCheck(Part):
    """Two parts of the evidence that ought to give one stiffness, or one natural length."""

    device: str = Field(description="its name")
    approach: Literal["A", "B", "paired"] = Field(description="as in `support`")
    check: Literal["approaches", "repetitions", "strokes", "pulls", "relaxation", "sides", "misfit", "halves"] = Field(
        description="what is compared"
    )
    group: str = Field(description="of bands that share stiffness and law")
    between: list[str] = Field(description="the two parts")
    difference: Number = Field(description="first minus second; of `misfit`: how far the stiffness may be off")
    std: Number = Field(description="of the difference")
    unit: Literal["N/m", "m"] = later(
        "of both; m of `halves`, and of `repetitions` and `strokes` with one stiffness, which compare natural lengths"
    )
    z: Number = Field(description="difference over std")
    limit: Number = Field(description="of |z|")
    small: Number = later("[unit] a difference that fails nothing, however sure: a third of the doubt that is told")
    agrees: bool = Field(
        description="within the limit, or no more than `small`; where not, the stiffness is not identifiable"
    )


@final
class StiffnessFit(Part):
    """How all bands of one device were fitted by one approach."""

    device: str = Field(description="its name")
    approach: Literal["A", "B", "paired", "prior"] = Field(description="as in `support`")
    parameters: list[str] = Field(description="`stiffness[group]`, `natural_length[band]`, in the order of correlation")
    correlation: list[list[Number]] = Field(description="of the parameters, -1…1")
    rms: dict[str, Number] = Field(description="by joint: what the bands leave unexplained [N·m]")
    samples: int = Field(description="used")
    notes: list[str] = Field(description="what to keep in mind, in sentences")
