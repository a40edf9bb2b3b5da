"""What a sensor under a foot has wrong: what the catalogue has a name for, and what it has not."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol, final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, lfilter, sosfiltfilt

from exogauge.blind.generator.cut import AXES
from exogauge.blind.generator.motion import RATE_HZ
from exogauge.synthetic.robot_facts import FEET, LINKS
from exogauge.synthetic.sensors import NOISE, rotation

Array = NDArray[np.float64]

STD = np.repeat([NOISE["force"], NOISE["moment"]], 3)  # (6,) of one sample of a sensor
_BAND_HZ, _EVERY = 10.0, 10


class FootFault(Protocol):
    """A frozen dataclass of what was drawn. name: as results.json has it. foot: index, None for both alike."""

    @property
    def name(self) -> str: ...

    @property
    def where(self) -> dict[str, str]: ...

    def read(self, wrench: Array, log: int) -> Array:
        """(T, 2, 6) what the log says of the true wrenches, world on robot, force then moment."""
        ...


@final
@dataclass(frozen=True)
class Gain:
    """One component reads (1 + gain) of what it feels; a little more so at large values, by curve |w| / rms."""

    foot: int
    axis: int
    gain: float
    curve: float
    name: str = field(default="ft_gain", init=False)

    @property
    def where(self) -> dict[str, str]:
        return {"sensor": FEET[self.foot], "axis": AXES[self.axis]}

    def read(self, wrench: Array, log: int) -> Array:
        out, w = wrench.copy(), wrench[:, self.foot, self.axis]
        out[:, self.foot, self.axis] += self.gain * w * (1.0 + self.curve * np.abs(w) / np.sqrt(np.mean(w**2)))
        return out


@final
@dataclass(frozen=True)
class Drift:
    """A zero moves by size [N, N·m] in every log, or in one: the share soon within `settling` [s], the rest evenly."""

    foot: int
    axis: int
    size: float
    log: int | None
    soon: float
    settling: float
    name: str = field(default="ft_drift", init=False)

    @property
    def where(self) -> dict[str, str]:
        return {"sensor": FEET[self.foot], "axis": AXES[self.axis]}

    def read(self, wrench: Array, log: int) -> Array:
        out = wrench.copy()
        if self.log in (None, log):
            time = np.arange(len(wrench)) / RATE_HZ
            path = self.soon * (1.0 - np.exp(-time / self.settling)) + (1.0 - self.soon) * time / time[-1]
            out[:, self.foot, self.axis] += self.size * path
        return out


@final
@dataclass(frozen=True)
class Tilt:
    """The sensor is bolted on askew: it reads forces and moments in axes that are turned by `turn` [rad], exactly."""

    foot: int
    turn: tuple[float, float, float]
    name: str = field(default="ft_tilt", init=False)

    @property
    def where(self) -> dict[str, str]:
        return {"sensor": FEET[self.foot]}

    def read(self, wrench: Array, log: int) -> Array:
        out, R = wrench.copy(), rotation(np.array(self.turn))
        out[:, self.foot, :3], out[:, self.foot, 3:] = wrench[:, self.foot, :3] @ R.T, wrench[:, self.foot, 3:] @ R.T
        return out


@final
@dataclass(frozen=True)
class Alike:
    """Both feet read (1 + gain) of all they feel: with every mass as much larger nothing contradicts it."""

    gain: float
    name: str = field(default="feet_alike", init=False)

    @property
    def where(self) -> dict[str, str]:
        return {"sensor": "all"}

    def read(self, wrench: Array, log: int) -> Array:
        return np.asarray((1.0 + self.gain) * wrench)


@final
@dataclass(frozen=True)
class Creep:
    """What is loaded gives way: size of the load is read on top, `lag` [s] late (first order), as glue under a strain
    gauge does; the load at a log's beginning has been there for long."""

    foot: int
    axis: int
    size: float
    lag: float
    name: str = field(default="ft_creep", init=False)

    @property
    def where(self) -> dict[str, str]:
        return {"sensor": FEET[self.foot], "axis": AXES[self.axis]}

    def read(self, wrench: Array, log: int) -> Array:
        out, w = wrench.copy(), wrench[:, self.foot, self.axis]
        keep = float(np.exp(-1.0 / (RATE_HZ * self.lag)))
        late, _ = lfilter([1.0 - keep], [1.0, -keep], w, zi=[keep * w[0]])
        out[:, self.foot, self.axis] += self.size * (late - w)
        return out


