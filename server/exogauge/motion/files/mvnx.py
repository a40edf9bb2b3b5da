"""MVNX of Xsens MVN: segments with their places and turns in the world, over time (MVN User Manual, MVNX): metres,
z up, quaternions with their scalar first, in milliseconds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import final
from xml.etree.ElementTree import Element, ParseError, iterparse

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from exogauge.criteria.motion_import import USUAL
from exogauge.motion.files.captured import AXES, Captured, fault, number
from exogauge.motion.human import JointTree

Array = NDArray[np.float64]
AT_REST = ("tpose", "npose", "identity")  # whichever comes first is where all angles are zero


@final
@dataclass
class _File:
    """points: of every segment, by name, in its own axes [m]. above: parents by name; ends: of a parent, the point at
    which the first of its joints is. measured: what of the body was.

    frames: by type, (index, time [ms], orientation, position) of each."""

    names: list[str] = field(default_factory=list)
    points: list[dict[str, Array]] = field(default_factory=list)
    above: dict[str, str] = field(default_factory=dict)
    ends: dict[str, str] = field(default_factory=dict)
    rate: float = 0.0
    measured: str = ""
    frames: dict[str, list[tuple[float, float, Array, Array]]] = field(default_factory=dict)


def read_mvnx(path: Path) -> Captured:
    """Raises BadMotion."""
    file = _File()
    for event, tag, element in _elements(path):
        if event == "start" and tag == "subject":
            if file.names:
                raise fault(path, "two people are in the file", "two_people", "Export each person alone",
                            value=element.get("label"))  # fmt: skip
            file.measured = element.get("configuration", "")
            file.rate = number(path, element.get("frameRate", "0"), None, "frameRate")
        elif event == "end" and tag == "segment":
            file.names.append(element.get("label", ""))
            file.points.append(_points(path, element, file.names[-1]))
        elif event == "end" and tag == "joint":
            (above, _, at), (below, _, _) = ((_text(element, f"connector{k}") or "").partition("/") for k in (1, 2))
            file.above[below] = above
            file.ends.setdefault(above, at)
        elif event == "end" and tag == "frame":
            _frame(path, element, file)
            element.clear()
    moving = file.frames.get("normal", file.frames.get("", []))
    if not file.names or not moving:
        raise fault(path, "no segments with a motion are described", "not_mvnx",
                    "Export orientation and position of all segments")  # fmt: skip
    names, parent, order = _ordered(path, file)
    turn, place = _turns(path, file, moving, order)
    kind = next((each for each in AT_REST if each in file.frames), None)
    if kind is None:
        rest, still = np.tile(np.eye(3), (len(names), 1, 1)), _unturned(parent, turn, place)
    else:
        rested = _turns(path, file, file.frames[kind][:1], order)
        rest, still = rested[0][0], rested[1][0]
    own = np.stack([_end(file, k) for k in order])
    told = {"measured": f"{file.measured}: the rest follows what was"} if file.measured[:4] not in ("", "Full") else {}
    tree = JointTree(names, parent, place, turn, place + np.einsum("tjab,jb->tja", turn, own), rest, still,
                     still + np.einsum("jab,jb->ja", rest, own))  # fmt: skip
    return Captured("MVNX", _times(path, file, moving), 1.0, AXES["z"], skeleton=tree, told=told)


def _elements(path: Path) -> Iterator[tuple[str, str, Element]]:
    """Event, tag without its namespace, element."""
    try:
        for event, element in iterparse(path, events=("start", "end")):
            yield event, element.tag.rsplit("}", 1)[-1], element
    except ParseError as problem:
        row, _ = problem.position
        raise fault(path, f"the XML ends or breaks here: {problem.msg}", "not_mvnx", "Export the file again",
                    row=row) from None  # fmt: skip


def _text(element: Element, tag: str) -> str | None:
    return next((each.text for each in element.iter() if each.tag.rsplit("}", 1)[-1] == tag), None)


def _points(path: Path, segment: Element, name: str) -> dict[str, Array]:
    """(3,) [m] each."""
    inside = (each for each in segment.iter() if each.tag.rsplit("}", 1)[-1] == "point")
    return {each.get("label", ""): _numbers(path, "".join(each.itertext()), 3, name) for each in inside}


def _end(file: _File, segment: int) -> Array:
    """(3,) [m] where the first of its joints is; of the last ones the point that lies farthest."""
    points = file.points[segment]
    farthest = max(points.values(), key=lambda point: float(np.linalg.norm(point)), default=np.zeros(3))
    return points.get(file.ends.get(file.names[segment], ""), farthest)


def _numbers(path: Path, text: str, count: int, of: str) -> Array:
    words = text.split()
    if len(words) != count:
        raise fault(path, f"{len(words)} numbers where {count} belong", "row_length", "Export the file again",
                    column=of, value=text.strip()[:40] or None)  # fmt: skip
    try:
        values = np.array(words, dtype=np.float64)
    except ValueError:
        values = np.full(count, np.nan)
    if not np.isfinite(values).all():
        for k, word in enumerate(words):
            number(path, word, None, f"{of}, number {k + 1}")
    return values


def _frame(path: Path, frame: Element, file: _File) -> None:
    kind, index = frame.get("type", ""), frame.get("index") or frame.get("time") or "0"
    count = len(file.names)
    read = [_numbers(path, _text(frame, tag) or "", wide * count, f"{tag} of frame {index}")
            for tag, wide in (("orientation", 4), ("position", 3))
            if kind in ("", "normal") or _text(frame, tag)]  # fmt: skip
    if len(read) < 2:
        return  # a calibration that says a part
    of = f"frame {index}"
    said = [number(path, frame.get(key) or "0", None, f"{key} of {of}") if kind in ("", "normal") else 0.0
            for key in ("index", "time")]  # fmt: skip
    file.frames.setdefault(kind, []).append((said[0], said[1], read[0].reshape(-1, 4), read[1].reshape(-1, 3)))


def _ordered(path: Path, file: _File) -> tuple[tuple[str, ...], NDArray[np.intp], list[int]]:
    """Names and parents, parents first, and where each stands in the file."""
    order: list[str] = [name for name in file.names if file.above.get(name) not in file.names]
    if len(order) != 1 or len(set(file.names)) < len(file.names):
        raise fault(path, "the segments are no tree with one root", "loose_bone",
                    "Every segment but the pelvis is the second of one joint", column="joints",
                    value=", ".join(order[:4]))  # fmt: skip
    while len(order) < len(file.names):
        ready = [name for name in file.names if name not in order and file.above[name] in order]
        if not ready:
            left = next(name for name in file.names if name not in order)
            raise fault(path, f"segment {left!r} hangs on nothing", "loose_bone",
                        "Every segment hangs on the pelvis in the end", column="joints", value=left)  # fmt: skip
        order += ready
    parent = [-1, *(order.index(file.above[name]) for name in order[1:])]
    return tuple(order), np.array(parent, dtype=np.intp), [file.names.index(name) for name in order]


def _turns(
    path: Path, file: _File, frames: list[tuple[float, float, Array, Array]], order: list[int]
) -> tuple[Array, Array]:
    """(T, J, 3, 3) R_world_segment and (T, J, 3) [m]."""
    q = np.stack([each[2] for each in frames])[:, order]
    size = np.linalg.norm(q, axis=2)
    odd = np.abs(size - 1.0) > USUAL.quaternion
    if odd.any():
        t, j = np.argwhere(odd)[0]
        raise fault(path, "an orientation is no rotation", "bad_quaternion",
                    "Four numbers a segment, whose squares add to 1: export orientations as quaternions",
                    column=f"{file.names[order[j]]} of frame {frames[t][0]:g}",
                    value=f"length {size[t, j]:.4g}")  # fmt: skip
    turn = Rotation.from_quat(q.reshape(-1, 4)[:, [1, 2, 3, 0]]).as_matrix()
    return turn.reshape(*q.shape[:2], 3, 3), np.stack([each[3] for each in frames])[:, order]


def _unturned(parent: NDArray[np.intp], turn: Array, place: Array) -> Array:
    """(J, 3) [m]: segments with their axes along the world's, which is how MVN defines them in the T-pose."""
    still: Array = np.zeros(place[0].shape)
    for j, above in enumerate(parent[1:], start=1):
        in_parent = np.einsum("tba,tb->ta", turn[:, above], place[:, j] - place[:, above])
        still[j] = still[above] + np.median(in_parent, axis=0)
    return still


