"""C3D: markers, as Intel, DEC or SGI processors write them (C3D file format, user guide of 2008: header, parameter and
data section)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exogauge.motion.files.captured import AXES, METRES, Captured, fault

Array = NDArray[np.float64]
Values = list[str] | NDArray[Any]

NO_MARKERS = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS")
BLOCK = 512  # bytes; the format counts in blocks of this size
INTEL, DEC, SGI = 84, 85, 86  # processor types
KINDS = {1: "i1", 2: "i2", 4: "f4"}


def read_c3d(path: Path) -> Captured:
    """Raises BadMotion. Angles, forces, moments, powers and scalars among the points are left out, and told."""
    data = path.read_bytes()
    if len(data) < 2 * BLOCK or data[1] != 0x50:
        raise fault(path, "this is no C3D file", "not_c3d", "A C3D file is at least 1 kB and has 0x50 in byte 2")
    begin = BLOCK * (data[0] - 1)
    processor = data[begin + 3] if 0 < begin < len(data) - 4 else 0
    if processor not in (INTEL, DEC, SGI):
        raise fault(path, "its parameters do not begin where the header says", "not_c3d", "Export it again",
                    value=str(processor))  # fmt: skip
    point = _parameters(data, begin, processor)
    points, analog, first, last = (int(each) for each in _numbers(data, 2, 4, "u2", processor))
    announced = _announced(point, last - first + 1)
    if points == 0 or not announced:
        raise fault(path, "the header announces no point or no frame", "no_markers", "Export the trial again")
    scale, rate = (float(_numbers(data, at, 1, "f4", processor)[0]) for at in (12, 20))
    if not rate > 0.0 and len(told_rate := point.get("RATE", [])):
        rate = float(told_rate[0])
    if not rate > 0.0:
        raise fault(path, "the header says no frame rate", "no_rate", "POINT:RATE is what the cameras ran at",
                    column="POINT:RATE", value=str(rate))  # fmt: skip
    kind = "f4" if scale < 0.0 else "i2"
    start, wide = BLOCK * (int(_numbers(data, 16, 1, "u2", processor)[0]) - 1), 4 * points + analog
    one = wide * int(kind[1])
    there = (len(data) - start) // one
    frames = max((count for count in announced if count <= there), default=0)
    if not frames:
        raise fault(path, f"the header announces {max(announced)} frames, and the file is too short for them",
                    "frame_count", "The file was cut off: copy it again", value=f"{len(data)} bytes")  # fmt: skip
    if (there - frames) * one > 2 * BLOCK + one:  # files are filled up to whole blocks
        raise fault(path, f"the header announces {frames} frames, and the file holds about {there}", "frame_count",
                    "A C3D header counts to 65535: cut the trial, or save it as TRC", value=str(frames))  # fmt: skip
    rows = _numbers(data, start, frames * wide, kind, processor).reshape(frames, wide)[:, : 4 * points]
    with np.errstate(invalid="ignore"):  # a NaN of another kind is a NaN
        place = rows.reshape(frames, points, 4).astype(np.float64)
    position = place[..., :3] * (1.0 if scale < 0.0 else scale)
    position[(place[..., 3] < 0.0) | (position == 0.0).all(axis=2)] = np.nan
    odd = np.isfinite(position).any(axis=2) & ~np.isfinite(position).all(axis=2)
    labels = [text for key in ("LABELS", "LABELS2", "LABELS3") for text in point.get(key, ())][:points]
    labels = [str(text) for text in labels] + [f"unnamed {k + 1}" for k in range(len(labels), points)]
    if odd.any():
        t, m = (int(each) for each in np.argwhere(odd)[0])
        raise fault(path, "of this point a part of the coordinates is a number", "half_a_point",
                    "The file is damaged: export it again", row=t + 1, column=labels[m],
                    value=", ".join(f"{x:g}" for x in position[t, m]))  # fmt: skip
    other = {str(name) for each in NO_MARKERS for name in point.get(each, ())}
    kept = [k for k, label in enumerate(labels) if label not in other]
    if not kept:
        raise fault(path, "the file holds no marker", "no_markers", "Export the trial with its trajectories")
    told = {"left_out": ", ".join(label for label in labels if label in other)} if len(kept) < len(labels) else {}
    unit, up = (str(next(iter(point.get(key, ())), "")).lower() for key in ("UNITS", "Y_SCREEN"))
    return Captured("C3D", np.arange(frames) / rate, METRES.get(unit), AXES.get(up), tuple(labels[k] for k in kept),
                    position[:, kept], None, told)  # fmt: skip


def _numbers(data: bytes, at: int, count: int, kind: str, processor: int) -> NDArray[Any]:
    """(count,) from byte `at`. DEC's floats have their two words exchanged, and an exponent that is larger by two."""
    if processor == DEC and kind == "f4":
        words = np.frombuffer(data, "<u2", 2 * count, at).reshape(-1, 2)[:, ::-1]
        return np.ascontiguousarray(words).view("<f4")[:, 0] / 4.0
    return np.frombuffer(data, (">" if processor == SGI else "<") + kind, count, at)


def _announced(point: dict[str, Values], header: int) -> list[int]:
    """Frames as the header, POINT:FRAMES or TRIAL's fields of two words have them: the first two may end at 65535."""
    found = [header]
    if len(frames := point.get("FRAMES", [])):
        found.append(int(float(frames[0])) if float(frames[0]) > 0.0 else int(float(frames[0])) + 2**16)
    ends = [point.get(f"ACTUAL_{end}_FIELD", []) for end in ("START", "END")]
    if all(len(each) > 1 for each in ends):
        low, high = (int(each[0]) % 2**16 + 2**16 * (int(each[1]) % 2**16) for each in ends)
        found.append(high - low + 1)
    return [count for count in found if count > 0]


def _parameters(data: bytes, begin: int, processor: int) -> dict[str, Values]:
    """Of the groups POINT and TRIAL, by name."""
    groups, found = dict[int, str](), list[tuple[int, str, int]]()
    blocks = data[begin + 2] or 255  # some leave their count out
    at, end = begin + 4, min(begin + BLOCK * blocks, len(data) - 4)
    while at < end and (long := abs(_signed(data[at]))) > 0:
        group, name = _signed(data[at + 1]), data[at + 2 : at + 2 + long].decode("latin-1").strip().upper()
        at += 2 + long
        follows = int(_numbers(data, at, 1, "i2", processor)[0])
        if group < 0:
            groups[-group] = name
        else:
            found.append((group, name, at + 2))
        if follows <= 0:
            break
        at += follows
    return {name: _value(data, at, processor) for group, name, at in found if groups.get(group) in ("POINT", "TRIAL")}


def _value(data: bytes, at: int, processor: int) -> Values:
    """Texts or numbers of a parameter, one after the other."""
    kind, depth = _signed(data[at]), data[at + 1]
    shape = [int(each) for each in data[at + 2 : at + 2 + depth]]
    at, count = at + 2 + depth, int(np.prod(shape, dtype=np.int64))
    if kind != -1:
        return _numbers(data, at, count, KINDS[kind], processor)
    long = shape[0] if shape else 1
    texts = (data[k : k + long] for k in range(at, at + count, max(long, 1)))
    return [text.decode("utf-8", errors="replace").strip(" \0") for text in texts]


def _signed(byte: int) -> int:
    return byte - 256 if byte > 127 else byte
