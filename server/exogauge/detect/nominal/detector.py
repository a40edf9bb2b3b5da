"""A number of the maker that data contradict, as a finding. The model holds the change already; new is its name.

Numbers of the maker that a free parameter absorbs: looked for once all that leaves a residual is in the model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from exogauge.detect.nominal.contradicted import Change, Contradiction, contradicted, put_back, row_memory
from exogauge.detect.nominal.let_go import let_go
from exogauge.detect.nominal.nominal_values import Array, gain_columns, undecided_between
from exogauge.detect.so_far import SoFar
from exogauge.devices.result import Estimate
from exogauge.findings.as_told import ALL
from exogauge.findings.basis import BesideStated
from exogauge.findings.result import Alternative, Evidence, Finding, Place
from exogauge.findings.verdict import Caveat, Objection, Why
from exogauge.identification.model import RobotModel
from exogauge.identification.parameters import coefficient_unit
from exogauge.identification.result import Identification
from exogauge.identification.settings import Recording, Settings
from exogauge.robots.ends import takes_payload
from exogauge.search.ambiguity import Number, Undecided
from exogauge.search.judge import told

NOTHING_TO_DRAW = np.zeros(0)


def name_contradiction(
    rank: int, found: Identification, recordings: Sequence[Recording], settings: Settings, odd: Contradiction
) -> Finding:
    """found: with all effects that were named before it."""
    model, best = found.model, odd.best
    effect, place = _effect_and_place(model, best)
    held_out = put_back(found, recordings, best, settings)
    same = [Alternative("link_mass", place, 1.0, Objection(Why.ONE_BODY))] if effect == "payload" else []
    same += [Alternative("kt_gain", Place("joint", ALL), 1.0, Objection(Why.ONE_FACTOR))] if odd.or_all_gains else []
    alike = [*same, *(_alternative(model, each, best) for each in odd.alike)][: model.criteria.nominal.most_alike]
    return Finding(
        rank=rank,
        effect=effect,
        place=place,
        parameters=_load(best) if best.of_link else _gain(model, best),
        held_out=held_out,
        score=held_out.explained,
        basis=BesideStated(_doubt(model, best)),
        alternatives=tuple(_alternative(model, each, best) for each in odd.others),
        also_possible=tuple(alike),
        evidence=Evidence("", "", *([NOTHING_TO_DRAW] * 5)),
    )


def doubt_of(model: RobotModel, odd: Contradiction, memory: Array) -> Undecided | None:
    """What tells the number from those that explain as much; None where there are none. memory: as of `row_memory`."""
    if not odd.alike:
        return None
    alike = odd.alike[: model.criteria.nominal.most_alike]
    return undecided_between(model, [_number(model, each) for each in (odd.best, *alike)], memory)


def _number(model: RobotModel, change: Change) -> Number:
    effect, place = _effect_and_place(model, change)
    at, index, value = (place.kind, place.name, ""), change.stated.index, change.value
    if change.of_link:
        seen, phi = model.solution.prior.seen[:, 10 * index : 10 * index + 10], model.robot.tree.phi[index]
        if change.stated.sort == "scaled":
            return Number(effect, at, value[:1] / phi[0], (seen @ phi)[:, None])
        return Number(effect, at, value, seen)
    if model.robot.joints[index].actuation == "torque":
        return Number(effect, at, value, None, index)
    unit, column = np.zeros((model.equations.size, 1)), gain_columns(model.equations)[index]
    unit[column] = model.solution.prior.seen_mean[column]
    return Number(effect, at, value, unit)


def _doubt(model: RobotModel, best: Change) -> float:
    """What the maker doubts: of a mass [kg], of a gain as a share."""
    if best.of_link:
        return float(model.solution.prior.std[10 * best.stated.index])
    stated = _stated_gain(model, best)
    return stated.std if stated.unit == "1" else stated.std / abs(stated.value)


def _load(best: Change) -> dict[str, Estimate]:
    """Mass, and where its centre is in the link's frame."""
    mass, std = float(best.value[0]), float(best.std[0])
    centre, own = best.value[1:4] / mass, best.stated.sort == "scaled"  # the link's centre, whatever the mass
    doubt = np.zeros(3) if own else np.hypot(best.std[1:4] / mass, centre * std / mass)
    found = {"mass": Estimate(mass, std, "kg")}
    return found | {name: Estimate(float(c), float(s), "m") for name, c, s in zip("xyz", centre, doubt, strict=True)}


