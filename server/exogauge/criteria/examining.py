"""When the doctor doubts a log, from its signals alone.

When the doctor doubts a log because it contradicts the robot's description.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import criterion, derived, judgement, measured

RULES = "docs/doctor.md"


@final
@dataclass(frozen=True)
class Examining:
    """rms change: of a channel from one sample to the next."""

    densest: float = criterion(
        22_600.0,
        "kg/m³",
        "of half of a robot's mass: osmium, the densest there is. 84 URDFs have 37 to 6 700",
        derived("handbook value at 20 °C"),
    )
    lightest: float = criterion(
        1.2, "kg/m³", "the same of what is lighter than any robot: air", derived("handbook value at 20 °C and 1 bar")
    )
    turned: float = criterion(
        18.0,
        "rad",
        "median end of the joints that turn, beyond which it is in degrees. Of 127 stock URDFs the largest is 10",
        judgement("docs/measured/stock-robots.md"),
    )
    rate: float = criterion(0.02, "1", "by which a log's rate may differ from the declared one", judgement(RULES))
    slowest_rate_hz: float = criterion(
        25.0,
        "Hz",
        "below which it is told: a turn takes a joint some tenths of a second, and few samples are left of it",
        measured(
            "docs/measured/humanoid-of-other-code.md: at 10 Hz 44 of 53 joint parameters inside 95 %, at 200 Hz all"
        ),
    )
    rate_wrong: float = criterion(
        0.5, "1", "beyond that the declaration or the unit of time is wrong, not the clock", judgement(RULES)
    )
    jitter: float = criterion(
        0.2, "1", "spread of the sample periods (1 % to 99 %), of their median, that is told", judgement(RULES)
    )
    late: float = criterion(
        0.5, "1", "of the median period, by which a single one is off before it is told", judgement(RULES)
    )
    gap: float = criterion(
        5.0, "periods", "without a sample, from which on it is a gap and no jitter", judgement(RULES)
    )
    clipped_run: int = criterion(
        5, "samples", "in a row at an extreme, or at one value, before it is told", judgement(RULES)
    )
    clipped_count: int = criterion(
        10, "samples", "at an extreme in all, before a channel is said to be clipped", judgement(RULES)
    )
    clipped_speed: float = criterion(
        0.3, "rms changes", "a clipped signal arrives at its limit in full swing", judgement(RULES)
    )
    approach: int = criterion(8, "samples", "before an extreme, in which its arrival is looked at", judgement(RULES))
    frozen_s: float = criterion(
        0.25, "s", "at one value, of a channel that changes all the time, before it is told", judgement(RULES)
    )
    frozen_share: float = criterion(
        0.02,
        "1",
        "of a log, for which a wrench or an IMU may stand while joints move, before the log is spoiled",
        judgement(RULES),
    )
    in_motion: float = criterion(
        0.1, "1", "of a position's range, from which on a joint moved meanwhile", judgement(RULES)
    )
    unloaded: float = criterion(
        0.2, "1", "of the weight: a foot that reads less is in the air where the others bear the rest", judgement(RULES)
    )
    alive: float = criterion(
        0.2, "1", "of the samples may repeat in a channel that is expected to change all the time", judgement(RULES)
    )
    shared_samples: int = criterion(
        50, "samples", "in a row that read alike in two logs, before they count as the same", judgement(RULES)
    )
    coarse_bits: float = criterion(
        6.0, "bits", "over a channel's range, below which its steps are warned of", judgement(RULES)
    )
    noted_bits: float = criterion(
        10.0, "bits", "over a channel's range, below which its steps are noted", judgement(RULES)
    )
    noise_samples: int = criterion(400, "samples", "with fewer nothing is said of a channel's noise", judgement(RULES))
    noise_above: float = criterion(
        0.25, "1", "of the sampling rate: above is no motion, so noise is seen there", judgement(RULES)
    )
    noisy: float = criterion(3.0, "1", "times the declared noise, before it is told", judgement(RULES))
    still_steps: float = criterion(
        8.0, "steps", "of its resolution: a joint that moves less does not move", judgement(RULES)
    )
    most_amperes: float = criterion(
        200.0, "A", "no joint of a robot that a person can stand beside takes more", judgement(RULES)
    )
    around: int = criterion(
        8, "changes", "of a position before and after a step, by which it is judged", judgement(RULES)
    )
    jump: float = criterion(
        5.0, "1", "times the median of these, from which a step of a position may be a jump", judgement(RULES)
    )
    jump_speed: tuple[float, float] = criterion(
        (2.0, 5.0),
        "1",
        "times the joint's limit, else its top speed otherwise, from which a jump is warned of, and is an error",
        measured("a walking iCub, 100 Hz: 14 jumps of 2 to 3.1 where samples were lost"),
    )
    jumps: float = criterion(0.01, "1", "of all steps, at most: what jumps more often is noise", judgement(RULES))
    far_beyond: float = criterion(
        3.0, "spans", "of its limits, by which a position in degrees lies beyond them at the least", judgement(RULES)
    )
    longest_lag_s: float = criterion(0.25, "s", "by which a velocity is tried to be late or early", judgement(RULES))
    unlike: float = criterion(0.9, "1", "correlation below which dq is not the derivative of q", judgement(RULES))
    lag_samples: float = criterion(
        1.0,
        "samples",
        "a backward difference lags by half a sample: up to here that is noted, not warned of",
        derived("(q_k - q_{k-1}) / T is the velocity of half a sample before"),
    )
    noted_lag: float = criterion(0.3, "samples", "by which a velocity is late before it is noted", judgement(RULES))
    scale: float = criterion(
        0.1, "1", "by which a velocity may be larger or smaller than the derivative", judgement(RULES)
    )
    attenuation: float = criterion(
        0.8,
        "1",
        "of the upper half of the motion's band against the lower: below, a velocity was filtered",
        judgement(RULES),
    )
    moves: float = criterion(
        5.0, "1", "times the noise of its derivative: only then is there a velocity to compare with", judgement(RULES)
    )
    resting: float = criterion(
        0.3, "1", "of the samples, those with the least rotation, count as rest", judgement(RULES)
    )
    gravity: float = criterion(0.05, "1", "by which the acceleration at rest may differ from gravity", judgement(RULES))
    tilt_hz: float = criterion(1.0, "Hz", "below, an accelerometer sees the direction of gravity", judgement(RULES))
    steady: float = criterion(
        0.2, "1", "variation of the slow acceleration up to which its direction is that of gravity", judgement(RULES)
    )
    tilt_rate: float = criterion(0.02, "rad/s", "rms: slower tilting says nothing about the gyro", judgement(RULES))
    levers_m: tuple[float, float] = criterion(
        (1.5, 1.0),
        "m",
        "below and above the IMU, to the point about which a base turns at most: a humanoid's ankles, a crane's hook",
        judgement(RULES),
    )
    gyro_noise: float = criterion(
        3.0,
        "1",
        "times what white noise, as seen above the motion, has below tilt_hz: a gyro that tells no more tells nothing",
        measured("a gyro that turns: 54 at the least, a simulated body at 0.02 rad/s; a walking iCub 61"),
    )
    level_m: float = criterion(
        0.1,
        "m",
        "rms, by which a base may sway without turning at all: beyond, gravity did turn in the accelerometer",
        judgement(RULES),
    )
    gyro_unlike: float = criterion(
        0.5, "1", "likeness with gravity's motion below which the gyro's axes are in doubt", judgement(RULES)
    )
    gyro_alike: float = criterion(
        0.9, "1", "likeness from which an exchange of its axes explains what is seen", judgement(RULES)
    )
    more_alike: float = criterion(
        0.5, "1", "of what the second best of 48 exchanges of axes misses of full likeness", judgement(RULES)
    )
    whole_numbers: int = criterion(
        10, "values", "that a position takes, all of them whole numbers, for them to be counts", judgement(RULES)
    )
    weight: float = criterion(0.1, "1", "by which the feet may carry more or less than the weight", judgement(RULES))
    weight_sign: float = criterion(
        0.25,
        "1",
        "the same where the sign, or another axis, is asked for: another error may be there too",
        judgement(RULES),
    )


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
    slowest_hz: float = criterion(1.0, "Hz", "cut-off of the low-pass for a comparison, at least", judgement(RULES))
    fastest_hz: float = criterion(
        8.0, "Hz", "the same, at most: gravity and inertia of a robot's motion lie below", judgement(RULES)
    )
    unmodelled: tuple[float, ...] = criterion(
        (0.05, 0.1, 0.2, 0.4),
        "of an effort's rms",
        "tried for friction that is no straight line, ripple, what nobody described",
        judgement(RULES),
    )
    offset: float = criterion(0.3, "of an effort's rms", "std of what is constant in it", judgement(RULES))
    independent: float = criterion(
        0.4, "1", "of all moments: what is left unmodelled is alike at neighbours", judgement(RULES)
    )
    moving: float = criterion(0.1, "1", "of an axis' usual speed, from which on it counts as moving", judgement(RULES))
    moving_least: float = criterion(
        0.002, "rad/s or m/s", "from which on an axis counts as moving at all", judgement(RULES)
    )
    slides: float = criterion(
        0.01,
        "rad or m",
        "since its last turn, from which on a joint slides: before, friction is a spring, and bears what it is asked",
        judgement("docs/doctor.md: gears creep by 0.3 to 5 mrad before they slide"),
    )
    bristles: tuple[float, ...] = criterion(
        (0.003, 0.01, 0.03),
        "rad or m",
        "ways over which friction may turn round, tried where efforts seem late: it comes late by itself",
        judgement("gears creep by .3 to 5 mrad before they slide, belts and cables further"),
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
    unlike: float = criterion(
        0.5,
        "1",
        "of an axis' effort that is left whatever is tried, from which it is told as unlike its description",
        judgement("docs/doctor.md: more than half; recorded robots leave 0.17 at most"),
    )
    others: float = criterion(
        3.0,
        "1",
        "times what is left of an axis' effort in every other log, by size and by share, from which one log is odd",
        measured("recordings and logs of three other robots as they are: 1.8 at most; one log with a slip: 5 to 50"),
    )
    held: float = criterion(
        0.2,
        "1",
        "of a log, for which a position stays at one number, from which it may be dead: a dwell is shorter",
        judgement(RULES),
    )
    most_slips: int = criterion(
        6, "slips", "in one study: who has more has one that was not thought of", judgement(RULES)
    )
    most_doubted: int = criterion(6, "joints", "for which slips are tried, the worst first", judgement(RULES))
    most_screened: int = criterion(
        8, "readings", "of positions that a screening leaves to be compared in full, at most", judgement(RULES)
    )
    screened: float = criterion(
        0.3, "1", "of what the best reading gains in a screening: who gains less is not compared", judgement(RULES)
    )
    far: float = criterion(3.0, "1", "times a limit of the description: no joint was driven there", judgement(RULES))
    sides_before: float = criterion(
        0.5,
        "1",
        "of how much the feet's moments change, or an exchange of feet changes them, that bodies as described have to "
        "leave unasked for: feet that are exchanged leave all of the latter",
        judgement(RULES),
    )
    sides_falls: float = criterion(0.5, "1", "of that may be left once two feet are exchanged back", judgement(RULES))
    apart_m: float = criterion(
        0.01, "m", "between two places about which a foot's moments are tried to be told", judgement(RULES)
    )
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
    delay_latest_s: float = criterion(
        1.0, "s", "by which the efforts of one log are tried to be late, as two loggers begin apart", judgement(RULES)
    )
    delay_far_s: float = criterion(
        0.12, "s", "beyond it a wrong model gains by a shift as well as a right one", judgement(RULES)
    )
    delay_far_falls: float = criterion(
        0.5, "1", "of what is unexplained may be left once such a delay is undone", judgement(RULES)
    )
    delay_samples: float = criterion(
        3.0, "samples", "a drive, a bus and a filter are late by as many, and nobody minds", judgement(RULES)
    )
    delay_least_s: float = criterion(0.015, "s", "a shorter delay is not told", judgement(RULES))
    imu_delay_least_s: float = criterion(
        0.1,
        "s",
        "the same of an IMU: `imu_delay`, which is first order in it, names a shorter one with its number",
        measured("a small floating robot, 20, 50, 70, 100 ms late: named as 19, 48, 67, 95; from 130 ms on not named"),
    )
    zero: float = criterion(
        8.0,
        "log likelihood",
        "over the zero as it is, before another is told",
        measured("recordings as they are: a joint gained 2.7 at most (Z1, joint2)"),
    )
    zero_falls: float = criterion(
        0.9, "1", "of what is unexplained may be left once another zero is undone", judgement(RULES)
    )
    zero_step: float = criterion(0.05, "rad", "from one zero that is tried to the next", judgement(RULES))
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
    bears: float = criterion(
        0.1, "1", "of what all feet bear: a foot that bears less may stand on an edge, or in the air", judgement(RULES)
    )
    halved: float = criterion(
        0.5, "1", "of the angle may be left: else it may be lean, sway or a foot's frame", judgement(RULES)
    )
