"""Bands that do not pull in proportion to their stretch; all of them in logs with the device only."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self, final

import numpy as np
from scipy.signal import lfilter

from exogauge.blind.generator.hidden.effect import Array, Change, Pull, Where
from exogauge.blind.generator.hidden.friction import bristle
from exogauge.blind.generator.motion import RATE_HZ
from exogauge.blind.generator.scene import Scene
from exogauge.blind.generator.wear import LENGTH_STD, STIFFNESS_STD, Band, Wear

_MAINLY = 0.3  # of the largest torque of a band on any joint


def wear_of(scene: Scene) -> Wear:
    if scene.wear is None:
        raise ValueError(f"{scene.kind.name} wears no device")
    return scene.wear


def named(scene: Scene, name: str) -> Band:
    return next(band for band in wear_of(scene).bands if band.wire.name == name)


def more(scene: Scene, band: Band, tension: Array) -> Change:
    """tension: (W, T) or, by stretches, (W, T, S) [N] beside k (l - l_0)."""
    wear = wear_of(scene)
    on = np.broadcast_to(wear.worn[:, None], scene.shape)
    return Change(wear.in_all_logs(band.pull(tension)), None, on, Pull(band.wire.name, tension))


def together(scene: Scene, pulls: Sequence[Pull]) -> Array:
    """(L, T, J) [N·m] of all that bands have beside k (l - l_0): none pushes, however much of it lets go at once."""
    wear, torque = wear_of(scene), np.zeros((*scene.shape, len(scene.joints)))
    springs = {band.wire.name: band.tension for band in wear.bands}
    for band in (*wear.bands, *wear.spare):
        own = [pull.tension for pull in pulls if pull.band == band.wire.name]
        if own:
            more = sum(np.zeros_like(band.lengths) + (each if each.ndim == 3 else each[:, :, None]) for each in own)
            spring = springs.get(band.wire.name, np.zeros(band.length.shape))
            torque += wear.in_all_logs(band.pull(np.maximum(more, -spring[:, :, None])))
    return torque


def with_band(scene: Scene, band: Band) -> Scene:
    """The scene with this band in place of the one of its name."""
    wear = wear_of(scene)
    bands = tuple(band if each.wire.name == band.wire.name else each for each in wear.bands)
    return replace(scene, wear=replace(wear, bands=bands))


class _OnOneBand:
    """Places of effects that sit in a band of the device."""

    reported: ClassVar[bool] = False

    @classmethod
    def places(cls, scene: Scene) -> list[Where]:
        return [{"band": band.wire.name} for band in wear_of(scene).bands]

    def believed(self, scene: Scene) -> float | None:
        return None


class OnASpring(_OnOneBand, ABC):
    """Those that change the band's spring itself."""

    @abstractmethod
    def changed(self, scene: Scene, size: float) -> Scene:
        """The scene in which other effects of the same band act: with its spring as this one leaves it."""


@final
@dataclass(frozen=True)
class BandStiffness(OnASpring):
    """This band alone is stiffer (sign 1) or softer by the share size than is stated."""

    band: str
    sign: float

    name: ClassVar[str] = "band_stiffness"
    linear: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        return cls(str(where["band"]), float(rng.choice([-1.0, 1.0])))

    def limits(self, scene: Scene) -> tuple[float, float]:
        return 0.25, 0.6

    def believed(self, scene: Scene) -> float | None:
        return STIFFNESS_STD

    def change(self, scene: Scene, size: float) -> Change:
        band = named(scene, self.band)
        return more(scene, band, (self._of(band, size) - band.stiffness) * band.stretch)

    def changed(self, scene: Scene, size: float) -> Scene:
        band = named(scene, self.band)
        return with_band(scene, replace(band, stiffness=self._of(band, size)))

    def _of(self, band: Band, size: float) -> float:
        return band.stated[0] * (1.0 + self.sign * size)


@final
@dataclass(frozen=True)
class BandLength(OnASpring):
    """Its natural length is longer (sign 1) or shorter by the share size than is stated."""

    band: str
    sign: float

    name: ClassVar[str] = "band_length"
    linear: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        return cls(str(where["band"]), float(rng.choice([-1.0, 1.0])))

    def limits(self, scene: Scene) -> tuple[float, float]:
        return 0.02, 0.05

    def believed(self, scene: Scene) -> float | None:
        return LENGTH_STD

    def change(self, scene: Scene, size: float) -> Change:
        band = named(scene, self.band)
        return more(scene, band, _longer(band, self._of(band, size) - band.natural_length))

    def changed(self, scene: Scene, size: float) -> Scene:
        band = named(scene, self.band)
        return with_band(scene, replace(band, natural_length=self._of(band, size)))

    def _of(self, band: Band, size: float) -> float:
        return band.stated[1] * (1.0 + self.sign * size)


