"""The bands of a device from one approach's supporting torques: values, doubt, and what these motions cannot tell.

95 % intervals: symmetric where the profile of the likelihood is, along it where it is not. A standard deviation is no
less than its interval tells: the slopes at an estimate that is too large are those of a band that comes taut late,
which would be known better than it is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import ndtri

from exogauge.criteria.criterion import Z95
from exogauge.criteria.supporting import Supporting
from exogauge.devices.bench import bench_line
from exogauge.devices.device import Band, Device
from exogauge.devices.result import Approach, BandEstimate, Estimate, NamedLaw, StiffnessResult
from exogauge.devices.routing import Routing
from exogauge.effects.band_laws import LINEAR
from exogauge.identification.model import RobotModel
from exogauge.identification.type_b import ROBOT, UNEXPLAINED
from exogauge.remarks import About, Remark
from exogauge.support.band_doubt import contributions, inverted
from exogauge.support.band_fit import BandFit, NamedBands, fit_beside, fit_device, involved, without_shapes
from exogauge.support.band_inputs import DONNING, VIA_POINTS
from exogauge.support.band_interval import SHORTEST, SKEWED, Profiles
from exogauge.support.band_model import (
    LENGTH_DOUBT,
    NULL,
    STIFFNESS_DOUBT,
    Layout,
    at_bounds,
    fit,
    thinned,
)
from exogauge.support.band_rows import band_wires
from exogauge.support.band_weights import rms
from exogauge.support.cross_checks import within
from exogauge.support.evidence import Evidence, Nothing
from exogauge.support.named_laws import numbers, sharpness
from exogauge.support.rows_of_approach import rows_with, rows_without

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@final
@dataclass(frozen=True)
class Springs:
    """What the logs say of a device's bands by one approach. shares: source -> its part of the doubt; of_robot: sources
    that are the robot's (`contributions`). blind: names of values of which the samples hold nothing."""

    bands: Sequence[Band]
    seen: BandFit
    notes: tuple[Remark, ...]
    of_robot: Mapping[str, Array]
    shares: Mapping[str, Array]
    blind: frozenset[str]

    @cached_property
    def doubt(self) -> Array:
        """(P, P) of theta about the truth; infinite where nothing is known."""
        doubt = np.sum(list(self.shares.values()), axis=0)
        for index, name in enumerate(self.seen.fitted.wear.layout.names):
            if name in self.blind:
                doubt[index, index] = np.inf
        return np.asarray(doubt)

    def of(self, k: int) -> tuple[Estimate, Estimate]:
        """Stiffness and natural length of one band."""
        stiffness, length = (_as_wide_as(*each) for each in zip(self._by_slopes(k), self.intervals(k), strict=True))
        return stiffness, length

    @property
    def stated(self) -> Array:
        """(W,) [N/m] standard deviation of each band's stiffness."""
        return np.array([self.of(k)[0].std for k in range(len(self.bands))])

    def intervals(self, k: int) -> tuple[tuple[float, float], tuple[float, float]]:
        """95 % of stiffness and natural length of one band."""
        stretch = self.seen.setting.wires[k].longest - self.seen.fitted.wear.spring(k)[1]
        return self._profiles.of_band(k, max(stretch, 0.0))

    def slack_beside(self, k: int) -> tuple[str, ...]:
        """Bands of its group that pull nowhere, or may, while others do: these may pull for them, too, where a band
        does not run as it is described."""
        layout = self.seen.fitted.wear.layout
        group = np.flatnonzero(layout.stiffness == layout.stiffness[k])
        slack = [int(each) for each in group if not np.isfinite(self.intervals(int(each))[1][1])]
        return tuple(self.bands[each].name for each in slack) if len(slack) < len(group) else ()

    def may_be_slack(self, k: int, criteria: Supporting) -> bool:
        """The logs do not surely contradict that no band of its group ever pulls: then any stiffness would do."""
        wear, wires = self.seen.fitted.wear, self.seen.setting.wires
        place = int(wear.layout.stiffness[k])
        value, variance = float(wear.springs[place]), float(self.doubt[place, place])
        if not np.isfinite(variance) or value > 3.0 * self._sure(criteria) * np.sqrt(variance):  # needs no other fit
            return False
        group = np.flatnonzero(wear.layout.stiffness == place)
        slack = {int(wear.layout.natural_length[b]): max(wires[b].longest for b in group) for b in group}
        share = min(float(inverted(self.seen.fitted.hessian)[place, place]) / max(variance, 1e-300), 1.0)
        return share * (fit(self.seen.setting, wear, slack).cost - self.seen.fitted.cost) <= self._sure(criteria) ** 2

    def other_stiffness(self, k: int, criteria: Supporting) -> float | None:
        """[N/m] of another fit that the logs do not surely contradict, furthest from this one; None where it is less
        off than what counts as known. Of several bands one may pull for all, however sharp its fit."""
        layout = self.seen.fitted.wear.layout
        place = int(layout.stiffness[k])
        value, std = float(self.seen.fitted.wear.springs[place]), float(np.sqrt(self.doubt[place, place]))
        if not np.isfinite(std) or (std < SKEWED * value and np.sum(layout.stiffness == place) == 1):
            return None
        others = self._profiles.of_other_fits(place, self._sure(criteria))
        furthest = max(others, key=lambda other: abs(np.log(max(other, SHORTEST) / value)), default=value)
        return furthest if abs(furthest - value) > criteria.known * min(furthest, value) else None

    def _sure(self, criteria: Supporting) -> float:
        """Standard deviations by which another fit is worse that is surely not it."""
        return -float(ndtri(0.5 * criteria.false_alarms))

    @cached_property
    def _profiles(self) -> Profiles:
        return Profiles(self.seen, self.doubt, self._of_courses)

    @property
    def _of_courses(self) -> Array:
        """(P,) [m²] of natural lengths: variance from how long the courses are."""
        parts = [np.diag(self.shares[name]) for name in (VIA_POINTS, DONNING) if name in self.shares]
        variance = np.sum([np.zeros(len(self.doubt)), *parts], axis=0)
        variance[self.seen.fitted.wear.layout.stiffness] = 0.0
        variance[len(self.seen.fitted.wear.springs) :] = 0.0
        return np.asarray(variance)

    def _by_slopes(self, k: int) -> tuple[Estimate, Estimate]:
        wear = self.seen.fitted.wear
        places = int(wear.layout.stiffness[k]), int(wear.layout.natural_length[k])
        stiffness, length = (
            Estimate(
                np.nan if wear.layout.names[place] in self.blind else float(wear.springs[place]),
                float(np.sqrt(self.doubt[place, place])),
                unit,
                self._parts(place),
            )
            for place, unit in zip(places, ("N/m", "m"), strict=True)
        )
        return stiffness, length

    def _parts(self, place: int) -> dict[str, float]:
        if not np.isfinite(self.doubt[place, place]):
            return {}
        return {source: float(np.sqrt(max(float(C[place, place]), 0.0))) for source, C in self.shares.items()}

    def filled(self, device: Device) -> Device:
        """With these values where it states none."""
        wires = self.seen.setting.wires
        bands = [with_spring(band, self._by_slopes(k), wires[k].longest) for k, band in enumerate(device.bands)]
        return replace(device, bands=tuple(bands))


