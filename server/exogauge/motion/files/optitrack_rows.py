"""CSV of OptiTrack before 1.2 (Tracking Tools, Motive to 1.6): each row says in its first cell what it is.

Rows as the comments at the head of such files describe them: `info`, a key and its value; `frame`, its index, time [s],
count of rigid bodies, eleven cells for each of them, count of markers; x, y, z, identity, name of each that was seen.
"""

from __future__ import annotations

import csv
from pathlib import Path

from exogauge.motion.files.captured import fault, number
from exogauge.motion.files.table import Rows, Table, from_x

FIRST = ("comment", "info", "righthanded", "lefthanded")
VERSION = "1.1"
BODY, MARKER = 11, 5  # cells


def says_its_rows(lines: list[str]) -> bool:
    return lines[0].split(",")[0].strip().lower() in FIRST and any(line.startswith("frame,") for line in lines)


def frames_of(path: Path, lines: list[str]) -> tuple[Table, Rows]:
    """Measured markers, one column for each name, empty in frames that do not show it. Raises BadMotion."""
    said, seen = dict[str, tuple[str, int]](), list[tuple[int, str, str, dict[str, str]]]()
    for row, line in enumerate(lines, start=1):
        kind = line.split(",")[0].strip().lower()
        if kind == "lefthanded":
            raise fault(path, "its axes are left-handed", "left_handed", "Export it right-handed", row=row)
        if kind in ("info", "frame"):
            cells = [cell.strip() for cell in next(csv.reader([line]))]
            if kind == "frame":
                seen.append((row, *_frame(path, cells, row)))
            elif len(cells) > 2:
                said[cells[1].lower()] = (cells[2], row)
        if kind == "frame" and len(seen) == 1 and said.get("version", ("", 0))[0] != VERSION:
            given, at = said.get("version", ("", row))
            raise fault(path, f"only version {VERSION} names the markers of a frame", "other_version",
                        "Export the take from a newer Motive, or C3D", row=at, column="version",
                        value=given or None)  # fmt: skip
    labels = tuple(dict.fromkeys(name for *_, markers in seen for name in markers))
    rows = [
        (row, ",".join([frame, time, *(markers.get(label, ",,") for label in labels)]))
        for row, frame, time, markers in seen
    ]
    bodies, announced = said.get("rigidbodycount", ("0", 0))[0], said.get("framecount")
    return Table(
        f"Motive CSV {VERSION}", labels, tuple(from_x(2 + 3 * k) for k in range(len(labels))), 2 + 3 * len(labels), ",",
        None, time=1, frame=0, stated=(*announced, "framecount") if announced else None,
        told={"left_out": f"rigid bodies: {bodies}"} if bodies != "0" else {},
    ), rows  # fmt: skip


def _frame(path: Path, cells: list[str], row: int) -> tuple[str, str, dict[str, str]]:
    """Index, time and the named markers with their x, y and z; what has no name is left out."""
    begin = 4 + BODY * _count(path, cells, 3, row, "rigid bodies")
    count = _count(path, cells, begin, row, "markers")
    of = cells[begin + 1 :]
    if len(of) != MARKER * count:
        raise fault(path, f"{len(of)} cells for {count} markers", "row_length",
                    f"A marker has {MARKER}: x, y, z, identity, name. The file was cut off, or is another version",
                    row=row)  # fmt: skip
    markers = dict[str, str]()
    for k in range(0, len(of), MARKER):
        name = of[k + 4]
        if name in markers:
            raise fault(path, "two markers of a frame have one name", "label_twice", "Label each once",
                        row=row, value=name)  # fmt: skip
        if name:
            markers[name] = ",".join(of[k : k + 3])
    return cells[1], cells[2], markers


def _count(path: Path, cells: list[str], at: int, row: int, of: str) -> int:
    value = number(path, cells[at] if at < len(cells) else "", row, f"count of {of}")
    if not (value.is_integer() and 0.0 <= value <= len(cells)):
        raise fault(path, "this is no count", "not_a_number", "Export the file again", row=row, column=f"count of {of}",
                    value=f"{value:g}")  # fmt: skip
    return int(value)
