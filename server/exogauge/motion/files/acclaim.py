"""ASF/AMC: a skeleton and its angles (Acclaim; documented by J. Lander, 1998). The ASF's unit of length counts."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from exogauge.motion.files.captured import METRES, Captured, fault, lines_of, not_radians, number, posed

Array = NDArray[np.float64]
DOF = ("tx", "ty", "tz", "rx", "ry", "rz")
RATE = 120.0  # Hz; an AMC says none, and CMU's database was captured at this one


@final
@dataclass
class _Bone:
    """direction, axis: (3,) as the ASF has them, in the skeleton's frame. dof: tx … rz, in the AMC's order."""

    dof: list[str] = field(default_factory=list)
    direction: Array = field(default_factory=lambda: np.zeros(3))
    axis: Array = field(default_factory=lambda: np.zeros(3))
    length: float = 0.0


def read_amc(path: Path, skeleton: Path | None, said: str | None = None) -> Captured:
    """Raises BadMotion. Turns are in the unit that is said, else that of the AMC's own head, else that of the ASF."""
    if skeleton is None:
        raise fault(path, "an AMC file holds angles and no bones", "no_skeleton", "Give its ASF file too")
    unit, degrees, bones, hierarchy = _bones(skeleton)
    own, frames = _frames(path, bones)
    turned = {"deg": True, "rad": False}.get(said or own, degrees)
    if turned and said is None:
        angles = [abs(value) for frame in frames for name, values in frame.items()
                  for value, each in zip(values, bones[name].dof, strict=True) if each[0] == "r"]  # fmt: skip
        not_radians(path, max(angles, default=0.0))
    names = ("root", *[name for name in _ordered(skeleton, hierarchy) if name in bones and name != "root"])
    parent = np.array([-1, *[names.index(hierarchy[name]) for name in names[1:]]], dtype=np.intp)
    size = len(frames)
    local, offset, end = np.empty((size, len(names), 3, 3)), np.zeros((len(names), 3)), np.zeros((len(names), 3))
    rest = np.empty((len(names), 3, 3))
    world = [Rotation.from_euler("xyz", bones[name].axis, degrees=degrees) for name in names]
    root = np.zeros((size, 3))
    for j, name in enumerate(names):
        above = Rotation.identity() if parent[j] < 0 else world[parent[j]]
        still = above.inv() * world[j]
        turns = np.zeros((size, 3))
        dof = bones[name].dof
        for k, each in enumerate(dof):
            values = np.array([frame[name][k] for frame in frames])
            if each[0] == "t" and j and values.any():
                raise fault(path, f"bone {name!r} moves in its parent, which is not read", "limb_moves",
                            "Export it with translations of the root alone, or as BVH", column=name)  # fmt: skip
            if each[0] == "t" and j == 0:
                root[:, "xyz".index(each[1])] = values
            elif each[0] == "r":
                turns[:, "xyz".index(each[1])] = values
        local[:, j] = (still * Rotation.from_euler("xyz", turns, degrees=turned)).as_matrix()
        rest[j] = still.as_matrix()
        end[j] = world[j].inv().apply(bones[name].direction) * bones[name].length
        offset[j] = 0.0 if parent[j] < 0 else end[parent[j]]
    told = {"rate": f"guessed: {RATE:g} Hz, an AMC file does not say"}
    body = posed(names, parent, local, rest, offset, end, root)
    return Captured("ASF/AMC", np.arange(size) / RATE, unit, None, skeleton=body, told=told)


def _bones(path: Path) -> tuple[float, bool, dict[str, _Bone], dict[str, str]]:
    """Metres per unit, degrees?, bones by name, parents by name."""
    unit, degrees, section = METRES["in"], True, ""
    bones = {"root": _Bone(list(DOF))}
    hierarchy: dict[str, str] = {}
    now = _Bone()
    for row, line in enumerate(lines_of(path), start=1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0].startswith(":"):
            section = words[0][1:].lower()
        elif section == "units" and words[0] == "length":
            unit = METRES["in"] / _length(path, words[1:], row, least=1e-6)
        elif section == "units" and words[0] == "angle":
            degrees = words[1].lower().startswith("deg")
        elif section == "root" and words[0] == "order":
            bones["root"].dof = _dof(path, words[1:], row)
        elif section == "root" and words[0] in ("axis", "orientation"):
            turned = words[0] == "orientation" and any(number(path, word, row, "orientation") for word in words[1:])
            if turned or (words[0] == "axis" and words[1:] != ["XYZ"]):
                raise fault(path, "a root in other axes than XYZ, or turned, is not read", "bad_axis",
                            "Export it with axis XYZ and orientation 0 0 0", row=row, value=line.strip())  # fmt: skip
        elif section == "bonedata" and words[0] == "begin":
            now = _Bone()
        elif section == "bonedata" and words[0] == "name":
            bones[words[1]] = now
        elif section == "bonedata" and words[0] in ("direction", "axis"):
            if len(words) < 4 or (words[0] == "axis" and words[4:] not in ([], ["XYZ"])):
                raise fault(path, "this axis cannot be read", "bad_axis", "Three numbers, in the order XYZ", row=row)
            setattr(now, words[0], np.array([number(path, word, row, words[0]) for word in words[1:4]]))
        elif section == "bonedata" and words[0] == "length":
            now.length = _length(path, words[1:], row)
        elif section == "bonedata" and words[0] == "dof":
            now.dof = _dof(path, words[1:], row)
        elif section == "hierarchy" and words[0] not in ("begin", "end"):
            hierarchy |= dict.fromkeys(words[1:], words[0])
    if len(bones) < 2 or not hierarchy:
        raise fault(path, "no bones are described", "not_asf", "An ASF file has :bonedata and :hierarchy")
    return unit, degrees, bones, hierarchy


