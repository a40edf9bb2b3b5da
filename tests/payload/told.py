"""What is told of a recording: by its logs, and by the same sample by sample after its postures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from tests.payload import foreign

from exogauge.payload.contract import Role
from exogauge.payload.evaluate import Evaluation, evaluate
from exogauge.payload.intake import Payload, open_payload
from exogauge.payload.live import Known, Live
from exogauge.payload.live_start import pose_of, start_of

Array = NDArray[np.float64]


def evaluated(folder: Path) -> Evaluation:
    return evaluate(open_payload(folder))


def still(folder: Path) -> Payload:
    """Its postures alone."""
    payload = open_payload(folder)
    return replace(payload, recordings=tuple(payload.of("postures")))


def off(found: Evaluation, truth: foreign.Truth) -> Array:
    """(16,) errors in standard deviations."""
    assert found.stages.excitation is not None
    chosen = found.stages.excitation.chosen
    return np.asarray((chosen.value - truth.x) / chosen.std)


def streamed(
    folder: Path, truth: foreign.Truth, role: Role = "excitation", after: tuple[Role, ...] = ("postures",)
) -> tuple[Array, Known]:
    """(16,) errors in standard deviations at the end of a log, and all that is known then. after: what was known."""
    payload, known = open_payload(folder), None
    before = replace(payload, recordings=tuple(each for each in payload.recordings if each.role in after))
    live = Live(replace(start_of(before), pose=pose_of(payload)), foreign.RATE)
    log = payload.of(role)[0]
    for k in range(0, len(log.pose.time), 20):
        part = slice(k, k + 20)
        for each in live.push(log.pose.time[part], log.pose.values[part], log.wrench.values[part]):
            known = each if isinstance(each, Known) else known
    assert known is not None
    assert known.estimate.state == "converged"
    return (known.estimate.value - truth.x) / known.estimate.std, known


def broken(errors: list[Array], most: float = 4.5) -> list[str]:
    """What is claimed and does not hold. 16 numbers of each payload, of which hardly ten do not depend on others: 0.95
    less three standard errors of 20 to 60."""
    share, worst = float(np.mean(np.abs(errors) < 1.96)), float(np.abs(errors).max())
    found = [] if share > 0.85 else [f"{share:.2f} lie inside 95 % intervals"]
    return found + ([] if worst < most else [f"one is {worst:.1f} standard deviations off"])
