"""The bands of a device from one approach's supporting torques: values, doubt, and what these motions cannot tell."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.band_fit import (
    NULL,
    BandFit,
    Belief,
    Layout,
    Reduced,
    at,
    fit_bands,
    layout,
    null_directions,
)
from exogauge.devices.band_intervals import interval
from exogauge.devices.bench_line import bench_line
from exogauge.devices.device import Band, Device
from exogauge.devices.result import Approach, BandEstimate, Estimate, StiffnessResult
from exogauge.effects.band_laws import LINEAR
from exogauge.identification.model import RobotModel
from exogauge.support.band_doubt import NullLog, covariance
from exogauge.support.band_samples import BandSamples, band_samples
from exogauge.support.evidence import Evidence

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

WEIGHINGS = 2  # of fitting and weighing the joints by what is left
SHARE = 0.2  # of a unit direction: a parameter with more is part of it
LEAST_PULL = 1e-3  # [N] of a band: less is none
KNOWN = 0.5  # std over the value (over the largest stretch, for a length) up to which the data decide


def identify_bands(
    model: RobotModel,
    device: Device,
    approach: Approach,
    evidences: Sequence[Evidence],
    sigma: Array,
    null_logs: Sequence[NullLog],
    joints: Sequence[str],
) -> StiffnessResult:
    """All logs with the device together. sigma: (D,) [N·m] what the approach finds where there is nothing."""
    samples = band_samples(evidences, approach)
    plan, fit, left, notes = _fit(device, samples, sigma)
    beliefs = _beliefs(device.bands, plan)
    if beliefs:
        left = left * _overstated(
            model, approach, at(plan, fit.reduced, fit.theta), samples, left, evidences, null_logs
        )
        fit = fit_bands(plan, Reduced(samples.weighted(left)), beliefs)
    blind = {name for direction in null_directions(fit) for name in _involved(plan, direction)}
    blind |= _without_pull(plan, fit, beliefs)
    doubt = covariance(model, approach, fit, samples, left, evidences, null_logs, beliefs)
    for index, name in enumerate(plan.names):
        if name in blind:
            doubt[index, index] = np.inf
    std = np.sqrt(np.diag(doubt))
    with np.errstate(invalid="ignore"):
        correlation = doubt / np.outer(std, std)
    return StiffnessResult(
        device=device.name,
        approach=approach,
        bands=tuple(_estimate(band, k, fit, doubt, blind, beliefs) for k, band in enumerate(device.bands)),
        parameters=plan.names,
        correlation=correlation,
        rms=dict(zip(joints, map(float, samples.rms(fit)), strict=True)),
        samples=int(samples.used.any(axis=1).sum()),
        notes=notes,
    )


def _fit(device: Device, samples: BandSamples, sigma: Array) -> tuple[Layout, BandFit, Array, tuple[str, ...]]:
    """Fit; tie natural lengths of a group where the motions cannot tell them apart, say so, and fit again."""
    tied, notes = device.tied, _other_laws(device)
    while True:
        plan = layout(device.bands, tied)
        fit, left = _weighed_fit(device.bands, plan, samples, sigma)
        group = _inseparable(plan, fit, device, tied)
        if group is None:
            return plan, fit, left, tuple(notes)
        tied |= {group}
        names = " and ".join(band.name for band in device.bands if band.group == group)
        notes.append(
            f"These motions cannot tell the natural lengths of {names} apart, so one is given for all of them. "
            "A motion that lengthens them differently, such as a twist beside a bend, would."
        )


def _other_laws(device: Device) -> list[str]:
    """That the fit knows straight springs alone, where a band is stated to be something else."""
    other = [band for band in device.bands if band.law != LINEAR]
    if not other:
        return []
    names = ", ".join(f"{band.name} ({band.law})" for band in other)
    return [
        f"Every band was fitted as a straight spring. Of {names} device.yaml states another law: their stiffness and "
        "natural length are those of the straight spring that is nearest to it in these motions."
    ]


def _weighed_fit(bands: Sequence[Band], plan: Layout, samples: BandSamples, sigma: Array) -> tuple[BandFit, Array]:
    """A joint counts by what the bands leave on it, at least by what is there without a device."""
    left, beliefs = sigma, _beliefs(bands, plan)
    for _ in range(WEIGHINGS):
        weights = left
        fit = fit_bands(plan, Reduced(samples.weighted(weights)), beliefs)
        left = np.maximum(sigma, samples.rms(fit))
    return fit, weights


def _overstated(
    model: RobotModel,
    approach: Approach,
    alone: BandFit,
    samples: BandSamples,
    sigma: Array,
    evidences: Sequence[Evidence],
    null_logs: Sequence[NullLog],
) -> float:
    """By how much too small sigma is for what the data alone tell, at least 1. alone: the fit without beliefs in it.

    Errors last, and those of the robot's parameters are alike at every sample; a bench test must be weighed against
    what the data are worth, not against their number.
    """
    doubt = covariance(model, approach, alone, samples, sigma, evidences, null_logs, ())
    scale = alone.layout.scale
    H = alone.hessian * np.outer(scale, scale)
    seen = int(np.sum(np.linalg.eigvalsh(H) > NULL * np.trace(H)))
    return float(np.sqrt(max(1.0, np.trace(alone.hessian @ doubt) / max(seen, 1))))


def _inseparable(plan: Layout, fit: BandFit, device: Device, tied: frozenset[str]) -> str | None:
    """A group whose natural lengths alone make up a direction that the data do not see."""
    for direction in null_directions(fit):
        involved = _involved(plan, direction)
        bands = [band for band in device.bands if f"natural_length[{band.name}]" in involved]
        groups = {band.group for band in bands}
        if len(bands) > 1 and len(bands) == len(involved) and len(groups) == 1 and not groups <= tied:
            return groups.pop()
    return None


def _involved(plan: Layout, direction: Array) -> list[str]:
    return [name for name, share in zip(plan.names, direction, strict=True) if abs(share) > SHARE]


def _without_pull(plan: Layout, fit: BandFit, beliefs: Sequence[Belief]) -> set[str]:
    """What belongs to bands that pull nowhere alone: any stiffness explains that, if only they are long enough."""
    pulls = _pulling(fit)
    known = {*plan.stiffness[pulls].tolist(), *plan.natural_length[pulls].tolist(), *(b.index for b in beliefs)}
    return {name for index, name in enumerate(plan.names) if index not in known}


def _pulling(fit: BandFit) -> BoolArray:
    """(W,) which bands pull anywhere."""
    return np.asarray(fit.tension.max(axis=0) > LEAST_PULL)


def _beliefs(bands: Sequence[Band], plan: Layout) -> list[Belief]:
    """What bench tests say that are not kept as the truth to compare with."""
    beliefs = {}
    for k, band in enumerate(bands):
        if band.bench is not None and not band.bench.is_truth:
            line = bench_line(band.bench)
            k_at, l_at = int(plan.stiffness[k]), int(plan.natural_length[k])
            beliefs[k_at] = Belief(k_at, line.stiffness, line.stiffness_std)
            beliefs[l_at] = Belief(l_at, line.natural_length, line.natural_length_std)
    return list(beliefs.values())


def true_stiffness(band: Band) -> float | None:
    """[N/m] where it is known."""
    if band.bench is not None and band.bench.is_truth:
        return bench_line(band.bench).stiffness
    return band.stiffness if band.ground_truth else None


def _estimate(
    band: Band, k: int, fit: BandFit, doubt: Array, blind: set[str], beliefs: Sequence[Belief]
) -> BandEstimate:
    plan = fit.layout
    k_at, l_at = int(plan.stiffness[k]), int(plan.natural_length[k])
    value, rest = float(fit.theta[k_at]), float(fit.theta[l_at])
    k_std, l_std = (float(np.sqrt(doubt[i, i])) for i in (k_at, l_at))
    stretch = max(float(fit.reduced.length[k].max()) - rest, 0.0)
    truth = true_stiffness(band)
    k_interval = interval(fit, doubt, k_at, value, beliefs)
    k_known, l_known = k_std <= KNOWN * value and np.isfinite(k_interval[1]), l_std <= KNOWN * stretch
    return BandEstimate(
        band=band.name,
        group=band.group,
        stiffness=Estimate(value, k_std, "N/m"),
        natural_length=Estimate(rest, l_std, "m"),
        stiffness_interval=k_interval,
        natural_length_interval=interval(fit, doubt, l_at, stretch, beliefs),
        true_stiffness=truth,
        error_percent=None if truth is None else 100.0 * (value - truth) / truth,
        identifiable=bool(k_known),
        length_identifiable=l_known,
        note=_note(band, bool(_pulling(fit)[k]), [plan.names[k_at], plan.names[l_at]], blind, k_known, l_known),
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
