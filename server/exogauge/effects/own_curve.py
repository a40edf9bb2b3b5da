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
STEP = 0.01  # of a shape's range


@final
@dataclass(frozen=True)
class OwnCurve:
    """Beside an effect whose columns are u: u |u|/s and u³/s² of each, with s its usual size, or where the effect says
    `departures` itself, those columns instead; and ∂u/∂ of each shape, because one that fits best without them does not
    with them.

    The former are zero where the effect is, and bend it where it is large: no other cause can hide in them. An effect
    of the same site as the one that it is of, with the same shapes.

    of: the effect. sizes: (C,) s of each of its columns. terms: which of all these columns, in order.
    """

    of: Any
    sizes: tuple[float, ...]
    terms: tuple[int, ...]

    @property
    def name(self) -> str:
        return f"{self.of.name}_curve"

    @property
    def words(self) -> str:
        return str(self.of.words)

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
            bent = self.of.departures(signals, shape)
        else:
            own = self.of.columns(signals, shape)
            relative = np.abs(own / np.array(self.sizes))
            bent = np.concatenate([own * relative, own * relative**2], axis=1)
        every, width = [bent], len(self.of.coefficients)
        for number, place in enumerate(_searched(self.of)):
            first = bent.shape[1] + number * width
            asked = any(first <= term < first + width for term in self.terms)
            every.append(self._along(signals, shape, place) if asked else np.zeros((len(bent), width)))
        return np.asarray(np.concatenate(every, axis=1)[:, list(self.terms)])

    def _along(self, signals: Any, shape: tuple[float, ...], place: int) -> Array:
        """(T, C) by how much the columns change per share of that shape's range."""
        one = self.of.shapes[place]
        shares = [min(max(one.share(shape[place]) + step, 0.0), 1.0) for step in (-STEP, STEP)]
        before, after = (
            self.of.columns(signals, (*shape[:place], one.at(share), *shape[place + 1 :])) for share in shares
        )
        return np.asarray((after - before) / (shares[1] - shares[0]))

    def applies(self, signals: Any) -> bool:
        return bool(self.of.applies(signals))


def _searched(of: Any) -> list[int]:
    """Places of the shapes that are no choices."""
    return [place for place, one in enumerate(of.shapes) if not one.choice]


def possible_terms(of: Any) -> tuple[Quantity, ...]:
    """What each term's coefficient is called, in the order of `OwnCurve.terms`. of: the effect."""
    bent = tuple(Quantity(f"{each.name}_{name}", each.unit) for name in NAMES for each in of.coefficients)
    along = [
        Quantity(f"{each.name}_along_{of.shapes[place].name}", each.unit)
        for place in _searched(of)
        for each in of.coefficients
    ]
    return (*(of.departing if hasattr(of, "departures") else bent), *along)
