"""What a robot's logs cannot show of themselves, as its owner knows it: standard uncertainties of type B (GUM 4.3)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final


@final
@dataclass(frozen=True)
class Declared:
    """Standard uncertainties, one standard deviation each; 0: known, or left out of the budget.

    ft_gain: share by which one force/torque sensor reads too much, each for itself; ft_gain_common: all of them alike,
    as after one calibration. ft_zero_force [N], ft_zero_moment [N·m]: zero of one component, another in each log.
    kt_drift: share by which a motor gives more than k_T i, another in each log and joint. imu_tilt [rad]: of the IMU's
    mounting, about each axis across. torque_zero [N·m, N where it slides]: a constant of a joint's torque, another in
    each log, beside what zeros of force/torque sensors make of it; torque_zero_of: joint -> what is stated of it alone.
    defaulted: names of those that nobody stated.
    """

    ft_gain: float = 0.0
    ft_gain_common: float = 0.0
    ft_zero_force: float = 0.0
    ft_zero_moment: float = 0.0
    kt_drift: float = 0.0
    imu_tilt: float = 0.0
    torque_zero: float = 0.0
    torque_zero_of: Mapping[str, float] = field(default_factory=dict)
    defaulted: frozenset[str] = frozenset()


EXACT = Declared()
