"""Why a candidate was not named, as data."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import final

from exogauge.devices.result import Estimate


@final
class Why(StrEnum):
    """Behind each: what `value`, `beside` and `of` of its objection are."""

    TOO_SHORT = "too_short"  # [s] of steady motion that was not fitted, and that are needed
    FEW_MOMENTS = "few_moments"  # standard errors by which the fitted logs ask for it
    LITTLE = "little"  # share of the error that it explains
    NOT_SURE = "not_sure"  # standard errors by which the held-out error falls, and that are asked for
    NOT_SURE_ONCE = "not_sure_once"  # the same in the one log that has it
    WORSE = "worse"  # standard errors by which the error grows; of: a regime
    NOT_FALLING = "not_falling"  # held-out error without and with it [unit]; of: channel, and the one log that has it
    NOT_FALLING_AGAIN = "not_falling_again"  # the same, low-passed, with the robot identified again
    MAY_BE_NONE = "may_be_none"  # sizes: of what may as well be zero
    SIZE_NOT_SURE = "size_not_sure"  # standard deviations from zero, and that are asked for
    TOO_SMALL = "too_small"  # RMS that it takes off, and noise floor
    SMALL_BESIDE = "small_beside"  # of: the effect that was named there, if it is one
    UNDER_SUPPORT = "under_support"  # share of the support that it would have to be
    AT_FLOOR = "at_floor"
    ONCE = "once"
    BETTERED = "bettered"  # of: effects with which another one explains more
    NOT_NEEDED = "not_needed"  # of: effects with which it is not needed
    ALIKE = "alike"
    LESS = "less"
    LESS_LIKELY = "less_likely"
    ONE_FACTOR = "one_factor"  # on every motor's gain
    ONE_BODY = "one_body"  # a heavier link, and a load fixed to it


@final
@dataclass(frozen=True)
class Objection:
    """value, beside [unit], of, sizes: as `Why` says."""

    why: Why
    value: float = math.nan
    beside: float = math.nan
    unit: str = ""
    of: tuple[str, ...] = ()
    sizes: Mapping[str, Estimate] = field(default_factory=dict)