def _times(path: Path, file: _File, frames: list[tuple[float, float, Array, Array]]) -> Array:
    """[s], by the frames' indices and the rate; their times say the same."""
    index, time = np.array([each[0] for each in frames]), 1e-3 * np.array([each[1] for each in frames])
    steps = np.diff(index)
    if (steps != 1.0).any():
        k = int(np.argmax(steps != 1.0))
        raise fault(path, f"frame {index[k] + 1:g} is missing", "frame_lost", "Cut where frames are lost",
                    column=f"index of frame {index[k + 1]:g}", value=f"{index[k + 1]:g}")  # fmt: skip
    if not file.rate > 0.0:
        raise fault(path, "the file says no frame rate", "no_rate", "frameRate of the subject", column="frameRate",
                    value=f"{file.rate:g}")  # fmt: skip
    lasts, runs = len(steps) / file.rate, float(np.ptp(time))
    if runs > 0.0 and abs(lasts / runs - 1.0) > USUAL.same_rate and abs(lasts - runs) > 1.0 / file.rate:
        raise fault(path, f"frameRate says that it lasts {lasts:.4g} s, times {runs:.4g}", "two_rates",
                    "Times are in milliseconds: correct them, or frameRate", column="frameRate",
                    value=f"{file.rate:g}")  # fmt: skip
    return np.arange(len(index)) / file.rate
