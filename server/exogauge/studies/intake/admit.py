"""What a study's logs must be before anything is made of them: one place, so that `doctor` refuses what `run` does.

What the robot's description lets the doctor expect of every log stands here, too.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from exogauge.errors import BadLog, BadStudy, Fault
from exogauge.identification.settings import Recording
from exogauge.identification.turns import WIDEST
from exogauge.logs.model import Log
from exogauge.progress import Doing, Progress, unwatched
from exogauge.robots.description import Robot
from exogauge.studies.intake.expected import expectation
from exogauge.studies.intake.open import Study, read_recordings, read_worn
from exogauge.support.motions import require_same_motions
from exogauge.support.settings import PlainLog, WornLog

SLOWEST_HZ = 5.0  # twice the 2.5 Hz of a slow arm's excitation; a log in ms read as s stands far below
FASTEST_HZ = 1e5  # no drive is sampled faster; a log in s read as ms or µs stands above
MOVED = 0.02  # [rad or m] more than noise and creeping at rest
SHORTEST_S = 1.0  # less holds no motion of a joint and its return


@final
@dataclass(frozen=True)
class Admitted:
    """The logs of a study as they are used; motions: name of each log's motion."""

    study: Study
    recordings: list[Recording]
    worn: list[WornLog]

    @property
    def plain(self) -> list[PlainLog]:
        return self.as_plain(self.recordings)

    def as_plain(self, recordings: Sequence[Recording]) -> list[PlainLog]:
        motions = self.study.motions
        return [PlainLog(each.log, motions[each.log.recording].motion, each.held_out) for each in recordings]


def admit(study: Study, worn: bool = True, progress: Progress = unwatched) -> Admitted:
    """Every log that is read, and none that nothing can be made of. worn: those with a device too.

    Raises BadLog for a column that is missing and a clock that cannot be right, BadStudy for motions with the device
    that no log without it shows.
    """
    logs = Admitted(study, read_recordings(study), read_worn(study) if worn else [])
    every = [*(each.log for each in logs.recordings), *(each.log for each in logs.worn)]
    of_recording = {name: entry.file[0] for name, entry in zip(study.log_names, study.file.logs, strict=True)}
    files = {log.name: of_recording[log.recording] for log in every}
    faults = [
        replace(fault, file=files[log.name])
        for log in every
        for fault in (
            *impossible_clock(log),
            *dead_currents(study.robot, log),
            *too_slow_for(study.settings.cutoff_hz, log),
        )
    ]
    if faults:
        raise BadLog(faults)
    if logs.worn:
        progress(0.08, Doing.COMPARING_MOTIONS)
        try:
            require_same_motions(study.robot, logs.worn, logs.plain, study.support_settings)
        except BadStudy as different:  # the fault names the file, not only the log
            told = [replace(fault, file=files[fault.file or ""]) for fault in different.faults]
            raise BadStudy([*in_degrees(study.robot, every, files), *told]) from None
    return logs


def in_degrees(robot: Robot, logs: Sequence[Log], files: Mapping[str, str]) -> list[Fault]:
    """Of positions, once each: in degrees no two motions are alike, and that is not what is wrong with them."""
    from exogauge.logs.joint_rules import beyond_limits

    expected, found = expectation(robot), dict[str, Fault]()
    for log in logs:
        for each in beyond_limits(log, expected):
            if each.rule in ("degrees", "motor_side") and each.channel not in found:
                found[each.channel] = Fault(
                    each.detail, each.rule, each.advice, files[log.name], each.row, each.channel, f"{each.value:.4g}"
                )
    return [*found.values()]


def impossible_rate(log: Log) -> list[Fault]:
    """The unit of time is the suspect."""
    return [fault for fault in impossible_clock(log) if fault.rule == "rate_impossible"]


def dead_currents(robot: Robot, log: Log) -> Iterator[Fault]:
    """Of joints that move with a current that is one number throughout: friction alone takes another one each way."""
    for joint in robot.joints:
        q, i = log.channels[f"q.{joint.name}"], log.channels.get(f"i.{joint.name}")
        if joint.actuation == "current" and i is not None and np.ptp(i) == 0.0 and np.ptp(q) > MOVED:
            detail = f"joint {joint.name!r} moves by {np.ptp(q):.3g} in log {log.name!r}, its current never changes"
            advice = "Name the column that holds the current, or say `actuation: none` in robot.yaml."
            yield Fault(detail, "effort_dead", advice, column=f"i.{joint.name}", value=f"{i[0]:g}")


def too_slow_for(cutoff_hz: float | None, log: Log) -> Iterator[Fault]:
    """cutoff_hz: as stated; one that the logs choose suits them."""
    if cutoff_hz is None or impossible_clock(log):
        return
    if cutoff_hz > WIDEST * log.rate_hz:
        detail = f"log {log.name!r} has {log.rate_hz:.4g} Hz, too slow for the stated cut-off of {cutoff_hz:.3g} Hz"
        advice = f"Log at {cutoff_hz / WIDEST:.0f} Hz or more, or set a lower cutoff_hz."
        yield Fault(detail, "rate_too_low", advice, column="t", value=f"{log.rate_hz:.3g} Hz")


def impossible_clock(log: Log) -> list[Fault]:
    """A log too short to move in, or a rate at which no robot is logged: then the unit of time is the suspect."""
    if log.samples < 2:
        detail, advice = f"log {log.name!r} has {log.samples} samples", "Record at least some seconds of motion."
        return [Fault(detail, "too_short", advice, column="t", value=str(log.samples))]
    rate, seconds = log.rate_hz, float(log.time[-1] - log.time[0])
    said = f"{log.samples} samples over {seconds:.4g} s, {rate:.3g} Hz"
    if rate < SLOWEST_HZ:
        advice = "Is t in ms or µs? State its unit in a mapping. Otherwise log at 50 Hz or more."
        return [Fault(f"log {log.name!r} has {said}", "rate_impossible", advice, column="t", value=f"{rate:.3g} Hz")]
    if rate > FASTEST_HZ:
        advice = "t is in seconds: state its unit in a mapping."
        return [Fault(f"log {log.name!r} has {said}", "rate_impossible", advice, column="t", value=f"{rate:.3g} Hz")]
    if seconds < SHORTEST_S:
        advice = "Record at least some seconds of motion, or state the unit of t in a mapping."
        return [Fault(f"log {log.name!r} has {said}", "too_short", advice, column="t", value=f"{seconds:.3g} s")]
    return []
