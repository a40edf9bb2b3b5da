"""The report's section on missing effects: verdict, chain, each finding with its evidence, and what is left."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

from markupsafe import Markup

from exogauge.devices.result import Estimate
from exogauge.findings.result import Alternative, Consequence, Discrepancy, Excess, Finding, Lineage, Link
from exogauge.studies.report.discrepancy_figures import draw_chain, draw_evidence, is_cut
from exogauge.studies.report.support_section import plus_minus
from exogauge.studies.words.discrepancy_sentences import (
    chain_unit,
    chain_words,
    kind_of_channels,
    looked_at,
    moves,
)
from exogauge.studies.words.finding_sentences import consequence_words, finding_sentence, where_words
from exogauge.studies.words.motion_sentences import motion_words
from exogauge.studies.words.names import added_words, capital, channel, parameter_words, step_words, titled
from exogauge.studies.words.reason_sentences import note_words, objection_words
from exogauge.studies.words.rounding import significant, with_std

COORDINATES = {
    "position": "angle",
    "drive": "torque of the motor",
    "load": "load on the joint",
    "reading": "expected reading",
}
CHAIN = "From the first model to the noise floor"
BEYOND_BAND = "Above the cut-off, of which the model says nothing, the noise alone counts. "
WEAR_CHAIN = "The model of the wear, from bands as described to the noise floor of the supporting torque"
MOST_LETTERS = 3  # of a symbol: longer ones are words
GREEK = {"beta": "β", "delta": "δ", "mu": "μ", "theta": "θ"}


@final
@dataclass(frozen=True)
class Picture:
    """An inline SVG, the words that stand in for it, and its caption."""

    svg: Markup
    words: str
    caption: str


@final
@dataclass(frozen=True)
class ParameterRow:
    """symbol: whether `name` is a letter with an index rather than a word. means: what it is, in words, or ""."""

    name: str
    symbol: bool
    value: str
    std: str
    unit: str
    means: str


@final
@dataclass(frozen=True)
class CandidateRow:
    """name in words; effect: its identifier; share: of the excess explained, in per cent; bar: the same, 0 to 100."""

    name: str
    effect: str
    share: str
    bar: float
    reason: str
    chosen: bool = False


@final
@dataclass(frozen=True)
class FindingView:
    title: str
    effect: str
    sentence: str
    channel: str
    before: str
    after: str
    floor: str
    unit: str
    picture: Picture | None
    parameters: tuple[ParameterRow, ...]
    beaten: tuple[CandidateRow, ...]
    alike: tuple[CandidateRow, ...]
    motion: str


@final
@dataclass(frozen=True)
class ExcessRow:
    channel: str
    rmse: str
    floor: str
    ratio: str
    z: str
    unit: str
    where: str


@final
@dataclass(frozen=True)
class ChangeRow:
    """A quantity of support or stiffness without and with the named effects; change in per cent."""

    quantity: str
    before: str
    after: str
    unit: str
    change: str


@final
@dataclass(frozen=True)
class DiscrepancyView:
    """channels: `torques`, or `channels` where other readings were looked at too. at_floor: nothing is left
    above the noise, and enough was seen to say so."""

    verdict: str
    at_floor: bool
    sentence: str
    left: str
    looked_at: str
    channels: str
    chain: Picture | None
    wear_chain: Picture | None
    findings: tuple[FindingView, ...]
    located: tuple[ExcessRow, ...]
    unexplained: tuple[ExcessRow, ...]
    within_declared: tuple[ExcessRow, ...]
    rejected: tuple[CandidateRow, ...]
    changes: tuple[ChangeRow, ...]
    unchanged: tuple[ChangeRow, ...]
    lineage: tuple[tuple[str, str, str], ...]
    notes: tuple[str, ...]


def discrepancy_view(found: Discrepancy | None, content: Mapping[str, Any]) -> DiscrepancyView | None:
    """content: of results.json. None where the step was skipped."""
    if found is None:
        return None
    entry = content["discrepancy"]
    findings = tuple(_finding(each, f"d{each.rank}") for each in found.findings)
    chain = _chain(found.chain, "dc", CHAIN) if found.chain else None
    wear_chain = _chain(found.wear_chain, "dw", WEAR_CHAIN) if found.wear_chain else None
    return DiscrepancyView(
        verdict=entry["verdict"],
        at_floor=entry["left"] == "nothing",
        sentence=entry["sentence"],
        left=entry["left_sentence"],
        looked_at=looked_at(content),
        channels=kind_of_channels(content),
        chain=chain,
        wear_chain=wear_chain,
        findings=findings,
        located=_excesses(found.located),
        unexplained=_excesses(found.unexplained),
        within_declared=_excesses(found.declared.channels),
        rejected=_rejected(found.rejected),
        changes=tuple(_change(each) for each in found.before_after if moves(each.before, each.after)),
        unchanged=tuple(_change(each) for each in found.before_after if not moves(each.before, each.after)),
        lineage=tuple((each.version, each.parent or "–", _added(each)) for each in found.lineage),
        notes=tuple(dict.fromkeys(map(note_words, found.notes))),
    )


def _chain(links: Sequence[Link], key: str, of: str) -> Picture:
    """of: what the bars are, before the quantity that they show."""
    steps = ", ".join(f"{step_words(link.step)} {significant(link.rmse)}" for link in links)
    floor = significant(links[-1].noise_floor)
    unit = links[-1].unit
    told = chain_words(unit)
    words = f"{of}: {told}, steady motion, held-out logs, {chain_unit(unit)}: {steps}; noise floor {floor}."
    beyond = BEYOND_BAND if of == CHAIN else ""
    colours = "Grey: what noise explains; coloured: what is above it."
    caption = f"{of}: {told}, in steady motion on held-out logs. {beyond}{colours}"
    if is_cut(links):
        caption += " The bar with a gap is longer than drawn."
    return Picture(Markup(draw_chain(links, key)), words, caption)


def _finding(finding: Finding, key: str) -> FindingView:
    held = finding.held_out
    title = titled(finding.effect, finding.place)
    own = CandidateRow(capital(title), finding.effect, *_share(finding.score), "the one named", chosen=True)
    others = sorted(finding.alternatives, key=_by_score)
    return FindingView(
        title=capital(title),
        effect=finding.effect,
        sentence=finding_sentence(finding),
        channel=channel(held.channel),
        before=significant(held.rmse_before),
        after=significant(held.rmse_after),
        floor=significant(held.noise_floor),
        unit=held.unit,
        picture=_evidence(finding, title, key) if len(finding.evidence.at) else None,
        parameters=tuple(_parameter(finding.effect, name, each) for name, each in finding.parameters.items()),
        beaten=(own, *(_candidate(each) for each in others)),
        alike=tuple(_candidate(each) for each in finding.also_possible),
        motion=motion_words(finding),
    )


def _evidence(finding: Finding, title: str, key: str) -> Picture:
    evidence, held = finding.evidence, finding.held_out
    name, unit = channel(held.channel), held.unit
    reading = held.channel.startswith("ft.")
    way = " along its motion" if evidence.along_motion else ""
    lacking = (
        f"What {name} reads beyond the model" if reading else f"Torque that acts on {name}{way} and the model lacks"
    )
    over = COORDINATES.get(evidence.coordinate, evidence.coordinate.replace("_", " "))
    words = (
        f"{lacking}, over {over}, and the part of {title}. Before, it reaches "
        f"{_largest(evidence.before)} {unit}, after {_largest(evidence.after)} {unit}."
    )
    caption = f"{lacking}, over {over}: means of bins, without and with {title}."
    return Picture(Markup(draw_evidence(evidence, COORDINATES, key, unit)), words, caption)


def _largest(values: Iterable[float]) -> str:
    return significant(max((abs(float(value)) for value in values if math.isfinite(value)), default=math.nan), 2)


def _parameter(effect: str, name: str, found: Estimate) -> ParameterRow:
    head, under, index = name.partition("_")
    head = GREEK.get(head, head)
    symbol = len(head) <= MOST_LETTERS
    value, std = with_std(found.value, found.std)
    unit = "" if found.unit == "1" else found.unit
    shown = head + under + index if symbol else name.replace("_", " ")
    return ParameterRow(shown, symbol, value, std, unit, parameter_words(effect, name))


def _candidate(other: Alternative) -> CandidateRow:
    title = capital(titled(other.effect, other.place))
    return CandidateRow(title, other.effect, *_share(other.score), objection_words(other.objection))


def _rejected(found: Sequence[Alternative]) -> tuple[CandidateRow, ...]:
    """Each effect at its place once, with the most that it ever explained: rounds of the search repeat them."""
    best = {(each.effect, each.place): each for each in sorted(found, key=_by_score, reverse=True)}
    return tuple(_candidate(each) for each in sorted(best.values(), key=_by_score))


def _share(score: float) -> tuple[str, float]:
    if not math.isfinite(score):
        return "–", 0.0
    return f"{100 * max(score, 0.0):.0f} %", 100 * min(max(score, 0.0), 1.0)


def _by_score(other: Alternative) -> float:
    return -other.score if math.isfinite(other.score) else math.inf


def _excesses(found: Sequence[Excess]) -> tuple[ExcessRow, ...]:
    """The furthest above its floor first."""
    ordered = sorted(found, key=lambda each: -each.z if math.isfinite(each.z) else math.inf)
    return tuple(
        ExcessRow(
            channel(each.channel),
            significant(each.rmse),
            significant(each.noise_floor),
            significant(each.rmse / each.noise_floor, 2) if each.noise_floor > 0.0 else "–",
            significant(each.z, 2),
            each.unit,
            where_words(each),
        )
        for each in ordered
    )


def _change(found: Consequence) -> ChangeRow:
    before, after, change = found.before, found.after, ""
    if math.isfinite(before.value) and math.isfinite(after.value) and before.value != 0.0:
        percent = round(100 * (abs(after.value) / abs(before.value) - 1.0))
        change = f"{'+' if percent > 0 else '−' if percent < 0 else ''}{abs(percent)} %"
    return ChangeRow(consequence_words(found), plus_minus(before), plus_minus(after), after.unit, change)


def _added(version: Lineage) -> str:
    return capital(added_words(version.added)) if version.added else "–"
