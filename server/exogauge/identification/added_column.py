"""One more coefficient of the model, and the kinds of rows that it is in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.effects.effect import Quantity


@final
@dataclass(frozen=True)
class AddedColumn:
    """name: `stribeck.tau_b`. place: the joint or sensor, in words. kinds: of the rows (`Equations`) that hold it."""

    name: str
    place: str
    kinds: tuple[int, ...]
    coefficient: Quantity
