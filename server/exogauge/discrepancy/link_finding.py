"""A link that weighs other than its maker says, as a finding."""

from __future__ import annotations

import numpy as np

from exogauge.devices.result import Estimate
from exogauge.discrepancy.links import LinkScore, OddLink, carries_nothing
from exogauge.discrepancy.result import Alternative, Evidence, Finding, HeldOut, Place
from exogauge.identification.model import RobotModel
from exogauge.identification.result import Identification

NOTHING_TO_DRAW = np.zeros(0)
MOTION = "Turn each of these links about axes of its own, fast and with gravity across it, while the others rest."


def name_link(rank: int, model: RobotModel, odd: OddLink, found: Identification) -> Finding:
    """More than stated is a payload, less a wrong mass. The model holds the change already; what is new is its name."""
    best, bodies = odd.best, model.robot.tree.bodies
    mass, std = float(best.change[0]), float(best.std[0])
    effect = "payload" if mass > 0.0 else "link_mass"
    link, held_out = bodies[best.body], _held_out(found)
    stated = float(model.solution.prior.std[10 * best.body])
    twins = () if carries_nothing(model, best.body) or effect == "link_mass" else (best,)
    alike = tuple(_alternative(bodies, each, effect, best) for each in odd.alike)
    alike += tuple(
        Alternative("link_mass", Place("link", link), 1.0, "a heavier link and a load fixed to it are the same")
        for _ in twins
    )
    sentence = (
        f"{link}: weighs {mass:+.2f} ± {std:.2f} kg beside what its maker says and doubts by ± {stated:.2g} kg. With "
        f"the maker's inertias the held-out error of {held_out.channel} is {held_out.rmse_before:.2g} "
        f"{held_out.unit} RMSE, with the identified ones {held_out.rmse_after:.2g} (noise floor "
        f"{held_out.noise_floor:.2g})."
    )
    return Finding(
        rank=rank,
        effect=effect,
        place=Place("link", link),
        parameters=_parameters(best),
        held_out=held_out,
        score=held_out.explained,
        sentence=sentence,
        alternatives=tuple(_alternative(bodies, each, effect, best) for each in odd.others),
        also_possible=alike,
        motion=MOTION if odd.alike else "",
        evidence=Evidence("", "", *([NOTHING_TO_DRAW] * 5)),
    )


def _parameters(best: LinkScore) -> dict[str, Estimate]:
    """Mass, and where its centre is in the link's frame."""
    mass, std = float(best.change[0]), float(best.std[0])
    centre, doubt = best.change[1:] / mass, best.std[1:] / abs(mass)
    spread = np.hypot(doubt, centre * std / mass)
    found = {"mass": Estimate(mass, std, "kg")}
    found |= {name: Estimate(float(c), float(s), "m") for name, c, s in zip("xyz", centre, spread, strict=True)}
    return found


def _alternative(bodies: tuple[str, ...], each: LinkScore, effect: str, best: LinkScore) -> Alternative:
    share = float(np.clip(each.evidence / best.evidence, 0.0, 1.0))
    return Alternative(effect, Place("link", bodies[each.body]), share, "the data are less likely with it")


def _held_out(found: Identification) -> HeldOut:
    """The channel on which the maker's inertias err most, relative to its noise."""
    fits = [fit for fit in found.validation if fit.held_out] or list(found.validation)
    base = [fit for fit in fits if fit.channel.startswith("base.m")]
    by_channel: dict[str, list[tuple[float, float, float]]] = {}
    for fit in base or fits:
        by_channel.setdefault(fit.channel, []).append((fit.rmse_prior, fit.rmse_identified, fit.noise_floor))
    pooled = {name: np.sqrt(np.mean(np.square(values), axis=0)) for name, values in by_channel.items()}
    channel = max(pooled, key=lambda name: pooled[name][0] / max(pooled[name][2], 1e-12))
    before, after, floor = (float(value) for value in pooled[channel])
    return HeldOut(channel, "N·m", before, after, floor)
