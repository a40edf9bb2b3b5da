"""When the logs of a study were recorded, and whether that tells what drifts meanwhile from the device."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

from exogauge.remarks import About, Remark
from exogauge.robots.description import Robot
from exogauge.studies.intake.contract import StudyFile


@final
@dataclass(frozen=True)
class Session:
    """started: log -> [s] on one clock; empty where that is not said of every log. remarks: what is missing of it."""

    started: Mapping[str, float]
    remarks: tuple[Remark, ...] = ()


def read_session(file: StudyFile, names: Sequence[str], robot: Robot) -> Session:
    """Asks for nothing where no drift of motors is declared, or where no motion was recorded with and without."""
    entries = dict(zip(names, file.logs, strict=True))
    untold = tuple(name for name, entry in entries.items() if entry.started is None)
    started = {} if untold else {name: entry.started or 0.0 for name, entry in entries.items()}
    plain, worn = (
        {name: entry.motion for name, entry in entries.items() if entry.role in roles and entry.motion is not None}
        for roles in (("without_device", "validation"), ("with_device",))
    )
    both = [motion for motion in dict.fromkeys(worn.values()) if motion in plain.values()]
    if not both or robot.declared.kt_drift <= 0.0 or all(each.actuation != "current" for each in robot.joints):
        return Session(started)
    if untold:
        return Session(started, (Remark(About.SESSION_UNKNOWN, untold),))
    late = tuple(motion for motion in both if _last(plain, started, motion) < _last(worn, started, motion))
    return Session(started, (Remark(About.NO_RUN_AFTER, late),) if late else ())


def _last(motions: Mapping[str, str | None], started: Mapping[str, float], motion: str) -> float:
    return max(started[name] for name, own in motions.items() if own == motion)
