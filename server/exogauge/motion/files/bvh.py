"""BVH: a skeleton and its angles in one file; channels in whatever order a joint has them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from exogauge.criteria.motion_import import USUAL
from exogauge.motion.files.captured import Captured, fault, lines_of, not_radians, number, posed
from exogauge.motion.human import JointTree

Array = NDArray[np.float64]
CHANNELS = {axis + kind for axis in "xyz" for kind in ("position", "rotation")}


def read_bvh(path: Path, angle: str | None = None) -> Captured:
    """Raises BadMotion. A BVH file says no unit of length; angles are in degrees, unless rad is said."""
    lines = lines_of(path)
    names: list[str] = []
    parent, offset, end, channels = [], [], [], []  # type: list[int], list[Array], list[Array], list[list[str]]
    open_, at_end, begin = [], False, None  # type: list[int], bool, int | None
    for row, line in enumerate(lines, start=1):
        words = line.replace("{", " ").split()
        word = words[0].upper() if words else ""
        if word in ("ROOT", "JOINT"):
            parent.append(open_[-1] if open_ else -1)
            names.append(" ".join(words[1:]))
            offset.append(np.full(3, np.nan))
            end.append(np.full(3, np.nan))
            channels.append([])
            open_.append(len(names) - 1)
        elif word == "END":
            at_end = True
        elif word == "OFFSET" and open_:
            value = np.array([number(path, word, row, "OFFSET") for word in words[1:4]])
            if len(value) != 3:
                raise fault(path, "an offset has three numbers", "bad_offset", "Export the file again", row=row)
            (end if at_end else offset)[open_[-1]] = value
        elif word == "CHANNELS" and open_:
            channels[open_[-1]] = [each.lower() for each in words[2:]]
            if words[1:2] != [str(len(words) - 2)]:
                said = " ".join(words[1:2]) or "no"
                raise fault(path, f"{said} channels are announced and {len(words[2:])} named", "channel_count",
                            "Export the file again", row=row, column=names[open_[-1]])  # fmt: skip
            if other := [each for each in words[2:] if each.lower() not in CHANNELS]:
                raise fault(path, "this channel is neither a position nor a rotation", "bad_channel",
                            "Export the skeleton with Xposition … Zrotation alone: no scales, no quaternions", row=row,
                            column=names[open_[-1]], value=other[0])  # fmt: skip
            if len(set(channels[open_[-1]])) < len(channels[open_[-1]]):
                raise fault(path, "a channel is named twice", "bad_channel", "Name each axis once", row=row,
                            column=names[open_[-1]], value=" ".join(words[2:]))  # fmt: skip
        elif word == "}":
            if at_end:
                at_end = False
            elif open_:
                open_.pop()
        elif word == "MOTION":
            begin = row
            break
    below = [
        (row, line) for row, line in enumerate(lines, start=1) if begin is not None and row > begin and line.strip()
    ]
    if begin is None or not names or len(below) < 2:
        raise fault(path, "no skeleton with a motion is described", "not_bvh",
                    "A BVH file has HIERARCHY, then MOTION, Frames and Frame Time")  # fmt: skip
    if open_ or at_end:
        last = names[open_[-1] if open_ else 0]
        raise fault(path, f"the braces of {last} are not closed", "not_bvh", "One } on a line of its own for every {",
                    row=begin, column=last)  # fmt: skip
    if lost := [name for name, each in zip(names, offset, strict=True) if np.isnan(each).any()]:
        raise fault(path, "a bone has no OFFSET", "bad_offset", "Export the file again", column=lost[0])
    if parent.count(-1) > 1:
        raise fault(path, "the file holds more than one skeleton", "two_people", "Export each person alone")
    (count_at, count), (step_at, text) = ((row, line.replace(":", " ").split()[-1]) for row, line in below[:2])
    step = number(path, text, step_at, "Frame Time")
    rows = [(row, line.split()) for row, line in below[2:]]
    if step <= 0.0:
        raise fault(path, "a frame takes no time", "no_rate", "Frame Time is that of one frame, in seconds",
                    row=step_at, column="Frame Time", value=f"{step:g}")  # fmt: skip
    told = {} if angle is None else {"angles": f"stated: {angle}"}
    if rows and count == str(len(rows) - 1):
        told["frames"] = f"{len(rows)}, one more than Frames says: it is the last one's number, as Rokoko writes"
    elif count != str(len(rows)) or not rows:
        raise fault(path, f"{len(rows)} frames are there and {count} announced", "frame_count",
                    "The file was cut off, or joined of two: export it again", row=count_at, value=count)  # fmt: skip
    wide = sum(len(each) for each in channels)
    for row, words in rows:
        if len(words) != wide:
            raise fault(path, f"{len(words)} numbers for {wide} channels", "row_length", "Export it again", row=row)
    data = np.array([[number(path, word, row, "motion") for word in words] for row, words in rows])
    turns = np.array([each.endswith("rotation") for named in channels for each in named], dtype=bool)
    most = float(np.abs(data[:, turns]).max(initial=0.0))
    if angle is None:
        not_radians(path, most, 2.0 * USUAL.least_turn_deg)  # Euler angles are written from 0 to a whole turn too
        if most < USUAL.largest_angle_rad:
            _goes_nowhere(path, names, parent, np.stack(offset), channels[0], data, most)
    if angle == "rad":
        data[:, turns] = np.degrees(data[:, turns])
    rest, moved = _places(names, np.stack(offset), channels, data, told)
    return Captured("BVH", np.arange(len(rows), dtype=np.float64) * step, None, None, told=told,
                    skeleton=_posed(names, np.array(parent, np.intp), rest, moved, end, channels, data))  # fmt: skip


def _goes_nowhere(
    path: Path, names: list[str], parent: list[int], offset: Array, channels: list[str], data: Array, most: float
) -> None:
    """Raises BadMotion where the root goes farther than the body is long: no legs do so by turns of `most` degrees."""
    place = np.zeros_like(offset)
    for j in range(1, len(names)):
        place[j] = place[parent[j]] + offset[j]
    columns = [k for k, each in enumerate(channels) if each.endswith("position")]
    if columns and np.ptp(data[:, columns], axis=0).max() > np.ptp(place, axis=0).max():
        detail = f"{names[0]} goes farther than the body is long, and no angle is larger than {most:.2g}: radians?"
        raise fault(path, detail, "radians_for_degrees", "Say the unit of angles: rad or deg", column="angle",
                    value=f"{most:.3g}")  # fmt: skip


def _places(
    names: list[str], offset: Array, channels: list[list[str]], data: Array, told: dict[str, str]
) -> tuple[Array, Array | None]:
    """(J, 3) of each bone in its parent, and (T, J, 3) where position channels of limbs say more than their OFFSETs.

    Such a channel is the place in the parent, as most programs write it, or what is added to OFFSET: whichever leaves
    the bones as they are described.
    """
    begins = np.cumsum([0, *map(len, channels)])
    given = np.zeros((len(names), 3), dtype=bool)
    said = np.zeros((len(data), len(names), 3))
    for j, named in enumerate(channels):
        for column, each in enumerate(named, start=int(begins[j])):
            if j and each.endswith("position"):
                given[j, "xyz".index(each[0])] = True
                said[:, j, "xyz".index(each[0])] = data[:, column]
    whole = np.where(given, said, offset)
    added = offset + said
    place = min((whole, added), key=lambda each: float(np.abs(each - offset).sum()))
    stray = np.linalg.norm(place - offset, axis=2).max(axis=0)
    if stray.max() <= USUAL.same_place * np.linalg.norm(offset, axis=1).max(initial=0.0):
        return offset, None
    j = int(stray.argmax())
    how = "in place of OFFSET" if place is whole else "added to OFFSET"
    told["limb_positions"] = f"read, {how}: {names[j]} is up to {stray[j]:.3g} off it, in units of the file"
    return np.median(place, axis=0), place


def _posed(
    names: list[str], parent: NDArray[np.intp], offset: Array, moved: Array | None, end: list[Array],
    channels: list[list[str]], data: Array,
) -> JointTree:  # fmt: skip
    local, root, column = np.empty((len(data), len(names), 3, 3)), np.tile(offset[0], (len(data), 1)), 0
    ends_in = dict[int, int]()
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
            ends_in |= {j: below[0]} if below else {}
    still = np.tile(np.eye(3), (len(names), 1, 1))
    tree = posed(names, parent, local, still, offset, np.stack(end), root, moved)
    if moved is None:
        return tree
    ends = tree.end.copy()
    for j, child in ends_in.items():
        ends[:, j] = tree.position[:, child]
    return replace(tree, end=ends)
