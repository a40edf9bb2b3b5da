"""What was done with the logs before they were compared."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from exogauge.identification.added_columns import COMPONENTS
from exogauge.identification.disturbances import DRIFTS
from exogauge.identification.model import RobotModel
from exogauge.logs.model import Log
from exogauge.remarks import About, Remark
from exogauge.support.drift import Drift
from exogauge.support.settings import PlainLog, WornLog
from exogauge.support.zeros import Zeros

MISLABELLED = {About.LABELS_EXCHANGED, About.DEVICE_ON_WHERE_FITTED}  # no estimate is worth anything then

IntArray = NDArray[np.intp]


def notes_on_logs(plain: Sequence[PlainLog], worn: Sequence[WornLog]) -> tuple[Remark, ...]:
    """Time that was left out, and logs that were low-passed before they were stored."""
    with_device = [each.log for each in worn]
    logs = [*(each.log for each in plain), *with_device]
    left_out = [_left_out(each) for each in logs if each.left_out]
    limited = [each for each in logs if each.stored is not None]
    return (*left_out, *_filtered(limited), *_not_alike(limited, [each for each in with_device if not each.stored]))


def notes_on_drift(model: RobotModel, drift: Drift | None, joints: IntArray) -> tuple[Remark, ...]:
    """What motors were found to do through the session."""
    if drift is None:
        return ()
    numbers = dict[str, tuple[float, float]]()
    for k, drifts in enumerate(drift.names):
        coefficient = next(each.coefficient.name for each in model.equations.effects if each.name == DRIFTS[drifts])
        for j in (j for j in joints if drift.told[j]):
            moved, std = 100.0 * float(drift.moved[j, k]), 100.0 * float(drift.std[j, k])
            if abs(moved) > model.criteria.judging.significant * std:
                numbers[f"{coefficient} {model.robot.joints[j].name}"] = moved, std
    return (Remark(About.DRIFT_FOUND, tuple(numbers), tuple(numbers.values())),) if numbers else ()


def notes_on_zeros(model: RobotModel, zeros: Zeros | None) -> tuple[Remark, ...]:
    """What the feet's zeros together were found to do through the session."""
    if zeros is None:
        return ()
    found = zip(COMPONENTS, *(each.tolist() for each in zeros.sums), strict=True)
    told = [each for each in found if abs(each[1]) > model.criteria.judging.significant * each[2]]
    numbers = tuple((moved, std) for _, moved, std in told)
    return (Remark(About.ZEROS_FOUND, tuple(name for name, _, _ in told), numbers),) if told else ()


def _left_out(log: Log) -> Remark:
    return Remark(About.TOUCHED, (log.name,), numbers=tuple(float(end) for span in log.left_out for end in span))


def _filtered(limited: Sequence[Log]) -> list[Remark]:
    """One for each low-pass."""
    rate_hz = limited[0].rate_hz if limited else 0.0
    return [
        Remark(
            About.LOW_PASSED,
            tuple(each.name for each in limited if each.stored == stored),
            numbers=(stored.half_hz(rate_hz),),
        )
        for stored in dict.fromkeys(each.stored for each in limited if each.stored)
    ]


def _not_alike(limited: Sequence[Log], others: Sequence[Log]) -> list[Remark]:
    if not limited or not others:
        return []
    names, slow = (tuple(each.name for each in logs) for logs in (others, limited))
    return [Remark(About.STORED_UNLIKE, names, beside=slow)]


def in_doubt(remarks: Sequence[Remark], devices: Collection[str]) -> frozenset[str]:
    """Those of which nothing is decided: all where labels do not hold, as partners are not what they say either, else
    those of which something else was measured."""
    if any(each.about in MISLABELLED for each in remarks):
        return frozenset(devices)
    return frozenset(name for each in remarks if each.about == About.NOT_OF_BANDS for name in each.beside)
