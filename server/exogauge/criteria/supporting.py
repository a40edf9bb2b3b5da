"""Supporting torque and bands: which estimate a headline number comes from, when two estimates contradict each
other, and when a band has an effect.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import convention, criterion, derived, judgement

RULES = "docs/decisions/0004-supporting-torque.md"
DRIFTS = "docs/decisions/0026-drift-through-a-session.md"


@final
@dataclass(frozen=True)
class Supporting:
    """z: difference over its standard deviation, of the logarithms of two RMS."""

    peak_s: float = criterion(
        0.2, "s", "over which a peak is a mean: the largest of many noisy samples is too large", judgement(RULES)
    )
    memory_s: float = criterion(
        1.0,
        "s",
        "how long an error lasts that is not of the robot's parameters: means over less do not average it out",
        judgement(RULES),
    )
    drift_missed: float = criterion(
        1.0,
        "1",
        "of a motor's torque that the model may miss in a motion: nothing is known of it, only its change tells",
        judgement(DRIFTS),
    )
    drift_most: float = criterion(
        2.58,
        "std",
        "of what is declared, by which repetitions may differ before they tell less of a motor: the model misses "
        "something that is another in each",
        derived("normal distribution, one in a hundred, as `judging.declared_most`"),
    )
    drift_samples: int = criterion(
        50, "samples", "of a joint in steady motion, below which a run says nothing of its motor", judgement(DRIFTS)
    )
    zero_missed: float = criterion(
        10.0,
        "1",
        "of the declared zero of a foot, which a wrong mass or tilt may look like in a motion: only its change tells",
        judgement("docs/decisions/0031-zeros-of-the-feet-through-a-session.md"),
    )
    label_pulls: float = criterion(
        0.5, "1", "of the largest pull in a motion: a log that shows as much has the device on", judgement(RULES)
    )
    label_none: float = criterion(0.25, "1", "of the same: a log that shows less has it off", judgement(RULES))
    label_likeness: float = criterion(
        0.8, "1", "of what the model misses with how the bands would pull, for it to be theirs", judgement(RULES)
    )
    not_as_stated: float = criterion(
        5.0,
        "std",
        "by which a band is other than its file says before it is told",
        derived("normal distribution, 6e-7"),
    )
    not_as_stated_share: float = criterion(
        0.5, "1", "of the doubt of a stated value that it has to be at least: less matters to nobody", judgement(RULES)
    )
    equal: float = criterion(
        2.0,
        "z",
        "difference of two null tests, of one's mean from what is declared, or of one check by two approaches, up to "
        "which it may be chance",
        derived("normal distribution, 95.4 %"),
    )
    known: float = criterion(
        0.5,
        "1",
        "std over the value (over the largest stretch, for a length) up to which the data decide it, and cross-checks "
        "compare it",
        judgement(RULES),
    )
    misfit: float = criterion(
        2.0,
        "1",
        "variance of what the bands leave, over that without the device, up to which it may be chance",
        derived("F distribution, 95 %, 25 independent errors in either"),
    )
    misfit_matters: float = criterion(
        0.05,
        "1",
        "of a stiffness, its least doubt where it is held against what its springs leave: that is a worst case, which "
        "a fit that is right to a per cent need not withstand",
        judgement(RULES),
    )
    small: float = criterion(
        1.0 / 3.0,
        "std",
        "of what is told, by which parts of the evidence may differ however surely: as squares add up, that would add "
        "a twentieth to the doubt",
        derived("√(1 + 1/9) = 1.054"),
    )
    not_of_bands: float = criterion(
        0.5,
        "1",
        "of what is measured with a device on, what its bands leave beyond chance, from which on it counts as another "
        "thing's: then most of it is not theirs; less is for the cross-checks",
        judgement(RULES),
    )
    false_alarms: float = criterion(
        0.01,
        "1",
        "probability that any of a device's cross-checks fails by chance; each has its share of it, both sides",
        derived("normal distribution, Bonferroni"),
    )


BANDS = "docs/decisions/0008-effects-of-bands.md"


@final
@dataclass(frozen=True)
class Wearing:
    """What is asked of any name is in `Judging`."""

    most_folds: int = criterion(5, "folds", "repetitions or motions, each left out in turn", judgement(BANDS))
    parts: int = criterion(3, "parts", "of a single log, each left out in turn", judgement(BANDS))
    shortest_part_s: float = criterion(6.0, "s", "that such a part lasts at least", judgement(BANDS))
    evidence_once: float = criterion(
        40.0,
        "evidence",
        "asked of an effect of one moment, which nothing that was left out can confirm",
        judgement(BANDS),
    )
    spread_once: float = criterion(
        2.0, "z", "asked of its gain by blocks: it must not be one moment's alone", judgement(BANDS)
    )
    acts: float = criterion(
        0.3, "1", "of an effect's torque on the joint that feels it most, from which a joint is asked", judgement(BANDS)
    )
    of_support: float = criterion(
        0.02, "1", "of the supporting torque: a smaller effect is not worth a name", judgement(BANDS)
    )
    beyond: float = criterion(
        1.3, "std", "stated doubts within which a value is no news: a maker's catalogue is no better", judgement(BANDS)
    )
    trials: int = criterion(14, "fits", "of a search for a shape, per shape", judgement(BANDS))
    shape_worth: float = criterion(4.0, "1", "of the cost, in independent errors: less is chance", judgement(BANDS))
    first_step: float = criterion(0.08, "1", "of a shape's range, with which its search begins", judgement(BANDS))
    fine: int = criterion(
        12, "values", "of a grid, beyond which the first step is half of one of its steps", judgement(BANDS)
    )
    joint_moves: float = criterion(
        0.05, "rad or m", "travel of a joint from which it can show what pulls at it", judgement(BANDS)
    )
    most_crossed: int = criterion(4, "joints", "between the ends of a wire that is tried", judgement(BANDS))
    lightest: float = criterion(
        0.01, "1", "of the robot's mass, of a link whose inertia says how large it is", judgement(BANDS)
    )
    least_travel_m: float = criterion(0.005, "m", "of a wire that motions stretch", judgement(BANDS))
    likely: int = criterion(3, "1", "joints that are followed up, and wires that are judged", judgement(BANDS))
    furthest_m: float = criterion(0.2, "m", "by which the ends of a wire are led better", judgement(BANDS))
    wire_worth: float = criterion(
        6.0,
        "evidence",
        "of a wire that nobody declared, beyond what the number of tries gives by chance",
        derived("2 ln 20 = 5.99"),
    )
    most_effects: int = criterion(
        4, "effects", "that are named of one device: beyond, the formulas fit what others leave", judgement(BANDS)
    )
    worth_judging: float = criterion(
        6.0, "evidence", "of a candidate from which the fits that judge it are spent on it", derived("2 ln 20 = 5.99")
    )
    judged: int = criterion(8, "candidates", "with most evidence that are judged in a round", judgement(BANDS))
    remainder: float = criterion(
        0.2,
        "1",
        "of what a named effect explained on a joint: less may be what its formula leaves of a real band",
        judgement(BANDS),
    )
    remainder_of_wire: float = criterion(
        0.5,
        "1",
        "the same of a wire that nobody declared: it can run anywhere, and so fits what any formula leaves",
        judgement(BANDS),
    )
    clear: float = criterion(
        1.5,
        "floors",
        "that a further band may leave on its joint for others to be looked at beside it",
        judgement(BANDS),
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


DEVICE_FILE = "docs/device.md"


@final
@dataclass(frozen=True)
class Described:
    """Of a device's description, and of a band on a test bench. No run may have other numbers: a description is read
    before any run."""

    fewest_points: int = criterion(2, "via points", "of a band: it begins and ends somewhere", derived("two ends"))
    most_points: int = criterion(50, "via points", "of a band: no suit has so many", judgement(DEVICE_FILE))
    same_place_m: float = criterion(
        1e-6,
        "m",
        "via points on one link nearer than that are one: a stretch needs a direction",
        judgement(DEVICE_FILE),
    )
    slack: float = criterion(
        0.02, "of the largest force", "on a test bench: below, the band counts as slack", judgement(DEVICE_FILE)
    )
    bench: float = criterion(
        0.01, "1", "of the value: no test bench is taken to be better than that", judgement(DEVICE_FILE)
    )


DEVICES = Described()


SAME = "docs/decisions/0004-supporting-torque.md, the same motion"


@final
@dataclass(frozen=True)
class Motions:
    """Which logs show the same motion, and what its phases are. No run may have other numbers: a study's logs are
    brought together before any run."""

    moves: float = criterion(
        0.04, "of the largest velocity", "slower is holding or standing", judgement("server/exogauge/support/phases.py")
    )
    away: float = criterion(
        0.2,
        "of the range",
        "from the posture at the start: beyond, a pause is a hold",
        judgement("server/exogauge/support/phases.py"),
    )
    shortest_phase_s: float = criterion(
        0.15, "s", "shorter parts belong to their neighbours", judgement("server/exogauge/support/phases.py")
    )
    upright: float = criterion(
        0.7,
        "1",
        "vertical part of a unit joint axis: beyond about 45 degrees a joint turns, below it bends",
        judgement("server/exogauge/support/phases.py"),
    )
    smooth_hz: float = criterion(8.0, "Hz", "motions are compared below it", judgement(SAME))
    overlap: float = criterion(0.3, "of the shorter log", "that two have in common, at least", judgement(SAME))
    common: float = criterion(
        0.5, "1", "of a joint's motion that two logs must share, or it is not the same motion", judgement(SAME)
    )
    moving: float = criterion(0.02, "rad/s", "rms velocity above which a joint counts as moving", judgement(SAME))
    minor: float = criterion(
        0.1,
        "1",
        "of the fastest joint's rms velocity, below which a joint that moves otherwise is doubtful and refuses nothing",
        judgement(SAME),
    )
    stands_apart: float = criterion(
        0.1, "rad", "rms angle between two runs above which a joint that hardly moves is doubtful", judgement(SAME)
    )
    alike: float = criterion(
        0.02,
        "of the motions' own size",
        "two shifts of a periodic motion that differ by less explain it alike",
        judgement(SAME),
    )


MOTIONS = Motions()
