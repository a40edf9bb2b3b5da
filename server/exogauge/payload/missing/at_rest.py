"""What postures alone say of what is missing: that something is, not what. No motion names it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import Criteria
from exogauge.errors import NotIdentifiable
from exogauge.findings.verdict import Caveat, Decision
from exogauge.payload.missing.fit import SIZE
from exogauge.payload.missing.search import Missing, unjudged
from exogauge.payload.statics import Holds, StaticSolution, moment_noise, static_stage

Array = NDArray[np.float64]
POSTURES = "postures"
OF = np.r_[0:4, 10:SIZE]  # mass, m c, zero, turn: all but the inertia


def judged_at_rest(holds: Holds, found: StaticSolution, criteria: Criteria) -> Missing:
    """Unexplained where more is left than noise, and than a sensor's own errors reach: a cable, a hose, a pose that is
    off; below that it is open what it is. Its doubt is what is left in one number, were it in one of as many; and what
    a lean does that was not fitted.
    """
    lean = _of_lean(holds, found, criteria)
    open_ = replace(unjudged(Caveat("no_motion")), slight_doubt=lean)
    noise = holds.std if holds.unrest is None else np.maximum(holds.std, holds.unrest)
    noise = np.concatenate([noise[:3], moment_noise(noise, found.centre)])
    decided = 6 + 4 + 2 * int(found.inclined)  # zero, mass and its centre, inclination
    free = holds.wrench.size - decided
    if free <= 0:
        return open_
    ratios = np.sqrt(np.sum(found.residual**2, axis=0) / (free / 6.0)) / noise
    left = float(np.sqrt(np.mean(np.sum(found.residual[:, :3] ** 2, axis=1))))
    largest = float(np.linalg.norm(holds.wrench[:, :3], axis=1).max())
    sure = criteria.judging.above + criteria.judging.sure_above * float(np.sqrt(0.5 * 6.0 / free))
    if ratios.max() < sure:
        return open_
    _, known = found.moments
    rest = float(np.sum((found.residual / noise) ** 2))
    share = max(rest - free, 0.0) / SIZE / max(rest / free, 1.0)
    doubt = lean.copy()
    doubt[np.ix_(OF, OF)] += share * known
    surely = left > criteria.payload_static.unexplained * largest
    decision = Decision("unexplained", "above", None) if surely else Decision("undecided", "open", Caveat("no_motion"))
    told = {POSTURES: ratios}
    return Missing((), (), decision, told, told, 0, slight_doubt=doubt)


def _of_lean(holds: Holds, found: StaticSolution, criteria: Criteria) -> Array:
    """(18, 18) what the lean of a base that was taken to be level does to body and zero: what it seems to be, and how
    well that is known; 0 where the postures do not tell it at all."""
    doubt = np.zeros((SIZE, SIZE))
    if found.inclined:
        return doubt
    try:
        other = static_stage(holds, found.gravity, found.sign, inclined=True, criteria=criteria.payload_static)
    except NotIdentifiable:
        return doubt
    (value, C), level = other.moments, found.moments[0]
    shift = np.concatenate([value - level, -other.tilt])  # gravity turns the other way than the base
    across = C[:, 10:]
    doubt[np.ix_(OF, OF)] = across @ np.linalg.inv(C[10:, 10:]) @ across.T + np.outer(shift, shift)
    return doubt


def said_at_rest(missing: Missing, inclined: bool) -> list[str]:
    """Where more is left in postures than noise. inclined: whether the base's inclination was taken."""
    if POSTURES not in missing.after:
        return []
    times = f"{missing.after[POSTURES].max():.2g} times the noise is left in the postures"
    pull = "What pulls one way in all of them looks like weight, and numbers are then off by more than their doubt."
    if missing.decision.verdict == "unexplained":
        return [f"{times}, more than a sensor's own errors: a cable, a hose or a touch, or poses that are off. {pull}"]
    level = "" if inclined else "The base was taken to be level: where it leans, that is left. "
    return [f"{times}. {level}Errors of sensor and pose may be so large, and so may a cable or a hose. {pull}"]
