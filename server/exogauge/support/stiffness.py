"""The bands of a device from one approach's supporting torques: values, doubt, and what these motions cannot tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from exogauge.devices.bench_line import bench_line
from exogauge.devices.device import Band, Device
from exogauge.devices.result import Approach, BandEstimate, Estimate, StiffnessResult
from exogauge.devices.routing import Routing
from exogauge.effects.band_laws import LINEAR
from exogauge.identification.model import RobotModel
from exogauge.support.band_fit import BandFit, NamedBands, fit_beside, fit_device, involved
from exogauge.support.band_interval import QUANTILE, interval
from exogauge.support.band_model import fit
from exogauge.support.band_rows import band_wires, rows_with, rows_without
from exogauge.support.band_weights import rms
from exogauge.support.evidence import Evidence, Nothing

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

LEAST_PULL = 1e-3  # [N] of a band: less is none
KNOWN = 0.5  # std over the value (over the largest stretch, for a length) up to which the data decide


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
    """All logs with the device together. sigma: (D,) [N·m] what the approach finds where there is nothing.

    The law that device.yaml states of a band is in the model, its values as stated. named: what a search has named is
    fitted beside the springs, which are then believed as the search believes them: beside hardening, say, a motion
    leaves next to nothing of a spring's own stiffness.
    """
    notes = _stated_laws(device)
    if named is not None and named.approach == approach:
        seen = named.fit
    else:
        columns = np.array([model.robot.tree.joints.index(name) for name in joints])
        logs = rows_with(evidences, approach, columns, joints, model.cutoff_hz)
        null = None if approach == "A" else rows_without(nothings, evidences, approach, columns, joints)
        wires = band_wires(logs, Routing(model.robot.tree, device.bands))
        robot = model.a_priori_covariance if approach == "prior" else model.covariance
        if named is None:
            seen, told = fit_device(device, logs, wires, null, robot, sigma)
            notes += told
        else:
            seen = fit_beside(logs, wires, null, robot, sigma, named.fit)
    fitted, plan = seen.fitted, seen.fitted.wear.layout
    known = {place for place in range(len(plan.names)) if seen.setting.belief.precision[place, place] > 0.0}
    blind = {name for direction in fitted.null_directions for name in involved(plan, direction)}
    blind |= _without_pull(seen, known)
    doubt = seen.covariance(fitted)
    for index, name in enumerate(plan.names):
        if name in blind:
            doubt[index, index] = np.inf
    std = np.sqrt(np.diag(doubt))[: len(plan.names)]
    with np.errstate(invalid="ignore"):
        correlation = doubt[: len(std), : len(std)] / np.outer(std, std)
    return StiffnessResult(
        device=device.name,
        approach=approach,
        bands=tuple(_estimate(band, k, seen, doubt, blind, named) for k, band in enumerate(device.bands)),
        parameters=plan.names,
        correlation=correlation,
        rms=dict(zip(joints, map(float, rms(seen.setting.logs, fitted.e)), strict=False)),
        samples=int(seen.setting.logs.used[:, : len(joints)].any(axis=1).sum()),
        notes=tuple(notes),
    )


def _stated_laws(device: Device) -> list[str]:
    """That a law's values were taken as stated, so that no doubt of them is in what is told."""
    other = [band for band in device.bands if band.law != LINEAR]
    if not other:
        return []
    names = ", ".join(f"{band.name} ({band.law})" for band in other)
    return [f"Fitted with the law that device.yaml states, its values as stated and not doubted: {names}."]


def _without_pull(seen: BandFit, known: set[int]) -> set[str]:
    """What belongs to bands that pull nowhere alone: any stiffness explains that, if only they are long enough."""
    plan, pulls = seen.fitted.wear.layout, _pulling(seen)
    told = {*plan.stiffness[pulls].tolist(), *plan.natural_length[pulls].tolist(), *known}
    return {name for index, name in enumerate(plan.names) if index not in told}


def _pulling(seen: BandFit) -> BoolArray:
    """(W,) which bands pull anywhere."""
    wear, wires = seen.fitted.wear, seen.setting.wires
    longest = np.array([wire.longest for wire in wires[: len(wear.k)]])
    return np.asarray(wear.k * (longest - wear.l_0) > LEAST_PULL)


def _longer_than(seen: BandFit, k: int) -> float:
    """[m] length that a band which pulls nowhere is surely longer than; 0 where nothing is sure. With its stiffness
    known from others, one that began to pull earlier would be seen."""
    place, wire = int(seen.fitted.wear.layout.natural_length[k]), seen.setting.wires[k]

    def excess(length: float) -> float:
        held = fit(seen.setting, seen.fitted.wear, {place: length})
        H, doubt = held.hessian, seen.covariance(replace(held, e=seen.fitted.e))
        size = 1.0 / np.sqrt(np.maximum(np.diag(H), 1e-300))
        curvature = np.linalg.pinv(H * np.outer(size, size), rcond=1e-12, hermitian=True) * np.outer(size, size)
        share = curvature[place, place] / max(doubt[place, place], 1e-300)
        return float(min(share, 1.0) * (held.cost - seen.fitted.cost) - QUANTILE**2)

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
    band: Band, k: int, seen: BandFit, doubt: Array, blind: set[str], named: NamedBands | None
) -> BandEstimate:
    wear, wire = seen.fitted.wear, seen.setting.wires[k]
    plan, (value, rest) = wear.layout, wear.spring(k)
    own = k_at, l_at = int(plan.stiffness[k]), int(plan.natural_length[k])
    k_std, l_std = (float(np.sqrt(doubt[place, place])) for place in own)
    stretch, pulls = max(wire.longest - rest, 0.0), bool(_pulling(seen)[k])
    truth, names = true_stiffness(band), [plan.names[place] for place in own]
    k_interval = interval(seen.setting, seen.fitted, doubt, k_at, value)
    l_interval = interval(seen.setting, seen.fitted, doubt, l_at, stretch)
    if not pulls and np.isfinite(k_std):
        l_interval = (_longer_than(seen, k), np.inf)
    k_known, l_known = k_std <= KNOWN * value and np.isfinite(k_interval[1]), l_std <= KNOWN * stretch
    stiffness, length = (
        Estimate(np.nan if name in blind else float(wear.springs[place]), float(np.sqrt(doubt[place, place])), unit)
        for name, place, unit in zip(names, own, ("N/m", "m"), strict=True)
    )
    return BandEstimate(
        band=band.name,
        group=band.group,
        stiffness=stiffness,
        natural_length=length,
        stiffness_interval=k_interval,
        natural_length_interval=l_interval,
        true_stiffness=truth,
        error_percent=None if truth is None or names[0] in blind else 100.0 * (value - truth) / truth,
        identifiable=bool(k_known),
        length_identifiable=bool(l_known),
        note=_note(band, pulls, names, blind, k_known, l_known),
        with_effects=named is not None,
        longest=wire.longest,
    )


def _note(band: Band, pulls: bool, own: Sequence[str], blind: set[str], k_known: bool, l_known: bool) -> str:
    unseen = [name for name in own if name in blind]
    if not pulls and unseen:
        return f"{band.name} pulls nowhere in these motions, as if slack throughout: they say nothing of it."
    if unseen:
        others = ", ".join(sorted(blind - set(unseen)))
        from_others = f"cannot tell {' and '.join(unseen)} from {others}" if others else f"say nothing of {unseen[0]}"
        return f"These motions {from_others}."
    if not k_known:
        return "The doubt is more than half of the value: a motion that stretches this band further would decide."
    return "" if l_known else "The natural length is hardly decided by these motions."
