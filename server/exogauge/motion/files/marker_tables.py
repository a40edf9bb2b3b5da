"""Headers of the tables of Qualisys (Track Manager's manual, Motion data), OptiTrack (Motive's documentation, Data
Export: CSV) and Vicon (Nexus, Export ASCII)."""

from __future__ import annotations

import csv
import re
from dataclasses import replace
from pathlib import Path

from exogauge.motion.files.captured import METRES, Captured, fault, lines_of, number
from exogauge.motion.files.table import Rows, Table, points_of

NAMELESS = re.compile(r"(\*\d*|unlabell?ed.*|unidentified.*|)", re.IGNORECASE)
QUALISYS = re.compile(r"[A-Z][A-Z0-9_]+")
SECTIONS = ("Trajectories", "Devices", "Joints", "Model Outputs", "Segments")


def read_table(path: Path) -> Captured:
    """Raises BadMotion. What has no name, and what is no marker, is left out and told."""
    lines = lines_of(path)
    titles = [(k, word) for k, line in enumerate(lines[:-1]) if (word := line.strip('\t,; "')) in SECTIONS]
    if lines[0].split("\t")[0].strip() in ("NO_OF_FRAMES", "FILE_VERSION"):
        table, rows = _qualisys(path, lines)
    elif lines[0].lower().startswith("format version,"):
        table, rows = _motive(path, lines)
    elif titles:
        table, rows = _nexus(path, lines, titles)
    else:
        advice = "TSV of Qualisys, CSV of Motive or of Nexus, each with its header; or C3D, or TRC"
        if ",q." in lines[0]:
            advice = "Joint angles of a robot are judged and written by `exogauge motion check` and `export`"
        raise fault(path, "the table has no header that is known", "unknown_format", advice, row=1,
                    value=lines[0][:40])  # fmt: skip
    return points_of(path, _named(path, table), rows)


def _named(path: Path, table: Table) -> Table:
    """Without trajectories that nobody named."""
    kept = [k for k, label in enumerate(table.labels) if not NAMELESS.fullmatch(label.split(":")[-1].strip())]
    if not kept:
        raise fault(path, "no trajectory has the name of a marker", "no_markers",
                    "Label the markers before the export, and export their positions",
                    value=str(len(table.labels)))  # fmt: skip
    beside = [table.told["left_out"]] if "left_out" in table.told else []
    if nameless := len(table.labels) - len(kept):
        beside.append(f"trajectories without a name: {nameless}")
    told = {**table.told, "left_out": ", ".join(beside)} if beside else table.told
    return replace(table, labels=tuple(table.labels[k] for k in kept), first=tuple(table.first[k] for k in kept),
                   told=told)  # fmt: skip


def _qualisys(path: Path, lines: list[str]) -> tuple[Table, Rows]:
    """Track Manager writes millimetres, and where events are told one line each."""
    end = next((k for k, line in enumerate(lines) if not QUALISYS.fullmatch(line.split("\t")[0].strip())), len(lines))
    header = {cells[0].strip(): (k + 1, cells[1:]) for k, line in enumerate(lines[:end]) if (cells := line.split("\t"))}

    def said(key: str) -> tuple[int, str]:
        row, cells = header.get(key, (1, [""]))
        return row, cells[0].strip() if cells else ""

    row, kind = said("DATA_INCLUDED")
    if kind != "3D":
        raise fault(path, "these are no positions of markers", "no_markers", "Export 3D data with the TSV header",
                    row=row, column="DATA_INCLUDED", value=kind or None)  # fmt: skip
    row, count = said("NO_OF_MARKERS")
    named_at, names = header.get("MARKER_NAMES", (row, []))
    names = names[:-1] if names and not names[-1].strip() and count == str(len(names) - 1) else names
    if not names or count != str(len(names)):
        raise fault(path, f"{len(names)} markers are named and {count or 'none'} announced", "marker_count",
                    "NO_OF_MARKERS announces what MARKER_NAMES names", row=named_at, column="NO_OF_MARKERS",
                    value=count or None)  # fmt: skip
    head = [cell.strip().lower() for cell in lines[end].split("\t")] if end < len(lines) else []
    titled = bool(head) and (head[0] in ("frame", "time") or any(cell.endswith(" x") for cell in head))
    begin = end + titled
    rows = _filled(lines, begin)
    before = {cell: k for k, cell in enumerate(head[:2]) if begin > end and cell in ("frame", "time")}
    if begin == end and rows and len(rows[0][1].rstrip("\t").split("\t")) > 3 * len(names):
        before = {"frame": 0, "time": 1}
    rate_row, rate = said("FREQUENCY")
    first = tuple(len(before) + 3 * k for k in range(len(names)))
    frames_row, frames = said("NO_OF_FRAMES")
    return Table("Qualisys TSV", tuple(name.strip() for name in names), first, len(before) + 3 * len(names), "\t",
                 METRES["mm"], number(path, rate, rate_row, "FREQUENCY") if rate not in ("", "EXT") else None,
                 (rate_row, "FREQUENCY"), before.get("time"), before.get("frame"),
                 (frames, frames_row, "NO_OF_FRAMES")), rows  # fmt: skip


