"""Find what the model of the wear lacks: other laws than a spring, values not as stated, a band that nobody declared.

Like the search on joints, on another torque: the supporting torque, of which the model is the wear. Every candidate is
fitted with all bands' stiffness and natural length beside it, and must explain what was left out of the fit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.supporting import Wearing
from exogauge.detect.device.baseline import Ground, lay_ground, weighed, whitened
from exogauge.detect.device.declared import within_declared
from exogauge.detect.device.extra_band import further_wires, led_on
from exogauge.detect.device.finding import CHANNEL, name_contradicted, name_effect, rejection
from exogauge.detect.device.judge import BandJudgement, Folds, folds_of, judge, left_out_residual, rmse, with_best_shape
from exogauge.detect.device.nominal import Contradicted, contradicted
from exogauge.detect.device.score import BandScore, Scorer, candidates
from exogauge.detect.device.uncovered_joints import Beyond
from exogauge.detect.so_far import descendant
from exogauge.devices.device import Device
from exogauge.devices.result import Estimate, StiffnessResult
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
from exogauge.findings.verdict import Caveat, Objection, Seen, Why
from exogauge.identification.model import RobotModel
from exogauge.progress import Doing, Progress, unwatched
from exogauge.search.judge import not_named, refused, told
from exogauge.search.sums import summed, sureness
from exogauge.side_by_side import each as side_by_side
from exogauge.support.band_fit import NamedBands
from exogauge.support.band_model import Wear, fit
from exogauge.support.band_rows import BLOCK_S
from exogauge.support.evaluate import Gathered

Array = NDArray[np.float64]


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
    criteria = model.criteria.device
    folds = folds_of(ground.setting.logs, criteria)
    if not folds.left_out:
        return _unjudged(Caveat("nothing_left_out", device.name))
    first, findings, rejected, tried, unclear = ground, list[Finding](), list[Alternative](), 0, False
    wears, explained = [ground.fitted.wear], np.zeros(len(ground.joints))
    while True:
        ground, judged, count = _judged(ground, effects, folds)
        beside = [each.objection or _remainder(each, explained, criteria) for each in judged]
        judged = [replace(each, objection=why) for each, why in zip(judged, beside, strict=True)]
        tried = max(tried, count)
        rejected = [rejection(ground, each, each.objection) for each in judged if each.objection]
        winner = next((each for each in judged if not each.objection), None)
        if winner is None or len(findings) >= criteria.most_effects:
            break
        sharpened, winner, judged = _sharpened(ground, winner, judged, folds)
        finding = name_effect(named + len(findings) + 1, sharpened, winner, judged, folds, of)
        if objection := refused(finding, model.criteria.judging):
            rejected.append(not_named(finding, objection))
            break
        ground = sharpened
        findings.append(finding)
        explained = np.maximum(explained, winner.gone)
        ground = weighed(ground, winner.fitted)
        wears.append(ground.fitted.wear)
        wire, left = winner.added.effect.sort == "wire", rmse(winner.after, winner.joint)
        unclear = wire and left > criteria.clear * ground.floor[winner.joint]
        if unclear:
            break
    ground, wears, findings, refuted = _of_their_laws(first, ground, wears, findings, folds)
    rejected += refuted
    scorer, ended = Scorer(ground.setting, ground.fitted), ground
    values = [] if unclear else contradicted(ground, ground.fitted.wear, folds)
    for each in values:
        if effects.get(each.effect) is not None:
            finding = name_contradicted(named + len(findings) + 1, ground, each, scorer, folds, of)
            why = _no_spring(ground, each, values[-1].after) or _beside_a_wire(each)
            if why:
                rejected.append(not_named(finding, why))
                continue
            named_now, doubtful = told([finding], model.criteria.judging)
            findings += named_now
            rejected += doubtful
            if named_now:
                ended = replace(ground, setting=each.setting, fitted=each.fitted)
    left_out = left_out_residual(ground.setting, ground.fitted.wear, folds)
    above = _unexplained(ground, left_out)
    declared = within_declared(ground, left_out, above, CHANNEL)
    return WearFindings(
        findings=tuple(findings),
        chain=_chain(ground, findings, wears, folds, of),
        rejected=tuple(rejected),
        unexplained=tuple(each for each in above if each not in declared.channels),
        declared=declared,
        seen=_seen(ground, left_out),
        before_after=_before_after(first, ground, of) if len(wears) > 1 else (),
        bands=(NamedBands(device, ended.approach, ended.fit),) if len(wears) > 1 or ended is not ground else (),
        tried=tried,
        notes=(Caveat("unclear_course", device.name),) if unclear else (),
    )


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


def _judged(ground: Ground, effects: Mapping[str, BandEffect], folds: Folds) -> tuple[Ground, list[BandJudgement], int]:
    """The ground with further wires that are worth it, the candidates judged, with most evidence first, and how many
    shapes were tried."""
    scorer, tried, worth = Scorer(*whitened(ground)), 0, list[BandScore]()
    criteria = ground.model.criteria.device

    def best_of(candidate: tuple[BandEffect, int]) -> tuple[BandScore | None, int]:
        best, count = scorer.best(*candidate)
        return None if best is None or best.evidence <= criteria.worth_judging else scorer.refined(best), count

    for best, count in side_by_side(best_of, candidates(scorer, effects)):
        tried += count
        worth += [] if best is None else [best]
    for effect in (each for each in effects.values() if each.sort == "wire"):
        ground, scorer, scores, count = further_wires(ground, scorer, effect)
        worth, tried = worth + [scorer.refined(each) for each in scores], tried + count
    worth = sorted(worth, key=lambda each: -each.evidence)[: criteria.judged]
    judged = list(side_by_side(lambda each: judge(ground, each, folds), worth))
    likely = [each for each in judged if each.evidence > criteria.worth_judging]
    return ground, sorted(likely, key=lambda one: -one.evidence), tried


def _sharpened(
    ground: Ground, winner: BandJudgement, judged: Sequence[BandJudgement], folds: Folds
) -> tuple[Ground, BandJudgement, list[BandJudgement]]:
    """The winner with its best shape, or on its best course, in its place among the others; and the ground with it."""
    if winner.added.effect.sort == "wire":
        ground, again = _on_best_course(ground, winner, folds)
    else:
        again = with_best_shape(ground, winner, folds)
    return ground, again, [again if each is winner else each for each in judged]


def _on_best_course(ground: Ground, winner: BandJudgement, folds: Folds) -> tuple[Ground, BandJudgement]:
    """What leaves least of what was left out of the fit: the winner, a wire whose ends were led to where it explains
    most, or that one led on with joints weighed by what it leaves on them.

    By what a wire takes off, those that it pulls at hardly count once it is nearly right; by what it leaves, a wire
    that is far from right looks for others.
    """
    wider, scorer, scores, _ = further_wires(ground, Scorer(*whitened(ground)), winner.added.effect, led_better=True)
    best = _leaves_least([(ground, winner), *((wider, judge(wider, scorer.refined(each), folds)) for each in scores)])
    for _ in range(4):  # joints are weighed anew each time
        further = [(wider, judge(wider, scorer.refined(score), folds)) for wider, scorer, score in led_on(*best)]
        before, best = best, _leaves_least([best, *further])
        if best is before:
            break
    return best


def _leaves_least(found: Sequence[tuple[Ground, BandJudgement]]) -> tuple[Ground, BandJudgement]:
    """Of the first and all that may be claimed."""

    def left(each: tuple[Ground, BandJudgement]) -> float:
        ground, judged = each
        return float(np.sum([(rmse(judged.after, d) / max(floor, 1e-12)) ** 2 for d, floor in enumerate(ground.floor)
                             if np.isfinite(judged.after[:, d]).any()]))  # fmt: skip

    return min([found[0], *(each for each in found[1:] if not each[1].objection)], key=left)


def _remainder(judged: BandJudgement, explained: Array, criteria: Wearing) -> Objection | None:
    """Whether it may be what an effect that was named leaves because real bands follow no formula. explained: (D,)
    [N·m] RMS that the largest of those explained."""
    wire = judged.added.effect.sort == "wire"
    share = criteria.remainder_of_wire if wire else criteria.remainder
    if judged.gone[judged.joint] < share * explained[judged.joint]:
        return Objection(Why.SMALL_BESIDE)
    return None


def _chain(
    ground: Ground, findings: Sequence[Finding], wears: Sequence[Wear], folds: Folds, of: str
) -> tuple[Link, ...]:
    """RMSE of the supporting torque of the joints in question, version by version; nothing where nothing was named."""
    if len(wears) < 2:
        return ()
    joints = sorted({ground.joints.index(each.held_out.channel.removeprefix(CHANNEL)) for each in findings})
    floor = float(np.sqrt(np.mean(ground.floor[joints] ** 2)))
    links = []
    for k, wear in enumerate(wears):
        e = left_out_residual(ground.setting, fit(ground.setting, wear).wear, folds)
        each = np.array([rmse(e, joint) for joint in joints])
        worst = joints[int(np.argmax(each / np.maximum(ground.floor[joints], 1e-12)))]
        step = ChainStep("effect", findings[k - 1].effect, findings[k - 1].place) if k else ChainStep("bands")
        channel = f"{CHANNEL}{ground.joints[worst]}"
        links.append(
            Link(step, float(np.sqrt(np.mean(each**2))), floor, channel, rmse(e, worst), float(ground.floor[worst]))
        )
    return tuple(links)


def _of_their_laws(
    first: Ground, ground: Ground, wears: Sequence[Wear], findings: Sequence[Finding], folds: Folds
) -> tuple[Ground, list[Wear], list[Finding], list[Alternative]]:
    """Without the laws that leave, of what there was beside springs, as much as the noise and more than a law does that
    is not quite right: what is there follows another. A further band, whose course is hardly ever right, stays."""
    if not findings:
        return ground, list(wears), [], []
    was, now = (left_out_residual(each.setting, each.fitted.wear, folds) for each in (first, ground))
    kept, refuted = list[int](), list[Alternative]()
    for number, (finding, added) in enumerate(zip(findings, wears[-1].added, strict=True)):
        joint = ground.joints.index(finding.held_out.channel.removeprefix(CHANNEL))
        held = replace(finding.held_out, rmse_before=rmse(was, joint), rmse_after=rmse(now, joint))
        if added.effect.sort != "wire" and held.of_another_law(ground.model.criteria.judging):
            why = Objection(Why.OTHER_LAW, held.explained, held.floors, of=(held.channel,))
            refuted.append(not_named(finding, why))
        else:
            kept.append(number)
    if not refuted:
        return ground, list(wears), list(findings), []
    wears = [replace(wears[-1], added=tuple(wears[-1].added[k] for k in kept[:n])) for n in range(len(kept) + 1)]
    ranks = (findings[0].rank + n for n in range(len(kept)))
    ground = weighed(ground, fit(ground.setting, wears[-1]))
    return ground, wears, [replace(findings[k], rank=rank) for k, rank in zip(kept, ranks, strict=True)], refuted


def _no_spring(ground: Ground, found: Contradicted, left: Array) -> Objection | None:
    """A number of a spring is wrong only where the bands of its group are springs: where they leave surely more than
    the noise at a joint that they act on, whatever their numbers, they follow another law. left: (N, D) [N·m] with all
    such numbers let go."""
    bands = ground.device.bands
    group = [b for b, each in enumerate(bands) if each.group == bands[found.band].group]
    acts = np.abs(found.fitted.A[:, :, group]).max(axis=(0, 2)) > 0.0
    own = {f"{CHANNEL}{name}" for name, there in zip(ground.joints, acts, strict=True) if there}
    excess = [each for each in _unexplained(ground, left) if each.channel in own]
    if not excess:
        return None
    worst = max(excess, key=lambda each: each.rmse / each.noise_floor)
    was, now = (rmse(each, found.joint) ** 2 for each in (found.before, found.after))
    return Objection(Why.OTHER_LAW, 1.0 - now / was, worst.rmse / worst.noise_floor, of=(worst.channel,))


def _beside_a_wire(found: Contradicted) -> Objection | None:
    """A further band and springs that act on the same joint share what they do: its course is hardly ever quite right,
    and their numbers make up for it."""
    wear, places = found.fitted.wear, [found.band]
    start = len(wear.springs)
    for each in wear.added:
        if each.effect.sort == "wire":
            places.append(start)
        start += len(each.coefficients)
    acts = np.abs(found.fitted.A[:, :, places]).max(axis=0) > 0.0  # (D, 1 + wires)
    shared = (acts[:, :1] & acts[:, 1:]).any()
    return Objection(Why.ALIKE) if shared else None


def _unexplained(ground: Ground, e: Array) -> tuple[Excess, ...]:
    """Joints on which the wear's model errs by more than repeated runs do. e: (N, D) [N·m] of what was left out."""
    judging, found = ground.model.criteria.judging, list[Excess]()
    for joint, name in enumerate(ground.joints):
        error, floor = rmse(e, joint), float(ground.floor[joint])
        used = np.isfinite(e[:, joint])
        if floor > 0.0 and used.any() and error > judging.above * floor:
            count = summed(used[used].astype(float), ground.setting.logs.block[used])
            z = sureness(
                summed(e[used, joint] ** 2, ground.setting.logs.block[used]) / count - (judging.above * floor) ** 2
            )
            if z > judging.sure_above:
                found.append(Excess(f"{CHANNEL}{name}", ground.unit(joint), error, floor, z))
    return tuple(found)


