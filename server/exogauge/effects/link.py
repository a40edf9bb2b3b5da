"""What a link may weigh otherwise than before."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, final

import numpy as np
from numpy.typing import NDArray

from exogauge.effects.shaped import MissingEffect

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class LinkSignals:
    """One link in one log of T samples. time: (T,) [s]. number: of the log in the order of the study, from 0; -1 where
    it is not known. carries_nothing: no link hangs on it: a hand, a tool."""

    time: Array
    number: int
    carries_nothing: bool


class LinkEffect(MissingEffect, Protocol):
    """Of the mass and the first moments of a link. place is `link`; coordinate: `time`."""

    def present(self, signals: LinkSignals, shape: tuple[float, ...]) -> float:
        """1 in a log that has it, else 0. Coefficients: mass [kg], then first moments [kg·m] in the link's frame."""
        ...

    def applies(self, signals: LinkSignals) -> bool:
        """Whether it can sit there."""
        ...