def with_spring(band: Band, spring: tuple[Estimate, Estimate], longest: float) -> Band:
    """With stiffness and natural length where it states none. One that pulls nowhere is as long as it was ever seen, of
    whatever stiffness."""
    k, l_0 = (each.value for each in spring)
    return replace(
        band,
        stiffness=(k if np.isfinite(k) else 1.0) if band.stiffness is None else band.stiffness,
        natural_length=(l_0 if np.isfinite(l_0) else longest) if band.natural_length is None else band.natural_length,
    )


def fit_springs(
    model: RobotModel,
    device: Device,
    approach: Approach,
    evidences: Sequence[Evidence],
    sigma: Array,
    nothings: Sequence[Nothing],
    joints: Sequence[str],
    named: NamedBands | None = None,
) -> Springs:
    """All logs with the device together. sigma: (D,) [N·m] what the approach finds where there is nothing.

    The law that device.yaml states of a band is in the model, its values as stated. named: what a search has named is
    fitted beside the springs, which are then believed as the search believes them: beside hardening, say, a motion
    leaves next to nothing of a spring's own stiffness.
    """
    notes, robot_doubt = _stated_laws(device), model.a_priori_doubt if approach == "prior" else model.doubt
    columns = np.array([model.robot.tree.joints.index(name) for name in joints])
    zero = model.robot.torque_zero[columns]
    logs = rows_with(evidences, approach, columns, joints, model.cutoff_hz, zero_std=zero)
    null = None
    if approach not in ("A", "paired"):
        null = rows_without(nothings, evidences, approach, columns, joints, zero_std=zero)
    wires = band_wires(logs, Routing(model.robot.tree, device.bands))
    if named is None:
        seen, told = fit_device(device, logs, wires, null, robot_doubt, sigma)
        notes += told
    else:
        seen = fit_beside(logs, wires, null, robot_doubt, sigma, named.fit)
    plan = seen.fitted.wear.layout
    known = {place for place in range(len(plan.names)) if seen.setting.belief.precision[place, place] > 0.0}
    blind = {name for direction in seen.fitted.null_directions for name in involved(plan, direction)}
    blind |= _without_pull(seen, known)
    of_robot = {ROBOT: robot_doubt} if approach == "prior" else model.doubt_by_source
    shares = contributions(seen.setting, seen.fitted, of_robot, seen.null)
    if seen.beyond is not None:
        shares |= {UNEXPLAINED: np.outer(seen.beyond, seen.beyond)}
    return Springs(device.bands, seen, tuple(notes), of_robot, shares, frozenset(blind | undecided(plan, shares)))


