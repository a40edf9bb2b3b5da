"""What a link may weigh otherwise than before."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol, final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.effect import Quantity
from exogauge.effects.shaped import Shape

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class LinkSignals:
    """One link in one log of T samples. time: (T,) [s]. number: of the log in the order of the study, from 0; -1 where
    it is not known. carries_nothing: no link hangs on it: a hand, a tool."""

    time: Array
    number: int
    carries_nothing: bool


class LinkEffect(Protocol):
    """As `ShapedEffect`, for the mass and the first moments of a link. place is `link`. coordinate: `time`."""

    name: ClassVar[str]
    place: ClassVar[str]
    sentence: ClassVar[str]
    coefficients: ClassVar[tuple[Quantity, ...]]
    shapes: ClassVar[tuple[Shape, ...]]
    confounds: ClassVar[tuple[str, ...]]
    needs: ClassVar[str]
    coordinate: ClassVar[str]

    def present(self, signals: LinkSignals, shape: tuple[float, ...]) -> float:
        """1 in a log that has it, else 0. Coefficients: mass [kg], then first moments [kg·m] in the link's frame."""
        ...

    def applies(self, signals: LinkSignals) -> bool:
        """Whether it can sit there."""
        ...
