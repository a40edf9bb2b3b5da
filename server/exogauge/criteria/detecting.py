"""When logs are not what they seem: when they are said to have been low-passed before they were stored, when something
touched the robot, and when the data contradict a number of the maker."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import criterion, derived, judgement, measured

RULES = "docs/decisions/0011-rules-of-single-effects.md, stored low-passes"


@final
@dataclass(frozen=True)
class StoredFilter:
    """What is asked of held-out logs is in `Judging`."""

    most: float = criterion(
        0.5,
        "1",
        "of the middle joint's square error: little else takes that from all joints, and `judging.sure` will do",
        judgement(f"{RULES}: made on 18 cases"),
    )
    joints: float = criterion(
        0.75,
        "1",
        "of the joints have to gain: every joint passes a stored low-pass, presliding is one's own",
        judgement(RULES),
    )
    alike: float = criterion(1.5, "1", "ratio of the edges of logs that were stored alike", judgement(RULES))
    widths: float = criterion(
        3.0, "1", "factor around the usual shape's cut-off in which that of another shape is sought", judgement(RULES)
    )
    above_edge: float = criterion(4.0, "edges", "the highest cut-off that is tried", judgement(RULES))
    lowest_hz: float = criterion(
        0.5,
        "Hz",
        "the lowest that is tried: a gentle low-pass begins far below where its fall is seen",
        judgement(RULES),
    )
    coarse: float = criterion(1.25, "1", "factor from one cut-off that is tried first to the next", judgement(RULES))
    fine: int = criterion(9, "cut-offs", "tried around the best of them", judgement(RULES))
    near: float = criterion(1.2, "1", "factor to either side within which these lie", judgement(RULES))
    turn_s: float = criterion(0.1, "s", "a joint that turns round at once is at rest for no longer", judgement(RULES))
    forgotten_s: float = criterion(
        0.5, "s", "after a rest, and before one: by then a low-pass holds nothing of it", judgement(RULES)
    )
    least_s: float = criterion(
        2.0, "s", "of turns and motion; a joint with less is looked at as a whole", judgement(RULES)
    )


TOUCH = "docs/decisions/0011-rules-of-single-effects.md, contact"


@final
@dataclass(frozen=True)
class Touching:
    """gain: by which the weighted square error falls with a force at a link.
    level: what its root reaches by chance."""

    durations_s: tuple[float, ...] = criterion(
        (0.25, 0.5, 1.0), "s", "of pushes that are tried first", judgement(TOUCH)
    )
    usual_n: float = criterion(25.0, "N", "what a push is believed to be, one standard deviation", judgement(TOUCH))
    apart_s: float = criterion(1.5, "s", "between two bursts: what is nearer is one", judgement(TOUCH))
    most_bursts: int = criterion(3, "bursts", "in all logs: what comes more often is no accident", judgement(TOUCH))
    false_alarm: float = criterion(
        1e-4, "1", "chance per study that usual errors reach the level, as far as their tail says", judgement(TOUCH)
    )
    above_next: float = criterion(
        1.6, "1", "times the next moment that is no burst, in the square root of the gain", judgement(TOUCH)
    )
    explained: float = criterion(0.8, "1", "of a burst, by one force: else it is something else", judgement(TOUCH))
    largest_n: float = criterion(
        200.0, "N", "what asks for more force than this at one link is no touch", judgement(TOUCH)
    )
    briefest_s: float = criterion(
        0.11, "s", "gears jolt for as long as they swing; a hand, a cable or a table takes longer", judgement(TOUCH)
    )
    force_known: float = criterion(
        0.7, "std", "part of a force may be felt by no joint, however clear the push is", judgement(TOUCH)
    )
    one_axis: float = criterion(
        0.95, "1", "of the gain: seen by one joint alone, where friction and gears make bursts too", judgement(TOUCH)
    )
    wholly_seen: float = criterion(
        0.8, "1", "of a burst's time: less comes where the joint starts, stops or turns", judgement(TOUCH)
    )
    alone_above: float = criterion(
        5.0,
        "1",
        "times the next moment, in the square root of the gain: what starts and turns do, they do again",
        measured("docs/decisions/0005-missing-effects.md: of 400 blind cases one was let in at four times"),
    )
    far_above: float = criterion(1.5, "levels", "asked of what one joint alone shows", judgement(TOUCH))
    alike: float = criterion(1.25, "1", "ratio of speeds that count as alike", judgement(TOUCH))
    fewest: int = criterion(
        20,
        "samples",
        "as slow, elsewhere: with fewer the speed is one that the joint hardly ever has",
        judgement(TOUCH),
    )
    larger: float = criterion(3.0, "1", "times 95 % of what is unexplained at such speeds", judgement(TOUCH))
    tell_apart: float = criterion(
        15.0, "evidence", "between links: with less, another link explains it as well", judgement(TOUCH)
    )
    scale: float = criterion(
        0.03,
        "1",
        "to which a joint's torque is known: what it takes of the gain tells no links apart",
        measured(f"{TOUCH}: 20 blind cases"),
    )
    margin_s: tuple[float, float] = criterion(
        (0.05, 0.3),
        "s",
        "left out beside a push, at least and at most: its begin and end are known no better",
        judgement(TOUCH),
    )
    rounds: int = criterion(
        3, "identifications", "without the pushes, until the same are seen again; else none is sure", judgement(TOUCH)
    )
    same_s: float = criterion(0.5, "s", "between the begins of one push that was found twice", judgement(TOUCH))
    powers: tuple[float, ...] = criterion(
        (0.5, 1.0, 2.0),
        "1",
        "of the sine that a push rises and falls with: nearly constant, half a wave, bell",
        judgement(TOUCH),
    )
    bounds_s: tuple[float, float] = criterion(
        (0.1, 2.5), "s", "shortest and longest push that is tried", judgement(TOUCH)
    )
    least_n: float = criterion(1.0, "N", "force that the doubt of its moment takes for granted", judgement(TOUCH))
    level_s: float = criterion(
        4.0,
        "s",
        "a running median over this is no burst: drifts, a load put down, an anchor that slipped",
        judgement(TOUCH),
    )
    speeds: int = criterion(5, "parts", "of an axis' speeds, in each of which its own error is usual", judgement(TOUCH))
    rows: int = criterion(20, "rows", "of a kind, below which nothing is usual", judgement(TOUCH))
    most: float = criterion(
        0.9, "1", "share of errors whose size says what is usual, beside the median", judgement(TOUCH)
    )
    most_std: float = criterion(1.645, "std", "that hold that share", derived("normal distribution, 90 %"))
    mad_std: float = criterion(
        1.4826, "1", "a standard deviation over a median of sizes", derived("normal distribution")
    )
    nearest_m: float = criterion(
        0.03, "m", "how far from a link's middle it is pushed, at least, one standard deviation", judgement(TOUCH)
    )
    of_length: float = criterion(0.3, "1", "of the link's length, if that is more", judgement(TOUCH))


NUMBERS = "docs/decisions/0005-missing-effects.md, 0011"


@final
@dataclass(frozen=True)
class Contradicting:
    """Which link or motor is asked, what may be wrong with it, and which odds are enough."""

    sure: float = criterion(
        9.0,
        "evidence",
        "for letting a number go: odds of 90, as some twenty numbers are looked at",
        derived("2 ln 90 = 9.0"),
    )
    most: int = criterion(
        2, "numbers", "named in one study: with more it is the description that is wrong", judgement(NUMBERS)
    )
    base_turns: float = criterion(
        0.02,
        "rad/s",
        "rms angular velocity of a floating base, below which its accelerometer says nothing beside gravity",
        judgement(NUMBERS),
    )
    tilts: float = criterion(
        0.15, "rad", "rms turn of gravity in a body's frame that shows its weight", judgement(NUMBERS)
    )
    mass_kg: float = criterion(
        1.0, "kg", "what might hang on a link, one standard deviation of a broad belief", judgement(NUMBERS)
    )
    reach_m: float = criterion(0.1, "m", "how far from the link's frame it might hang", judgement(NUMBERS))
    broad_share: float = criterion(0.5, "1", "by which a link may be of another density", judgement(NUMBERS))
    broad_gain: float = criterion(0.25, "1", "by which a motor may give something else", judgement(NUMBERS))
    centre: float = criterion(
        0.1, "1", "of a first moment's doubt that is about where the centre lies, at least", judgement(NUMBERS)
    )
    second_moments: float = criterion(
        2.0,
        "1",
        "times the doubt of a mass: how far the model's prior lets inertias go",
        derived("identification.prior"),
    )
    torque_doubt: float = criterion(
        0.02, "1", "of a logged torque: what a calibration leaves, of which no maker writes", judgement(NUMBERS)
    )
    most_alike: int = criterion(2, "numbers", "told beside one that was named, as also possible", judgement(NUMBERS))
