"""`discrepancy` of results.json: what the search for missing effects found."""

from __future__ import annotations

from typing import Annotated, Literal, final

from pydantic import Field

from exogauge.studies.results.schema.values import PAIR, Consequence, Measured, Number, Part, later, maybe

Where = dict[str, str | bool]
WHERE = '`{"joint": "torso_pitch"}`, `{"sensor": "wrist", "axis": "fx"}`, `{"base": true}`; the name `all`: every one'


@final
class HeldOutError(Part):
    """RMSE of one channel in steady motion on held-out logs, without and with the effect."""

    channel: str = Field(description="as in `identification.validation`, or `support.<joint>`")
    unit: str = Field(description="N·m or N")
    rmse_before: Number = Field(description="without the effect [unit]")
    rmse_after: Number = Field(description="with it [unit]")
    noise_floor: Number = Field(description="that the sensors' own noise leaves [unit]")
    channel_words: str = later("the channel in words")
    log: str = later("the only log that has the effect, then fitted; else empty")


@final
class Objection(Part):
    """Why a candidate was not chosen, as data."""

    why: str = Field(description="which objection")
    value: Number = Field(description="the number that stands against it")
    beside: Number = Field(description="what was asked for, or what it stands beside")
    of: list[str] = Field(description="effects, the channel and the log, or the regime that it is about")
    sizes: dict[str, Measured] = Field(description="parameters that may as well be none")


@final
class Candidate(Part):
    """An effect that was tried and not chosen."""

    effect: str = Field(description="its identifier, as docs/effects.md lists them")
    where: Where = Field(description=WHERE)
    title: str = later("effect and place in words")
    score: Number = Field(description="share of the excess over the noise that it explains on held-out logs, 0…1")
    reason: str = Field(description="why it was not chosen, in words")
    objection: Objection | None = later("the same as data")


@final
class Coordinate(Part):
    """What an effect depends on, in bins."""

    name: str = Field(description="`velocity`, `position`, `time` …")
    unit: str = Field(description="of the values")
    values: list[Number] = Field(description="means of the bins [unit]")


@final
class EvidenceCurve(Part):
    """Mean residuals over the coordinate that the effect depends on."""

    coordinate: Coordinate = Field(description="the abscissa")
    unit: str = Field(description="of what follows")
    before: list[Number] = Field(description="mean residual without the effect [unit]")
    after: list[Number] = Field(description="mean residual with it [unit]")
    spread: list[Number] = Field(description="standard error of the mean residual [unit]")
    model: list[Number] = Field(description="mean of what the effect itself adds [unit]")
    along_motion: bool = later("positive is along the motion, not along the joint")


@final
class RivalApart(Part):
    """How far a finding and what these logs cannot tell from it are apart."""

    rival: str = Field(description="effect of the rival")
    place: str = Field(description="where it would sit, in words")
    left_now: Number = Field(description="share of what tells them apart that is left in these logs, 0…1")
    left_then: Number = Field(description="the same with the planned motion, 0…1")
    evidence_now: Number = Field(description="twice the log likelihood to be expected of these logs; 10 is enough")
    evidence: Number = Field(description="the same that the planned motion adds")
    rate: Number = Field(description="the same per 10 s of it")
    seconds: Number = Field(
        description="until it is enough [s]; null where no motion that was tried does it in ten minutes"
    )


@final
class Companion(Part):
    """A joint that moves slowly beside the one that is swept."""

    joint: str = Field(description="its name")
    range: Annotated[list[float], PAIR] = Field(description="[low, high] [rad or m]")


@final
class Planned(Part):
    """A motion to record."""

    file: str = Field(description="of every joint's position over it")
    joint: str = Field(description="that is swept; empty where none is")
    kind: Literal["speeds", "sine", "small", "drawn"] = Field(
        description="how; drawn: several joints as the file says, amplitude, offset and speeds are null then"
    )
    amplitude: Number = Field(description="[unit]")
    offset: Number = Field(description="[unit]")
    slowest: Number = Field(description="[unit/s]")
    fastest: Number = Field(description="[unit/s]")
    period_s: Number = Field(description="of a sine [s]; else null")
    unit: Literal["rad", "m"] = Field(description="m of a joint that slides")
    companion: Companion | None = Field(description="null where nothing moves beside it")
    others: list[str] = later("joints that move as the file says, alone or beside the swept one")
    kept: list[Literal["touch", "torque", "balance"]] = later(
        "what holds beside every joint's own limits: it does not touch itself, bears the torques, keeps its balance"
    )
    unknown: list[Literal["touch", "torque", "balance"]] = later("which of these is not known")
    repeats: int = Field(description="how often the whole is moved")
    duration_s: Number = Field(description="of all repeats [s]")
    tells_from: list[str] = Field(description="effects that it tells from the finding")
    sentence: str = Field(description="the same in words")


