"""What a name has to hold wherever it is found, on a robot or on a device, and when a gap counts as one.

What is missing beside a rigid payload behind an ideal sensor: what a name has to hold.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import convention, criterion, derived, judgement, measured

MISSING = "docs/decisions/0005-missing-effects.md"


@final
@dataclass(frozen=True)
class Judging:
    """evidence: twice the log likelihood, with as many samples as are independent, less the price of what was chosen.
    z: standard errors of a mean over blocks."""

    block_s: float = criterion(
        1.0, "s", "blocks of this length count as independent: errors of joints forget within it", judgement(MISSING)
    )
    fewest_blocks: int = criterion(
        5, "blocks", "below, the standard error of a mean over them is hardly known", judgement(MISSING)
    )
    sure: float = criterion(
        3.0,
        "z",
        "the held-out square error has to fall by this: dozens of effects and shapes are tried for each joint",
        judgement(MISSING),
    )
    once: float = criterion(
        6.0,
        "z",
        "asked in place of `sure` of what the fitted logs alone show: nothing was held out that could confirm it",
        judgement("docs/decisions/0011-rules-of-single-effects.md: made on 18 cases of stored low-passes"),
    )
    least: float = criterion(
        0.05, "1", "share of the square error that has to go: less is real and worth no name", judgement(MISSING)
    )
    worse: float = criterion(3.0, "z", "no regime of motion may surely get worse", judgement(MISSING))
    fewest_in_regime: int = criterion(
        30,
        "samples",
        "with fewer a regime is not asked",
        convention("thirty: from there on means count as normally distributed"),
    )
    worth_judging: float = criterion(
        6.0, "evidence", "odds of twenty to one, before the number of candidates is counted", derived("2 ln 20 = 5.99")
    )
    open: float = criterion(
        6.0,
        "evidence",
        "a lead of less, odds of twenty to one, leaves open which of two it is",
        derived("2 ln 20 = 5.99"),
    )
    tell_apart: float = criterion(
        2.0,
        "z",
        "a smaller lead by blocks leaves open which of two it is: one in twenty is chance",
        derived("normal distribution, 95.4 %"),
    )
    significant: float = criterion(
        2.0,
        "std",
        "the size of what is named has to differ from none by this: one in twenty, as with every interval told",
        derived("normal distribution, 95.4 %"),
    )
    falls: float = criterion(
        0.995,
        "1",
        "share of the error before that may be left at most: with more the two are told by the same three digits",
        derived("half a unit of the third digit"),
    )
    above: float = criterion(
        1.25,
        "noise floors",
        "from here on a channel is said to stand above its floor: below, the floor itself is not known better",
        measured(f"{MISSING}: 40 channels of a robot in which nothing is hidden stand at 0.97 to 1.01"),
    )
    noise_falls: float = criterion(
        1.25,
        "1",
        "density of noise just above the band, as a multiple of that far above, from which on it is not white: three "
        "standard errors of a log of 25 s",
        derived("a variance by median deviations has 1/.37 of the variance of the best estimate, in 1000 values"),
    )
    noise_apart: float = criterion(
        1.5,
        "1",
        "as factor, between two frequencies that tell whether noise falls",
        judgement("server/exogauge/logs/noise_colour.py"),
    )
    noise_told: float = criterion(
        0.16,
        "of the sampling rate",
        "up to which noise is seen to fall and can be continued into the band: further up all first-order noise falls "
        "alike",
        derived(
            "density above 0.17 over that above 0.34 of the rate: 1.33 for 0.5, 1.42 for 0.8 from sample to sample"
        ),
    )
    noise_assumed: float = criterion(
        0.8,
        "1",
        "that one sample of noise may hand on to the next where it is seen to fall, and not how steeply",
        measured("tests/logs/test_noise_colour.py: recovered to a quarter up to there where it can be told"),
    )
    noise_steepest: float = criterion(
        0.98,
        "1",
        "that one sample of noise may hand on to the next: at 300 Hz its density falls to half at 1 Hz, and what falls "
        "faster is not told from motion",
        derived("(1 - p) rate / 2 pi = 0.95 Hz"),
    )
    declared_most: float = criterion(
        2.58,
        "std",
        "that a declared uncertainty may lie from none, for what it explains to count as declared: one in a hundred",
        judgement(MISSING),
    )
    declared_told: float = criterion(
        0.1,
        "share",
        "of what all declared uncertainties do together, from which on one of them is named: less of it is no advice",
        judgement(MISSING),
    )
    sure_above: float = criterion(
        3.0,
        "z",
        "by which the mean square error has to stand above what noise alone leaves in as many rows",
        judgement(MISSING),
    )

    far_above: float = criterion(
        3.0,
        "noise floors",
        "that a place is left at with all that was named: from here on a name has to explain most of what was there",
        judgement("docs/decisions/0022-feet.md; formulas that are not quite right leave 2.3 at a joint at most"),
    )
    mostly: float = criterion(
        0.5,
        "1",
        "of the square error beyond the noise that was there before anything was named: a name that explains less, "
        "where far more than noise is left, is no cause",
        judgement("docs/decisions/0022-feet.md"),
    )
    as_noise: float = criterion(
        1.41,
        "noise floors",
        "left at a place with all that was named there: as much as the noise, by their squares",
        derived("the root of 1 + 1"),
    )
    nearly_all_speeds: float = criterion(
        0.95,
        "1",
        "of the moments of logs that have what begins with one: no faster, the others are asked whether they do not",
        judgement(MISSING),
    )
    of_its_law: float = criterion(
        0.1,
        "1",
        "of the square error beyond the noise that was there before anything was named: where more is left, and as "
        "much as the noise, what is there follows another law than what was named",
        measured("docs/decisions/0039-another-law.md: laws of other formulas leave 5 %, other laws 10 to 57 %"),
    )
    hardly: float = criterion(
        0.25,
        "1",
        "of the same excess of one channel: what explains less of each on which it acts, and leaves one above its "
        "noise, is fitted to what is lacking there for another reason",
        judgement("docs/decisions/0022-feet.md"),
    )

    @property
    def needed_s(self) -> float:
        """[s] of steady held-out motion of a channel, below which nothing is said of it."""
        return self.fewest_blocks * self.block_s


PAYLOAD = "docs/payload.md"


@final
@dataclass(frozen=True)
class Carrying:
    """evidence: log likelihood, less half the logarithm of the samples for every number, less that of all tried."""

    worth: float = criterion(
        6.0, "log odds", "odds of four hundred to one beyond the number of candidates", derived("exp 6 = 403")
    )
    rival: float = criterion(10.0, "log odds", "a lead of less leaves another explanation as good", judgement(PAYLOAD))
    most: int = criterion(4, "effects", "more of one payload are a model that does not hold", judgement(PAYLOAD))
    judged: int = criterion(
        8, "candidates", "best of a round that are held against what was not fitted", judgement(PAYLOAD)
    )
    slow_s: float = criterion(
        0.2,
        "s",
        "means over it hold the motion and hardly the errors of smoothed accelerations, which are faster",
        measured(f"{PAYLOAD}: the sample's arm, whose smoother errs at 5 to 8 Hz"),
    )
    swings: float = criterion(
        3.0, "std", "between the halves of a posture, from which on something still swings there", judgement(PAYLOAD)
    )
    least_noise: float = criterion(
        0.01, "of the stated noise", "no sensor is a hundred times better than it is said to be", judgement(PAYLOAD)
    )
    above_motion: float = criterion(
        0.6, "of half the rate", "from where on only noise is heard: no arm moves there", judgement(PAYLOAD)
    )
    latest_s: float = criterion(
        0.05,
        "s",
        "that a wrench may be late against its pose, either way: beyond, it is another clock",
        judgement(PAYLOAD),
    )
    farthest_turn_rad: float = criterion(
        0.17, "rad", "that axes of a wrench may stand off those of its frame, each way: 10°", judgement(PAYLOAD)
    )
    hangs_hz: tuple[float, float] = criterion(
        (1.0, 25.0),
        "Hz",
        "of what hangs on springs: below it swings too far, above it is rigid to the sensor",
        judgement(PAYLOAD),
    )
    hangs_damped: tuple[float, float] = criterion(
        (0.02, 1.5), "1", "damping ratio of what hangs on springs: rubber has 0.05 and more", judgement(PAYLOAD)
    )
    hangs_within_m: float = criterion(1.0, "m", "of the sensor, along each axis, is what hangs", judgement(PAYLOAD))
    other_ratio: float = criterion(
        1.5,
        "1",
        "times by which moments may differ from what forces say of m c: beyond, a unit is wrong and no sensor's gain",
        judgement(PAYLOAD),
    )
    ratio_known: float = criterion(
        0.1, "1", "of that ratio, its std at most: a centre near the sensor's origin tells nothing", judgement(PAYLOAD)
    )
    steep_deg: float = criterion(
        15.0, "°", "a base inclined more than that is a wrong pose, gravity or pair of axes", judgement(PAYLOAD)
    )
    beyond_range: float = criterion(
        2.0,
        "1",
        "of the rated range, through most of a log: amplifiers end before, and the unit is another one",
        judgement(PAYLOAD),
    )
    heaviest_kg: float = criterion(
        2500.0,
        "kg",
        "no arm lifts more: forces are in another unit; the strongest are sold for 2300",
        judgement(PAYLOAD),
    )
    far_m: float = criterion(
        3.0, "m", "no centre of mass is farther from a wrist: moments are in another unit", judgement(PAYLOAD)
    )
    no_weight: float = criterion(
        3.0,
        "std of a mean",
        "forces of all postures that differ by less are one: nothing hangs there",
        judgement(PAYLOAD),
    )
    full: float = criterion(0.98, "1", "of the rated range: beyond, gauges are no longer linear", judgement(PAYLOAD))
    cut_off_run: float = criterion(
        8.0,
        "samples",
        "at exactly one extreme in a row, at least, before a channel is said to be cut off there",
        judgement(PAYLOAD),
    )
    cut_off_chance: float = criterion(
        1e-6,
        "1",
        "that a log holds such a run by chance, from how often its channel repeats a value elsewhere",
        judgement(PAYLOAD),
    )
    cut_off_alive: float = criterion(
        0.6,
        "1",
        "of the samples may repeat the one before, where most do: with more the channel is coarse and stands at rest",
        judgement(PAYLOAD),
    )
    cut_off_judged: int = criterion(
        200, "samples", "away from the extremes, of which it is told how often they repeat", judgement(PAYLOAD)
    )
    other_mass: float = criterion(
        0.2, "of the weighed mass", "farther off, a unit is wrong rather than the identification", judgement(PAYLOAD)
    )
    impossible: float = criterion(
        100.0, "χ²", "ten standard deviations to the next body that can exist are no chance", derived("10² = 100")
    )
    margin_s: float = criterion(0.2, "s", "left out on either side of a touch", judgement(PAYLOAD))
    touched: float = criterion(
        0.3, "of the excitation", "more is no touch but a model that does not hold", judgement(PAYLOAD)
    )


CARRYING = Carrying()
