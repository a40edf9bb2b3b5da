"""When the logs of a session lie, and how what only ever goes on through it may have gone: cold motors, zeros."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.identifying import DECLARED
from exogauge.logs.model import Log
from exogauge.support.settings import PlainLog

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@final
@dataclass(frozen=True)
class Session:
    """L logs in the order of their time. logs: name -> its row. course: (L, R) of each of R courses in each log."""

    logs: Mapping[str, int]
    course: Array


def session(plain: Sequence[PlainLog], worn: Sequence[Log], started: Mapping[str, float]) -> Session | None:
    """None where it is not said of every log when it began, or none was fitted. started: recording -> [s]."""
    logs = [*(each.log for each in plain), *worn]
    fitted = np.array([*(not each.held_out for each in plain), *(False for _ in worn)])
    if not fitted.any() or any(log.recording not in started for log in logs):
        return None
    begins = np.array([started[log.recording] + float(log.time[0]) for log in logs])
    lasting = np.array([float(log.time[-1] - log.time[0]) for log in logs])
    first = float(begins.min())
    middle, end = begins - first + 0.5 * lasting, float(np.max(begins - first + lasting))
    order = np.argsort(middle)
    return Session({logs[k].name: row for row, k in enumerate(order)}, courses(middle, lasting, fitted, end)[order])


def courses(middle_s: Array, lasting_s: Array, fitted: BoolArray, end_s: float) -> Array:
    """(L, R) of logs whose middle is so long after the session's beginning; 0 on the average of the fitted ones, from
    cold to the end of the session 1. lasting_s: (L,) of each."""
    found = []
    for constant in DECLARED.warming_s:
        w = np.expm1(-middle_s / constant) / np.expm1(-end_s / constant)
        found.append(w - np.average(w[fitted], weights=lasting_s[fitted]))
    return np.stack(found, axis=1)
