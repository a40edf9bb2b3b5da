"""The springs of a device, fitted from nothing: every joint weighed by what is left on it, from several starts.

The search begins with every band taut at every sample, and again with bands that come taut part-way, because with all
bands slack the slope is exactly zero. Natural lengths of a group that the motions cannot tell apart are tied.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.bench import bench_line
from exogauge.devices.device import Band, Device
from exogauge.remarks import About, Remark
from exogauge.support.band_doubt import covariance
from exogauge.support.band_inputs import nuisance_torques
from exogauge.support.band_model import (
    NULL,
    SHORTEST,
    SMALL,
    Added,
    Belief,
    Fitted,
    Layout,
    Reached,
    Setting,
    Wear,
    at,
    columns,
    declared_laws,
    fit,
    lowest,
    shared,
    thinned,
)
from exogauge.support.band_rows import WearLogs, Wire
from exogauge.support.band_weights import memories, spread, weights
from exogauge.support.named_laws import with_best_shapes

Array = NDArray[np.float64]

STARTS = (0.0, 0.3, 0.6)  # share of a band's travel at which it comes taut, where the search begins
USUAL_STIFFNESS = 100.0  # [N/m] where the search begins if the samples call for none
SHARE = 0.2  # of a unit direction: a value with more is part of it


@final
@dataclass(frozen=True)
class BandFit:
    """What the samples say. robot: covariance of its parameters. null: logs without the device as if it were on. joints
    of the setting: those of the result come first. beyond: (P,) by which theta would be another if shapes of what was
    named could not go on, along their slopes, beyond all that the law can be."""

    robot: Array
    null: Setting | None
    setting: Setting
    fitted: Fitted
    beyond: Array | None = None

    def covariance(self, fitted: Fitted) -> Array:
        """(P, P) of theta about the truth."""
        return covariance(self.setting, fitted, self.robot, self.null)


@final
@dataclass(frozen=True)
class NamedBands:
    """A device with what a search has named of its bands: the fit that the search ended with, in which every band has
    its own values, and further wires run behind the declared bands."""

    device: Device
    fit: BandFit


def fit_device(
    device: Device, logs: WearLogs, wires: tuple[Wire, ...], null: WearLogs | None, robot: Array, sigma: Array
) -> tuple[BandFit, list[Remark]]:
    """Fit; tie natural lengths of a group where the motions cannot tell them apart, say so, and fit again."""
    tied, notes = device.tied, list[Remark]()
    while True:
        plan = shared(device.bands, tied)
        belief, laws = _bench_belief(device.bands, plan), declared_laws(device.bands)
        seen = _weighed_fit(logs, wires, null, robot, sigma, belief, starts(plan, wires, laws))
        group = _inseparable(plan, seen.fitted, device, tied)
        if group is None:
            return (_beside_beliefs(seen) if belief.precision.any() else seen), notes
        tied |= {group}
        names = tuple(band.name for band in device.bands if band.group == group)
        notes.append(Remark(About.LENGTHS_TIED, names))


def fit_beside(
    logs: WearLogs,
    wires: tuple[Wire, ...],
    null: WearLogs | None,
    robot: Array,
    sigma: Array,
    named: BandFit,
) -> BandFit:
    """With what was named beside the springs, believed as the search believes them, at the shapes that suit it best
    with what is declared beside it, too."""
    wear, W = named.fitted.wear, len(wires)
    wires += tuple(logs.wire(wire.course) for wire in named.setting.wires[W:])
    return _beside_beliefs(_weighed_fit(logs, wires, null, robot, sigma, named.setting.belief, [wear]))


def without_shapes(setting: Setting, fitted: Fitted) -> Setting:
    """With all that is fitted beside the springs but the shapes of what was named."""
    return replace(setting, added=nuisance_torques(setting, fitted, shapes=False))


def _weighed_fit(
    logs: WearLogs,
    wires: tuple[Wire, ...],
    null: WearLogs | None,
    robot: Array,
    sigma: Array,
    belief: Belief,
    begin: Sequence[Wear],
) -> BandFit:
    """A joint counts by what is left on it and how long that lasts, at least by what is there without a device.
    What is declared is fitted beside the springs as soon as there are some: a fit without it bends to it. The best of
    several starts, refined on all samples."""
    setting = Setting(logs, wires, *weights(logs, sigma, np.ones(len(sigma))), belief)
    fitted = fit(setting, best_start(setting, begin))
    for others in (begin, ()):  # the best of several without what is declared may not be the best with it
        memory = memories(logs, fitted.e)
        left = spread(logs, fitted.e, sigma / np.sqrt(memory))
        weight, independent = weights(logs, left, memory)
        setting = replace(setting, weight=weight, independent=independent)
        setting = replace(setting, added=nuisance_torques(setting, fitted))
        fitted = fit(setting, best_start(setting, [fitted.wear, *others]))
    beyond = None
    if fitted.wear.added:
        alone = without_shapes(setting, fitted)
        within = fit(alone, with_best_shapes(alone, fitted.wear))
        setting = replace(setting, added=nuisance_torques(setting, within))
        fitted = fit(setting, within.wear)
        beyond = fitted.wear.theta - within.wear.theta
    return BandFit(robot, null_test(null, setting, fitted, 1.0 / (left**2 * memory)), setting, fitted, beyond)


def null_test(logs: WearLogs | None, setting: Setting, fitted: Fitted, counts: Array) -> Setting | None:
    """Logs without the device as if it were on, with what is fitted beside the bands there. counts: (D,) [1/(N·m)²] a
    sample."""
    if logs is None:
        return None
    wires, weight = tuple(logs.wire(wire.course) for wire in setting.wires), logs.used * counts
    null = Setting(logs, wires, weight, setting.independent, setting.belief)
    if setting.added is None:
        return null
    return replace(null, added=nuisance_torques(null, replace(fitted, A=columns(logs, wires, fitted.wear))))


def best_start(setting: Setting, begin: Sequence[Wear]) -> Wear:
    """Of several, downhill from each on few samples."""
    if len(begin) == 1:
        return begin[0]
    return min(downhill(thinned(setting), begin), key=lambda each: each.cost).wear


def downhill(setting: Setting, begin: Sequence[Wear], small: float = SMALL) -> list[Reached]:
    """Where each start ends. small: as in `lowest`."""
    return [lowest(setting, _with_best_stiffness(setting, each), small=small) for each in begin]


def starts(plan: Layout, wires: Sequence[Wire], laws: tuple[Added, ...]) -> list[Wear]:
    """Bands that come taut at a share of their travel: taut throughout, or part-way."""
    found = []
    for share in STARTS:
        springs = np.full(len(plan.names), USUAL_STIFFNESS)
        for place, wire in zip(plan.natural_length, wires, strict=True):
            begin = wire.shortest - 0.02 if share == 0.0 else wire.shortest + share * wire.travel
            springs[place] = max(begin, SHORTEST)
        found.append(Wear(plan, springs, laws))
    return found


def _with_best_stiffness(setting: Setting, start: Wear) -> Wear:
    """Natural lengths as they are; a usual stiffness where they call for none, or the band were lost to the search."""
    begun = at(setting, start)
    own = np.unique(start.layout.stiffness)
    g = np.einsum("ndp,nd,nd->p", begun.A, setting.weight, begun.e)[own]
    k = start.springs[own] + np.linalg.lstsq(begun.hessian[np.ix_(own, own)], g, rcond=NULL)[0]
    springs = start.springs.copy()
    springs[own] = np.where(k > 1.0, k, USUAL_STIFFNESS)
    return replace(start, springs=springs)


def _beside_beliefs(seen: BandFit) -> BandFit:
    """Samples weighed by what they alone tell: errors last, and those of the robot's parameters are alike at every
    sample; what is believed must be weighed against what the samples are worth, not against their number."""
    S = len(seen.setting.belief.mean)
    nothing = replace(seen.setting, belief=Belief(seen.setting.belief.mean, np.zeros((S, S))))
    alone = at(nothing, seen.fitted)
    doubt = covariance(nothing, alone, seen.robot, seen.null)
    size = 1.0 / np.sqrt(np.maximum(np.diag(alone.hessian), 1e-300))
    known = int(np.sum(np.linalg.eigvalsh(alone.hessian * np.outer(size, size)) > NULL * len(size)))
    overstated = float(max(1.0, np.trace(alone.hessian @ doubt) / max(known, 1)))
    setting = replace(seen.setting, weight=seen.setting.weight / overstated)
    fitted = fit(setting, seen.fitted)
    null = None if seen.null is None else replace(seen.null, weight=seen.null.weight / overstated)
    return replace(seen, setting=setting, fitted=fitted, null=null)


def _inseparable(plan: Layout, fitted: Fitted, device: Device, tied: frozenset[str]) -> str | None:
    """A group whose natural lengths alone make up a direction that the data do not see."""
    for direction in fitted.null_directions:
        own = involved(plan, direction)
        bands = [band for band in device.bands if f"natural_length[{band.name}]" in own]
        groups = {band.group for band in bands}
        if len(bands) > 1 and len(bands) == len(own) and len(groups) == 1 and not groups <= tied:
            return groups.pop()
    return None


def involved(plan: Layout, direction: Array) -> list[str]:
    return [name for name, share in zip(plan.names, direction, strict=True) if abs(share) > SHARE]


def _bench_belief(bands: Sequence[Band], plan: Layout) -> Belief:
    """What bench tests say that are not kept as the truth to compare with."""
    mean, precision = np.zeros(len(plan.names)), np.zeros(len(plan.names))
    for k, band in enumerate(bands):
        if band.bench is not None and not band.bench.is_truth:
            line, of_k, of_l = bench_line(band.bench), plan.stiffness[k], plan.natural_length[k]
            mean[of_k], precision[of_k] = line.stiffness, line.stiffness_std**-2
            mean[of_l], precision[of_l] = line.natural_length, line.natural_length_std**-2
    return Belief(mean, np.diag(precision))
