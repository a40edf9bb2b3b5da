"""A load that is picked up between two logs."""

from __future__ import annotations

from typing import final

from exogauge.effects.effect import Quantity
from exogauge.effects.order import present, since_log
from exogauge.effects.places import LinkSignals


@final
class Payload:
    """From log `since` on (counted from 0 in the order of the study) the hand or tool carries mass m at c.

    One that is there from the first log on is part of the link's inertia, and told by its distance from what the maker
    states. The load's own rotational inertia is neglected.
    """

    name = "payload"
    words = "a payload"
    place = "link"
    sentence = "It carries a load that it did not carry in the first logs."
    coefficients = (
        Quantity("mass", "kg", low=0.0, words="mass that was picked up"),
        Quantity("mx", "kg·m", words="its mass times its place along x of the link"),
        Quantity("my", "kg·m", words="its mass times its place along y of the link"),
        Quantity("mz", "kg·m", words="its mass times its place along z of the link"),
    )
    shapes = (since_log(),)
    confounds = ("mass", "first moments")
    needs = "Logs with and without the load, through postures in which gravity pulls along every axis of the hand."
    coordinate = "time"

    def present(self, signals: LinkSignals, shape: tuple[float, ...]) -> float:
        return float(present(self.shapes, shape, signals.number))

    def applies(self, signals: LinkSignals) -> bool:
        return signals.carries_nothing


EFFECT = Payload()
