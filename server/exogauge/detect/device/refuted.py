"""Names that are taken back or not given, as what is there follows another law than theirs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.detect.device.baseline import Ground, weighed
from exogauge.detect.device.finding import CHANNEL
from exogauge.detect.device.judge import Folds, left_out_residual, rmse
from exogauge.detect.device.laws import Laws
from exogauge.detect.device.left_over import unexplained
from exogauge.detect.device.nominal import Contradicted
from exogauge.findings.result import Alternative
from exogauge.findings.verdict import Objection, Why
from exogauge.search.judge import not_named
from exogauge.support.band_model import fit

Array = NDArray[np.float64]


def of_their_laws(laws: Laws, folds: Folds) -> Laws:
    """Without the laws that leave, of what there was beside springs, as much as the noise and more than a law does that
    is not quite right: what is there follows another. A further band, whose course is hardly ever right, stays."""
    first, ground, findings = laws.first, laws.ground, laws.findings
    if not findings:
        return laws
    was, now = (left_out_residual(each.setting, each.fitted, folds) for each in (first, ground))
    kept, refuted, last = list[int](), list[Alternative](), laws.wears[-1]
    for number, (finding, added) in enumerate(zip(findings, last.added, strict=True)):
        joint = ground.joints.index(finding.held_out.channel.removeprefix(CHANNEL))
        held = replace(finding.held_out, rmse_before=rmse(was, joint), rmse_after=rmse(now, joint))
        if added.effect.sort != "wire" and held.of_another_law(ground.model.criteria.judging):
            why = Objection(Why.OTHER_LAW, held.explained, held.floors, of=(held.channel,))
            refuted.append(not_named(finding, why))
        else:
            kept.append(number)
    if not refuted:
        return laws
    wears = tuple(replace(last, added=tuple(last.added[k] for k in kept[:n])) for n in range(len(kept) + 1))
    return replace(
        laws,
        ground=weighed(ground, fit(ground.setting, wears[-1])),
        wears=wears,
        findings=tuple(replace(findings[k], rank=findings[0].rank + n) for n, k in enumerate(kept)),
        rejected=(*laws.rejected, *refuted),
    )


def why_no_number(ground: Ground, found: Contradicted, left: Array) -> Objection | None:
    """Why a number of a spring is not told although it contradicts what is stated. left: (N, D) [N·m] with all such
    numbers let go."""
    return _no_spring(ground, found, left) or _beside_a_wire(found)


def _no_spring(ground: Ground, found: Contradicted, left: Array) -> Objection | None:
    """It is wrong only where the bands of its group are springs: where they leave surely more than the noise at a joint
    that they act on, whatever their numbers, they follow another law. left: as above."""
    bands = ground.device.bands
    group = [b for b, each in enumerate(bands) if each.group == bands[found.band].group]
    acts = np.abs(found.fitted.A[:, :, group]).max(axis=(0, 2)) > 0.0
    own = {f"{CHANNEL}{name}" for name, there in zip(ground.joints, acts, strict=True) if there}
    excess = [each for each in unexplained(ground, left) if each.channel in own]
    if not excess:
        return None
    worst = max(excess, key=lambda each: each.rmse / each.noise_floor)
    was, now = (rmse(each, found.joint) ** 2 for each in (found.before, found.after))
    return Objection(Why.OTHER_LAW, 1.0 - now / was, worst.rmse / worst.noise_floor, of=(worst.channel,))


def _beside_a_wire(found: Contradicted) -> Objection | None:
    """A further band and springs that act on the same joint share what they do: its course is hardly ever quite right,
    and their numbers make up for it."""
    wear, places = found.fitted.wear, [found.band]
    start = len(wear.springs)
    for each in wear.added:
        if each.effect.sort == "wire":
            places.append(start)
        start += len(each.coefficients)
    acts = np.abs(found.fitted.A[:, :, places]).max(axis=0) > 0.0  # (D, 1 + wires)
    shared = (acts[:, :1] & acts[:, 1:]).any()
    return Objection(Why.ALIKE) if shared else None