def identify_bands(
    model: RobotModel,
    device: Device,
    approach: Approach,
    evidences: Sequence[Evidence],
    sigma: Array,
    nothings: Sequence[Nothing],
    joints: Sequence[str],
    named: NamedBands | None = None,
) -> StiffnessResult:
    """What `fit_springs` finds, with intervals, and held against itself."""
    springs = fit_springs(model, device, approach, evidences, sigma, nothings, joints, named)
    seen, doubt = springs.seen, springs.doubt
    names = seen.fitted.wear.layout.names
    std = np.sqrt(np.diag(doubt))[: len(names)]
    with np.errstate(invalid="ignore"):
        correlation = doubt[: len(std), : len(std)] / np.outer(std, std)
    edge, criteria = _at_bounds_of_each(seen), model.criteria.support
    return StiffnessResult(
        device=device.name,
        approach=approach,
        bands=tuple(
            _estimate(band, k, springs, edge[k], criteria, named is not None) for k, band in enumerate(device.bands)
        ),
        parameters=names,
        correlation=correlation,
        rms=dict(zip(joints, map(float, rms(seen.setting.logs, seen.fitted.e)), strict=False)),
        samples=int(seen.setting.logs.used[:, : len(joints)].any(axis=1).sum()),
        notes=(*springs.notes, *(() if approach == "prior" else _not_as_stated(springs, criteria))),
        cross_checks=()
        if approach == "prior"
        else within(seen, device.bands, springs.of_robot, criteria, sigma, springs.stated),
        named=_named(springs) if approach in ("A", "B") else (),  # of which findings have theirs
    )


def _named(springs: Springs) -> tuple[NamedLaw, ...]:
    """What is fitted beside the springs."""
    seen, found = springs.seen, list[NamedLaw]()
    wear, std = seen.fitted.wear, np.sqrt(np.diag(springs.doubt))
    at, alone = len(wear.springs), without_shapes(seen.setting, seen.fitted) if wear.added else seen.setting
    for number, added in enumerate(wear.added):
        wire, own = seen.setting.wires[added.wire], std[at : at + len(added.coefficients)]
        told = numbers(added, wire, own, sharpness(thinned(alone), wear, number))
        found.append(NamedLaw(added.effect.name, wire.course.name, told))
        at += len(added.coefficients)
    return tuple(found)