@final
@dataclass(frozen=True)
class BandSlip(OnASpring):
    """An anchor gives way by size [m], once: in the log-th log with the device, at `begin`, within `within` [s]."""

    band: str
    log: int
    begin: float
    within: float

    name: ClassVar[str] = "band_slip"
    linear: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        last = float(scene.motion.time[-1])
        log = int(rng.integers(int(wear_of(scene).worn.sum())))
        begin = float(rng.uniform(0.25, 0.7)) * last
        return cls(str(where["band"]), log, begin, float(rng.uniform(0.05, 0.3)))

    def limits(self, scene: Scene) -> tuple[float, float]:
        return 0.005, 0.015

    def change(self, scene: Scene, size: float) -> Change:
        band = named(scene, self.band)
        return more(scene, band, _longer(band, size * self._gone(scene, band)))

    def changed(self, scene: Scene, size: float) -> Scene:
        band = named(scene, self.band)
        return with_band(scene, replace(band, natural_length=band.natural_length + size * self._gone(scene, band)))

    def _gone(self, scene: Scene, band: Band) -> Array:
        gone = np.zeros_like(band.length)
        x = np.clip((scene.motion.time - self.begin) / self.within, 0.0, 1.0)
        gone[self.log] = x**2 * (3.0 - 2.0 * x)
        gone[self.log + 1 :] = 1.0
        return gone


@final
@dataclass(frozen=True)
class BandViscous(_OnOneBand):
    """size [N] at the band's own usual speed v_0, times |v/v_0|^power with its sign; it never pushes."""

    band: str
    power: float
    usual: float

    name: ClassVar[str] = "band_viscous"
    linear: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        speed = _speed(named(scene, str(where["band"])))
        power = float(rng.choice([rng.uniform(0.6, 0.8), rng.uniform(1.25, 1.5)]))
        return cls(str(where["band"]), power, float(np.sqrt(np.mean(speed**2))))

    def limits(self, scene: Scene) -> tuple[float, float]:
        return 0.0, 0.5 * float(named(scene, self.band).tension.mean())

    def change(self, scene: Scene, size: float) -> Change:
        band = named(scene, self.band)
        v = _speed(band) / self.usual
        drag = size * np.sign(v) * np.abs(v) ** self.power * (band.stretch > 0.0)
        return more(scene, band, np.maximum(drag, -band.tension))


@final
@dataclass(frozen=True)
class BandRelaxation(_OnOneBand):
    """Two branches that creep, together the share size of the stiffness: the second, `soft` of it, in `longer` times
    the time constant `tau` [s] of the first. They are relaxed when a log begins."""

    band: str
    tau: float
    longer: float
    soft: float

    name: ClassVar[str] = "band_relaxation"
    linear: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        tau, longer, soft = (float(x) for x in rng.uniform([0.3, 3.0, 0.3], [1.5, 6.0, 0.5]))
        return cls(str(where["band"]), tau, longer, soft)

    def limits(self, scene: Scene) -> tuple[float, float]:
        return 0.0, 0.6

    def change(self, scene: Scene, size: float) -> Change:
        band = named(scene, self.band)
        branches = (((1.0 - self.soft), self.tau), (self.soft, self.tau * self.longer))
        strain = sum(share * _crept(band.stretch, tau) for share, tau in branches)
        return more(scene, band, np.maximum(size * band.stiffness * np.asarray(strain), -band.tension))


@final
@dataclass(frozen=True)
class BandHardening(_OnOneBand):
    """At its largest stretch x_m it pulls the share size more, below in proportion to (x/x_m)^power, and x itself."""

    band: str
    power: float

    name: ClassVar[str] = "band_hardening"
    linear: ClassVar[bool] = True

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        return cls(str(where["band"]), float(rng.choice([rng.uniform(0.6, 0.8), rng.uniform(1.4, 2.2)])))

    def limits(self, scene: Scene) -> tuple[float, float]:
        return 0.0, 1.5

    def change(self, scene: Scene, size: float) -> Change:
        band = named(scene, self.band)
        return more(scene, band, size * band.tension * (band.stretch / band.stretch.max()) ** self.power)


@final
@dataclass(frozen=True)
class BandSoftening(_OnOneBand):
    """At its largest stretch x_m it pulls the share size less, below in proportion to (x/x_m)^power, and x itself."""

    band: str
    power: float

    name: ClassVar[str] = "band_softening"
    linear: ClassVar[bool] = True

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        return cls(str(where["band"]), float(rng.uniform(0.5, 1.2)))

    def limits(self, scene: Scene) -> tuple[float, float]:
        return 0.0, 0.4  # more, and with a power of 1.2 it would pull less the further it is stretched

    def change(self, scene: Scene, size: float) -> Change:
        band = named(scene, self.band)
        return more(scene, band, -size * band.tension * (band.stretch / band.stretch.max()) ** self.power)


