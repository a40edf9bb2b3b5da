"""Stiffness against itself: parts of the same evidence that ought to agree, and by how much they do not.

The springs of the fit are let differ between two parts, everything else is kept, and one Gauss-Newton step from the
common fit says by how much they do: with the columns split in two, A = (A₁, A₂), δ = H₁⁻¹ A₁ᵀ w e - H₂⁻¹ A₂ᵀ w e. All
doubts of the fit go through the same split columns, so that what both parts share (a gain, a via point) is taken off.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from exogauge.criteria.supporting import Supporting
from exogauge.devices.device import Band
from exogauge.devices.result import BandEstimate, CrossCheck, StiffnessResult
from exogauge.remarks import About, Remark
from exogauge.support.band_doubt import contributions
from exogauge.support.band_fit import BandFit
from exogauge.support.band_model import NULL, Belief, Fitted, Setting, columns, each_its_own, information
from exogauge.support.band_offsets import without_offsets

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

SAID = {
    "approaches": About.APPROACHES_DISAGREE,
    "repetitions": About.REPETITIONS_DISAGREE,
    "strokes": About.STROKES_DISAGREE,
    "sides": About.SIDES_DISAGREE,
}
LENGTHENING, SHORTENING = "lengthening", "shortening"


def within(
    seen: BandFit, bands: Sequence[Band], robot: Mapping[str, Array], criteria: Supporting
) -> tuple[CrossCheck, ...]:
    """Of one approach: each log against all others, bands that lengthen against the same that shorten, and bands of a
    group against each other. robot: as in `contributions`. What the motions cannot tell apart is not compared."""
    found = list[tuple[float, CrossCheck]]()
    layout, wear, logs = seen.fitted.wear.layout, seen.fitted.wear, seen.setting.logs
    for place in np.unique(layout.stiffness):
        members = np.flatnonzero(layout.stiffness == place)
        group, value = bands[int(members[0])].group, float(wear.springs[place])
        for number, log in enumerate(logs.logs):
            if len(logs.logs) > 1 and (number == 0 or len(logs.logs) > 2):
                pair = (log.name, logs.logs[1].name if len(logs.logs) == 2 else "others")
                found += _between_samples(seen, robot, int(place), logs.log == number, "repetitions", group, pair)
        rate = np.sum([seen.setting.wires[k].rate for k in members], axis=0)
        pair = (LENGTHENING, SHORTENING)
        found += _between_samples(seen, robot, int(place), rate > 0.0, "strokes", group, pair)
        if not wear.added:
            found += _between_bands(seen, bands, robot, members.tolist(), value)
    return tuple(each for value, each in found if 0.0 < each.std <= criteria.known * value)


def _between_samples(
    seen: BandFit,
    robot: Mapping[str, Array],
    place: int,
    first: BoolArray,
    check: str,
    group: str,
    between: tuple[str, str],
) -> Iterator[tuple[float, CrossCheck]]:
    """first: (N,) samples of one part; the others are the other. place: of the stiffness."""
    fitted, setting = seen.fitted, _believing_nothing(seen.setting)
    S = len(fitted.wear.springs)
    springs, more = fitted.A[:, :, :S], fitted.A[:, :, S:]
    parts = [springs * part[:, None, None] for part in (first, ~first)]
    A = np.concatenate([*parts, more], axis=2)
    contrast = np.zeros(A.shape[2])
    contrast[place], contrast[S + place] = 1.0, -1.0
    shares = [float(np.sum(setting.weight[part] * fitted.A[part][:, :, place] ** 2)) for part in (first, ~first)]
    whole = max(sum(shares), 1e-300)
    # What logs without the device say is not split: each part is taken to err by all of it, independently.
    yield from _compared(
        replace(seen, setting=setting, null=None),
        _with_columns(setting, fitted, A),
        robot,
        contrast,
        _null_of_fit(seen, place) * np.sqrt(2.0) if min(shares) > NULL * whole else 0.0,
        float(fitted.wear.springs[place]),
        (check, group, between),
    )


def _between_bands(
    seen: BandFit, bands: Sequence[Band], robot: Mapping[str, Array], members: Sequence[int], value: float
) -> Iterator[tuple[float, CrossCheck]]:
    """Every band its own stiffness; each pair of a group."""
    if len(members) < 2:
        return
    wear, layout = seen.fitted.wear, each_its_own(bands)
    own = replace(wear, layout=layout, springs=np.concatenate([wear.k, wear.l_0]))
    setting = replace(seen.setting, belief=Belief(own.springs, np.zeros((len(own.springs), len(own.springs)))))
    alone = replace(seen.fitted, wear=own)
    A = columns(setting.logs, setting.wires, own)
    for one, other in combinations(members, 2):
        contrast = np.zeros(A.shape[2])
        contrast[layout.stiffness[one]], contrast[layout.stiffness[other]] = 1.0, -1.0
        said = ("sides", bands[one].group, (bands[one].name, bands[other].name))
        yield from _compared(
            replace(seen, setting=setting), _with_columns(setting, alone, A), robot, contrast, 0.0, value, said
        )


def _compared(
    seen: BandFit,
    split: Fitted,
    robot: Mapping[str, Array],
    contrast: Array,
    beside: float,
    value: float,
    said: tuple[str, str, tuple[str, str]],
) -> Iterator[tuple[float, CrossCheck]]:
    """The step's difference along the contrast; nothing where the data hold none. value, beside: [N/m] the
    stiffness, which goes with it, and further doubt."""
    H = split.hessian
    size = 1.0 / np.sqrt(np.maximum(np.diag(H), 1e-300))
    curvature, vectors = np.linalg.eigh(H * np.outer(size, size))
    blind = vectors[:, curvature <= NULL * len(H)] * size[:, None]
    chosen = np.flatnonzero(contrast)
    if np.any(np.diag(H)[chosen] <= 0.0) or np.any(np.abs(contrast @ blind) > 1e-6 * size[chosen].max()):
        return
    score = np.einsum("ndp,nd,nd->p", split.A, seen.setting.weight, split.e)
    step = np.linalg.lstsq(H * np.outer(size, size), size * score, rcond=1e-12)[0] * size
    explained = without_offsets(seen.setting.logs, seen.setting.weight, split.A @ step)
    let_differ = replace(split, e=split.e - explained)  # or a disagreement would count as scatter
    shares = contributions(seen.setting, let_differ, robot, seen.null, seen.joint_weight)
    variance = sum(float(contrast @ each @ contrast) for each in shares.values()) + beside**2
    yield value, CrossCheck(*said, float(contrast @ step), float(np.sqrt(max(variance, 0.0))))


def _null_of_fit(seen: BandFit, place: int) -> float:
    """[N/m] what the null test is in the doubt of a stiffness."""
    if seen.null is None:
        return 0.0
    found = contributions(seen.setting, seen.fitted, {}, seen.null, seen.joint_weight).get("null_test")
    return 0.0 if found is None else float(np.sqrt(max(found[place, place], 0.0)))


def _believing_nothing(setting: Setting) -> Setting:
    S = len(setting.belief.mean)
    return replace(setting, belief=Belief(setting.belief.mean, np.zeros((S, S))))


def _with_columns(setting: Setting, fitted: Fitted, A: Array) -> Fitted:
    return replace(fitted, A=A, hessian=information(setting, A))


def judged(found: Sequence[StiffnessResult], criteria: Supporting) -> tuple[StiffnessResult, ...]:
    """With the approaches held against each other, all checks of a device at one level, and what fails no longer
    identifiable."""
    result = list(found)
    for device in dict.fromkeys(each.device for each in found):
        own = [k for k, each in enumerate(found) if each.device == device and each.approach != "prior"]
        between = {k: _against_others(found[k], [found[n] for n in own if n != k]) for k in own}
        count = sum(len(found[k].cross_checks) for k in own) + sum(len(each) for each in between.values()) // 2
        limit = float(norm.isf(0.5 * criteria.false_alarms / max(count, 1)))
        for k in own:
            inside = [each for each in found[k].cross_checks if each.check != "approaches"]
            checks = tuple(replace(each, limit=limit) for each in (*inside, *between[k]))
            bands = tuple(_told(band, checks) for band in found[k].bands)
            result[k] = replace(found[k], bands=bands, cross_checks=checks)
    return tuple(result)


def _against_others(one: StiffnessResult, others: Sequence[StiffnessResult]) -> list[CrossCheck]:
    """Their errors count as independent: they share logs, which makes errors alike, so the doubt is overstated."""
    checks = list[CrossCheck]()
    for other in others:
        theirs = {band.group: band for band in other.bands}
        for group, band in {band.group: band for band in one.bands}.items():
            if band.identifiable and theirs[group].identifiable:
                difference = band.stiffness.value - theirs[group].stiffness.value
                std = float(np.hypot(band.stiffness.std, theirs[group].stiffness.std))
                if std > 0.0:
                    checks.append(CrossCheck("approaches", group, (one.approach, other.approach), difference, std))
    return checks


def _told(band: BandEstimate, checks: Sequence[CrossCheck]) -> BandEstimate:
    """Not identifiable where a check fails, with the worst in the note."""
    failed = [each for each in checks if each.group == band.group and not each.agrees]
    if not failed or not band.identifiable:
        return band
    worst = max(failed, key=lambda each: abs(each.z))
    note = Remark(SAID[worst.check], worst.between, numbers=(worst.difference, worst.std))
    return replace(band, identifiable=False, note=note)
