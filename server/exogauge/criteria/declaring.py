"""Standard uncertainties that stand in where robot.yaml and device.yaml state none (GUM 4.3, type B)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from exogauge.criteria.criterion import criterion, judgement

USUAL = "docs/decisions/0013-uncertainty-budget.md"
OFFSETS = "docs/decisions/0016-offsets-of-logs.md"


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
    ft_zero_force: float = criterion(2.0, "N", "zero of a force that was not taken anew before a log", judgement(USUAL))
    ft_zero_moment: float = criterion(0.2, "N·m", "the same of a moment, at a tenth of a metre", judgement(USUAL))
    kt_drift: float = criterion(
        0.01, "1", "torque per ampere of a motor that warms by 10 K: magnets lose .1 % per K", judgement(USUAL)
    )
    alike: float = criterion(
        0.8,
        "1",
        "share of the variance of a drift or a zero that the logs with the device have in common: they follow each "
        "other late in a session, and what walks at random until then is .8 to 1 alike in them",
        judgement(USUAL),
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