@final
@dataclass(frozen=True)
class BandHysteresis(_OnOneBand):
    """Its threads rub on each other: it pulls the share size · c more. c, -1…1, is what `ways` [m] as many threads in
    parallel hold, each of which sticks until strained by its way (Iwan): loops grow with the swing, and remember all
    turns that were not passed since."""

    band: str
    ways: tuple[float, ...]

    name: ClassVar[str] = "band_hysteresis"
    linear: ClassVar[bool] = True

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        middle = float(np.exp(rng.uniform(np.log(0.7e-3), np.log(5e-3))))
        return cls(str(where["band"]), tuple(float(way) for way in middle * np.geomspace(0.2, 5.0, 7)))

    def limits(self, scene: Scene) -> tuple[float, float]:
        return 0.0, 0.4

    def change(self, scene: Scene, size: float) -> Change:
        band = named(scene, self.band)
        return more(scene, band, size * band.tension * held_by_threads(band.length, np.array(self.ways)))


@final
@dataclass(frozen=True)
class BandViaFriction(_OnOneBand):
    """It rubs where it bends: tensions on both sides of a via point differ by e^(size · wrap angle · c).

    c, -1…1, follows how far the band has slid there, as two bristles that give way over `way` [m] and, with the share
    `soft`, over `longer` times that; the stretch towards which it slides pulls more. The stretches' mean tension, by
    length, stays what it was.
    """

    band: str
    way: float
    power: float
    soft: float
    longer: float

    name: ClassVar[str] = "band_via_friction"
    linear: ClassVar[bool] = False

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        way, power, soft, longer = rng.uniform([5e-4, 1.2, 0.2, 2.0], [3e-3, 1.6, 0.4, 4.0])
        return cls(str(where["band"]), float(way), float(power), float(soft), float(longer))

    def limits(self, scene: Scene) -> tuple[float, float]:
        return 0.0, 0.6

    def change(self, scene: Scene, size: float) -> Change:
        band = named(scene, self.band)
        share = band.lengths / band.length[:, :, None]
        uneven = np.zeros_like(band.lengths)
        for corner in range(band.lengths.shape[2] - 1):
            slid = band.natural_length * share[:, :, : corner + 1].sum(axis=2)
            quick, slow = (
                np.array([bristle(each, way, self.power) for each in slid])
                for way in (self.way, self.way * self.longer)
            )
            held = (1.0 - self.soft) * quick + self.soft * slow
            uneven[:, :, corner + 1] = uneven[:, :, corner] - size * band.wraps[:, :, corner] * held
        relative = np.exp(uneven)
        relative /= np.sum(relative * share, axis=2, keepdims=True)
        return more(scene, band, band.tension[:, :, None] * (relative - 1.0))


@final
@dataclass(frozen=True)
class ExtraBand:
    """Cloth or a cable between two links that device.yaml does not name: size [N/m] beyond its natural length.

    ends: links. joints: those that it mainly pulls at.
    """

    course: str
    ends: tuple[str, str]
    joints: tuple[str, ...]

    name: ClassVar[str] = "extra_band"
    linear: ClassVar[bool] = True
    reported: ClassVar[bool] = False

    @classmethod
    def places(cls, scene: Scene) -> list[Where]:
        return [{"band": "extra"} for _ in wear_of(scene).spare]

    @classmethod
    def draw(cls, rng: np.random.Generator, scene: Scene, where: Where) -> Self:
        spare = wear_of(scene).spare
        band = spare[int(rng.integers(len(spare)))]
        lever = np.sqrt(np.mean(band.pull(band.stretch) ** 2, axis=(0, 1)))
        joints = [name for name, own in zip(scene.joints, lever, strict=True) if own > _MAINLY * lever.max()]
        return cls(band.wire.name, (band.wire.points[0][0], band.wire.points[-1][0]), tuple(joints))

    def limits(self, scene: Scene) -> tuple[float, float]:
        return 10.0, 300.0

    def believed(self, scene: Scene) -> float | None:
        return None

    def change(self, scene: Scene, size: float) -> Change:
        band = next(band for band in wear_of(scene).spare if band.wire.name == self.course)
        return more(scene, band, size * band.stretch)


def _longer(band: Band, by: Array | float) -> Array:
    """(W, T) change of the tension when the natural length grows by so much [m]."""
    return np.asarray(band.stiffness * np.maximum(band.length - band.natural_length - by, 0.0) - band.tension)


def _speed(band: Band) -> Array:
    return np.asarray(np.gradient(band.length, 1.0 / RATE_HZ, axis=1))


def _crept(stretch: Array, tau: float) -> Array:
    """(W, T) what is left of the stretch in a branch that creeps: s' = x' - s / tau, exact steps from rest."""
    keep = float(np.exp(-1.0 / (RATE_HZ * tau)))
    gain = RATE_HZ * tau * (1.0 - keep)
    steps = np.diff(stretch, axis=1, prepend=stretch[:, :1])
    return np.asarray(lfilter([gain], [1.0, -keep], steps, axis=1))


def held_by_threads(length: Array, ways: Array) -> Array:
    """(W, T) mean force, -1…1, of threads that each give way once they are strained by their own way; unstrained at
    the beginning."""
    force, held = np.zeros((len(length), len(ways))), np.zeros_like(length)
    for k, step in enumerate(np.diff(length, axis=1).T, start=1):
        force = np.clip(force + step[:, None] / ways, -1.0, 1.0)
        held[:, k] = force.mean(axis=1)
    return held
