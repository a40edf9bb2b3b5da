"""A load that is picked up between two logs."""

from __future__ import annotations

from typing import final

from exogauge.effects.effect import Quantity
from exogauge.effects.link import LinkSignals
from exogauge.effects.order import since_log


@final
class Payload:
    """From log `since` on (counted from 0 in the order of the study) the hand or tool carries mass m at c.

    One that is there from the first log on is part of the link's inertia, and told by its distance from what the maker
    states. The load's own rotational inertia is neglected.
    """

    name = "payload"
    place = "link"
    sentence = "It carries a load that it did not carry in the first logs."
    coefficients = (
        Quantity("mass", "kg", low=0.0),
        Quantity("mx", "kg·m"),
        Quantity("my", "kg·m"),
        Quantity("mz", "kg·m"),
    )
    shapes = (since_log(),)
    confounds = ("mass", "first moments")
    needs = "Logs with and without the load, through postures in which gravity pulls along every axis of the hand."
    coordinate = "time"

    def present(self, signals: LinkSignals, shape: tuple[float, ...]) -> float:
        return float(signals.number < 0 or signals.number >= shape[0])

    def applies(self, signals: LinkSignals) -> bool:
        return signals.carries_nothing


EFFECT = Payload()
