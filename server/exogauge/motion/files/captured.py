"""What a reader hands on: the file's own axes and unit, not yet turned upright."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import final

import numpy as np
from numpy.typing import NDArray

from exogauge.criteria.motion_import import USUAL
from exogauge.errors import BadMotion, Fault
from exogauge.motion.human import JointTree

Array = NDArray[np.float64]

STILL = "every frame is the same"
METRES = {
    "m": 1.0,
    "mm": 1e-3,
    "cm": 1e-2,
    "in": 0.0254,
    "cmu": 0.0254 / 0.45,
}  # per unit; CMU's is that of its ASF files
METRES |= {
    "meters": 1.0,
    "metres": 1.0,
    "millimeters": 1e-3,
    "millimetres": 1e-3,
    "centimeters": 1e-2,
    "centimetres": 1e-2,
}
AXES = {
    sign + name: s * np.eye(3)[k] for k, name in enumerate("xyz") for sign, s in (("", 1.0), ("+", 1.0), ("-", -1.0))
}


@final
@dataclass(frozen=True)
class Captured:
    """unit: metres per unit of length, None where the file does not say. up: (3,) axis, None likewise.

    labels, position: (T, M, 3) of markers, NaN where one was not seen; or a skeleton, in the file's axes and unit.
    row: of the file, that holds the first frame.
    """

    format: str
    time: Array
    unit: float | None
    up: Array | None
    labels: tuple[str, ...] = ()
    position: Array | None = None
    skeleton: JointTree | None = None
    told: Mapping[str, str] = field(default_factory=dict)
    row: int = 1


def lines_of(path: Path) -> list[str]:
    """Lines of a text file without their ends, of which \\r\\r\\n is one: programs on Windows write it that end a line
    twice. Raises BadMotion where there is none, or where it is no text."""
    data = path.read_bytes()
    if not data.strip():
        raise fault(path, "the file is empty", "empty_file", "Export the motion again")
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", errors="replace").replace("\r\r\n", "\n").splitlines()
    if b"\0" in data[:4096]:
        raise fault(path, "the file holds no text", "not_text", "Name the file as what it is: .c3d for C3D")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:  # as programs on Windows write letters with accents
        text = data.decode("cp1252", errors="replace")
    del data  # of ten million markers 350 MB
    return text.replace("\r\r\n", "\n").splitlines()


def fault(
    path: Path, detail: str, rule: str, advice: str, *, row: int | None = None, column: str | None = None,
    value: str | None = None,
) -> BadMotion:  # fmt: skip
    return BadMotion(Fault(detail, rule, advice, path.name, row, column, value))


def number(path: Path, text: str, row: int | None, column: str) -> float:
    """A number, finite and no larger than any that is written. row counts the file's lines from 1."""
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not abs(value) < USUAL.largest_number:
        advice = "Export it with decimal points" if "," in text else "Export the file again"
        raise fault(path, "this is no number", "not_a_number", advice, row=row, column=column, value=text)
    return value


def not_radians(path: Path, most: float, turns: float = USUAL.least_turn_deg) -> None:
    """Raises BadMotion where angles that are read as degrees are no larger than `most`, and those in radians may be as
    large as `turns`."""
    if 0.0 < most < turns:
        detail = f"no angle is larger than {most:.2g}: these are radians, or nearly nothing moves"
        raise fault(path, detail, "radians_for_degrees", "Say the unit of angles: rad or deg", column="angle",
                    value=f"{most:.3g}")  # fmt: skip


def even_time(path: Path, time: Array, row: int = 1) -> Array:
    """From 0, on an even clock. row: of the file, that holds the first time."""
    if len(time) < 2:
        raise fault(path, "one frame is no motion", "one_frame", "Two frames at least", value=str(len(time)))
    even = np.linspace(0.0, time[-1] - time[0], len(time))
    if 0.0 < even[1] < USUAL.shortest_frame_s:
        raise fault(path, f"a frame lasts {even[1]:.3g} s", "fast_clock", "Export it with the rate of the cameras",
                    column="time", value=f"{even[1]:g}")  # fmt: skip
    if even[1] > USUAL.longest_frame_s:
        raise fault(path, f"a frame lasts {even[1]:.3g} s", "slow_clock", "Time is in seconds", column="time",
                    value=f"{even[1]:g}")  # fmt: skip
    stray = np.abs(time - time[0] - even)
    allowed = max(USUAL.uneven * even[1], min(USUAL.rounded_s, USUAL.rounded * even[1]))
    if not even[1] > 0.0 or stray.max() > allowed:
        raise fault(path, "time does not run evenly", "uneven_time", "Resample it, or cut where frames are lost",
                    row=int(stray.argmax()) + row, column="time", value=f"{time[stray.argmax()]:g}")  # fmt: skip
    return even


def posed(
    names: Sequence[str], parent: NDArray[np.intp], local: Array, rest: Array, offset: Array, end: Array, root: Array,
    moved: Array | None = None,
) -> JointTree:  # fmt: skip
    """The skeleton in every frame and at rest.

    local: (T, J, 3, 3) turn of each bone in its parent; rest: (J, 3, 3) with all angles zero. offset: (J, 3) of its
    origin in its parent's frame; moved: (T, J, 3) the same in each frame, where it is not always there. end: (J, 3) in
    its own frame. root: (T, 3).
    """
    position, rotation, ends = _pose(parent, local, offset[None] if moved is None else moved, end, root)
    still, turned, still_end = (each[0] for each in _pose(parent, rest[None], offset[None], end, root[:1]))
    return JointTree(tuple(names), parent, position, rotation, ends, turned, still, still_end)


def _pose(parent: NDArray[np.intp], local: Array, offset: Array, end: Array, root: Array) -> tuple[Array, Array, Array]:
    """Places (T, J, 3), turns (T, J, 3, 3), ends (T, J, 3) of bones, parents first. offset: (T or 1, J, 3)."""
    rotation, position = np.empty_like(local), np.empty((*local.shape[:2], 3))
    for j, above in enumerate(parent):
        if above < 0:
            rotation[:, j], position[:, j] = local[:, j], root
        else:
            rotation[:, j] = rotation[:, above] @ local[:, j]
            turned = np.einsum("tab,tb->ta", rotation[:, above], np.broadcast_to(offset[:, j], root.shape))
            position[:, j] = position[:, above] + turned
    return position, rotation, position + np.einsum("tjab,jb->tja", rotation, end)
