"""An effect of a band that may be claimed, as a finding: its numbers, its evidence, what it beat.

The plot that shows an effect of a band: torque that the wear's model lacks, over what the effect depends on.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.detect.device.baseline import Ground, weighed
from exogauge.detect.device.judge import BandJudgement, Folds, apart, rmse
from exogauge.detect.device.nominal import Contradicted
from exogauge.detect.device.score import Scorer
from exogauge.devices.result import Estimate, StiffnessResult
from exogauge.effects.band import BandEffect
from exogauge.effects.catalogue import band_effects
from exogauge.findings.basis import Moment, OfBand
from exogauge.findings.binned import binned
from exogauge.findings.result import Alternative, Discrepancy, Evidence, Finding, HeldOut, Place
from exogauge.findings.verdict import Objection, Why
from exogauge.support.band_rows import Wire
from exogauge.support.named_laws import numbers, sharpness

Array = NDArray[np.float64]

CHANNEL = "support."  # of a joint's supporting torque


def place_of(wire: Wire) -> Place:
    return Place(wire.course.kind, wire.course.name)


def rejection(ground: Ground, judged: BandJudgement, objection: Objection) -> Alternative:
    wire = ground.setting.wires[judged.added.wire]
    return Alternative(judged.added.effect.name, place_of(wire), max(judged.explained, 0.0), objection)


def name_effect(
    rank: int,
    ground: Ground,
    winner: BandJudgement,
    whole: BandJudgement,
    rivals: Sequence[BandJudgement],
    folds: Folds,
    of: str,
) -> Finding:
    """One band's. whole: what all bands together have that are named with it, which rivals are held against. of: which
    wear, where there are several; or ""."""
    effect, wire = winner.added.effect, ground.setting.wires[winner.added.wire]
    held_out = held(ground, winner.joint, winner.before, winner.after)
    criteria = ground.model.criteria.device
    alike = [each for each in rivals if each.z > criteria.nearly_sure and abs(apart(whole, each)) < criteria.tell_apart]
    others = [rejection(ground, each, Objection(Why.ALIKE) if each in alike else each.objection or Objection(Why.LESS))
              for each in rivals]  # fmt: skip
    return Finding(
        rank=rank,
        effect=effect.name,
        place=place_of(wire),
        parameters=parameters(ground, winner),
        held_out=held_out,
        score=held_out.explained,
        basis=OfBand(
            effect, of, "nothing" if winner.once else folds.what, _moment(ground, winner) if winner.once else None
        ),
        alternatives=tuple(others),
        also_possible=tuple(each for each, rival in zip(others, rivals, strict=True) if rival in alike),
        evidence=band_evidence(ground, wire, effect.coordinate, winner.joint, winner.before, winner.after),
    )


def name_contradicted(rank: int, ground: Ground, found: Contradicted, scorer: Scorer, folds: Folds, of: str) -> Finding:
    effect, wire = band_effects()[found.effect], ground.setting.wires[found.band]
    held_out = held(ground, found.joint, found.before, found.after)
    unit = "N/m" if found.of == "stiffness" else "m"
    alike = tuple(_instead(ground, scorer, found))
    return Finding(
        rank=rank,
        effect=found.effect,
        place=place_of(wire),
        parameters={
            found.of: Estimate(found.value, found.std, unit),
            f"stated_{found.of}": Estimate(found.stated, 0.0, unit),
        },
        held_out=held_out,
        score=held_out.explained,
        basis=OfBand(effect, of, folds.what),
        alternatives=alike,
        also_possible=alike,
        evidence=band_evidence(ground, wire, effect.coordinate, found.joint, found.before, found.after),
    )


def held(ground: Ground, joint: int, before: Array, after: Array) -> HeldOut:
    channel = f"{CHANNEL}{ground.joints[joint]}"
    return HeldOut(channel, ground.unit(joint), rmse(before, joint), rmse(after, joint), float(ground.floor[joint]))


def parameters(ground: Ground, winner: BandJudgement) -> Mapping[str, Estimate]:
    """Coefficients and shapes in SI units, as doubtful as the search leaves them."""
    effect, wear = winner.added.effect, winner.fitted.wear
    setting = weighed(ground, winner.fitted).setting if effect.shapes else ground.setting
    sharp = sharpness(setting, wear, len(wear.added) - 1)
    stds = np.sqrt(winner.std**2 + sum((each.moves**2 for each in sharp), np.zeros_like(winner.std)))
    return numbers(winner.added, ground.setting.wires[winner.added.wire], stds, sharp)


def with_numbers_beside(found: Discrepancy, stiffness: Sequence[StiffnessResult]) -> Discrepancy:
    """Findings of bands with the numbers that go with the springs in `stiffness`: by A where there is one, as these
    are told and taken over."""
    chosen = {each.device: each for each in stiffness if each.approach in ("A", "B")}
    chosen |= {each.device: each for each in stiffness if each.approach == "A"}
    findings = [_beside(each, list(chosen.values())) for each in found.findings]
    return replace(found, findings=tuple(findings))


def _beside(finding: Finding, stiffness: Sequence[StiffnessResult]) -> Finding:
    basis = finding.basis
    if not isinstance(basis, OfBand):
        return finding
    numbers = dict(finding.parameters)
    for result in (each for each in stiffness if basis.device in ("", each.device)):
        for named in result.named:
            if (named.effect, named.place) == (finding.effect, finding.place.name):
                numbers |= named.numbers
        for band in (each for each in result.bands if each.with_effects and each.band == finding.place.name):
            springs = {"stiffness": band.stiffness, "natural_length": band.natural_length}
            contradicted = {f"stated_{name}" for name in springs} & numbers.keys()
            numbers |= {name: springs[name] for name in springs if f"stated_{name}" in contradicted}
    return replace(finding, parameters=numbers)


def _moment(ground: Ground, winner: BandJudgement) -> Moment:
    """Where on the logs laid end to end an effect of one moment happens."""
    logs = ground.setting.logs
    moment = winner.added.shape[0] * logs.span
    log = int(np.searchsorted(logs.starts, moment, side="right")) - 1
    stays = winner.added.shape[1] >= 0.5 and log < len(logs.logs) - 1
    return Moment(logs.logs[log].name, float(moment - logs.starts[log]), stays)


def _instead(ground: Ground, scorer: Scorer, found: Contradicted) -> list[Alternative]:
    """Other laws that would bring the value back to what is stated, at nearly the same cost."""
    result = []
    for effect in band_effects().values():
        if effect.name in _of(effect, found.effect):
            scored = scorer.best(effect, found.band)[0]
            if scored is not None and scored.gain > 0.5 * found.gain:
                place = place_of(ground.setting.wires[found.band])
                share = min(scored.gain / max(found.gain, 1e-300), 1.0)
                result.append(Alternative(effect.name, place, share, Objection(Why.ALIKE)))
    return result


def _of(effect: BandEffect, confounded: str) -> tuple[str, ...]:
    return (effect.name,) if effect.sort == "law" and confounded in effect.confounds else ()


UNITS = {"stretch": "m", "rate": "m/s", "clock": "s"}
NAMES = {"stretch": "band length", "rate": "rate of the band", "clock": "time"}


def band_evidence(ground: Ground, wire: Wire, coordinate: str, joint: int, before: Array, after: Array) -> Evidence:
    """before, after: (N, D) [N·m] residuals, NaN where they do not count; their difference is what the effect adds."""
    used = np.isfinite(before[:, joint]) & np.isfinite(after[:, joint])
    values = {"stretch": wire.length, "rate": wire.rate, "clock": ground.setting.logs.clock}[coordinate]
    at, was, now = values[used], before[used, joint], after[used, joint]
    unit = UNITS[coordinate] if wire.course.routing is not None else UNITS[coordinate].replace("m", "rad")
    means = binned(at, was, now, was - now, coordinate == "rate")  # what depends on the rate turns round at zero
    return Evidence(NAMES[coordinate], unit, *means)
