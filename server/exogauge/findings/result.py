"""What the search for missing effects says: named effects in order, what else was tried, and the chain of gaps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.result import Estimate
from exogauge.findings.band_numbers import BandNumbers
from exogauge.findings.planned_motion import Apart, PlannedMotion
from exogauge.findings.verdict import Decision, Facts, Seen, Verdict, decide

Array = NDArray[np.float64]

What = Literal["robot", "bands", "effect", "own_curve", "remainder"]

AT_MOST = 0.995  # of the held-out error before: with more the two are told by the same three digits


@final
@dataclass(frozen=True)
class Place:
    """kind: `joint`, `link`, `band`, `sensor`, `base` or `log`; name: which one (`all` for every joint); part: of a
    sensor, the component `fx` … `mz`."""

    kind: str
    name: str
    part: str = ""

    @property
    def words(self) -> str:
        """`torso_pitch`, `wrist.fx`."""
        return f"{self.name}.{self.part}" if self.part else self.name


@final
@dataclass(frozen=True)
class HeldOut:
    """RMSE of one channel in the regime where the model claims to hold (steady motion), on held-out logs.

    log: the only log that has the effect; then all is about that one, which is fitted. Else "".
    """

    channel: str
    unit: str
    rmse_before: float
    rmse_after: float
    noise_floor: float
    log: str = ""

    @property
    def falls(self) -> bool:
        """By more than what a last digit says."""
        return self.rmse_after <= AT_MOST * self.rmse_before

    @property
    def explained(self) -> float:
        """Share of the excess over the noise floor that goes, 0…1."""
        excess = self.rmse_before**2 - self.noise_floor**2
        gone = self.rmse_before**2 - self.rmse_after**2
        return float(np.clip(gone / excess, 0.0, 1.0)) if excess > 0.0 else 0.0


@final
@dataclass(frozen=True)
class Alternative:
    """A candidate that was not chosen. score: share of the excess residual it explains on held-out logs, 0…1.

    reason: why it was not chosen, in words.
    """

    effect: str
    place: Place
    score: float
    reason: str


@final
@dataclass(frozen=True)
class Evidence:
    """The plot that shows an effect: residual before and after in the coordinate it depends on, binned.

    coordinate, unit: of `at` (n,). before, after: (n,) mean residual [of the finding's channel]; spread: (n,) its
    standard error. model: (n,) mean of what the effect itself adds. along_motion: torques are
    positive along the motion, not along the joint.
    """

    coordinate: str
    unit: str
    at: Array
    before: Array
    after: Array
    spread: Array
    model: Array
    along_motion: bool = field(default=False, kw_only=True)


@final
@dataclass(frozen=True)
class Finding:
    """One named effect. parameters: coefficients and shapes by name. score: share of the excess it explains on held-out
    logs. sentence: the evidence in words. also_possible: what these data cannot tell from it; motion: in words, the one
    that would. apart: how far each of those is from it, where that was computed; plans: the motions that tell them
    apart. undecided: what planning them needs (`search.ambiguity.Undecided`), None once that is done."""

    rank: int
    effect: str
    place: Place
    parameters: Mapping[str, Estimate]
    held_out: HeldOut
    score: float
    sentence: str
    alternatives: tuple[Alternative, ...]
    also_possible: tuple[Alternative, ...]
    motion: str
    evidence: Evidence
    apart: tuple[Apart, ...] = ()
    plans: tuple[PlannedMotion, ...] = ()
    undecided: object | None = field(default=None, repr=False, compare=False)


@final
@dataclass(frozen=True)
class ChainStep:
    """What a model has that the one before it has not: an effect at a place, its own curve, or the remainder of it.

    what: `robot` as identified and `bands` as springs are first models, without effect and place.
    """

    what: What
    effect: str = ""
    place: Place | None = None

    @property
    def identifier(self) -> str:
        """`stribeck@torso_pitch`, `own curve of stribeck@torso_pitch`."""
        sort = "" if self.what == "effect" else f"{self.what.replace('_', ' ')} of "
        return f"{sort}{self.effect}@{self.place.words if self.place else ''}"


@final
@dataclass(frozen=True)
class Link:
    """One bar of the chain: what the model is, and its RMSE over all joints' channels relative to the noise floor.

    rmse: pooled over the channels in question (those with a finding, or above their floor; else all joint torques) in
    steady motion on held-out logs [unit]; with channels of several units in multiples of each one's noise floor (unit
    `floors`). worst, worst_rmse, worst_floor [worst_unit]: the channel furthest above its floor.
    """

    step: ChainStep
    rmse: float
    noise_floor: float
    worst: str
    worst_rmse: float
    worst_floor: float
    unit: str = "N·m"
    worst_unit: str = "N·m"


@final
@dataclass(frozen=True)
class Excess:
    """A channel whose residual is above what noise explains. rmse, noise_floor [unit]; z: standard errors above it.

    where: in words, at which speeds, positions or times it is largest.
    """

    channel: str
    unit: str
    rmse: float
    noise_floor: float
    z: float
    where: str


@final
@dataclass(frozen=True)
class Lineage:
    """A model version: its parent's version, what was added, and the settings that name it again."""

    version: str
    parent: str | None
    added: str


@final
@dataclass(frozen=True)
class Discrepancy:
    """before_after: quantity name -> (before, after), of supporting torque and stiffness. wear_chain: as chain, of the
    supporting torque and the model of the wear; empty where nothing was added to it. seen: every channel that was
    looked at, with all that was named. cannot: why something was not judged, in words. bands: their numbers beside the
    effects that were named of them."""

    findings: tuple[Finding, ...]
    chain: tuple[Link, ...]
    located: tuple[Excess, ...]
    unexplained: tuple[Excess, ...]
    rejected: tuple[Alternative, ...]
    lineage: tuple[Lineage, ...]
    candidates: int
    notes: tuple[str, ...]
    before_after: Mapping[str, tuple[Estimate, Estimate]]
    wear_chain: tuple[Link, ...] = ()
    seen: tuple[Seen, ...] = ()
    cannot: tuple[str, ...] = ()
    bands: tuple[BandNumbers, ...] = ()

    @property
    def verdict(self) -> Verdict:
        return self.decision.verdict

    @property
    def decision(self) -> Decision:
        """From nothing but what stands here, so that it cannot contradict it."""
        ends = [links[-1] for links in (self.chain, self.wear_chain) if links]
        return decide(
            Facts(
                named=len(self.findings),
                above=tuple(each.channel for each in self.unexplained),
                seen=self.seen,
                told=tuple(each.worst_rmse / each.worst_floor for each in ends if each.worst_floor > 0.0),
                cannot=self.cannot,
            )
        )
