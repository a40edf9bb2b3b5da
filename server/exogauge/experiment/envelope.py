"""Motions that a robot may make: Fourier series, drawn and shrunk until they keep within every bound."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.motion_excite import USUAL, MotionExcite
from exogauge.errors import NotIdentifiable
from exogauge.experiment.series_search import largest_within
from exogauge.robots.motion import Motion
from exogauge.robots.moving.base import BaseTurn
from exogauge.robots.moving.stance import OutOfReachError, Stance, Three
from exogauge.robots.moving.strain import Bounds
from exogauge.robots.series import Series

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Envelope:
    """Series of motions of a robot, and every bound that they have to keep. order: as `Bounds`. home: (free,) where
    motions are shrunk to."""

    stance: Stance
    series: Series
    bounds: Bounds
    criteria: MotionExcite = USUAL

    @property
    def order(self) -> NDArray[np.intp]:
        return self.bounds.order

    @cached_property
    def home(self) -> Array:
        robot = self.stance.robot
        assert robot.home is not None
        return np.asarray(robot.home[self.stance.free])

    @cached_property
    def sizes(self) -> Array:
        """(free, 1) [rad/s or m/s] speeds that count alike."""
        robot = self.stance.robot
        fast = np.where(np.isfinite(robot.limits.velocity), robot.limits.velocity, 3.0)
        base = np.array([0.1, 0.1, 0.1, 0.5, 0.5, 0.5])[: robot.base]
        return np.asarray(np.concatenate([base, fast])[self.stance.free][:, None])

    @cached_property
    def still(self) -> Array:
        """(free, 2N-2) at home throughout."""
        x = np.zeros((len(self.stance.free), self.series.size))
        x[:, -1] = self.home
        return x

    @cached_property
    def time(self) -> Array:
        count = self.criteria.per_period * self.series.harmonics
        return np.arange(count) * self.series.duration / count

    def motion(self, whole: Three) -> Motion:
        """As the identification sees it."""
        q, v, a = whole
        columns = self.stance.robot.base + self.order
        joints = q[:, columns], v[:, columns], a[:, columns]
        if not self.stance.robot.floating:
            none = np.zeros((len(q), 3))
            return Motion(*joints, np.tile(self._up, (len(q), 1)), none, none)
        return Motion(*joints, *BaseTurn.of(q[:, 3:6], v[:, 3:6], a[:, 3:6]).felt(a[:, :3]))

    @cached_property
    def _up(self) -> Array:
        return -np.asarray(self.stance.robot.model.gravity.linear)

    def loads(self, motion: Motion) -> Array:
        """(T, rows) what the robot asks for, as `Bounds` takes it."""
        raise NotImplementedError

    def largest(self, x: Array, rate_hz: float | None = None) -> tuple[float, str]:
        """Share of the bound that is nearest, at any sample, and which."""
        rate = rate_hz or self.criteria.check_hz
        time = np.arange(round(rate * self.series.duration) + 1) / rate
        return self.largest_of(self.series.motion(x, time))

    def largest_of(self, free: Three) -> tuple[float, str]:
        """The same of the free coordinates' (T, free) u, u̇, ü."""
        return max((share, name) for name, share in self.shares(free).items())

    def shares(self, free: Three) -> dict[str, float]:
        """Of every bound, by name, the largest."""
        try:
            whole = self.stance.whole(*free)
        except OutOfReachError:
            return {"reach of a leg": np.inf}
        found = dict[str, float]()
        for part in self.bounds.parts(*whole, self.loads(self.motion(whole))):
            for share, name in zip(part.share.max(axis=0), part.names, strict=True):
                found[name] = max(float(share), found.get(name, 0.0))
        return found


def random_motion(envelope: Envelope, rng: np.random.Generator, share: float = 1.0) -> Array:
    """(free, 2N-2) of random numbers, every joint as large as its own bounds bear, then all together as large
    as the others do; `share` of that. Raises NotIdentifiable where home itself is outside."""
    x = rng.standard_normal(envelope.still.shape) * envelope.sizes
    x[:, -1] = envelope.home
    x = _alone(envelope, x, rng)
    rest, name = envelope.largest(envelope.still, 1.0)
    if rest > 1.0:
        beyond = f"{name}: {100.0 * rest:.0f} % of it"
        raise NotIdentifiable(f"home is outside a bound while nothing moves ({beyond}): choose another posture", ())
    rate = len(envelope.time) / envelope.series.duration
    most = largest_within(
        lambda part: envelope.largest(envelope.still + part * (x - envelope.still), rate)[0] <= 1.0,
        envelope.criteria.halvings,
    )
    return envelope.still + share * most * (x - envelope.still)


def _alone(envelope: Envelope, x: Array, rng: np.random.Generator) -> Array:
    """x with every joint as large as its own bounds on position, velocity and acceleration bear, somewhere in its
    range; the base as large as its sizes."""
    joints = envelope.stance.free >= envelope.stance.robot.base
    x = x.copy()
    x[:, :-1] /= _shares_of(envelope, x, envelope.time)[:, None]
    low, high = _room(envelope, x, envelope.time)
    x[joints, -1] += low + rng.uniform(size=len(low)) * (high - low)
    return x


def _shares_of(envelope: Envelope, x: Array, time: Array) -> Array:
    """(free,) of a joint's range, speed or acceleration that it would fill by itself; of the base, of its sizes."""
    limits, own = envelope.stance.robot.limits, envelope.stance.free - envelope.stance.robot.base
    joints, own = own >= 0, own[own >= 0]
    u, du, ddu = envelope.series.motion(x, time)
    share = np.abs(du / envelope.sizes[:, 0]).max(axis=0)
    for each, size in (
        (np.ptp(u[:, joints], axis=0), limits.upper[own] - limits.lower[own]),
        (np.abs(ddu[:, joints]).max(axis=0), limits.acceleration[own]),
    ):
        share[joints] = np.maximum(share[joints], each / size)
    return np.asarray(share)


def _room(envelope: Envelope, x: Array, time: Array) -> tuple[Array, Array]:
    """(joints,) how far each may be moved down and up as a whole until it meets its range."""
    limits, own = envelope.stance.robot.limits, envelope.stance.free - envelope.stance.robot.base
    joints, own = own >= 0, own[own >= 0]
    u = envelope.series.motion(x, time)[0][:, joints]
    return limits.lower[own] - u.min(axis=0), limits.upper[own] - u.max(axis=0)


def within(envelope: Envelope, x: Array) -> Array:
    """As it is, or each joint shrunk and moved into its own bounds, and then all towards home and rest until every
    other bound holds at `check_hz`."""
    rate, tight = envelope.criteria.check_hz, envelope.criteria.tight
    time = np.arange(round(rate * envelope.series.duration) + 1) / rate
    joints, x = envelope.stance.free >= envelope.stance.robot.base, x.copy()
    filled = _shares_of(envelope, x, time)
    x[joints, :-1] *= (tight / np.maximum(filled[joints], tight))[:, None]
    low, high = _room(envelope, x, time)
    x[joints, -1] += np.clip(0.0, low, high)
    at_rest = envelope.shares(envelope.series.motion(envelope.still, time[:1]))
    for _ in range(envelope.criteria.shrinks):
        share, name = envelope.largest(x)
        if share <= 1.0:
            return x
        rest = at_rest.get(name, 0.0)
        kept = tight * (1.0 - rest) / (share - rest) if np.isfinite(share) else 0.0
        x = envelope.still + min(tight, max(kept, 0.7)) * (x - envelope.still)
    return x if envelope.largest(x)[0] <= 1.0 else envelope.still