def _stated_laws(device: Device) -> list[Remark]:
    """That a law's values were taken as stated, so that no doubt of them is in what is told."""
    other = [band for band in device.bands if band.law != LINEAR]
    names, laws = tuple(band.name for band in other), tuple(band.law for band in other)
    return [Remark(About.LAW_STATED, names, beside=laws)] if other else []


def _not_as_stated(springs: Springs, criteria: Supporting) -> list[Remark]:
    """That a value of the device file is far from what the logs say: by many standard deviations of these, and by a
    good part of what is doubted of a stated one, within which nothing is named."""
    found = list[Remark]()
    for k, band in enumerate(springs.bands):
        stiffness, length = springs.of(k)
        for about, stated, estimate, doubt in (
            (About.STIFFNESS_NOT_AS_STATED, band.stiffness, stiffness, STIFFNESS_DOUBT),
            (About.LENGTH_NOT_AS_STATED, band.natural_length, length, LENGTH_DOUBT),
        ):
            if stated is None or band.ground_truth or not np.isfinite([estimate.value, estimate.std]).all():
                continue
            least = max(criteria.not_as_stated * estimate.std, criteria.not_as_stated_share * doubt * stated)
            if abs(estimate.value - stated) > least:
                found.append(Remark(about, (band.name,), ((estimate.value, stated),)))
    return found


def undecided(plan: Layout, shares: Mapping[str, Array]) -> set[str]:
    """Values doubted by so much that the samples hold nothing of them: a curvature beside which the scale's own is all,
    of which a finite number of any size may be left by rounding."""
    variance = np.diag(np.sum(list(shares.values()), axis=0))[: len(plan.names)]
    std = np.sqrt(np.where(variance >= 0.0, variance, np.inf))  # below: rounding of what is not known
    return {plan.names[place] for place in np.flatnonzero(~(std < plan.scale / np.sqrt(NULL)))}


def _without_pull(seen: BandFit, known: set[int]) -> set[str]:
    """What belongs to bands that pull nowhere alone: any stiffness explains that, if only they are long enough."""
    plan, pulls = seen.fitted.wear.layout, _pulling(seen)
    told = {*plan.stiffness[pulls].tolist(), *plan.natural_length[pulls].tolist(), *known}
    return {name for index, name in enumerate(plan.names) if index not in told}


def _pulling(seen: BandFit) -> BoolArray:
    """(W,) which bands pull anywhere."""
    least_pull = 1e-3  # [N] of a band: less is none
    wear, wires = seen.fitted.wear, seen.setting.wires
    longest = np.array([wire.longest for wire in wires[: len(wear.k)]])
    return np.asarray(wear.k * (longest - wear.l_0) > least_pull)


def _at_bounds_of_each(seen: BandFit) -> list[tuple[str, ...]]:
    """By band, what is at a bound of all that bears on its stiffness: the group's own, its lengths, what was added."""
    wear, plan = seen.fitted.wear, seen.fitted.wear.layout
    edge, found = at_bounds(wear), list[tuple[str, ...]]()
    added = [each for each in wear.added for _ in each.coefficients]
    for k in range(len(plan.stiffness)):
        shared = np.flatnonzero(plan.stiffness == plan.stiffness[k])
        places = [plan.stiffness[k], *plan.natural_length[shared]]
        names = [plan.names[place] for place in dict.fromkeys(places) if edge[place]]
        beside = zip(added, edge[len(plan.names) :], strict=True)
        names += [each.effect.name for each, reached in beside if reached and each.wire in shared]
        found.append(tuple(dict.fromkeys(names)))
    return found


def _longer_than(seen: BandFit, k: int) -> float:
    """[m] length that a band which pulls nowhere is surely longer than; 0 where nothing is sure. With its stiffness
    known from others, one that began to pull earlier would be seen."""
    place, wire = int(seen.fitted.wear.layout.natural_length[k]), seen.setting.wires[k]

    def excess(length: float) -> float:
        held = fit(seen.setting, seen.fitted.wear, {place: length})
        H, doubt = held.hessian, seen.covariance(replace(held, e=seen.fitted.e))
        share = inverted(H)[place, place] / max(doubt[place, place], 1e-300)
        return float(min(share, 1.0) * (held.cost - seen.fitted.cost) - Z95**2)

    low, high = wire.shortest, wire.longest
    if excess(low) <= 0.0:
        return 0.0
    return float(brentq(excess, low, high, xtol=1e-3 * wire.travel))


