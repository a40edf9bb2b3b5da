"""How samples of a pose stood when the wrench that came with them was: a sensor's filter makes a wrench late."""

from __future__ import annotations

from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.payload.smoothing import states_at

Array = NDArray[np.float64]


@final
class Retimed:
    """late: [s] by which wrenches are late against their poses; negative, and they wait for the pose that they need.
    May be changed at any time."""

    def __init__(self, farthest_s: float) -> None:
        self.late = 0.0
        self._farthest = farthest_s
        self.clear()

    def clear(self) -> None:
        self._time, self._state, self._moving = np.zeros(0), np.zeros((0, 0, 3)), np.zeros((0, 0))
        self._next = 0  # of what is kept, the first that was not given

    def then(self, time: Array, state: Array, moving: Array, *, last: bool = False) -> tuple[Array, Array]:
        """time: (n,) [s] of samples; state: (n, K, 3), moving: (n, G) of their poses. Both of the poses that belong to
        the wrenches of those samples, in their order, that are decided by now; of all, where these are the last."""
        kept = len(self._time) > 0
        self._time = np.concatenate([self._time, time]) if kept else time
        self._state = np.concatenate([self._state, state]) if kept else state
        self._moving = np.concatenate([self._moving, moving]) if kept else moving
        wanted = self._time[self._next :] - self.late
        ripe = len(wanted) if last else int(np.count_nonzero(wanted <= self._time[-1])) if len(wanted) else 0
        first, self._next = self._next, self._next + ripe
        if self.late == 0.0 or ripe == 0 or len(self._time) < 2:
            out = self._state[first : self._next], self._moving[first : self._next]
        else:
            at = np.clip(wanted[:ripe], self._time[0], self._time[-1])
            near = np.minimum(np.searchsorted(self._time, at), len(self._time) - 1)
            out = states_at(self._state, self._time, at), self._moving[near]
        if self._next:
            # What comes next may need what was before, by the farthest.
            spent = int(np.count_nonzero(self._time[: self._next] < self._time[self._next - 1] - self._farthest)) - 2
            spent = max(spent, 0)
            self._time, self._state, self._moving = self._time[spent:], self._state[spent:], self._moving[spent:]
            self._next -= spent
        return out
