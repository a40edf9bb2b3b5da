"""What postures alone say of what is missing: that something is, not what. No motion names it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.criteria import Criteria
from exogauge.findings.verdict import Caveat, Decision
from exogauge.payload.missing.fit import SIZE
from exogauge.payload.missing.search import Missing, unjudged
from exogauge.payload.statics import Holds, StaticSolution

Array = NDArray[np.float64]
POSTURES = "postures"


def judged_at_rest(holds: Holds, found: StaticSolution, criteria: Criteria) -> Missing:
    """Unexplained where more is left than noise, and than a sensor's own errors reach: a cable, a hose, a pose that is
    off; below that it is open what it is. Its doubt is what is left in one number, were it in one of as many.
    """
    noise = holds.std if holds.unrest is None else np.maximum(holds.std, holds.unrest)
    decided = 6 + 4 + 2 * int(found.inclined)  # zero, mass and its centre, inclination
    free = holds.wrench.size - decided
    if free <= 0:
        return unjudged(Caveat("no_motion"))
    ratios = np.sqrt(np.sum(found.residual**2, axis=0) / (free / 6.0)) / noise
    left = float(np.sqrt(np.mean(np.sum(found.residual[:, :3] ** 2, axis=1))))
    largest = float(np.linalg.norm(holds.wrench[:, :3], axis=1).max())
    sure = criteria.judging.above + criteria.judging.sure_above * float(np.sqrt(0.5 * 6.0 / free))
    if ratios.max() < sure:
        return unjudged(Caveat("no_motion"))
    of = np.r_[0:4, 10:SIZE]  # mass, m c, zero, turn: all but the inertia
    _, known = found.moments
    rest = float(np.sum((found.residual / noise) ** 2))
    share = max(rest - free, 0.0) / SIZE / max(rest / free, 1.0)
    doubt = np.zeros((SIZE, SIZE))
    doubt[np.ix_(of, of)] = share * known
    surely = left > criteria.payload_static.unexplained * largest
    decision = Decision("unexplained", "above", None) if surely else Decision("undecided", "open", Caveat("no_motion"))
    told = {POSTURES: ratios}
    return Missing((), (), decision, told, told, 0, slight_doubt=doubt)


def said_at_rest(missing: Missing) -> list[str]:
    """Where more is left in postures than noise."""
    if POSTURES not in missing.after:
        return []
    times = f"{missing.after[POSTURES].max():.2g} times the noise is left in the postures"
    pull = "What pulls one way in all of them looks like weight, and numbers are then off by more than their doubt."
    if missing.decision.verdict == "unexplained":
        return [f"{times}, more than a sensor's own errors: a cable, a hose or a touch, or poses that are off. {pull}"]
    return [f"{times}. Errors of sensor and pose may be so large, and so may a cable or a hose that pulls. {pull}"]
