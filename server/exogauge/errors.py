"""Everything exogauge raises on purpose.

ExogaugeError
├── BadInput             what a user handed in breaks a rule: one `Fault` per place
│   ├── BadLog           a log table or its mapping
│   ├── BadRobot         robot.yaml or the URDF
│   ├── BadMotion        a file of captured motion
│   ├── BadStudy         study.yaml, the bundle, a missing file
│   └── TooLarge         a size, depth or memory cap
├── NotIdentifiable      the data hold no answer to the question asked
├── PhysicallyImpossible an inertia no body can have, where a possible one is required
├── Cancelled            the caller asked to stop
├── NotFound             no such thing, or not yours to see
├── Gone                 it was there, and was taken back
├── Conflict             the thing changed meanwhile, or the same key was used for something else
├── TooMany              a limit on how much in how short a time; `retry_after_s` says when it works again
└── Unavailable          the database, the disk, an object store or a worker cannot serve now; trying again may help
    └── DiskFull         a disk has no room: the same works as soon as there is
        └── QuotaFull    the lab has as many bytes as it may

The domain knows no HTTP code; `api/problems.py` maps classes to statuses.
"""

from __future__ import annotations

import errno
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Fault:
    """One broken rule, at one place.

    detail: what is wrong, in a sentence. rule: a stable short code (`mass_not_positive`).
    advice: what to do about it. row counts data rows from 1 (the header is row 0).
    """

    detail: str
    rule: str
    advice: str = ""
    file: str | None = None
    row: int | None = None
    column: str | None = None
    value: str | None = None

    def __str__(self) -> str:
        place = [self.file] if self.file else []
        if self.row is not None:
            place.append(f"row {self.row}")
        if self.column:
            place.append(f"column {self.column!r}")
        text = ": ".join([", ".join(place), self.detail] if place else [self.detail])
        if self.value is not None:
            text += f" (value: {self.value})"
        return f"{text}. {self.advice}" if self.advice else text


class ExogaugeError(Exception):
    """Base of all errors raised on purpose."""


class BadInput(ExogaugeError):
    """What a user handed in breaks a rule; `faults` says where."""

    def __init__(self, faults: Fault | Sequence[Fault]) -> None:
        self.faults: tuple[Fault, ...] = (faults,) if isinstance(faults, Fault) else tuple(faults)
        super().__init__("\n".join(str(fault) for fault in self.faults))

    def __reduce__(self) -> tuple[type[BadInput], tuple[tuple[Fault, ...]]]:
        return type(self), (self.faults,)


class BadLog(BadInput):
    """A log table, or the mapping that reads it."""


class BadRobot(BadInput):
    """robot.yaml or the URDF."""


class BadMotion(BadInput):
    """A file of captured motion."""


class BadStudy(BadInput):
    """study.yaml, the bundle, or a file it names."""


class TooLarge(BadInput):
    """A cap on size, depth, rows or memory."""


class NotIdentifiable(ExogaugeError):
    """The data hold no answer; `parameters` names what cannot be told."""

    def __init__(self, message: str, parameters: Sequence[str] = ()) -> None:
        self.parameters = tuple(parameters)
        super().__init__(message)


class PhysicallyImpossible(ExogaugeError):
    """An inertia that no body can have; `links` names them."""

    def __init__(self, message: str, links: Sequence[str] = ()) -> None:
        self.links = tuple(links)
        super().__init__(message)


class Cancelled(ExogaugeError):
    """The caller asked to stop."""


class NotFound(ExogaugeError):
    """No such thing, or not visible to the one who asks."""


class Gone(ExogaugeError):
    """It was there, and was taken back."""


class Conflict(ExogaugeError):
    """Changed meanwhile, or an idempotency key used for another request."""


class Unavailable(ExogaugeError):
    """Cannot serve now; trying again may help."""


class Away(Unavailable):
    """Another machine does not answer, or the line to it is cut; somebody will mend it."""


class DiskFull(Unavailable):
    """A disk, or a quota on it, has no room; the same works as soon as there is."""


class QuotaFull(DiskFull):
    """The lab keeps as many bytes as it may."""


class TooMany(ExogaugeError):
    """More than may be in so short a time. retry_after_s: after which the same works again."""

    def __init__(self, message: str, retry_after_s: float) -> None:
        self.retry_after_s = retry_after_s
        super().__init__(message)


def no_room(error: BaseException | None) -> bool:
    """Whether a full disk or quota is behind an error, whatever was made of it since."""
    while error is not None:
        full = isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT)
        if full or isinstance(error, DiskFull):
            return True
        error = error.__cause__ or error.__context__
    return False