@final
class NamedEffect(Part):
    """An effect that the model lacked."""

    rank: int = Field(description="1 is what matters most")
    effect: str = Field(description="its identifier, as docs/effects.md lists them")
    where: Where = Field(description=WHERE)
    title: str = later("effect and place in words")
    parameters: dict[str, Measured] = Field(description="coefficients and shapes by name")
    parameter_words: dict[str, str] = later("what those are that need words, by name")
    held_out: HeldOutError = Field(description="the error without and with it")
    score: Number = Field(description="share of the excess over the noise that it explains on held-out logs, 0…1")
    evidence: str = Field(description="the evidence in a sentence")
    alternatives: list[Candidate] = Field(description="what it was tried against")
    also_possible: list[Candidate] = Field(description="what these logs cannot tell from it")
    motion: str = Field(description="in words: the motion that would; else empty")
    apart: list[RivalApart] = later("of each that is also possible")
    planned: list[Planned] = later("motions that would tell it from those")
    device: str = maybe("which, of several, where it is about a band")
    taken_over: str = maybe("file among the results: the device.yaml that states it")
    curve: EvidenceCurve = Field(description="the evidence drawn")


@final
class ChainLink(Part):
    """One model, from the maker's numbers to the last effect that was named."""

    step: str = Field(description="what the model is, in words")
    what: Literal["robot", "bands", "effect", "own_curve", "remainder"] = later(
        "what was added last; robot, bands: a first model"
    )
    effect: str | None = later("its identifier; null of a first model")
    where: Where | None = later(WHERE)
    rmse: Number = Field(description="of the channels in question, held out, in steady motion [unit]")
    noise_floor: Number = Field(description="that the sensors' own noise leaves [unit]")
    worst: str = Field(description="the channel furthest above its floor; empty where there is none")
    worst_rmse: Number = Field(description="its RMSE [worst_unit]")
    worst_floor: Number = Field(description="its floor [worst_unit]")
    unit: str = Field(description="`floors`: channels of several units, each in multiples of its noise floor")
    worst_unit: str = later("N·m or N")
    worst_words: str = later("the channel in words")


@final
class ChannelExcess(Part):
    """A channel above its noise."""

    channel: str = Field(description="as in `identification.validation`")
    unit: str = Field(description="N·m or N")
    rmse: Number = Field(description="[unit]")
    noise_floor: Number = Field(description="[unit]")
    z: Number = Field(description="standard errors above the floor")
    channel_words: str = later("the channel in words")
    where: str = Field(description="in words: at which speeds, positions or times, and in which log, it is largest")


@final
class ModelVersion(Part):
    """One version of the model."""

    version: str = Field(description="its hash")
    parent: str | None = Field(description="null of the first")
    added: str = Field(description="`effect@place`; empty of the first")
    title: str = later("the same in words")
    finding: int | None = later("rank of the finding that it was added with; null of what has no name of its own")


@final
class Discrepancy(Part):
    """Which effects the model lacked."""

    verdict: Literal["effects", "unexplained", "undecided", "none"] = Field(
        description="effects: some are named; unexplained: something is surely above the noise and nothing explains "
        "it; none: every channel stands at its floor; undecided: neither can be said"
    )
    left: Literal["above", "open", "nothing"] = later("what is above the noise with all that was named")
    reason: str = later("why that is open, in numbers; else empty")
    sentence: str = later("the verdict in words")
    left_sentence: str = later("what is left in words; empty where the verdict has said it")
    findings: list[NamedEffect] = Field(description="what matters most first")
    chain: list[ChainLink] = Field(description="from the first model to the last")
    wear_chain: list[ChainLink] = later("the same of the model of the wear; empty where nothing was added to it")
    located: list[ChannelExcess] = Field(description="above their noise before anything was named")
    unexplained: list[ChannelExcess] = Field(description="above their noise with all that was named")
    within_declared: list[ChannelExcess] = later("above their noise no further than declared uncertainties let them")
    rejected: list[Candidate] = Field(description="tried and not named")
    lineage: list[ModelVersion] = Field(description="versions of the model")
    candidates: int = Field(description="how many there were, each an effect at one place in one shape")
    notes: list[str] = Field(description="what to keep in mind, in sentences")
    before_after: dict[str, Consequence] = Field(description="by quantity of support or stiffness")
