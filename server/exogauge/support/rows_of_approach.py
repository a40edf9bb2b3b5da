"""Rows of bands from what an approach says of logs: with the wear on, and without it as if it were on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exogauge.devices.result import Approach
from exogauge.logs.filtering import LowPass
from exogauge.robots.tree import IntArray
from exogauge.support.band_rows import WearLog, WearLogs
from exogauge.support.evidence import Evidence, Nothing

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
Beside = tuple[Array, BoolArray]  # further columns: torque, and where it counts

DENSE = 12.0  # samples in a period of the cut-off: what rubs is followed from sample to sample


def rows_with(
    evidences: Sequence[Evidence],
    approach: Approach,
    joints: IntArray,
    names: Sequence[str],
    cutoff_hz: float,
    beside: Mapping[str, Beside] | None = None,
    zero_std: Array | None = None,
) -> WearLogs:
    """Logs with the wear on. A counts where both runs move with the same friction, B, the paired estimate and
    the prior where this run moves steadily. beside: further joints, by log. zero_std: (D,) [N·m] of one run's constant
    torque; what compares two runs has that of both."""
    if zero_std is not None and approach in ("A", "paired"):
        zero_std = np.sqrt(2.0) * zero_std
    found = [_with(each, approach, cutoff_hz, beside) for each in evidences]
    return WearLogs([replace(each, zero_std=zero_std) for each in found], joints, names)


def rows_without(
    nothings: Sequence[Nothing],
    evidences: Sequence[Evidence],
    approach: Approach,
    joints: IntArray,
    names: Sequence[str],
    beside: Mapping[str, Sequence[Beside]] | None = None,
    zero_std: Array | None = None,
) -> WearLogs | None:
    """Logs without the wear as if it were on, of the motions of those with it; None where there are none. Each stands
    for its share of them. beside: further joints, by motion in the order of its logs."""
    worn = [each.worn.motion for each in evidences]
    logs, places = list[WearLog](), dict[str, int]()
    for each in nothings:
        place = places[each.motion] = places.get(each.motion, -1) + 1
        if each.motion not in worn:
            continue
        pair = np.where(each.steady, each.a_priori if approach == "prior" else each.b, 0.0), each.steady
        if beside is not None:
            pair = _joined(pair, beside[each.motion][place])
        share = worn.count(each.motion) / sum(other.motion == each.motion for other in nothings)
        time, kept = each.time - each.time[0], np.arange(len(each.time))
        own = WearLog("", each.motion, time, each.posture, kept, *pair, each.sloped, None, share=share,
                      own=each.own, session=each.session, anew=each.anew, zero_std=zero_std)  # fmt: skip
        logs.append(own)
    return WearLogs(logs, joints, names) if logs else None


def _with(evidence: Evidence, approach: Approach, cutoff_hz: float, beside: Mapping[str, Beside] | None) -> WearLog:
    log, kept = evidence.worn.log, evidence.kept
    dense, step = _dense(kept, log.samples, log.rate_hz / (DENSE * cutoff_hz))
    torque, used = evidence.a_priori if approach == "prior" else evidence.b, evidence.steady
    inputs = evidence.inputs({"A": "a", "paired": "paired"}.get(approach, "b"))
    partner, ahead = "", 0.0
    if approach in ("A", "paired") and evidence.reference is not None and evidence.found is not None:
        partner, ahead = evidence.reference, evidence.found.lag_s
    if approach == "A":
        assert evidence.a is not None
        torque, used = evidence.a, evidence.compared & np.isfinite(evidence.a)
    if approach == "paired":
        assert evidence.paired is not None
        torque, used = evidence.paired, used & np.isfinite(evidence.paired)
    pair = np.where(used, torque, 0.0)[kept], used[kept]
    if beside is not None:
        pair = _joined(pair, beside[log.name])
    return WearLog(
        name=log.name,
        motion=evidence.worn.motion,
        time=evidence.time[dense] - evidence.time[0],
        posture=evidence.posture[dense],
        kept=np.searchsorted(dense, kept),
        torque=pair[0],
        used=pair[1],
        sloped=np.searchsorted(kept, evidence.sloped),
        slope=inputs.slope,
        own=inputs.own,
        session=inputs.session,
        anew=inputs.anew,
        low_pass=LowPass(cutoff_hz, log.rate_hz / step, stored=log.stored),
        partner=partner,
        ahead=ahead,
    )


def _dense(kept: IntArray, samples: int, most: float) -> tuple[IntArray, int]:
    """Every n-th sample, the kept ones among them; and n, at most `most`."""
    apart = int(np.gcd.reduce(np.diff(kept))) if len(kept) > 1 else 1
    step = max(n for n in range(1, apart + 1) if apart % n == 0 and n <= max(most, 1.0))
    first = int(kept[0]) % step if len(kept) else 0
    return np.arange(first, samples, step), step


def _joined(own: Beside, more: Beside) -> Beside:
    return np.hstack([own[0], more[0]]), np.hstack([own[1], more[1]])
