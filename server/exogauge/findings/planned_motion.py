"""A motion that was planned to tell a finding from what else it may be, and how well it would."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.findings.sweeps import Sweep

Array = NDArray[np.float64]

SURE = 10.0  # evidence (twice the log likelihood) that tells two effects apart: odds of 150 to one
LONGEST = 600.0  # [s] of motion that is worth asking for


@final
@dataclass(frozen=True)
class Apart:
    """How far a finding and one rival are apart, computed before any such motion is recorded.

    rival: `stribeck`; place: where it would sit, `wrist.fx`. left_now: share of the effect, once the model's own
    parameters are fitted again, that the other one does not take as well, 0…1, in these logs; left_then: with the
    planned motion. Of finding and rival, whichever is harder to see beside the other.
    evidence_now, evidence: twice the log likelihood by which the true one of the two stands out, to be expected of
    these logs, and what the motion adds; rate: the same per 10 s. seconds: of the motion until that is `SURE`, None
    where no motion that was tried does so within `LONGEST`.
    """

    rival: str
    place: str
    left_now: float
    left_then: float
    evidence_now: float
    evidence: float
    rate: float
    seconds: float | None


@final
@dataclass(frozen=True)
class PlannedMotion:
    """What to record next. joint: that is swept. companion: that moves slowly beside it to change its load, or "".

    sweep: of the joint. repeats: how often the whole is to be moved; duration: [s] of all repeats. unit: `rad` or `m`.
    time: (T,) [s] of one repeat; joints: (J,) names; q: (T, J) [rad or m]. pairs: what it tells apart.
    legs_rest: joints that carry the robot stay as they are, and the base stands still.
    """

    joint: str
    companion: str
    companion_range: tuple[float, float]
    sweep: Sweep
    unit: str
    repeats: int
    duration: float
    pairs: tuple[Apart, ...]
    legs_rest: bool
    time: Array
    joints: tuple[str, ...]
    q: Array
