"""When the logs of a session lie, and how what only ever goes on through it may have gone: cold motors, zeros."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.identifying import DECLARED
from exogauge.logs.model import Log

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Session:
    """L logs in the order of their time. logs: name -> its row. gone: (L, R) how far each of R courses has gone in each
    log, 0 as the session begins and 1 at its end. course: (L, R) the same, 0 on the average of the fitted logs."""

    logs: Mapping[str, int]
    gone: Array
    course: Array


def session(logs: Sequence[Log], fitted: Sequence[bool], started: Mapping[str, float]) -> Session | None:
    """None where it is not said of every log when it began, or none was fitted. started: recording -> [s], of all that
    the session holds. fitted: whether each was."""
    if not any(fitted) or any(log.recording not in started for log in logs):
        return None
    begins = np.array([started[log.recording] + float(log.time[0]) for log in logs])
    lasting = np.array([float(log.time[-1] - log.time[0]) for log in logs])
    first = min(float(begins.min()), *started.values())
    end = max(float(np.max(begins + lasting)), *started.values()) - first
    order = np.argsort(begins + 0.5 * lasting)
    gone = courses((begins - first + 0.5 * lasting)[order], end)
    at = np.array(fitted)[order]
    course = gone - np.average(gone[at], axis=0, weights=lasting[order][at])
    return Session({logs[k].name: row for row, k in enumerate(order)}, gone, course)


def courses(middle_s: Array, end_s: float) -> Array:
    """(L, R) how far each course has gone in logs whose middle is so long after the session's beginning."""
    constants = np.array(DECLARED.warming_s)
    return np.asarray(np.expm1(-middle_s[:, None] / constants) / np.expm1(-end_s / constants))
