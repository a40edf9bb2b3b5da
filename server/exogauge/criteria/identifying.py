"""What counts as rest and as steady motion, when the data, not what was believed before, decide a number, and the
standard uncertainties that stand in where robot.yaml and device.yaml state none (GUM 4.3, type B).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import criterion, derived, judgement, measured

HERE = "server/exogauge/identification"


@final
@dataclass(frozen=True)
class Resting:
    """Of one axis in one log. velocity noise: standard deviation of what
    noise of positions makes of a velocity."""

    sigmas: float = criterion(
        3.0, "std", "of the velocity noise: below, an axis counts as at rest", measured("trials: 2 to 3 was best")
    )
    slowest: float = criterion(
        1e-6,
        "rad/s",
        "that counts as motion, however clean the log: what rounding makes of a constant is none",
        judgement(HERE),
    )
    share: float = criterion(
        1e-3, "1", "of the joint's top speed: what filters leave ringing after a stop is no motion", judgement(HERE)
    )
    smooth: float = criterion(
        3.0,
        "1",
        "times the band of a low-passed log: no joint that turns round bends its velocity faster than that",
        judgement(HERE),
    )
    barely: float = criterion(
        0.05,
        "samples",
        "turns of low-passed logs are known as well as that",
        measured("docs/decisions/0005-missing-effects.md: 0.03 samples in six blind cases"),
    )
    steady: float = criterion(0.98, "1", "of the low-passed direction: below, an axis rests or turns", judgement(HERE))
    recovery: float = criterion(
        0.7,
        "periods",
        "of the cut-off before and after that, until the axis counts as in steady motion",
        judgement(HERE),
    )
    starting: float = criterion(
        1.3,
        "periods",
        "of the cut-off before and after a rest, the same: when a joint starts is known less well than when it turns",
        judgement(HERE),
    )
    longest_step: float = criterion(1.5, "steps", "of the nominal sampling: a longer one is a gap", judgement(HERE))


@final
@dataclass(frozen=True)
class Identifying:
    """std before: what was believed of a parameter before the data."""

    at_rest: float = criterion(
        0.995,
        "1",
        "of the low-passed rest signal: above, an axis is at rest and hardly anything rings from its stop",
        judgement(HERE),
    )
    possible: tuple[float, float] = criterion(
        (0.02, 10.0), "1", "times the stated torque constant: no doubt about a motor reaches further", judgement(HERE)
    )
    decided: float = criterion(
        0.5, "std before", "that the data leave at most of a parameter that is said to be identifiable", judgement(HERE)
    )
    feet_against_mass: float = criterion(
        2.58, "z", "of the total mass by the contact sensors against the maker's: beyond, it is told", derived("99 %")
    )
    negative_mass: float = criterion(
        3.0, "std", "below zero, from which the data ask for a negative mass", judgement(HERE)
    )
    fixed: float = criterion(
        0.5, "std before", "that a load leaves at most of the common factor that it is said to fix", judgement(HERE)
    )
    never_weighed: float = criterion(
        10.0, "1", "times its mass, one standard deviation: a load that tells nothing of any scale", judgement(HERE)
    )
    gain_known: float = criterion(
        0.9,
        "1",
        "of what is known of a gain can be taken off: its std becomes 3.2 times as large at most",
        derived("1 / √(1 - 0.9) = 3.16"),
    )
    scatter: float = criterion(
        2.0,
        "1",
        "of the residuals at rest against those in motion, beyond which the largest friction was not always met",
        judgement(HERE),
    )
    rest_rows: int = criterion(5, "rows", "at rest, below which static friction is not looked at", judgement(HERE))
    least_rest: float = criterion(
        0.05,
        "1",
        "of an axis' rows: below, rest says nothing of sticking",
        measured("slow turns alone made 1.5 % of the rows look like rest"),
    )
    hardly: float = criterion(
        0.01, "1", "of a log in one direction: an axis that moves for less has no say in the bandwidth", judgement(HERE)
    )
    moved_s: float = criterion(1.0, "s", "a joint that moves for less was not meant to", judgement(HERE))
    least_sliding: float = criterion(
        0.5,
        "1",
        "of a joint's steady motion in which it has gone on as far as `comparison.slides` since its last turn: with "
        "less, its friction is mostly a gear that gives way",
        judgement("docs/measured/humanoid-of-other-code.md: a wrist that moves by 6 mrad to either side"),
    )
    most_steady: float = criterion(
        0.5, "1", "of all axes' motion that has to be steady at a bandwidth", judgement(HERE)
    )
    least_steady: float = criterion(
        0.2, "1", "of an axis' motion in one direction that has to be steady", judgement(HERE)
    )
    noisy: float = criterion(
        0.1,
        "1",
        "of an axis' mean square acceleration that may be noise of its position, where a lower cut-off is at hand",
        derived("drawn once more and taken off, a share r leaves inertias too small by 2 r²: 2 %"),
    )
    drowned: float = criterion(
        0.5,
        "1",
        "of half of the axes' mean square acceleration that is noise of positions: such a cut-off is not taken",
        derived("as much noise as motion: inertias come out half as large, and sure"),
    )
    enough_steady: float = criterion(
        0.25, "1", "of what a joint moves, in steady motion: below, the reader is warned", judgement(HERE)
    )
    no_matter: float = criterion(
        0.02,
        "1",
        "of the best held-out score of the prior's strengths: a smaller difference is of no use to anyone",
        judgement(HERE),
    )
    fewest_folds: int = criterion(
        2,
        "parts",
        "of logs with rows in them; with fewer nothing can be left out, and the maker's word counts as stated",
        derived("one part to fit, one to judge by"),
    )
    most_folds: int = criterion(
        32,
        "parts",
        "that are left out in turn; of more, neighbours are left out together. Each costs a solution for every "
        "strength, and a study of one hour would have hundreds",
        derived("the standard error of a mean of 32 is itself known to 1 / sqrt(2 · 31) = 13 %"),
    )


USUAL = "docs/decisions/0013-uncertainty-budget.md"
DRIFTS = "docs/decisions/0026-drift-through-a-session.md"
OFFSETS = "docs/decisions/0016-offsets-of-logs.md"
PRIOR = "server/exogauge/identification/prior.py"


@final
@dataclass(frozen=True)
class Declaring:
    """One standard deviation each."""

    ft_gain: float = criterion(
        0.01, "1", "calibration of one force/torque sensor: makers give 1 to 2 % of the full scale", judgement(USUAL)
    )
    ft_gain_common: float = criterion(
        0.01, "1", "of all force/torque sensors alike: the weight or bench that they were calibrated with",
        judgement(USUAL),
    )  # fmt: skip
    ft_tilt: float = criterion(
        0.0035, "rad", "a fifth of a degree about each axis, of a sensor bolted between flanges", judgement(USUAL)
    )
    ft_place: float = criterion(
        0.001, "m", "of a sensor's frame along each axis: links, flanges and their drawings", judgement(USUAL)
    )
    encoder_zero: float = criterion(
        0.002, "rad", "a tenth of a degree, of a joint that was set to a mark or against a stop", judgement(USUAL)
    )
    clock: float = criterion(
        0.001, "s", "between streams of one recording: a cycle of a bus, a fifth of a sample at 200 Hz",
        judgement(USUAL),
    )  # fmt: skip
    ft_zero_force: float = criterion(2.0, "N", "zero of a force that was not taken anew before a log", judgement(USUAL))
    ft_zero_moment: float = criterion(0.2, "N·m", "the same of a moment, at a tenth of a metre", judgement(USUAL))
    kt_drift: float = criterion(
        0.01, "1", "torque per ampere of a motor that warms by 10 K: magnets lose .1 % per K", judgement(USUAL)
    )
    viscous_drift: float = criterion(
        0.1,
        "1",
        "viscous friction of a drive that warms by 10 K, as kt_drift has it: grease loses 1 % of its viscosity per K "
        "at least",
        judgement(USUAL),
    )
    coulomb_drift: float = criterion(
        0.05, "1", "the same of Coulomb friction, which temperature moves less: half of it", judgement(USUAL)
    )
    alike: float = criterion(
        0.8,
        "1",
        "share of the variance of a drift or a zero that the logs with the device have in common: late in a session, "
        "what walks at random until then is .8 to 1 alike in them",
        judgement(USUAL),
    )
    partner_alike: float = criterion(
        0.7,
        "1",
        "correlation of a drift or a zero in a log with the device and in its partner without: what walks at random, "
        "halfway through a session and at its end",
        derived("square root of 1/2"),
    )
    motors_alike: float = criterion(
        0.5,
        "1",
        "share of the variance of a drift that all motors of a robot have in common: they warm in one session and one "
        "room, each by its own load and losses",
        judgement(DRIFTS),
    )
    warming_s: tuple[float, ...] = criterion(
        (300.0, 600.0, 1200.0, 2400.0, 4800.0),
        "s",
        "time constants by which a drive may warm or cool, any of them: 5 to 80 minutes, windings to housing",
        judgement(DRIFTS),
    )
    imu_tilt: float = criterion(0.009, "rad", "half a degree, of an IMU screwed to a link", judgement(USUAL))
    torque_zero: float = criterion(
        0.2,
        "N·m",
        "of a joint's torque (N where it slides), another in each log: a current that reads .2 % of 100 N·m at none",
        judgement(OFFSETS),
    )
    via_points: float = criterion(0.005, "m", "of a coordinate measured by tape over cloth", judgement(USUAL))
    donning: float = criterion(
        0.003, "m", "by which a band is longer in one log than in another, straps done up by hand", judgement(USUAL)
    )
    inertial: float = criterion(
        0.25, "1", "of inertial parameters, where the maker gives no standard deviation", judgement(PRIOR)
    )
    gain: float = criterion(0.2, "1", "of k_T, where the maker gives no standard deviation", judgement(PRIOR))
    gyration_m: float = criterion(0.03, "m", "a link is not a point, even if its file says so", judgement(PRIOR))
    light_share: float = criterion(
        0.05, "of the mean link mass", "for the spread of links that are given (almost) no mass", judgement(PRIOR)
    )


DECLARED = Declaring()
