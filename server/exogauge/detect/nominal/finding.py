"""A number of the maker that data contradict, as a finding. The model holds the change already; new is its name."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exogauge.detect.nominal.ablation import put_back
from exogauge.detect.nominal.contradicted import Change, Contradiction
from exogauge.detect.nominal.nominal_values import TORQUE_DOUBT, gain_columns
from exogauge.detect.nominal.number_name import effect_and_place
from exogauge.devices.result import Estimate
from exogauge.findings.common_cause import ALL
from exogauge.findings.result import Alternative, Evidence, Finding, HeldOut, Place
from exogauge.identification.model import RobotModel
from exogauge.identification.parameters import coefficient_unit
from exogauge.identification.result import Identification
from exogauge.identification.settings import Recording, Settings

NOTHING_TO_DRAW = np.zeros(0)
MOST_ALIKE = 2  # others that are worth a name
TURN = "Turn each of these links about axes of its own, fast and with gravity across it, while the others rest."
HOLD = "Hold a load of known weight with this joint, level and hanging, and repeat the same motion without it."
ONE_FACTOR = "one factor on every motor's gain makes the data as likely"
ONE_BODY = "a heavier link and a load fixed to it are the same"


def name_contradiction(
    rank: int, found: Identification, recordings: Sequence[Recording], settings: Settings, odd: Contradiction
) -> Finding:
    """found: with all effects that were named before it."""
    model, best = found.model, odd.best
    effect, place = effect_and_place(model, best)
    held_out = put_back(found, recordings, best, settings)
    same = [Alternative("link_mass", place, 1.0, ONE_BODY)] if effect == "payload" else []
    same += [Alternative("kt_gain", Place("joint", ALL), 1.0, ONE_FACTOR)] if odd.or_all_gains else []
    alike = [*same, *(_alternative(model, each, best) for each in odd.alike)][:MOST_ALIKE]
    return Finding(
        rank=rank,
        effect=effect,
        place=place,
        parameters=_load(best) if best.of_link else _gain(model, best),
        held_out=held_out,
        score=held_out.explained,
        sentence=f"{_contradicted(model, best, place)} {_errors(held_out)}",
        alternatives=tuple(_alternative(model, each, best) for each in odd.others),
        also_possible=tuple(alike),
        motion=(TURN if best.of_link else HOLD) if odd.alike else "",
        evidence=Evidence("", "", *([NOTHING_TO_DRAW] * 5)),
    )


def _contradicted(model: RobotModel, best: Change, place: Place) -> str:
    if best.of_link:
        doubt = float(model.solution.prior.std[10 * best.stated.index])
        more = f"{best.value[0]:+.2f} ± {best.std[0]:.2f} kg"
        return f"{place.name}: weighs {more} beside what its maker says and doubts by ± {doubt:.2g} kg."
    stated, unit = _stated_gain(model, best)
    share, std = 100.0 * best.value[0], 100.0 * best.std[0]
    if unit == "1":
        what = f"its motor gives {share:+.1f} ± {std:.1f} % beside the torque that is logged, of which"
        return f"{place.name}: {what} {100.0 * TORQUE_DOUBT:.0f} % are doubted."
    doubt = 100.0 * stated.std / abs(stated.value)
    return (
        f"{place.name}: its motor gives {share:+.1f} ± {std:.1f} % of torque per ampere beside what its maker says "
        f"({stated.value:.4g} {unit}) and doubts by ± {doubt:.2g} %."
    )


def _errors(held_out: HeldOut) -> str:
    return (
        f"With the maker's value of this alone the held-out error of {held_out.channel} is "
        f"{held_out.rmse_before:.2g} {held_out.unit} RMSE, with the identified one {held_out.rmse_after:.2g} (noise "
        f"floor {held_out.noise_floor:.2g})."
    )


def _load(best: Change) -> dict[str, Estimate]:
    """Mass, and where its centre is in the link's frame."""
    mass, std = float(best.value[0]), float(best.std[0])
    centre, own = best.value[1:4] / mass, best.stated.sort == "scaled"  # the link's centre, whatever the mass
    doubt = np.zeros(3) if own else np.hypot(best.std[1:4] / mass, centre * std / mass)
    found = {"mass": Estimate(mass, std, "kg")}
    return found | {name: Estimate(float(c), float(s), "m") for name, c, s in zip("xyz", centre, doubt, strict=True)}


def _gain(model: RobotModel, best: Change) -> dict[str, Estimate]:
    stated, unit = _stated_gain(model, best)
    share, std = float(best.value[0]), float(best.std[0])
    return {
        "gain": Estimate(stated.value * (1.0 + share), abs(stated.value) * std, unit),
        "stated": stated,
        "ratio": Estimate(1.0 + share, std, "1"),
    }


def _stated_gain(model: RobotModel, best: Change) -> tuple[Estimate, str]:
    equations, axis, prior = model.equations, best.stated.index, model.solution.prior
    column, joint = gain_columns(equations)[axis], model.robot.joints[axis]
    unit = coefficient_unit("N·m/A", joint.name, model.robot)
    value = float(prior.seen_mean[column])
    std = TORQUE_DOUBT if joint.actuation == "torque" else float(np.sqrt(prior.seen_covariance[column, column]))
    return Estimate(value, std, unit), unit


def _alternative(model: RobotModel, each: Change, best: Change) -> Alternative:
    share = float(np.clip(each.evidence / best.evidence, 0.0, 1.0))
    return Alternative(*effect_and_place(model, each), share, "the data are less likely with it")
