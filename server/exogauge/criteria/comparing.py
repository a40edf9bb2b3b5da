"""When the doctor doubts a log because it contradicts the robot's description."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import criterion, derived, judgement, measured

RULES = "docs/doctor.md"


@final
@dataclass(frozen=True)
class Comparing:
    """log likelihood: of efforts given positions, counted in moments that are independent of each other."""

    most_logs: int = criterion(6, "logs", "that are looked at: a slip of a mapping is in all of them", judgement(RULES))
    rough: float = criterion(
        1.5,
        "1",
        "times the stated doubt of inertial parameters: stock descriptions are rougher than that",
        judgement(RULES),
    )
    moving: float = criterion(0.1, "1", "of an axis' usual speed, from which on it counts as moving", judgement(RULES))
    moving_least: float = criterion(
        0.002, "rad/s or m/s", "from which on an axis counts as moving at all", judgement(RULES)
    )
    fewest: int = criterion(
        20,
        "moments",
        "in motion: at rest friction holds a joint, and its effort says nothing of the load",
        judgement(RULES),
    )
    decisive: float = criterion(
        12.0,
        "log likelihood",
        "over the description as it stands: hundreds of slips are tried on rough descriptions",
        judgement(RULES),
    )
    doubted: float = criterion(
        5.0, "log likelihood", "that another factor gains, from which an axis is in doubt", judgement(RULES)
    )
    undecided: float = criterion(
        4.0, "log likelihood", "between two remedies that the data do not decide", judgement(RULES)
    )
    as_good_as: float = criterion(
        2.0,
        "logs",
        "that any number of them counts as: what a description lacks it lacks in every log",
        judgement(RULES),
    )
    misfit: float = criterion(
        0.2,
        "1",
        "of an axis' effort that is left, from which it is in doubt",
        measured("recorded robots with stock descriptions: 0.03 to 0.17 are left"),
    )
    most_slips: int = criterion(
        6, "slips", "in one study: who has more has one that was not thought of", judgement(RULES)
    )
    most_doubted: int = criterion(6, "joints", "for which slips are tried, the worst first", judgement(RULES))
    far: float = criterion(3.0, "1", "times a limit of the description: no joint was driven there", judgement(RULES))
    delay: float = criterion(
        20.0,
        "log likelihood",
        "over no delay, before one is told",
        measured("recordings without a delay: a joint gained 11 at most (UR10, wrist_2)"),
    )
    delay_agrees: float = criterion(
        3.0,
        "log likelihood",
        "of a joint that is alike late: chance gives 2",
        derived("the best of some shifts by chance"),
    )
    delay_falls: float = criterion(
        0.9, "1", "of what is unexplained may be left once a delay is undone", judgement(RULES)
    )
    delay_samples: float = criterion(
        3.0, "samples", "a drive, a bus and a filter are late by as many, and nobody minds", judgement(RULES)
    )
    delay_least_s: float = criterion(0.015, "s", "a shorter delay is not told", judgement(RULES))
    mostly: float = criterion(0.3, "1", "of the samples in motion that may be exactly zero", judgement(RULES))
    beyond_effort: float = criterion(
        10.0, "1", "times the URDF's limit: not a limit that was set too low", judgement(RULES)
    )
    beyond_speed: float = criterion(
        5.0, "1", "times the URDF's limit: not a limit that was set too low", judgement(RULES)
    )
    high: float = criterion(0.99, "1", "of the moments lie below what counts as largest", judgement(RULES))
    driven: float = criterion(
        5.0, "1", "times what its load varies: a joint that stands still is not driven so", judgement(RULES)
    )
    weighs: float = criterion(
        0.2,
        "1",
        "by which the contacts' force may miss m |a|: beyond, something else bears the robot",
        judgement(RULES),
    )
    most_moments: float = criterion(0.5, "1", "of a log, in which contacts have to bear the robot", judgement(RULES))
    halved: float = criterion(
        0.5, "1", "of the angle may be left: else it may be lean, sway or a foot's frame", judgement(RULES)
    )