def true_stiffness(band: Band) -> float | None:
    """[N/m] where it is known."""
    if band.bench is not None and band.bench.is_truth:
        return bench_line(band.bench).stiffness
    return band.stiffness if band.ground_truth else None


def _estimate(
    band: Band,
    k: int,
    springs: Springs,
    edge: tuple[str, ...],
    criteria: Supporting,
    with_effects: bool,
) -> BandEstimate:
    seen, blind, known = springs.seen, springs.blind, criteria.known
    wear, wire = seen.fitted.wear, seen.setting.wires[k]
    plan, (value, rest) = wear.layout, wear.spring(k)
    own = int(plan.stiffness[k]), int(plan.natural_length[k])
    stiffness, length = springs.of(k)
    stretch, pulls = max(wire.longest - rest, 0.0), bool(_pulling(seen)[k])
    truth, names = true_stiffness(band), [plan.names[place] for place in own]
    k_interval, l_interval = springs.intervals(k)
    if springs.may_be_slack(k, criteria):
        stiffness, length = (replace(each, value=np.nan, std=np.inf, parts={}) for each in (stiffness, length))
        k_interval, l_interval, blind, pulls = (0.0, np.inf), (0.0, np.inf), blind | set(names), False
    if not pulls and np.isfinite(stiffness.std):
        l_interval = (_longer_than(seen, k), np.inf)
    k_known = stiffness.std <= known * value and np.isfinite(k_interval[1]) and not edge
    l_known = length.std <= known * stretch and np.isfinite(l_interval[1]) and not edge
    other = springs.other_stiffness(k, criteria) if k_known or l_known else None
    slack = springs.slack_beside(k) if k_known else ()
    return BandEstimate(
        band=band.name,
        group=band.group,
        stiffness=stiffness,
        natural_length=length,
        stiffness_interval=k_interval,
        natural_length_interval=l_interval,
        true_stiffness=truth,
        error_percent=None if truth is None or names[0] in blind else 100.0 * (value - truth) / truth,
        identifiable=bool(k_known and other is None and not slack),
        length_identifiable=bool(l_known and other is None),
        note=Remark(About.ANOTHER_FIT, (band.name,), numbers=(other,))
        if other is not None
        else Remark(About.ALONE_IN_GROUP, slack, beside=(band.group,))
        if slack
        else _note(band, pulls, names, blind, edge, k_known, l_known),
        with_effects=with_effects,
        longest=wire.longest,
    )


def _note(
    band: Band, pulls: bool, own: Sequence[str], blind: Set[str], edge: tuple[str, ...], k_known: bool, l_known: bool
) -> Remark | None:
    unseen = tuple(name for name in own if name in blind)
    if not pulls and unseen:
        return Remark(About.PULLS_NOWHERE, (band.name,))
    if unseen:
        others = tuple(sorted(blind - set(unseen)))
        return Remark(About.NOT_TOLD_APART, unseen, beside=others) if others else Remark(About.NOT_TOLD, unseen[:1])
    if edge:
        return Remark(About.BOUND_REACHED, edge)
    if not k_known:
        return Remark(About.STIFFNESS_OPEN)
    return None if l_known else Remark(About.LENGTH_OPEN)


def _as_wide_as(estimate: Estimate, interval: tuple[float, float]) -> Estimate:
    """With no less doubt than its interval tells, every part in proportion."""
    half, rounding = (interval[1] - interval[0]) / (2.0 * Z95), 1.0 + 1e-9
    if not np.isfinite([half, estimate.std]).all() or half <= rounding * estimate.std or estimate.std == 0.0:
        return estimate
    parts = {source: each * half / estimate.std for source, each in estimate.parts.items()}
    return replace(estimate, std=half, parts=parts)
