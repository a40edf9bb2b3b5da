"""motion.yaml and its files become a motion; plan.yaml with what lies beside it becomes what is asked."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.errors import BadMotion, Fault
from exogauge.logs.findings import runs
from exogauge.motion.contacts import with_contacts
from exogauge.motion.contract import CaptureFile, ContactsEntry
from exogauge.motion.files import open_motion
from exogauge.motion.human import Contacts, HumanMotion
from exogauge.studies.intake.yaml_file import load_yaml

Array = NDArray[np.float64]
CAPTURE = "motion.yaml"
MICRO = 6  # decimals of a second


@final
@dataclass(frozen=True)
class Capture:
    """motion: with contacts, where both feet are known. static: of markers, the person standing straight."""

    name: str
    motion: HumanMotion
    static: HumanMotion | None


def open_capture(folder: Path) -> Capture:
    """The motion that `folder`/motion.yaml says. Raises BadMotion, BadStudy."""
    path = folder / CAPTURE
    if not path.is_file():
        raise BadMotion(Fault("there is no such file", "no_file", "Say what was captured in motion.yaml", CAPTURE))
    file = load_yaml(path.read_bytes(), CaptureFile, file=CAPTURE)
    for key, name in (("file", file.file), ("skeleton", file.skeleton), ("static", file.static)):
        if name is not None and not (folder / name).is_file():
            advice = "Paths are relative to motion.yaml"
            raise BadMotion(Fault("there is no such file", "no_file", advice, CAPTURE, None, key, name))

    def read(name: str, skeleton: Path | None = None) -> HumanMotion:
        return open_motion(folder / name, skeleton=skeleton, up=file.up, unit=file.unit, angle=file.angle,
                           subject=file.subject, names=file.names)  # fmt: skip

    motion = read(file.file, None if file.skeleton is None else folder / file.skeleton)
    static = None if file.static is None else read(file.static)
    name = file.name or motion.name
    return Capture(name, with_contacts(replace(motion, name=name)), static)


def spans_of(time: Array, stands: NDArray[np.bool_]) -> list[list[float]]:
    """Stretches [begin, end] [s] of (T,) times in which a foot stands."""
    starts, lengths = runs(stands)
    ends = [(float(time[k]), float(time[k + n - 1])) for k, n in zip(starts, lengths, strict=True)]
    return [[round(begin, MICRO), round(end, MICRO)] for begin, end in ends]


def contacts_from(time: Array, said: ContactsEntry) -> Contacts:
    """The same back, at times (T,)."""

    def stands(spans: list[list[float]]) -> NDArray[np.bool_]:
        out = np.zeros(len(time), dtype=bool)
        for begin, end in spans:
            out |= (time >= begin - 1e-6) & (time <= end + 1e-6)
        return out

    return Contacts(stands(said.left), stands(said.right))
