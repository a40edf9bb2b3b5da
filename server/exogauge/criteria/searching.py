"""How the search on the robot tries, judges, adds and takes back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import criterion, derived, judgement, measured
from exogauge.criteria.judging import MISSING

RULES = "docs/decisions/0011-rules-of-single-effects.md"
CREEPING = "docs/decisions/0010-creeping.md"


@final
@dataclass(frozen=True)
class Searching:
    """Names of units as in `Judging`."""

    most_effects: int = criterion(
        6, "rounds", "that act on the same rows: more are not told apart by a few logs", judgement(MISSING)
    )
    most_rounds: int = criterion(
        12, "rounds", "of a search, wherever they act: each costs as much as the first", judgement(MISSING)
    )
    judged: int = criterion(
        12,
        "candidates",
        "per round, of sensors and of the robot each: the best by evidence, refined and judged",
        judgement(MISSING),
    )
    hint: float = criterion(
        12.0,
        "evidence",
        "that waves of one order alone have to gain, before an order off the grid is tried: many orders are looked at",
        judgement(MISSING),
    )
    clear: float = criterion(
        60.0,
        "evidence",
        "of the fitted logs, from which held-out ones have one claim left to confirm, not one of many",
        judgement(MISSING),
    )
    sure_if_clear: float = criterion(2.5, "z", "asked of held-out logs of such a claim", judgement(MISSING))
    sure_fitted: float = criterion(
        2.5,
        "z",
        "asked of the fitted logs: their blocks show whether one moment alone asked for the effect",
        judgement(MISSING),
    )
    once_if_clear: float = criterion(
        4.0, "z", "asked in place of `judging.once` where `once_nearly_all` of the error goes", judgement(MISSING)
    )
    once_nearly_all: float = criterion(
        0.9, "1", "share of the square error of these logs, of which little else takes as much", judgement(MISSING)
    )
    slow: float = criterion(0.5, "rms velocities", "below: the regime of low speed", judgement(MISSING))
    fast: float = criterion(1.2, "rms velocities", "above: the regime of high speed", judgement(MISSING))
    better: float = criterion(
        10.0,
        "evidence",
        "by which another effect has to beat one that was named, to take its place: odds of 150 to one",
        derived("2 ln 150 = 10.02"),
    )
    not_needed: float = criterion(
        1.005,
        "1",
        "held-out error without an effect over that with it, up to which it is not needed",
        derived("half a unit of the third digit"),
    )
    surely_needed: float = criterion(
        1.05,
        "1",
        "the same of the fitted logs, of the rows that it acts on, from which it is needed unasked: ten times that",
        derived("1 + 10 (1.005 - 1)"),
    )
    relinearised: int = criterion(
        2,
        "identifications",
        "with an effect that depends on what the bodies weigh: the first one's were bent by it",
        judgement(MISSING),
    )
    turned: int = criterion(
        4,
        "identifications",
        "with a base that is turned: what it does is the turn times the bodies, and each finds both better",
        measured(
            "tests/discrepancy/test_sensor_effects.py, 6.7 degrees: the angle is 0.4 % off after two, 0.04 % after four"
        ),
    )
    matters: float = criterion(
        0.5,
        "noise floors",
        "what takes less off the held-out error matters to no reader: the error falls by 12 % of a floor at most",
        derived("√(1 + 0.5²) = 1.118"),
    )
    remainder: float = criterion(
        0.25,
        "1",
        "of what was named at the same place: less may be what that one's formula does not hold",
        judgement(MISSING),
    )
    of_the_curve: float = criterion(
        0.5,
        "1",
        "the same where both are curves over one coordinate, such as velocity: no real curve is a formula",
        judgement(MISSING),
    )
    common: int = criterion(
        2,
        "places",
        "at which an effect is named elsewhere, from which on it is no remainder of another one here",
        judgement(MISSING),
    )
    odd: float = criterion(
        1.5,
        "1",
        "times the fitted logs' error on the same channel: a held-out log that errs so is fitted for a try",
        judgement(MISSING),
    )
    soft_left: float = criterion(
        0.25,
        "noise floors",
        "that soft friction may lack of Coulomb's in a row: 3 % of the error, were it so in every row",
        derived("√(1 + 0.25²) = 1.031"),
    )
    trials: int = criterion(
        40, "fits", "of a search for a shape, per shape: then it has settled or will not", judgement(MISSING)
    )
    starts: int = criterion(
        2, "starts", "where shapes trade against each other, one start may end beside the summit", judgement(MISSING)
    )
    swallowed: float = criterion(
        0.5,
        "1",
        "of the evidence that a search begins with: what is left of it where a shape counts for nothing",
        judgement(MISSING),
    )
    broadly: tuple[float, float, float] = criterion(
        (0.08, 0.01, 1e-3),
        "ranges, ranges, gains",
        "first and last step of a shape, and the gain that a last step is worth, for all that are compared",
        judgement(MISSING),
    )
    closely: tuple[float, float, float] = criterion(
        (0.004, 1e-4, 1e-5),
        "ranges, ranges, gains",
        "the same of what is added: a wave's length over a wide range has to be known to a thousandth",
        measured(f"{MISSING}: a hundredth was not enough"),
    )
    shapes_above: float = criterion(
        1.05,
        "noise floors",
        "left of a channel, below which no shape is sought again: nothing is left to gain",
        judgement(RULES),
    )
    shapes_better: float = criterion(
        0.98, "1", "of the held-out error, that a new shape may leave at most", judgement(RULES)
    )
    remainder_above: float = criterion(
        1.1, "noise floors", "left of a channel, below which no remainder is sought", judgement(MISSING)
    )
    bend_sure: float = criterion(
        2.0,
        "z",
        "by which held-out error has to fall for a curve of its own: few are tried, and none gets a name",
        judgement(RULES),
    )
    bend_least: float = criterion(
        0.25,
        "noise floors",
        "that a curve of its own, or a remainder, has to take off the held-out error",
        judgement(RULES),
    )
    covered: float = criterion(
        0.98,
        "1",
        "quantile of a log's samples that says how far it reaches: a few samples cover nothing",
        judgement(RULES),
    )
    beyond: float = criterion(
        0.1,
        "1",
        "of what was fitted, that held-out logs go beyond before a law is said to be continued",
        judgement(RULES),
    )
    part: float = criterion(
        1.5,
        "1",
        "times the mean square error of a channel, in a third of its samples, from which that third is told",
        judgement(MISSING),
    )
    moments: float = criterion(
        0.1,
        "1",
        "share of all blocks that hold `of_moments` of the square error, up to which it sits in moments",
        judgement(MISSING),
    )
    of_moments: float = criterion(2.0 / 3.0, "1", "most of the square error", judgement(MISSING))
    told_rows: int = criterion(10, "rows", "of a channel, below which nothing is said of its error", judgement(MISSING))
    row_memory: float = criterion(
        2.5,
        "rows",
        "that count as one: so many stand to a period of the cut-off",
        derived("rate at which rows are kept"),
    )
    least_memory: float = criterion(
        4.0,
        "rows",
        "that count as one at least, where the maker's numbers are doubted: every one of them has all rows against it",
        judgement(RULES),
    )
