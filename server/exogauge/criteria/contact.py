"""When something is said to have touched the robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import criterion, derived, judgement, measured

RULES = "docs/decisions/0011-rules-of-single-effects.md, contact"


@final
@dataclass(frozen=True)
class Touching:
    """gain: by which the weighted square error falls with a force at a link.
    level: what its root reaches by chance."""

    durations_s: tuple[float, ...] = criterion(
        (0.25, 0.5, 1.0), "s", "of pushes that are tried first", judgement(RULES)
    )
    usual_n: float = criterion(25.0, "N", "what a push is believed to be, one standard deviation", judgement(RULES))
    apart_s: float = criterion(1.5, "s", "between two bursts: what is nearer is one", judgement(RULES))
    most_bursts: int = criterion(3, "bursts", "in all logs: what comes more often is no accident", judgement(RULES))
    false_alarm: float = criterion(
        1e-4, "1", "chance per study that usual errors reach the level, as far as their tail says", judgement(RULES)
    )
    above_next: float = criterion(
        1.6, "1", "times the next moment that is no burst, in the square root of the gain", judgement(RULES)
    )
    explained: float = criterion(0.8, "1", "of a burst, by one force: else it is something else", judgement(RULES))
    largest_n: float = criterion(
        200.0, "N", "what asks for more force than this at one link is no touch", judgement(RULES)
    )
    briefest_s: float = criterion(
        0.11, "s", "gears jolt for as long as they swing; a hand, a cable or a table takes longer", judgement(RULES)
    )
    force_known: float = criterion(
        0.7, "std", "part of a force may be felt by no joint, however clear the push is", judgement(RULES)
    )
    one_axis: float = criterion(
        0.95, "1", "of the gain: seen by one joint alone, where friction and gears make bursts too", judgement(RULES)
    )
    wholly_seen: float = criterion(
        0.8, "1", "of a burst's time: less comes where the joint starts, stops or turns", judgement(RULES)
    )
    alone_above: float = criterion(
        5.0,
        "1",
        "times the next moment, in the square root of the gain: what starts and turns do, they do again",
        measured("docs/decisions/0005-missing-effects.md: of 400 blind cases one was let in at four times"),
    )
    far_above: float = criterion(1.5, "levels", "asked of what one joint alone shows", judgement(RULES))
    alike: float = criterion(1.25, "1", "ratio of speeds that count as alike", judgement(RULES))
    fewest: int = criterion(
        20,
        "samples",
        "as slow, elsewhere: with fewer the speed is one that the joint hardly ever has",
        judgement(RULES),
    )
    larger: float = criterion(3.0, "1", "times 95 % of what is unexplained at such speeds", judgement(RULES))
    tell_apart: float = criterion(
        15.0, "evidence", "between links: with less, another link explains it as well", judgement(RULES)
    )
    scale: float = criterion(
        0.03,
        "1",
        "to which a joint's torque is known: what it takes of the gain tells no links apart",
        measured(f"{RULES}: 20 blind cases"),
    )
    margin_s: tuple[float, float] = criterion(
        (0.05, 0.3),
        "s",
        "left out beside a push, at least and at most: its begin and end are known no better",
        judgement(RULES),
    )
    rounds: int = criterion(
        3, "identifications", "without the pushes, until the same are seen again; else none is sure", judgement(RULES)
    )
    same_s: float = criterion(0.5, "s", "between the begins of one push that was found twice", judgement(RULES))
    powers: tuple[float, ...] = criterion(
        (0.5, 1.0, 2.0),
        "1",
        "of the sine that a push rises and falls with: nearly constant, half a wave, bell",
        judgement(RULES),
    )
    bounds_s: tuple[float, float] = criterion(
        (0.1, 2.5), "s", "shortest and longest push that is tried", judgement(RULES)
    )
    least_n: float = criterion(1.0, "N", "force that the doubt of its moment takes for granted", judgement(RULES))
    level_s: float = criterion(
        4.0,
        "s",
        "a running median over this is no burst: drifts, a load put down, an anchor that slipped",
        judgement(RULES),
    )
    speeds: int = criterion(5, "parts", "of an axis' speeds, in each of which its own error is usual", judgement(RULES))
    rows: int = criterion(20, "rows", "of a kind, below which nothing is usual", judgement(RULES))
    most: float = criterion(
        0.9, "1", "share of errors whose size says what is usual, beside the median", judgement(RULES)
    )
    most_std: float = criterion(1.645, "std", "that hold that share", derived("normal distribution, 90 %"))
    mad_std: float = criterion(
        1.4826, "1", "a standard deviation over a median of sizes", derived("normal distribution")
    )
    nearest_m: float = criterion(
        0.03, "m", "how far from a link's middle it is pushed, at least, one standard deviation", judgement(RULES)
    )
    of_length: float = criterion(0.3, "1", "of the link's length, if that is more", judgement(RULES))
