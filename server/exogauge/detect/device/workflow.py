"""Find what the model of the wear lacks: other laws than a spring, values not as stated, a band that nobody declared.

Like the search on joints, on another torque: the supporting torque, of which the model is the wear. Every candidate is
fitted with all bands' stiffness and natural length beside it, and must explain what was left out of the fit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import final

from exogauge.detect.device.baseline import Ground, lay_ground
from exogauge.detect.device.declared import within_declared
from exogauge.detect.device.finding import CHANNEL, name_contradicted
from exogauge.detect.device.judge import Folds, folds_of, left_out_residual
from exogauge.detect.device.laws import Laws, find_laws
from exogauge.detect.device.left_over import before_after, chain, seen, unexplained
from exogauge.detect.device.nominal import contradicted
from exogauge.detect.device.refuted import of_their_laws, why_no_number
from exogauge.detect.device.score import Scorer
from exogauge.detect.device.uncovered_joints import Beyond
from exogauge.detect.so_far import descendant
from exogauge.devices.device import Device
from exogauge.devices.result import StiffnessResult
from exogauge.effects.band import BandEffect
from exogauge.effects.catalogue import band_effects
from exogauge.findings.result import (
    Alternative,
    ChainStep,
    Consequence,
    Discrepancy,
    Excess,
    Finding,
    Link,
    WithinDeclared,
)
from exogauge.findings.verdict import Caveat, Seen
from exogauge.identification.model import RobotModel
from exogauge.progress import Doing, Progress, unwatched
from exogauge.search.judge import not_named, refused
from exogauge.support.band_fit import NamedBands
from exogauge.support.evaluate import Gathered


@final
@dataclass(frozen=True)
class WearFindings:
    """What the search says of one wear."""

    findings: tuple[Finding, ...]
    chain: tuple[Link, ...]
    rejected: tuple[Alternative, ...]
    unexplained: tuple[Excess, ...]
    before_after: tuple[Consequence, ...]
    tried: int
    notes: tuple[Caveat, ...]
    seen: tuple[Seen, ...] = ()
    cannot: tuple[Caveat, ...] = ()
    bands: tuple[NamedBands, ...] = ()
    declared: WithinDeclared = field(default_factory=WithinDeclared)


def find_band_effects(
    model: RobotModel,
    gathered: Gathered,
    stiffness: Sequence[StiffnessResult],
    so_far: Discrepancy,
    beyond: Beyond | None = None,
    effects: Mapping[str, BandEffect] | None = None,
    progress: Progress = unwatched,
) -> Discrepancy:
    """so_far: what the joints' search says of the same model; it comes back with the findings of all wears appended.
    gathered, stiffness: supporting torque and bands of the same logs. beyond: the same on joints that no declared band
    crosses. effects: what may be missing, default all."""
    effects = band_effects() if effects is None else effects
    devices = {each.worn.device.name: each.worn.device for each in gathered.evidences}
    found = so_far
    for done, device in enumerate(devices.values()):
        progress(done / len(devices), Doing.LOOKING_FOR_BAND_EFFECTS, device.name)
        of = device.name if len(devices) > 1 else ""
        said = search_wear(model, gathered, device, stiffness, beyond, effects, len(found.findings), of)
        found = appended(found, said)
    progress(1.0, Doing.COMPARED)
    return found


def search_wear(
    model: RobotModel,
    gathered: Gathered,
    device: Device,
    stiffness: Sequence[StiffnessResult],
    beyond: Beyond | None,
    effects: Mapping[str, BandEffect],
    named: int,
    of: str,
) -> WearFindings:
    """One device. named: findings that there are already. of: its name where there are others, or ""."""
    ground = lay_ground(model, gathered, device, stiffness, beyond)
    if ground is None:
        return _unjudged(Caveat("no_steady_motion", device.name))
    folds = folds_of(ground.setting.logs, model.criteria.device)
    if not folds.left_out:
        return _unjudged(Caveat("nothing_left_out", device.name))
    laws = of_their_laws(find_laws(ground, effects, folds, named, of), folds)
    ground, wears = laws.ground, laws.wears
    numbers, doubtful, ended = _wrong_numbers(laws, effects, folds, named, of)
    left_out = left_out_residual(ground.setting, ground.fitted, folds)
    above = unexplained(ground, left_out)
    declared = within_declared(ground, left_out, above, CHANNEL)
    return WearFindings(
        findings=(*laws.findings, *numbers),
        chain=chain(ground, (*laws.findings, *numbers), wears, folds, of),
        rejected=(*laws.rejected, *doubtful),
        unexplained=tuple(each for each in above if each not in declared.channels),
        declared=declared,
        seen=seen(ground, left_out),
        before_after=before_after(laws.first, ground, of) if len(wears) > 1 else (),
        bands=(NamedBands(device, ended.fit),) if len(wears) > 1 or ended is not ground else (),
        tried=laws.tried,
        notes=(Caveat("unclear_course", device.name),) if laws.unclear else (),
    )


def _wrong_numbers(
    laws: Laws, effects: Mapping[str, BandEffect], folds: Folds, named: int, of: str
) -> tuple[list[Finding], list[Alternative], Ground]:
    """Numbers of springs that contradict what is stated, those that are not told although they do, and the ground with
    the told ones let go."""
    ground, judging = laws.ground, laws.ground.model.criteria.judging
    told, doubtful, ended = list[Finding](), list[Alternative](), ground
    if laws.unclear:
        return told, doubtful, ended
    scorer, values = Scorer(ground.setting, ground.fitted), contradicted(ground, ground.fitted.wear, folds)
    for each in values:
        if effects.get(each.effect) is None:
            continue
        rank = named + len(laws.findings) + len(told) + 1
        finding = name_contradicted(rank, ground, each, scorer, folds, of)
        if why := why_no_number(ground, each, values[-1].after) or refused(finding, judging):
            doubtful.append(not_named(finding, why))
        else:
            told.append(finding)
            ended = replace(ground, setting=each.setting, fitted=each.fitted)
    return told, doubtful, ended


def _unjudged(why: Caveat) -> WearFindings:
    return WearFindings((), (), (), (), (), 0, (why,), cannot=(why,))


def appended(found: Discrepancy, said: WearFindings) -> Discrepancy:
    """The whole run's answer with that of one wear behind it."""
    findings, unexplained = (*found.findings, *said.findings), (*found.unexplained, *said.unexplained)
    lines = list(found.lineage)
    for each in said.findings:
        lines.append(descendant(lines[-1], ChainStep("effect", each.effect, each.place)))
    return replace(
        found,
        findings=findings,
        wear_chain=(*found.wear_chain, *said.chain),
        unexplained=unexplained,
        rejected=(*found.rejected, *said.rejected),
        lineage=tuple(lines),
        candidates=found.candidates + said.tried,
        notes=(*found.notes, *said.notes),
        before_after=(*found.before_after, *said.before_after),
        seen=(*found.seen, *said.seen),
        cannot=(*found.cannot, *said.cannot),
        bands=(*found.bands, *said.bands),
        declared=WithinDeclared(
            (*found.declared.channels, *said.declared.channels),
            tuple(dict.fromkeys((*found.declared.sources, *said.declared.sources))),
        ),
    )
