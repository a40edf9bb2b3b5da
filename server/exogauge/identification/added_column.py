"""One more coefficient of the model, and the kinds of rows that it is in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.effects.effect import Quantity


@final
@dataclass(frozen=True)
class AddedColumn:
    """name: `stribeck.tau_b`. place: the joint or sensor, in words. kinds: of the rows (`Equations`) that hold it.

    measured: (value, std) where it was measured otherwise than by the logs; None where nothing is known of it.
    """

    name: str
    place: str
    kinds: tuple[int, ...]
    coefficient: Quantity
    measured: tuple[float, float] | None = None