def _length(path: Path, words: list[str], row: int, least: float = 0.0) -> float:
    value = number(path, " ".join(words), row, "length")
    if value < least:
        raise fault(path, "no length is so short", "bad_length", "Give the ASF file as it was exported", row=row,
                    column="length", value=f"{value:g}")  # fmt: skip
    return value


def _dof(path: Path, words: list[str], row: int) -> list[str]:
    dof = [word.lower() for word in words]
    wrong = next((each for each in dof if each not in DOF), None)
    if wrong is not None:
        raise fault(path, "no such freedom of a bone", "bad_dof", f"One of {', '.join(DOF)}", row=row, value=wrong)
    return dof


def _ordered(path: Path, hierarchy: dict[str, str]) -> list[str]:
    """Parents before children."""
    order, left = ["root"], dict(hierarchy)
    while left:
        ready = [name for name, above in left.items() if above in order]
        if not ready:
            name, above = next(iter(left.items()))
            raise fault(path, f"bone {name!r} hangs on {above!r}, which hangs on nothing", "loose_bone",
                        "Every bone of :hierarchy hangs on root in the end")  # fmt: skip
        order += ready
        left = {name: above for name, above in left.items() if name not in ready}
    return order


def _frames(path: Path, bones: dict[str, _Bone]) -> tuple[str, list[dict[str, list[float]]]]:
    """deg, rad or nothing, as the head says; numbers by bone."""
    frames: list[dict[str, list[float]]] = []
    unit, first, begun = "", 1, list[int]()
    lines = lines_of(path)
    moved = {name for name, bone in bones.items() if bone.dof}
    for row, line in enumerate(lines, start=1):
        words = line.split()
        if not words or words[0][0] in "#:":
            unit = {":DEGREES": "deg", ":RADIANS": "rad"}.get(line.strip().upper(), unit)
            continue
        if len(words) == 1 and words[0].isdigit():
            first = first if frames else int(words[0])  # of what was cut out
            if int(words[0]) != first + len(frames):
                raise fault(path, f"frame {first + len(frames)} is missing", "frame_count", "Export the file again",
                            row=row, value=words[0])  # fmt: skip
            frames.append({})
            begun.append(row)
            continue
        if words[0] not in moved or not frames:
            raise fault(path, f"the skeleton has no moving bone {words[0]!r}", "other_bones",
                        "Give the ASF file of this person", row=row, column=words[0])  # fmt: skip
        dof = bones[words[0]].dof
        if len(words) - 1 != len(dof):
            raise fault(path, f"{len(words) - 1} numbers for {dof}", "other_bones", "Give the ASF file of this person",
                        row=row, column=words[0])  # fmt: skip
        if words[0] in frames[-1]:
            raise fault(path, f"bone {words[0]!r} stands twice in frame {first + len(frames) - 1}", "bone_twice",
                        "Export the file again", row=row, column=words[0])  # fmt: skip
        frames[-1][words[0]] = [number(path, word, row, words[0]) for word in words[1:]]
    short = next((k for k, frame in enumerate(frames) if set(frame) != moved), None)
    if not frames or short is not None:
        lost = sorted(moved - set(frames[short])) if short is not None else []
        raise fault(path, f"frame {(short or 0) + first} lacks bones: {', '.join(lost[:3]) or 'all'}", "frame_cut",
                    "The file was cut off, or belongs to another skeleton",
                    row=len(lines) if short in (None, len(frames) - 1) else begun[short])  # fmt: skip
    return unit, frames
