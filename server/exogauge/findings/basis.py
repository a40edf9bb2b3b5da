"""What a finding rests on, by how it was found: the numbers that its sentence needs beside those of the finding."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, final

from exogauge.devices.result import Estimate
from exogauge.effects.band import BandEffect
from exogauge.effects.shaped import MissingEffect

LeftOut = Literal["repetitions", "motions", "parts", "nothing"]
FloorOf = Literal["other_logs", "stated", "seen", "rounding"]


@final
@dataclass(frozen=True)
class Continued:
    """Held-out logs go beyond what was fitted, in this coordinate: to `reached`, from `fitted` on [unit]."""

    coordinate: str
    unit: str
    reached: float
    fitted: float


@final
@dataclass(frozen=True)
class OfRobot:
    """An effect of the catalogue that was added to the robot."""

    effect: MissingEffect
    continued: Continued | None = None


@final
@dataclass(frozen=True)
class Moment:
    """When something happens once: `at` [s] into a log. stays: in later logs, too."""

    log: str
    at: float
    stays: bool


@final
@dataclass(frozen=True)
class OfBand:
    """An effect that was added to a band, or a value of it that is not as stated. device: where there are several.

    left_out: of the fit, in turn, to judge it. moment: of an effect that happens once.
    """

    effect: BandEffect
    device: str
    left_out: LeftOut
    moment: Moment | None = None


@final
@dataclass(frozen=True)
class Touch:
    """One push. start, duration [s] on the clock of the log; force [N]: the largest."""

    log: str
    start: float
    duration: float
    force: Estimate


@final
@dataclass(frozen=True)
class Touched:
    """Something touched a link. lacks: largest residual of the finding's channel then [its unit]."""

    touches: tuple[Touch, ...]
    lacks: float


@final
@dataclass(frozen=True)
class BesideStated:
    """A number of the maker. doubt: his, of a mass [kg], of a gain as a share."""

    doubt: float


@final
@dataclass(frozen=True)
class LowPassed:
    """Logs were stored behind a low-pass. delay_s: by which it made them late, None for none.

    judges: logs whose error falls, where they were not held out; else (). floor: what the noise floor is taken from.
    """

    kind: str
    order: int
    delay_s: float | None
    judges: tuple[str, ...]
    floor: FloorOf


Basis = OfRobot | OfBand | Touched | BesideStated | LowPassed
