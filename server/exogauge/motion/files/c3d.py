"""C3D: markers. What ezc3d opens without a word although it is damaged is refused by the file's own header."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from exogauge.motion.files.captured import AXES, METRES, Captured, fault

NO_MARKERS = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS")
BLOCK = 512  # bytes; the C3D file format counts in blocks of this size
DEC, SGI = 84, 86  # processor types (C3D file format, parameter section)


def read_c3d(path: Path) -> Captured:
    """Raises BadMotion. Angles, forces, moments, powers and scalars among the points are left out, and told."""
    _check_header(path)
    import ezc3d

    try:
        file = ezc3d.c3d(str(path))
    except Exception as problem:  # ezc3d throws what its C++ throws
        raise fault(path, f"this C3D file cannot be read: {problem}", "not_c3d", "Export it again") from problem
    group = file["parameters"]["POINT"]
    points = np.moveaxis(np.asarray(file["data"]["points"], float)[:3], (0, 1, 2), (2, 1, 0)).copy()
    residual = np.asarray(file["data"]["meta_points"]["residuals"], float)[0].T
    points[(residual < 0.0) | (points == 0.0).all(axis=2)] = np.nan
    labels = [str(text).strip() for text in _value(group, "LABELS")][: points.shape[1]]
    labels += [f"unnamed {k + 1}" for k in range(len(labels), points.shape[1])]
    other = {str(name).strip() for kind in NO_MARKERS for name in _value(group, kind)}
    kept = [k for k, label in enumerate(labels) if label not in other]
    if not kept:
        raise fault(path, "the file holds no marker", "no_markers", "Export the trial with its trajectories")
    units, up = _value(group, "UNITS"), _value(group, "Y_SCREEN")
    rate = float(file["header"]["points"]["frame_rate"])
    if not rate > 0.0:
        raise fault(path, "the header says no frame rate", "no_rate", "POINT:RATE is what the cameras ran at",
                    column="POINT:RATE", value=str(rate))  # fmt: skip
    told = {"left_out": ", ".join(label for label in labels if label in other)} if len(kept) < len(labels) else {}
    return Captured(
        "C3D", np.arange(len(points)) / rate, METRES.get(str(units[0]).strip().lower()) if len(units) else None,
        AXES.get(str(up[0]).strip().lower()) if len(up) else None, tuple(labels[k] for k in kept), points[:, kept],
        None, told,
    )  # fmt: skip


def _value(group: object, name: str) -> list[object]:
    return list(group[name]["value"]) if name in group else []  # type: ignore[index,operator]


def _check_header(path: Path) -> None:
    """The data section must be as long as the header's frames make it."""
    size = path.stat().st_size
    with path.open("rb") as stream:
        head = stream.read(BLOCK)
        if size < 1024 or head[1] != 0x50:
            raise fault(path, "this is no C3D file", "not_c3d", "A C3D file is at least 1 kB and has 0x50 in byte 2")
        stream.seek(BLOCK * (head[0] - 1))
        start = stream.read(4)
    processor = start[3] if len(start) == 4 else 0
    if processor == SGI:
        raise fault(path, "the file is written for SGI processors", "sgi_c3d",
                    "Save it as Intel C3D: every maker's program and Mokka do", value=str(processor))  # fmt: skip
    points, analog, first, last = struct.unpack_from("<4H", head, 2)
    place = struct.unpack_from("<H", head, 16)[0]
    scale = head[12:16] if processor == DEC else head[14:16] + head[12:14]  # DEC writes its words the other way round
    width = 4 if scale[3] & 0x80 else 2
    frames = last - first + 1
    if points == 0 or frames <= 0:
        raise fault(path, "the header announces no point or no frame", "no_markers", "Export the trial again")
    one = width * (4 * points + analog)
    there = (size - BLOCK * (place - 1)) // one
    if there < frames:
        raise fault(path, f"the header announces {frames} frames, and the file is too short for them", "frame_count",
                    "The file was cut off: copy it again", value=f"{size} bytes")  # fmt: skip
    if (there - frames) * one > 2 * BLOCK + one:  # files are filled up to whole blocks
        raise fault(path, f"the header announces {frames} frames, and the file holds about {there}", "frame_count",
                    "A C3D header counts to 65535: cut the trial, or save it as TRC", value=str(frames))  # fmt: skip
