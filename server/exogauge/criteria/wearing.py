"""What a device's bands do that nobody stated: how it is searched, judged and named."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import convention, criterion, derived, judgement

RULES = "docs/decisions/0008-effects-of-bands.md"


@final
@dataclass(frozen=True)
class Wearing:
    """What is asked of any name is in `Judging`."""

    most_folds: int = criterion(5, "folds", "repetitions or motions, each left out in turn", judgement(RULES))
    parts: int = criterion(3, "parts", "of a single log, each left out in turn", judgement(RULES))
    shortest_part_s: float = criterion(6.0, "s", "that such a part lasts at least", judgement(RULES))
    evidence_once: float = criterion(
        40.0,
        "evidence",
        "asked of an effect of one moment, which nothing that was left out can confirm",
        judgement(RULES),
    )
    spread_once: float = criterion(
        2.0, "z", "asked of its gain by blocks: it must not be one moment's alone", judgement(RULES)
    )
    acts: float = criterion(
        0.3, "1", "of an effect's torque on the joint that feels it most, from which a joint is asked", judgement(RULES)
    )
    of_support: float = criterion(
        0.02, "1", "of the supporting torque: a smaller effect is not worth a name", judgement(RULES)
    )
    beyond: float = criterion(
        1.3, "std", "stated doubts within which a value is no news: a maker's catalogue is no better", judgement(RULES)
    )
    trials: int = criterion(14, "fits", "of a search for a shape, per shape", judgement(RULES))
    shape_worth: float = criterion(4.0, "1", "of the cost, in independent errors: less is chance", judgement(RULES))
    first_step: float = criterion(0.08, "1", "of a shape's range, with which its search begins", judgement(RULES))
    fine: int = criterion(
        12, "values", "of a grid, beyond which the first step is half of one of its steps", judgement(RULES)
    )
    joint_moves: float = criterion(
        0.05, "rad or m", "travel of a joint from which it can show what pulls at it", judgement(RULES)
    )
    most_crossed: int = criterion(4, "joints", "between the ends of a wire that is tried", judgement(RULES))
    lightest: float = criterion(
        0.01, "1", "of the robot's mass, of a link whose inertia says how large it is", judgement(RULES)
    )
    least_travel_m: float = criterion(0.005, "m", "of a wire that motions stretch", judgement(RULES))
    likely: int = criterion(3, "1", "joints that are followed up, and wires that are judged", judgement(RULES))
    furthest_m: float = criterion(0.2, "m", "by which the ends of a wire are led better", judgement(RULES))
    wire_worth: float = criterion(
        6.0,
        "evidence",
        "of a wire that nobody declared, beyond what the number of tries gives by chance",
        derived("2 ln 20 = 5.99"),
    )
    most_effects: int = criterion(
        4, "effects", "that are named of one device: beyond, the formulas fit what others leave", judgement(RULES)
    )
    worth_judging: float = criterion(
        6.0, "evidence", "of a candidate from which the fits that judge it are spent on it", derived("2 ln 20 = 5.99")
    )
    judged: int = criterion(8, "candidates", "with most evidence that are judged in a round", judgement(RULES))
    remainder: float = criterion(
        0.2,
        "1",
        "of what a named effect explained on a joint: less may be what its formula leaves of a real band",
        judgement(RULES),
    )
    remainder_of_wire: float = criterion(
        0.5,
        "1",
        "the same of a wire that nobody declared: it can run anywhere, and so fits what any formula leaves",
        judgement(RULES),
    )
    clear: float = criterion(
        1.5,
        "floors",
        "that a further band may leave on its joint for others to be looked at beside it",
        judgement(RULES),
    )
    tell_apart: float = criterion(
        2.0,
        "std errors",
        "by which the winner must explain more than a rival that is told not to be it",
        convention("two standard errors, 95 %"),
    )
    nearly_sure: float = criterion(
        2.0,
        "std errors",
        "from which a rival is no worse an answer, though it could not be claimed alone",
        convention("two standard errors, 95 %"),
    )
