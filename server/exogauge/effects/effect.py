"""What an effect on a joint is: a few columns that enter the actuator's torque linearly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol, final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Quantity:
    """A coefficient: its name, its unit at a revolute joint, its physical range, and in words what it is."""

    name: str
    unit: str
    low: float = -np.inf
    high: float = np.inf
    words: str = ""


@final
@dataclass(frozen=True)
class JointSignals:
    """T samples of one actuator axis.

    drive: (T,) [A], or [N·m] where torque is logged. velocity: (T,) [rad/s]. acceleration: (T,) [rad/s²].
    direction: (T,) sign of the velocity, 0 within the threshold that velocity noise sets (sgn_ε in [Evaluator] (7)).
    rest: (T,) 1 - |direction|. stick: (T,) rest times the sign of the residual torque r ([Evaluator] (8)-(9)).
    Where the drive is low-passed, direction and rest have passed the same filter.
    """

    drive: Array
    velocity: Array
    acceleration: Array
    direction: Array
    rest: Array
    stick: Array


class JointEffect(Protocol):
    """One reason why the torque at a joint is what it is. One file each; `EFFECT` is the instance the catalogue finds.

    name: identifier, a contract with results.json. words: the name that a person reads. sentence: for the user.
    coefficient: what is estimated.
    """

    name: ClassVar[str]
    words: ClassVar[str]
    sentence: ClassVar[str]
    coefficient: ClassVar[Quantity]

    def column(self, signals: JointSignals) -> Array:
        """(T,) torque delivered to the joint by the actuator per unit of the coefficient, friction negative."""
        ...
