"""Samples as the search for what is missing sees them: motion, wrench, the noise floor of every channel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.judging import CARRYING as USUAL
from exogauge.criteria.judging import Carrying
from exogauge.logs.noise import white_noise_std
from exogauge.payload.dynamics import regressor_slopes
from exogauge.payload.sensor_motion import SensorMotion
from exogauge.payload.statics import Holds

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Stretch:
    """name: of the log. motion, wrench (T, 6) [N, N·m]. floor: (6,) std of a sample by noise of sensor and kinematics.
    rigid: (T, 6, 10) s A of [Payload] (4), (5); proper: (T, 3) a - g in {S}; turning: (T, 3, 3) [1/s²] what p adds to
    that at p. still: means of postures. use: (T,) which samples count. memory: how many of them count as one. block:
    samples whose mean is one row. session: (T,) [s] since the first log began; None where clocks say nothing of it."""

    name: str
    motion: SensorMotion
    wrench: Array
    rigid: Array
    proper: Array
    turning: Array
    floor: Array
    use: NDArray[np.bool_]
    still: bool = False
    memory: float = 1.0
    block: int = 1
    session: Array | None = None

    @property
    def time(self) -> Array:
        """(T,) [s] as the log has it."""
        return self.motion.time

    def using(self, which: NDArray[np.bool_]) -> Stretch:
        return replace(self, use=self.use & which)

    def inside(self, late: float) -> NDArray[np.bool_]:
        """(T,) whether the log tells of the time `late` [s] before a sample."""
        return np.asarray((self.time - late >= self.time[0]) & (self.time - late <= self.time[-1]))

    def without(self, spans: Sequence[tuple[float, float]]) -> Stretch:
        """spans: from, to [s] of what does not count."""
        inside = [(self.time >= start) & (self.time <= end) for start, end in spans]
        return self.using(~np.any(inside, axis=0)) if inside else self

    def slow(self, seconds: float) -> Stretch:
        period = float(np.median(np.diff(self.time)))
        return replace(self, block=max(1, round(seconds / period)))

    def halves(self, block_s: float) -> tuple[Stretch, Stretch]:
        """Every second block, and the others; of postures, whose time is their number, every second one."""
        even = np.floor(self.time / block_s).astype(int) % 2 == 0
        return self.using(even), self.using(~even)


def moving_stretch(
    name: str, motion: SensorMotion, wrench: Array, gravity: Array, sign: int, body: Array, stated: Array,
    criteria: Carrying = USUAL, at_rest: Array | None = None,
) -> Stretch:  # fmt: skip
    """The floor is what is measured above all motion, and what the kinematics' noise makes of a body (10,). stated:
    (6,) std of a sample, for wrenches without noise. at_rest: (6,) of a sample in postures, where coloured noise shows
    what lies below that, too. That, and what third differences show of noise with tails, is believed up to what is
    stated: something may swing or knock there."""
    rate = 1.0 / float(np.median(np.diff(motion.time)))
    read = np.array([white_noise_std(each, rate, criteria.above_motion * rate / 2) for each in wrench.T])
    shown = np.diff(wrench, 3, axis=0).std(axis=0) / np.sqrt(20.0)
    read = np.maximum(read, np.minimum(shown if at_rest is None else np.maximum(shown, at_rest), stated))
    slopes = np.einsum("ktip,p->tik", regressor_slopes(motion.omega), body)
    by_motion = np.mean(np.sum((slopes @ motion.noise) ** 2, axis=2), axis=0)
    floor = np.maximum(np.sqrt(read**2 + by_motion), criteria.least_noise * stated)
    return _stretch(name, motion, wrench, gravity, sign, floor)


def still_stretch(holds: Holds, gravity: Array, sign: int, criteria: Carrying = USUAL) -> Stretch:
    K = len(holds)
    none = np.zeros((K, 3))
    motion = SensorMotion(np.arange(K, dtype=float), holds.rotation, none, none, none, np.zeros((K, 9, 1)))
    unrest = holds.std if holds.unrest is None else holds.unrest
    swings = criteria.swings
    floor = np.maximum(holds.std, (swings if np.any(unrest > swings * holds.std) else 1.0) * unrest)
    return replace(_stretch("postures", motion, holds.wrench, gravity, sign, floor), still=True)


def _stretch(name: str, motion: SensorMotion, wrench: Array, gravity: Array, sign: int, floor: Array) -> Stretch:
    rigid, proper = np.asarray(sign * motion.regressor(gravity)), motion.proper_acceleration(gravity)
    turning = sign * rigid[:, :3, 1:4]  # of 1 kg
    return Stretch(name, motion, wrench, rigid, proper, turning, floor, np.ones(len(wrench), dtype=bool))
