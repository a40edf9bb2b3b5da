"""Motions of the whole robot that are considered when one is planned: drawn within every bound, alone or while a joint
is swept."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from exogauge.experiment.motion_choices import Choice
from exogauge.experiment.reach import Reach
from exogauge.robots.moving.stance import OutOfReachError, Three

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Moving:
    """x: (free, 2N-2) of the reach's series. swept: a joint's sweep beside it, in place of what x has of that joint.

    price: as of a `Choice`.
    """

    reach: Reach
    x: Array
    swept: Choice | None
    price: float

    def whole(self, rate_hz: float) -> Three:
        """q, q̇, q̈ (T, n) of the robot's coordinates. Raises OutOfReachError."""
        reach = self.reach
        if self.swept is None:
            time = np.arange(round(reach.series.duration * rate_hz)) / rate_hz
            return reach.stance.whole(*reach.series.motion(self.x, time))
        lead = self.swept.sweep.position(rate_hz)
        time, whole = np.arange(len(lead)) / rate_hz, len(lead) / rate_hz
        series = replace(reach.series, duration=whole / max(1, round(whole / reach.series.duration)))
        u, du, ddu = series.motion(self.x, time)
        at = int(np.flatnonzero(reach.stance.free == reach.stance.robot.base + reach.order[self.swept.lead])[0])
        path = CubicSpline(time, lead)
        u[:, at], du[:, at], ddu[:, at] = lead, path(time, 1), path(time, 2)
        return reach.stance.whole(u, du, ddu)

    def keeps(self, at_hz: float) -> bool:
        try:
            return self.reach.within(self.whole(at_hz))
        except OutOfReachError:
            return False


def moving_choices(reach: Reach, sweeps: Sequence[Choice], at_hz: float) -> Iterator[Moving]:
    """sweeps: of single joints, one of each kind of which is tried together with what was drawn."""
    criteria = reach.planning
    price = criteria.beside * criteria.wider
    for paced, x in reach.drawn:
        yield Moving(paced, x, None, price)
    kinds = dict[tuple[int, str], Choice]()
    for sweep in sweeps:
        if sweep.companion is None:
            kinds.setdefault((sweep.lead, sweep.sweep.kind), sweep)
    beside = {paced.series: (paced, x) for paced, x in reversed(reach.drawn)}  # the first of each pace
    for swept in kinds.values():
        for paced, x in beside.values():
            home = paced.still
            for share in (1.0, 0.5, 0.25):
                made = Moving(paced, home + share * (x - home), swept, price)
                if made.keeps(at_hz):
                    yield made
                    break
