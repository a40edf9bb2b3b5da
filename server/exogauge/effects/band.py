"""What an effect is that a band may have beside its spring: tension that enters linearly, with shapes that do not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import ClassVar, Literal, Protocol, final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape

Array = NDArray[np.float64]
Sort = Literal["law", "stated", "wire"]


@final
@dataclass(frozen=True)
class Stated:
    """How device.yaml states a value of a law. typical: of ordinary size, to begin with. low, high: its range, ends
    included. default: what it is where it is left out; None: it must be given."""

    typical: float
    low: float = 0.0
    high: float = np.inf
    default: float | None = None


NOT_STATED: Mapping[str, Stated] = MappingProxyType({})


@final
@dataclass(frozen=True)
class WireMotion:
    """T samples of one band of S segments, in the order of time.

    time: (T,) [s]. length: (T,) [m]. rate: (T,) [m/s]. For laws per segment, else None: segment_length: (T, S) [m],
    wrap: (T, S-1) [rad] by how much the band turns at each via point between its ends.
    """

    time: Array
    length: Array
    rate: Array
    segment_length: Array | None = None
    wrap: Array | None = None

    def with_spring(self, stiffness: float, natural_length: float) -> BandSignals:
        """As a log of its own, of which nothing is known before its end: shortest and travel are 0."""
        return BandSignals(
            time=self.time,
            clock=self.time,
            start=0.0,
            span=float(np.ptp(self.time)) if len(self.time) else 0.0,
            length=self.length,
            rate=self.rate,
            stretch=np.maximum(self.length - natural_length, 0.0),
            stiffness=stiffness,
            natural_length=natural_length,
            shortest=0.0,
            travel=0.0,
            segment_length=self.segment_length,
            wrap=self.wrap,
        )


@final
@dataclass(frozen=True)
class BandSignals:
    """T samples of one band in one whole log with the wear on, in the order of time.

    time: (T,) [s] from the log's start. clock: (T,) [s] the same with all logs of the wear laid end to end; start,
    span: where this log begins on it and how long all are. length: (T,) [m]. rate: (T,) [m/s]. stretch: (T,) [m]
    beyond the natural length, 0 where slack. stiffness [N/m], natural_length [m]: as fitted so far. shortest, travel:
    [m] of the band's length over all logs. segment_length: (T, S) [m] of its straight parts, wrap: (T, S-1) [rad] by
    how much it turns between them; None where they do not matter. way: (T,) `way_of_a_sample`, where it is known.
    """

    time: Array
    clock: Array
    start: float
    span: float
    length: Array
    rate: Array
    stretch: Array
    stiffness: float
    natural_length: float
    shortest: float
    travel: float
    segment_length: Array | None = None
    wrap: Array | None = None
    way: Array | None = None

    @cached_property
    def taut(self) -> Array:
        """(T,) 1 where the band pulls, 0 where it is slack; it comes up within one sample's way, so that the moment
        moves with the natural length, and a fit can follow it."""
        least_way = 1e-4  # of the band's travel, within which one that hardly moves comes taut
        way = way_of_a_sample(self.time, self.rate) if self.way is None else self.way
        return np.asarray(np.clip(self.stretch / np.maximum(way, max(least_way * self.travel, 1e-9)), 0.0, 1.0))

    @property
    def tension(self) -> Array:
        """(T,) [N] of the linear law."""
        return self.stiffness * self.stretch


def way_of_a_sample(time: Array, rate: Array) -> Array:
    """(T,) [m] that a band's length goes within one sample. time: (T,) [s]. rate: (T,) [m/s]."""
    return np.abs(rate * np.gradient(time)) if len(time) > 1 else np.zeros(len(time))


class BandEffect(Protocol):
    """A reason why a band does not pull as the linear law says. One file each; `EFFECT` is what the catalogue finds.

    name: identifier, a contract with results.json. words: the name that a person reads. sentence: for the user.
    coefficients: what is estimated linearly. shapes: what is searched. confounds: what can stand in for it: other
    effects, or `stiffness` and `natural_length` that are fitted in any case. needs: in words, the motion that shows it.
    coordinate: of the evidence plot, one of `stretch`, `rate`, `clock`. once: it happens at one moment, so that nothing
    can be held out to judge it. per_segment: the tension differs along the band. sort: `law`, another way to pull;
    `stated`, the linear law with other values than the description's; `wire`, a wire that it does not know.

    A law that device.yaml knows has a name there, `law`, and says of each of its values how it is `stated`; else "" and
    nothing. Values are coefficients and shapes by name. A shape with a coefficient's name is the value about which the
    law is linear in that. A shape without a grid is stated, not looked for.
    """

    name: ClassVar[str]
    words: ClassVar[str]
    sentence: ClassVar[str]
    coefficients: ClassVar[tuple[Quantity, ...]]
    shapes: ClassVar[tuple[Shape, ...]]
    confounds: ClassVar[tuple[str, ...]]
    needs: ClassVar[str]
    coordinate: ClassVar[str]
    once: ClassVar[bool]
    per_segment: ClassVar[bool]
    sort: ClassVar[Sort]
    law: ClassVar[str]
    stated: ClassVar[Mapping[str, Stated]]

    def added_tension(self, signals: BandSignals, shape: tuple[float, ...]) -> Array:
        """(T, C) [N] that the band pulls more per unit of each coefficient; (T, S, C) per segment."""
        ...

    def applies(self, signals: BandSignals) -> bool:
        """Whether the log holds what the effect needs (a taut band, both directions, corners …)."""
        ...


def relaxed(kept: Array, gained: Array) -> Array:
    """(T,) x_k = kept_k x_{k-1} + gained_k from x = 0, kept within 0…1: what a band remembers of its way.

    Steps are joined two by two, then four by four, and so on: a log takes log₂ T passes and no loop over samples.
    """
    a, x, reach = kept.copy(), gained.copy(), 1
    while reach < len(x):
        x[reach:] += a[reach:] * x[:-reach]
        a[reach:] *= a[:-reach].copy()
        reach *= 2
    return x