def _gain(model: RobotModel, best: Change) -> dict[str, Estimate]:
    stated = _stated_gain(model, best)
    share, std = float(best.value[0]), float(best.std[0])
    return {
        "gain": Estimate(stated.value * (1.0 + share), abs(stated.value) * std, stated.unit),
        "stated": stated,
        "ratio": Estimate(1.0 + share, std, "1"),
    }


def _stated_gain(model: RobotModel, best: Change) -> Estimate:
    equations, axis, prior = model.equations, best.stated.index, model.solution.prior
    column, joint = gain_columns(equations)[axis], model.robot.joints[axis]
    unit = coefficient_unit("N·m/A", joint.name, model.robot)
    value = float(prior.seen_mean[column])
    logged = joint.actuation == "torque"
    doubt = model.criteria.nominal.torque_doubt
    std = doubt if logged else float(np.sqrt(prior.seen_covariance[column, column]))
    return Estimate(value, std, unit)


def _alternative(model: RobotModel, each: Change, best: Change) -> Alternative:
    share = float(np.clip(each.evidence / best.evidence, 0.0, 1.0))
    return Alternative(*_effect_and_place(model, each), share, Objection(Why.LESS_LIKELY))


def _effect_and_place(model: RobotModel, change: Change) -> tuple[str, Place]:
    """More than stated at a hand is a payload. Any other link, and a lighter hand, has a wrong mass."""
    robot, index = model.robot, change.stated.index
    if not change.of_link:
        return "kt_gain", Place("joint", robot.joints[index].name)
    heavier = change.value[0] > 0.0
    effect = "payload" if heavier and takes_payload(robot, index) else "link_mass"
    return effect, Place("link", robot.tree.bodies[index])


def nominal_values(so_far: SoFar) -> SoFar:
    """With what the data contradict beside the models, which hold the change already."""
    recordings = so_far.searched.recordings if so_far.searched else so_far.recordings
    current, first = so_far.current, len(so_far.findings) + 1
    fitted = [each.log for each in recordings if not each.held_out]
    odd = contradicted(current.model, fitted)
    settings = so_far.question.settings
    findings = [
        name_contradiction(n, current, recordings, settings, each) for n, each in enumerate(odd.one_by_one, first)
    ]
    named, doubtful = told(findings, so_far.criteria.judging)
    if so_far.searched is not None and any(each.alike for each in odd.one_by_one):
        memory = row_memory(current.model, fitted)
        doubts = {(finding.effect, finding.place): doubt for finding, each in zip(findings, odd.one_by_one, strict=True)
                  if (doubt := doubt_of(current.model, each, memory)) is not None}  # fmt: skip
        undecided = {**so_far.searched.undecided, **doubts}
        so_far = replace(so_far, searched=replace(so_far.searched, undecided=undecided))
    believed = let_go(current, recordings, settings)
    so_far = replace(so_far, models=(*so_far.models[:-1], believed), beside=named, doubtful=doubtful)
    if odd.feet is None:
        return so_far
    sensors = ", ".join(each.name for each in current.model.robot.contacts)
    share = Caveat("feet_alike", sensors, float(odd.feet.value[0]), needed=float(odd.feet.std[0]))
    return replace(so_far, question=replace(so_far.question, cannot=(*so_far.question.cannot, share)))
