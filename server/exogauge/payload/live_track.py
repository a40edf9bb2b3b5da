"""The sensor's motion a tenth of a second ago, sample by sample: the fixed-lag smoother of `smoothing`, and kinematics.

A joint that stands still is filtered as one that hardly moves; the first sample that it leaves its place, the window is
filtered again as moving. Else the noise of joints far from the sensor, which do not move, would hide a contact.

A sensor's filter makes a wrench late: poses are taken as they stood then (`Retimed`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.payload_live import USUAL, Streaming
from exogauge.loops.jerk_filter import flush, slide
from exogauge.payload.sensor_motion import Chain, SensorMotion, pose_motion
from exogauge.payload.smoothing import LAG_S, MEMORY, error_root, memory, states_at

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Pose:
    """Which channels a sample has. chain: they are joint angles; None: nine entries of R_BS, then three of position.
    std: (K,) [rad or m] of each. density: (K,) jerk density of each while it moves. even_s: period of samples that are
    taken evenly though their stamps jitter; None where stamps say when."""

    chain: Chain | None
    std: Array
    density: Array
    even_s: float | None = None

    @property
    def groups(self) -> NDArray[np.int64]:
        """(K,) channels that move together."""
        K = len(self.std)
        return np.arange(K) if self.chain is not None else np.repeat([0, 1], [9, K - 9])


@final
@dataclass(frozen=True)
class Tracked:
    """Of T samples: motion; settled: whether it can be trusted; noise_known: False while a joint that stopped is not
    known as well as one that stands still, and said to err like one that moves."""

    motion: SensorMotion
    settled: NDArray[np.bool_]
    noise_known: NDArray[np.bool_]

    def rows(self, which: slice) -> Tracked:
        return Tracked(self.motion.rows(which), self.settled[which], self.noise_known[which])


@final
class Track:
    """Smoothed motion of samples that come one after the other."""

    def __init__(
        self, pose: Pose, rate_hz: float, gravity: Array, *, still: Literal["settled", "as_moving"] = "settled",
        criteria: Streaming = USUAL, farthest_s: float = 0.0,
    ) -> None:  # fmt: skip
        """gravity: (3,) [m/s²] in {B}. still: how what stands still is filtered. farthest_s: that a wrench may be late,
        either way."""
        self.retimed = Retimed(farthest_s)
        self.pose, self.gravity, self.period = pose, gravity, 1.0 / rate_hz
        self.lag = max(round(LAG_S / self.period), 1)
        self._group = pose.groups
        moving = pose.density * self.period**5 / pose.std**2
        rest = np.minimum(moving, (MEMORY / criteria.still_samples) ** 6) if still == "settled" else moving
        self._ratio = np.column_stack([rest, moving])
        units = self.period ** -np.arange(3.0)
        self._scale = pose.std[:, None] * units
        roots = {ratio: error_root(ratio, self.lag) for ratio in np.unique(self._ratio)}
        self._roots = np.array([[roots[r] for r in pair] for pair in self._ratio]) * self._scale[:, None, :, None]
        self.edge = max(memory(float(ratio)) for ratio in moving)
        K, N = len(pose.std), self.lag + 1
        self._ring = (
            np.zeros((N, K, 3)), np.zeros((N, K, 3, 3)), np.zeros((N, K, 3, 3)), np.zeros((N, K)), np.zeros(N),
        )  # fmt: skip
        self._place, self._quiet = np.zeros(2, np.int64), np.zeros(self._group.max() + 1, np.int64)
        self._anchor, self._drift, self._zero = np.zeros(K), np.zeros(K), np.zeros(K)
        self._last = np.nan
        self._since = 0  # samples given since the filter began
        self._times = np.zeros(0)
        self._clock, self._clock_last = np.zeros(0), 0.0  # [s] when samples were taken, where stamps do not say it

    @property
    def waiting(self) -> int:
        """Samples that were taken and not given."""
        return len(self._times)

    def push(self, time: Array, values: Array) -> Tracked:
        """The samples that are now a lag back. time: (n,) [s], each later
        than the one before by no more than `longest_gap` periods; values: (n, K)."""
        if not self._place[1]:
            self._zero, self._last, self._since = values[0].copy(), time[0] - self.period, 0
            self._quiet[:] = 0
        z = (values - self._zero) / self.pose.std
        h = (time - np.concatenate([[self._last], time[:-1]])) / self.period
        if self.pose.even_s is not None:
            h = np.maximum(np.round(h), 1.0) * self.pose.even_s / self.period
        out, moving = np.empty((len(z), len(self._scale), 3)), np.empty((len(z), len(self._quiet)))
        x, P, C, Z, H = self._ring
        given = slide(
            z,
            h,
            self._group,
            self._ratio,
            self._place,
            x,
            P,
            C,
            Z,
            H,
            self._quiet,
            self._anchor,
            self._drift,
            out,
            moving,
        )
        self._last = time[-1]
        self._times = np.concatenate([self._times, time])
        self._clock = np.concatenate([self._clock, self._clock_last + self.period * np.cumsum(h)])
        self._clock_last = self._clock[-1]
        return self._given(out[:given], moving[:given], last=False)

    def flush(self) -> Tracked:
        """What is left, known worse the later it is; the next sample begins anew."""
        out, moving = np.empty((self.lag, len(self._scale), 3)), np.empty((self.lag, len(self._quiet)))
        x, _, C, _, H = self._ring
        given = flush(self._place, self._group, self._ratio, x, C, H, self._quiet, out, moving)
        found = self._given(out[:given], moving[:given], last=True)
        self.retimed.clear()
        return replace(found, settled=np.zeros(len(found.settled), dtype=bool))

    def _given(self, out: Array, moving: Array, *, last: bool) -> Tracked:
        clock, self._clock = self._clock[: len(out)], self._clock[len(out) :]
        state = out * self._scale
        state[:, :, 0] += self._zero
        state, moving = self.retimed.then(clock, state, moving, last=last)
        n = len(state)
        time, self._times = self._times[:n], self._times[n:]
        settled = self._since + np.arange(n) >= self.edge
        self._since += n
        which = np.ceil(moving).astype(np.intp)[:, self._group]
        noise_known = ~np.any(moving == 0.5, axis=1)
        roots = self._roots[np.arange(len(self._scale)), which]  # (n, K, 3, 3)
        if self.pose.chain is not None:
            motion = self.pose.chain.motion(time, state, roots, self.gravity)
        else:
            motion = pose_motion(time, state[:, :9], state[:, 9:], roots[:, 0], roots[:, 9:], self.gravity)
        return Tracked(motion, settled, noise_known)


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
