"""How a real effect departs from the formula that it is named by: terms over what the formula gives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape

Array = NDArray[np.float64]

NAMES = ("quadratic", "cubic")


@final
@dataclass(frozen=True)
class OwnCurve:
    """Beside an effect whose columns are u: u |u|/s and u³/s² of each, with s its usual size; and, where the effect
    says `departures` itself, those columns instead.

    Both are zero where the effect is, and bend it where it is large: no other cause can hide in them. An effect of the
    same site as the one that it is of, with the same shapes.

    of: the effect. sizes: (C,) s of each of its columns. terms: which of all these columns, in order.
    """

    of: Any
    sizes: tuple[float, ...]
    terms: tuple[int, ...]

    @property
    def name(self) -> str:
        return f"{self.of.name}_curve"

    @property
    def place(self) -> str:
        return str(self.of.place)

    @property
    def sentence(self) -> str:
        return str(self.of.sentence)

    @property
    def coefficients(self) -> tuple[Quantity, ...]:
        every = possible_terms(self.of)
        return tuple(every[term] for term in self.terms)

    @property
    def shapes(self) -> tuple[Shape, ...]:
        return tuple(self.of.shapes)

    @property
    def confounds(self) -> tuple[str, ...]:
        return tuple(self.of.confounds)

    @property
    def needs(self) -> str:
        return str(self.of.needs)

    @property
    def coordinate(self) -> str:
        return str(self.of.coordinate)

    def columns(self, signals: Any, shape: tuple[float, ...]) -> Array:
        """(T, terms) as those of the effect."""
        if hasattr(self.of, "departures"):
            every = self.of.departures(signals, shape)
        else:
            own = self.of.columns(signals, shape)
            relative = np.abs(own / np.array(self.sizes))
            every = np.concatenate([own * relative, own * relative**2], axis=1)
        return np.asarray(every[:, list(self.terms)])

    def applies(self, signals: Any) -> bool:
        return bool(self.of.applies(signals))


def possible_terms(of: Any) -> tuple[Quantity, ...]:
    """What each term's coefficient is called, in the order of `OwnCurve.terms`. of: the effect."""
    if hasattr(of, "departures"):
        return tuple(of.departing)
    return tuple(Quantity(f"{each.name}_{name}", each.unit) for name in NAMES for each in of.coefficients)
