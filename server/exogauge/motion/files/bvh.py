"""BVH: a skeleton and its angles in one file; channels in whatever order a joint has them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from exogauge.criteria.motion_import import USUAL
from exogauge.motion.files.captured import Captured, fault, lines_of, number, posed
from exogauge.motion.human import JointTree

Array = NDArray[np.float64]


def read_bvh(path: Path, angle: str | None = None) -> Captured:
    """Raises BadMotion. A BVH file says no unit of length; angles are in degrees, unless rad is said."""
    lines = lines_of(path)
    names: list[str] = []
    parent, offset, end, channels = [], [], [], []  # type: list[int], list[Array], list[Array], list[list[str]]
    open_, at_end, begin = [], False, None  # type: list[int], bool, int | None
    for row, line in enumerate(lines, start=1):
        words = line.split()
        if not words:
            continue
        if words[0] in ("ROOT", "JOINT"):
            parent.append(open_[-1] if open_ else -1)
            names.append(" ".join(words[1:]))
            offset.append(np.zeros(3))
            end.append(np.full(3, np.nan))
            channels.append([])
            open_.append(len(names) - 1)
        elif words[0].lower() == "end":
            at_end = True
        elif words[0] == "OFFSET" and open_:
            value = np.array([number(path, word, row, "OFFSET") for word in words[1:4]])
            if len(value) != 3:
                raise fault(path, "an offset has three numbers", "bad_offset", "Export the file again", row=row)
            (end if at_end else offset)[open_[-1]] = value
        elif words[0] == "CHANNELS" and open_:
            channels[open_[-1]] = [word.lower() for word in words[2:]]
            if words[1] != str(len(words) - 2):
                raise fault(path, f"{words[1]} channels are announced and {len(words) - 2} named", "channel_count",
                            "Export the file again", row=row, column=names[open_[-1]])  # fmt: skip
        elif words[0] == "}":
            if at_end:
                at_end = False
            elif open_:
                open_.pop()
        elif words[0] == "MOTION":
            begin = row
            break
    if begin is None or not names or len(lines) < begin + 3:
        raise fault(path, "no skeleton with a motion is described", "not_bvh",
                    "A BVH file has HIERARCHY, then MOTION")  # fmt: skip
    if parent.count(-1) > 1:
        raise fault(path, "the file holds more than one skeleton", "two_people", "Export each person alone")
    count = lines[begin].split()[-1]
    step = number(path, lines[begin + 1].split()[-1], begin + 2, "Frame Time")
    rows = [(row, line.split()) for row, line in enumerate(lines[begin + 2 :], start=begin + 3) if line.strip()]
    if step <= 0.0:
        raise fault(path, "a frame takes no time", "no_rate", "Frame Time is that of one frame, in seconds",
                    row=begin + 2, column="Frame Time", value=f"{step:g}")  # fmt: skip
    if count != str(len(rows)) or not rows:
        raise fault(path, f"{len(rows)} frames are there and {count} announced", "frame_count",
                    "The file was cut off, or joined of two: export it again", row=begin + 1, value=count)  # fmt: skip
    wide = sum(len(each) for each in channels)
    for row, words in rows:
        if len(words) != wide:
            raise fault(path, f"{len(words)} numbers for {wide} channels", "row_length", "Export it again", row=row)
    data = np.array([[number(path, word, row, "motion") for word in words] for row, words in rows])
    turns = np.array([each.endswith("rotation") for named in channels for each in named], dtype=bool)
    most = float(np.abs(data[:, turns]).max(initial=0.0))
    if angle is None and 0.0 < most < USUAL.least_turn_deg:
        detail = f"no angle is larger than {most:.2g}: these are radians, or nearly nothing moves"
        raise fault(path, detail, "radians_for_degrees", "Say the unit of angles: rad or deg", column="angle",
                    value=f"{most:.3g}")  # fmt: skip
    if angle == "rad":
        data[:, turns] = np.degrees(data[:, turns])
    told = {} if angle is None else {"angles": f"stated: {angle}"}
    return Captured("BVH", np.arange(len(rows), dtype=np.float64) * step, None, None, told=told,
                    skeleton=_posed(names, np.array(parent, np.intp), offset, end, channels, data))  # fmt: skip


def _posed(
    names: list[str], parent: NDArray[np.intp], offset: list[Array], end: list[Array], channels: list[list[str]],
    data: Array,
) -> JointTree:  # fmt: skip
    local, root, column = np.empty((len(data), len(names), 3, 3)), np.tile(offset[0], (len(data), 1)), 0
    for j, named in enumerate(channels):
        turn = Rotation.identity(len(data))
        for each in named:
            axis = "xyz".index(each[0])
            if each.endswith("position"):
                if j == 0:
                    root[:, axis] = data[:, column]
            else:
                turn = turn * Rotation.from_rotvec(np.radians(data[:, column])[:, None] * np.eye(3)[axis])
            column += 1
        local[:, j] = turn.as_matrix()
        if np.isnan(end[j]).any():  # a bone ends where its first child begins
            below = [k for k in range(len(names)) if parent[k] == j]
            end[j] = offset[below[0]] if below else np.zeros(3)
    still = np.tile(np.eye(3), (len(names), 1, 1))
    return posed(names, parent, local, still, np.stack(offset), np.stack(end), root)
