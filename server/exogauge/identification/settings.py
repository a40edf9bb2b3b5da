"""The choices a user may make about an identification; every default is chosen from the data or stated here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, final

from exogauge.criteria.criteria import Criteria
from exogauge.logs.model import Log


@final
@dataclass(frozen=True)
class Recording:
    """A log and what it is for: fitted, or held out and only predicted."""

    log: Log
    held_out: bool


@final
@dataclass(frozen=True)
class Settings:
    """How to identify.

    cutoff_hz: low-pass cut-off for every signal, None = chosen from the logs' spectra.
    effects: names from `effects.catalogue`, the columns of Z in [Evaluator] (12) and what is added to them.
    prior: `per_parameter` = a standard deviation for each parameter; `as_printed` = the uniform weights of
    [Evaluator] (16)-(17).
    prior_strength: factor on the prior's weight, None = chosen by error on held-out blocks of the fitted logs.
    consistency: `physical` = every link's pseudo-inertia positive definite, which on no recording of a real robot cost
    any held-out error; `free` = whatever fits best, also negative masses.
    creeping: joint -> speed [rad/s, or m/s] below which it is not in steady motion, though it is not at rest either;
    found by the search for missing effects (`search/creeping.py`).
    solver: `statistics` = from float64 sufficient statistics, `rows` = row-wise QR of every sample (slower).
    started: recording -> [s] when it began, on one clock; empty where that is not said of every log of the study.
    criteria: numbers that decide, each with its reason.
    """

    cutoff_hz: float | None = None
    effects: Sequence[str] = ("motor_gain", "viscous", "coulomb", "static_friction", "motor_offset", "rotor_inertia")
    prior: Literal["per_parameter", "as_printed"] = "per_parameter"
    prior_strength: float | None = None
    consistency: Literal["free", "physical"] = "physical"
    creeping: Mapping[str, float] = field(default_factory=dict)
    solver: Literal["statistics", "rows"] = "statistics"
    started: Mapping[str, float] = field(default_factory=dict)
    criteria: Criteria = field(default_factory=Criteria)
