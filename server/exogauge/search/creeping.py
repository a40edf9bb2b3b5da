"""Joints whose friction turns round over a span of speeds: below it they creep, and these rows are no steady motion.

Coulomb friction of the model has a sign. Where the friction of a joint is softer than a sign, rows at low speed say
nothing of its parameters, and what they lack looks like effects that are not there. So soft friction is tried beside
every effect of the catalogue, as one more way to explain the same rows. It is believed where it explains the fitted
logs surely better than each effect that acts on them, and the held-out logs err less with it. What follows is no name:
the rows at which it matters are left out, and all is sought once more.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from exogauge.effects.soft_coulomb import SOFT_COULOMB
from exogauge.findings.verdict import Caveat
from exogauge.identification.model import Site
from exogauge.identification.result import Identification
from exogauge.identification.sites import AxisSite, PairSite
from exogauge.robots.parameters import unit_at
from exogauge.search.judge import Judgement
from exogauge.search.locate import channels


@final
@dataclass(frozen=True)
class Creeping:
    """below: joint -> speed [rad/s or m/s] under which it creeps. open: what else it may be."""

    below: Mapping[str, float]
    open: tuple[Caveat, ...]


def creeping(
    found: Identification, judged: Sequence[Judgement], known: Mapping[str, float], named: Collection[Site]
) -> Creeping:
    """Among candidates that were judged, most evidence first; not at joints that are known to creep.

    named: where effects are. What is left there is what their formulas do not hold, at low speed too, so that soft
    friction has to lead surely: then rows that creep have bent the numbers of what was named.
    """
    open_lead = found.model.criteria.judging.open
    below, doubts = dict[str, float](), list[Caveat]()
    for soft in judged:
        site = soft.score.candidate.site
        if not is_soft(soft) or not isinstance(site, AxisSite) or not soft.after < soft.before:
            continue
        joint = found.model.robot.joints[site.axis].name
        rivals = [each for each in judged if not is_soft(each) and _acts_on(found, each, site)]
        lead = soft.score.evidence - max([each.score.evidence for each in rivals], default=-np.inf)
        speed = _speed(found, soft, site)
        least = open_lead if _has_a_name(found, named, site) else -open_lead
        if joint in known or lead < least or speed == 0.0:
            continue
        below[joint] = speed
        if lead < open_lead:
            other = rivals[0].score.candidate
            rival = (other.effect.name, *other.site.label(found.model.equations))
            unit = unit_at(found.model.robot.tree, joint, "rad/s")
            doubts.append(Caveat("creeping", joint, speed, rival=rival, unit=unit))
    return Creeping(below, tuple(doubts))


def is_soft(judged: Judgement) -> bool:
    return judged.score.candidate.effect is SOFT_COULOMB


def _has_a_name(found: Identification, named: Collection[Site], site: AxisSite) -> bool:
    own = set(site.kinds(found.model.equations))
    return any(own & set(each.kinds(found.model.equations)) for each in named if isinstance(each, AxisSite | PairSite))


def _acts_on(found: Identification, judged: Judgement, site: AxisSite) -> bool:
    equations = found.model.equations
    return bool(set(judged.score.candidate.site.kinds(equations)) & set(site.kinds(equations)))


def _speed(found: Identification, soft: Judgement, site: AxisSite) -> float:
    """Below which τ_c (1 - tanh(v / v_s)) is more than `search.soft_left` of the noise within the band."""
    criteria = found.model.criteria
    equations, (share,), (tau_c,) = found.model.equations, soft.score.candidate.shape, soft.score.coefficients
    channel = channels(equations)[equations.layout.axis(site.axis)]
    floors = [fit.noise_floor**2 - fit.noise_beyond_band**2 for fit in found.validation if fit.channel == channel]
    floor = float(np.sqrt(max(np.median(floors), 0.0)))
    v_s = share * float(found.model.sizes.velocity[site.axis])
    lacking = np.clip(criteria.search.soft_left * floor / max(float(tau_c), 1e-300), np.finfo(float).eps, 1.0)
    return float(v_s * np.arctanh(1.0 - lacking))