@final
@dataclass(frozen=True)
class Shunt:
    """A cover under the sole touches the ground at `at` [m] (x forward of the sensor, y to the left) while the weight
    stands on that side by more than `beyond` [m]: it bears `share` of the weight's way beyond, past the sensor."""

    foot: int
    at: tuple[float, float]
    beyond: float
    share: float
    name: str = field(default="foot_shunt", init=False)

    @property
    def where(self) -> dict[str, str]:
        return {"sensor": FEET[self.foot]}

    def read(self, wrench: Array, log: int) -> Array:
        out, own = wrench.copy(), wrench[:, self.foot]
        x, y = self.at
        reach = float(np.hypot(x, y))
        along = (-own[:, 4] * x + own[:, 3] * y) / np.maximum(own[:, 2], 1.0) / reach  # of the centre of pressure
        borne = self.share * own[:, 2] * np.maximum(along - self.beyond, 0.0) / reach
        out[:, self.foot, 2] -= borne
        out[:, self.foot, 3] -= y * borne
        out[:, self.foot, 4] += x * borne
        return out


OUTSIDE = ("ft_creep", "foot_shunt")  # of every catalogue
UNDECIDABLE = ("feet_alike",)  # of these rows: a name would be a guess
KINDS = ("ft_gain", "ft_drift", "ft_tilt", *OUTSIDE, "ft_gain", "ft_drift", "ft_tilt", "feet_alike", "nothing",
         "stribeck", "payload")  # fmt: skip


def kinds_known() -> tuple[str, ...]:
    return tuple(dict.fromkeys(KINDS))


def drawn(kind: str, rng: np.random.Generator, logs: int) -> FootFault | None:
    """logs: how many there are. None: the sort is none of a foot's."""
    foot, axis, side = int(rng.integers(2)), int(rng.integers(6)), float(rng.choice([-1.0, 1.0]))
    if kind == "ft_gain":
        return Gain(foot, axis, side * float(rng.uniform(0.03, 0.15)), float(rng.uniform(0.0, 0.15)))
    if kind == "ft_drift":
        log = int(rng.integers(logs)) if rng.uniform() < 0.3 else None
        size = side * float(rng.uniform(4.0, 20.0)) * float(STD[axis])
        return Drift(foot, axis, size, log, float(rng.uniform(0.4, 0.8)), float(rng.uniform(3.0, 12.0)))
    if kind == "ft_tilt":
        turn = np.deg2rad(rng.uniform(0.3, 1.5)) * (way := rng.standard_normal(3)) / np.linalg.norm(way)
        return Tilt(foot, (float(turn[0]), float(turn[1]), float(turn[2])))
    if kind == "ft_creep":
        return Creep(foot, axis, float(rng.uniform(0.03, 0.12)), float(rng.uniform(0.5, 3.0)))
    if kind == "foot_shunt":
        turn = rng.uniform(0.0, 2.0 * np.pi)
        at = (0.1 * float(np.cos(turn)), 0.05 * float(np.sin(turn)))
        return Shunt(foot, at, float(rng.uniform(-0.005, 0.015)), float(rng.uniform(0.2, 0.8)))
    if kind == "feet_alike":
        return Alike(side * float(rng.uniform(0.04, 0.1)))
    return None


def how_large(fault: FootFault, wrenches: list[Array]) -> tuple[float, str]:
    """rms below 10 Hz of what is left of the error on each component of both feet together, over the noise of their
    sum; and the component with most. Feet stand still, so forces are those of one mass that moves: one multiple of
    all three together is taken off. Moments, about the point between the feet: multiples of all six. What bodies take
    beside that makes it smaller yet."""
    low_pass = butter(2, _BAND_HZ, fs=RATE_HZ, output="sos")
    total, error = (
        np.concatenate([sosfiltfilt(low_pass, each, axis=0)[::_EVERY] for each in logs])
        for logs in (
            [_together(wrench) for wrench in wrenches],
            [_together(fault.read(wrench, n) - wrench) for n, wrench in enumerate(wrenches)],
        )
    )
    mass = float(np.vdot(total[:, :3], error[:, :3]) / np.vdot(total[:, :3], total[:, :3]))
    left = np.hstack(
        [error[:, :3] - mass * total[:, :3], error[:, 3:] - total @ np.linalg.lstsq(total, error[:, 3:], rcond=None)[0]]
    )
    ratio = np.sqrt(np.mean(left**2, axis=0))
    apart = np.array([0.0, 0.0, 0.0, _LEVER, 0.0, _LEVER])  # a force's noise makes moments across
    ratio /= np.sqrt(2.0) * np.hypot(STD, apart * STD[0])
    most = int(np.argmax(ratio))
    return float(ratio[most]), f"base.{AXES[most]}"


def _together(wrenches: Array) -> Array:
    """(T, 6) of both feet, about the point between them."""
    out = wrenches.sum(axis=1)
    for foot, y in enumerate((_LEVER, -_LEVER)):
        force = wrenches[:, foot, :3]
        out[:, 3] += y * force[:, 2]
        out[:, 5] -= y * force[:, 0]
    return np.asarray(out)


def _aside(name: str) -> float:
    """[m] of a link to the left of the base, at zero posture."""
    by_name, y = {link.name: link for link in LINKS}, 0.0
    while (link := by_name[name]).parent is not None:
        y, name = y + link.origin[1], link.parent
    return y


_LEVER = _aside(FEET[0])
