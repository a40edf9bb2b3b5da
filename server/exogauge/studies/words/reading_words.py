"""How to read a number that stands beside another one: sentences that the report and the page share."""

from __future__ import annotations

READING = {
    "steady": (
        "The total may exceed the floor although the model is right where it claims to be: a joint at rest takes any "
        "friction between two limits, so its torque is predictable only to an interval, and starts, stops and turns, "
        "which are in the total but in neither part, move the friction by its whole size within few samples. Steady "
        "motion is what the friction model is made for: compare that column with the floor."
    ),
    "steady_seconds": (
        "Seconds in which each joint moved steadily, of those in which it moved at all, over the fitted and over the "
        "held-out logs. Only steady motion gives the joint's equation its rows. A joint that moved steadily in one "
        "direction only cannot tell its Coulomb friction from its offset."
    ),
    "support_table": (
        "Each number of the table is one of the whole motion, over all its trials: the peak is the largest mean over "
        "0.2 s, the mean and the integral are over all samples. ± is one standard deviation of that number."
    ),
    "support_interval": (
        "A range at rest, such as −14.3 … 7.93, is not the doubt of a mean: it is what a single sample leaves open. "
        "While the joint stands still its friction may hold any part of the load, so the torque lies between two "
        "limits; the line is drawn at one value between them. The tables tell means and peaks of that line over the "
        "whole motion, with their own standard deviation."
    ),
}
"""By what they explain; `reading` of results.json."""