def _motive(path: Path, lines: list[str]) -> tuple[Table, Rows]:
    """Of types, names, identities, parents and kinds one row each; measured markers alone, as all else is computed."""
    split = list(csv.reader(lines[:12]))
    meta = {key.strip().lower(): value.strip() for key, value in zip(split[0][::2], split[0][1::2], strict=False)}
    end = next((k for k, cells in enumerate(split) if cells and cells[0].strip().lower() == "frame"), None)
    head = [cells for cells in split[1 : end or 1] if any(cells)]
    if end is None or len(head) < 3:
        raise fault(path, "the rows of types, names and axes are not there", "no_header",
                    "Export it with its header", row=min(len(lines), 3))  # fmt: skip
    axes = [cell.strip().lower() for cell in split[end]]
    wide = len(axes)
    types, names, kinds = ([cell.strip() for cell in (cells + [""] * wide)[:wide]] for cells in (*head[:2], head[-1]))
    placed = [k for k in range(wide - 2) if axes[k : k + 3] == ["x", "y", "z"] and kinds[k] == "Position"]
    first = [k for k in placed if types[k] == "Marker"]
    other = sorted({f"{types[k]} {names[k]}" for k in placed if types[k] != "Marker"})
    if not first:
        raise fault(path, "no measured marker is in the table", "no_markers",
                    "Tick Markers in the export; of a skeleton alone export BVH", row=3,
                    value=", ".join(other[:4]) or None)  # fmt: skip
    rate = next((key for key in ("Export Frame Rate", "Capture Frame Rate") if meta.get(key.lower())), "")
    said = meta.get("total exported frames")
    time = next((k for k, axis in enumerate(axes) if axis.startswith("time (")), None)
    return Table("Motive CSV", tuple(names[k] for k in first), tuple(first), wide, ",",
                 METRES.get(meta.get("length units", "").lower()),
                 number(path, meta[rate.lower()], 1, rate) if rate else None, (1, rate or "Capture Frame Rate"),
                 time, 0, (said, 1, "Total Exported Frames") if said else None,
                 {"left_out": ", ".join(other)} if other else {}), _filled(lines, end + 1)  # fmt: skip


def _nexus(path: Path, lines: list[str], titles: list[tuple[int, str]]) -> tuple[Table, Rows]:
    """The section of trajectories: title, rate, names, axes, units, rows, an empty one. Speeds are left out."""
    begin = next((k for k, title in titles if title == "Trajectories"), None)
    if begin is None or len(lines) < begin + 5:
        raise fault(path, "no trajectories are in the file", "no_markers", "Export trajectories from Nexus",
                    value=", ".join(title for _, title in titles))  # fmt: skip
    separator = next((each for each in ",;\t" if lines[begin + 3].startswith(f"Frame{each}Sub Frame")), None)
    if separator is None:
        raise fault(path, "the row of axes is not there", "no_header", "Rate, names, Frame with its axes, units, rows",
                    row=begin + 4, column="Frame", value=lines[begin + 3][:40])  # fmt: skip
    names, axes, units = (next(csv.reader([line], delimiter=separator)) for line in lines[begin + 2 : begin + 5])
    wide = max(k + 1 for k, axis in enumerate(axes) if axis)
    first = [k for k in range(2, wide - 2) if [axis.upper() for axis in axes[k : k + 3]] == ["X", "Y", "Z"]]
    labels = [names[k].strip() if k < len(names) else "" for k in first]
    said = {units[k].strip().lower() for k in first if k < len(units)}
    if len(said) > 1:
        raise fault(path, "trajectories are in several units", "no_unit", "Export all in one", row=begin + 5,
                    value=", ".join(sorted(said)))  # fmt: skip
    rows = _filled(lines, begin + 5, separator)
    rate = lines[begin + 1].strip(f"{separator} ")
    other = [title for _, title in titles if title != "Trajectories"]
    return Table("Nexus CSV", tuple(labels), tuple(first), wide, separator, METRES.get(next(iter(said), "")),
                 number(path, rate, begin + 2, "rate"), (begin + 2, "rate"), None, 0, None,
                 {"left_out": ", ".join(other)} if other else {}), rows  # fmt: skip


def _filled(lines: list[str], begin: int, ends: str | None = None) -> Rows:
    """(line, text) of what is not empty from `begin` on; up to the first empty one where a separator is given."""
    empty = [not line.strip(f"{ends or ''} \t") for line in lines[begin:]]
    stop = begin + empty.index(True) if ends is not None and True in empty else len(lines)
    return [(k + 1, lines[k]) for k in range(begin, stop) if lines[k].strip()]
