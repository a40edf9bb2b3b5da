"""What the search for missing effects says: named effects in order, what else was tried, and the chain of gaps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal, final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.judging import Judging
from exogauge.devices.result import Estimate
from exogauge.findings.basis import Basis
from exogauge.findings.planned_motion import Apart, PlannedMotion
from exogauge.findings.verdict import Caveat, Decision, Facts, Objection, Seen, Verdict, decide

if TYPE_CHECKING:  # the fit of bands is half of what loading this would load
    from exogauge.support.band_fit import NamedBands

Array = NDArray[np.float64]

Coordinate = Literal["time", "speed", "position", "load"]
What = Literal["robot", "bands", "effect", "own_curve", "remainder"]


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

    def falls(self, judging: Judging) -> bool:
        """By more than what a last digit says."""
        return self.rmse_after <= judging.falls * self.rmse_before

    @property
    def floors(self) -> float:
        """That are left."""
        return self.rmse_after / self.noise_floor if self.noise_floor > 0.0 else float("inf")

    def of_another_law(self, judging: Judging) -> bool:
        """Whether as much is left as the noise, and more of what was there than a law leaves that is nearly right."""
        rounding = 1e3  # noise floors: where more is left, there is no noise but that of digits
        as_noise = judging.as_noise <= self.floors <= rounding
        before, after = (each**2 - self.noise_floor**2 for each in (self.rmse_before, self.rmse_after))
        return as_noise and after > judging.of_its_law * before

    @property
    def explained(self) -> float:
        """Share of the excess over the noise floor that goes, 0…1."""
        excess = self.rmse_before**2 - self.noise_floor**2
        gone = self.rmse_before**2 - self.rmse_after**2
        return float(np.clip(gone / excess, 0.0, 1.0)) if excess > 0.0 else 0.0


@final
@dataclass(frozen=True)
class Alternative:
    """A candidate that was not chosen. score: share of the excess residual it explains on held-out logs, 0…1."""

    effect: str
    place: Place
    score: float
    objection: Objection


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
class Refinement:
    """What was done to a named effect later. what: a shape sought again, a curve of its own, or a remainder beside it
    that looks like `effect`. before: the held-out error until then."""

    what: Literal["shape", "own_curve", "remainder"]
    before: HeldOut
    effect: str = ""


@final
@dataclass(frozen=True)
class Finding:
    """One named effect. parameters: coefficients and shapes by name. score: share of the excess it explains on held-out
    logs. also_possible: what these data cannot tell from it. apart: how far each of those is from it, where that was
    computed; plans: the motions that tell them apart. as_drawn: parameters that the data do not decide, which are not
    told. alike: places that have it in common, the first of which this is about."""

    rank: int
    effect: str
    place: Place
    parameters: Mapping[str, Estimate]
    held_out: HeldOut
    score: float
    basis: Basis
    alternatives: tuple[Alternative, ...]
    also_possible: tuple[Alternative, ...]
    evidence: Evidence
    refined: tuple[Refinement, ...] = ()
    as_drawn: tuple[str, ...] = ()
    alike: tuple[Place, ...] = ()
    apart: tuple[Apart, ...] = ()
    plans: tuple[PlannedMotion, ...] = ()

    @property
    def named_at(self) -> Place:
        """Where its evidence is from."""
        return self.alike[0] if self.alike else self.place

    def refined_by(self, what: Literal["shape", "own_curve", "remainder"], rmse: float, effect: str = "") -> Finding:
        """rmse: the held-out error after it."""
        held = replace(self.held_out, rmse_after=rmse)
        refined = (*self.refined, Refinement(what, self.held_out, effect))
        return replace(self, held_out=held, score=held.explained, refined=refined)


@final
@dataclass(frozen=True)
class ChainStep:
    """What a model has that the one before it has not: an effect at a place, its own curve, or the remainder of it.

    what: `robot` as identified and `bands` as springs are first models, without effect and place. more: further places
    at which the same effect was added with it.
    """

    what: What
    effect: str = ""
    place: Place | None = None
    more: int = 0

    @property
    def identifier(self) -> str:
        """`stribeck@torso_pitch`, `own curve of stribeck@torso_pitch`, `presliding@j1 and 3 more`."""
        sort = "" if self.what == "effect" else f"{self.what.replace('_', ' ')} of "
        more = f" and {self.more} more" if self.more else ""
        return f"{sort}{self.effect}@{self.place.words if self.place else ''}{more}"


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
class Concentration:
    """Where most of an error sits: in a few moments, (log, [s]); or where a coordinate is above or below `at` [unit];
    else throughout. logs: those in which it is most, if any, the RMSE of the first `times` that of all."""

    moments: tuple[tuple[str, float], ...] = ()
    coordinate: Coordinate | None = None
    above: bool = False
    at: float = float("nan")
    unit: str = ""
    logs: tuple[str, ...] = ()
    times: float = float("nan")


THROUGHOUT = Concentration()


@final
@dataclass(frozen=True)
class Excess:
    """A channel whose residual is above what noise explains. rmse, noise_floor [unit]; z: standard errors above it."""

    channel: str
    unit: str
    rmse: float
    noise_floor: float
    z: float
    where: Concentration = THROUGHOUT


@final
@dataclass(frozen=True)
class WithinDeclared:
    """Channels above their noise no further than declared uncertainties of the measurement let them stand.

    sources: the kinds of these that it takes, as in `identification.disturbances`, what does most first; `noise_colour`
    last."""

    channels: tuple[Excess, ...] = ()
    sources: tuple[str, ...] = ()


@final
@dataclass(frozen=True)
class Lineage:
    """A model version: its parent's version, and what was added; None of the first."""

    version: str
    parent: str | None
    added: ChainStep | None


@final
@dataclass(frozen=True)
class Consequence:
    """A quantity without and with the named effects. of: of an RMSE of approach B the device, the motion and the joint;
    of a group its name, the approach and the device; of a band its name and, where there are several, the device."""

    what: Literal["rmse", "group_stiffness", "stiffness", "natural_length"]
    of: tuple[str, ...]
    before: Estimate
    after: Estimate


@final
@dataclass(frozen=True)
class Discrepancy:
    """before_after: of supporting torque and stiffness. wear_chain: as chain, of the supporting torque and the model of
    the wear; empty where nothing was added to it. declared: not among `unexplained`. seen: every
    channel that was looked at, with all that was named. cannot: why something was not judged. judging: what decides its
    verdict. bands: devices of whose bands something was named, fitted with it."""

    findings: tuple[Finding, ...]
    chain: tuple[Link, ...]
    located: tuple[Excess, ...]
    unexplained: tuple[Excess, ...]
    rejected: tuple[Alternative, ...]
    lineage: tuple[Lineage, ...]
    candidates: int
    notes: tuple[Caveat, ...]
    before_after: tuple[Consequence, ...]
    wear_chain: tuple[Link, ...] = ()
    declared: WithinDeclared = WithinDeclared()
    seen: tuple[Seen, ...] = ()
    cannot: tuple[Caveat, ...] = ()
    judging: Judging = field(default_factory=Judging)
    bands: tuple[NamedBands, ...] = ()

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
                declared=tuple(each.channel for each in self.declared.channels),
                sources=self.declared.sources,
                seen=self.seen,
                told=tuple(each.worst_rmse / each.worst_floor for each in ends if each.worst_floor > 0.0),
                cannot=self.cannot,
                judging=self.judging,
            )
        )