def _seen(ground: Ground, e: Array) -> tuple[Seen, ...]:
    """Joints that the wear acts on, as `_unexplained` looks at them, by blocks that were left out of the fit. A joint
    that the robot's own search asked for motion is not asked for it again. e: as there."""
    found = list[Seen]()
    for joint, name in enumerate(ground.joints):
        used = np.isfinite(e[:, joint])
        if ground.floor[joint] > 0.0 and used.any():
            seconds = BLOCK_S * len(np.unique(ground.setting.logs.block[used]))
            found.append(Seen(f"{CHANNEL}{name}", rmse(e, joint) / float(ground.floor[joint]), seconds, 0.0))
    return tuple(found)


def _before_after(first: Ground, last: Ground, of: str) -> tuple[Consequence, ...]:
    """Stiffness and natural length of every band, as springs alone and with what was named."""
    told: list[Consequence] = []
    W, was, now = len(first.device.bands), first.deviations(first.fitted), last.deviations(last.fitted)

    def estimates(place: int, unit: str) -> tuple[Estimate, Estimate]:
        pair = [(first.fitted.wear.theta, was), (last.fitted.wear.theta, now)]
        one, other = (Estimate(float(theta[place]), float(std[place]), unit) for theta, std in pair)
        return one, other

    for b, band in enumerate(first.device.bands):
        name = (band.name, of) if of else (band.name,)
        told.append(Consequence("stiffness", name, *estimates(b, "N/m")))
        told.append(Consequence("natural_length", name, *estimates(W + b, "m")))
    return tuple(told)
