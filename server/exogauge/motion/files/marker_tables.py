"""Headers of the tables of Qualisys (Track Manager's manual, Motion data), OptiTrack (Motive's documentation, Data
Export: CSV) and Vicon (Nexus, Export ASCII), and plain ones: one row with a name for every column."""

from __future__ import annotations

import csv
import re
from dataclasses import replace
from pathlib import Path

from exogauge.motion.files.captured import METRES, Captured, fault, lines_of, number
from exogauge.motion.files.optitrack_rows import frames_of, says_its_rows
from exogauge.motion.files.table import Rows, Table, Triple, from_x, pointed, points_of

NAMELESS = re.compile(r"(\*\d*|unlabell?ed.*|unidentified.*|)", re.IGNORECASE)
QUALISYS = re.compile(r"[A-Z][A-Z0-9_]+")
COORDINATE = re.compile(  # LASI_X, LASI.x, Ann:LASI:X, LASI (X), LASI_X_mm, LASI.x [mm]; X_LASI, x.LASI (mm)
    r"(?P<label>.*[^\W_])[\s_.:/|(\[-]+(?P<axis>[xyz])[)\]]?(?:[\s_/]*[\[(]?(?P<unit>mm|cm|m|in)[\])]?)?"
    r"|(?P<first>[xyz])[\s_.:-]+(?P<of>.*?\w)(?:\s*[\[(](?P<said>mm|cm|m|in)[\])])?",
    re.IGNORECASE,
)
CLOCK = re.compile(r"(?:t|times?|time_?stamp|seconds|secs?)(?:[\s_.]*[\[(]?(?P<unit>s|sec|seconds|ms|us|µs|ns)[\])]?)?",
                   re.IGNORECASE)  # fmt: skip
COUNT = re.compile(r"(?:frame|sample)s?(?:[\s_.]*(?:#|no\.?|nr\.?|number|index|id))?#?", re.IGNORECASE)
SECOND = {"ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9}
SAID = re.compile(  # above the row of names
    r"[#%/\s]*(?P<key>(?:length[\s_]*)?units?|(?:(?:frame|sample|sampling|data|capture)[\s_]*)?(?:rate|frequency))"
    r"(?:[\s_]*[\[(]hz[\])])?\s*[:=,;\t ]\s*(?P<value>[\w.]+)(?:\s*hz)?[\s,;]*",
    re.IGNORECASE,
)
SECTIONS = ("Trajectories", "Devices", "Joints", "Model Outputs", "Segments", "Objects")  # the last of Tracker


def read_table(path: Path) -> Captured:
    """Raises BadMotion. What has no name, and what is no marker, is left out and told."""
    lines = lines_of(path)
    titles = [(k, word) for k, line in enumerate(lines[:-1]) if (word := line.strip('\t,; "')) in SECTIONS]
    if lines[0].split("\t")[0].strip() in ("NO_OF_FRAMES", "FILE_VERSION"):
        table, rows = _qualisys(path, lines)
    elif lines[0].lower().startswith("format version,"):
        table, rows = _motive(path, lines)
    elif says_its_rows(lines):
        table, rows = frames_of(path, lines)
    elif titles:
        table, rows = _nexus(path, lines, titles)
    elif ",q." not in lines[0] and (plain := _names_row(lines)) is not None:
        table, rows = _plain(path, lines, *plain)
    else:
        advice = ("TSV of Qualisys, CSV of Motive or of Nexus, each with its header; columns called t, LASI_X, LASI_Y, "
                  "LASI_Z, …; or C3D, or TRC")  # fmt: skip
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
    return replace(table, labels=tuple(table.labels[k] for k in kept), columns=tuple(table.columns[k] for k in kept),
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
    columns = tuple(from_x(len(before) + 3 * k) for k in range(len(names)))
    frames_row, frames = said("NO_OF_FRAMES")
    return Table("Qualisys TSV", tuple(name.strip() for name in names), columns, len(before) + 3 * len(names), "\t",
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
    return Table("Motive CSV", tuple(names[k] for k in first), tuple(map(from_x, first)), wide, ",",
                 METRES.get(meta.get("length units", "").lower()),
                 number(path, meta[rate.lower()], 1, rate) if rate else None, (1, rate or "Capture Frame Rate"),
                 time, 0, (said, 1, "Total Exported Frames") if said else None,
                 {"left_out": ", ".join(other)} if other else {}), _filled(lines, end + 1)  # fmt: skip


def _nexus(path: Path, lines: list[str], titles: list[tuple[int, str]]) -> tuple[Table, Rows]:
    """The section of trajectories: title, rate, names, axes, units, rows, an empty one. Speeds are left out."""
    begin = next((k for k, title in titles if title == "Trajectories"), None)
    if begin is None or len(lines) < begin + 5:
        advice = "Export its trajectories; rigid objects of Tracker are no markers of a person"
        raise fault(path, "no trajectories are in the file", "no_markers", advice,
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
    return Table("Nexus CSV", tuple(labels), tuple(map(from_x, first)), wide, separator,
                 METRES.get(next(iter(said), "")), number(path, rate, begin + 2, "rate"), (begin + 2, "rate"),
                 None, 0, None, {"left_out": ", ".join(other)} if other else {}), rows  # fmt: skip


def _names_row(lines: list[str]) -> tuple[int, str, list[str]] | None:
    """The row that names two coordinates or more, what separates its cells, and the cells."""
    high = 20  # judgement: rows, that what is said above the names may take
    for k, line in enumerate(lines[:high]):
        for separator in max((",;\t"), key=line.count):
            cells = [cell.strip() for cell in next(csv.reader([line.lstrip("#% ")], delimiter=separator), [])]
            if sum(COORDINATE.fullmatch(cell) is not None for cell in cells) > 1:
                return k, separator, cells
    return None


def _plain(path: Path, lines: list[str], at: int, separator: str, cells: list[str]) -> tuple[Table, Rows]:
    """One row of names, in any order; above it what is said of unit and rate; below it units, where there are any."""
    while not cells[-1]:
        cells.pop()
    row = at + 1
    said = {"unit" if "unit" in found["key"].lower() else "rate": (k + 1, found["key"], found["value"])
            for k, line in enumerate(lines[:at]) if (found := SAID.fullmatch(line))}  # fmt: skip
    time, frame = (next((k for k, cell in enumerate(cells) if kind.fullmatch(cell)), None) for kind in (CLOCK, COUNT))
    markers = _markers(path, cells, row)
    used = {time, frame, *(k for each in markers.values() for k in each)}
    below = [cell.strip(' \t[]()"').lower() for cell in lines[row].split(separator)] if row < len(lines) else []
    below = [] if any(map(_numeric, below)) else below + [""] * (len(cells) - len(below))
    units_row = any(below)
    units = {said["unit"][2].lower()} if "unit" in said else set[str]()
    for k in (k for each in markers.values() for k in each):
        found = COORDINATE.fullmatch(cells[k])
        units |= {str(unit).lower() for unit in (found and (found["unit"] or found["said"]), units_row and below[k])
                  if unit}  # fmt: skip
    if len(units) > 1 or not units <= METRES.keys():
        wrong = "the markers are in several units" if len(units) > 1 else "no such unit is known"
        raise fault(path, wrong, "no_unit", "Export all in one: m, cm, mm or in", row=row + units_row, column="unit",
                    value=", ".join(sorted(units)))  # fmt: skip
    clock = CLOCK.fullmatch(cells[time]) if time is not None else None
    lasts = clock["unit"] or (below[time] if units_row and time is not None else "") if clock else ""
    rate_row, key, rate = said.get("rate", (row, "time" if frame is None else cells[frame], ""))
    beside = ", ".join(cell for k, cell in enumerate(cells) if k not in used and cell)
    rows = [(k, line.replace('"', "")) for k, line in _filled(lines, row + units_row)]
    if time is not None or frame is not None:  # Excel saves empty rows too
        rows = [(k, line) for k, line in rows if line.strip(f"{separator} \t")]
    return Table("plain CSV", tuple(markers), tuple(markers.values()), len(cells), separator,
                 METRES[units.pop()] if units else None, number(path, rate, rate_row, key) if rate else None,
                 (rate_row, key), time, frame, told={"left_out": beside} if beside else {},
                 second=SECOND.get(lasts.lower(), 1.0), head=tuple(cells)), rows  # fmt: skip


def _markers(path: Path, cells: list[str], row: int) -> dict[str, Triple]:
    """Columns of the x, y and z of every label; what has a w too is a turn."""
    axes = dict[str, dict[str, int]]()
    for k, cell in enumerate(cells):
        if (found := COORDINATE.fullmatch(cell)) is None:
            continue
        own, axis = axes.setdefault(found["label"] or found["of"], {}), (found["axis"] or found["first"]).lower()
        if axis in own:
            raise fault(path, f"columns {own[axis] + 1} and {k + 1} have one name", "label_twice",
                        "Name each marker once, or take one of them out", row=row, column=cell,
                        value=cells[own[axis]])  # fmt: skip
        own[axis] = k
    turns = {found[1] for cell in cells if (found := re.fullmatch(r"(.*[^\W_])[\s_.:/|-]+w", cell, re.IGNORECASE))}
    for label, own in axes.items():
        if label not in turns and len(own) < 3:
            lost = ", ".join(axis for axis in "xyz" if axis not in own)
            raise fault(path, f"of {label} no {lost} is there", "axis_missing",
                        "A marker is x, y and z: export all three, or take its columns out", row=row,
                        column=cells[min(own.values())], value=", ".join(cells[k] for k in own.values()))  # fmt: skip
    return {label: (own["x"], own["y"], own["z"]) for label, own in axes.items() if label not in turns}


def _numeric(cell: str) -> bool:
    try:
        float(pointed(cell))
    except ValueError:
        return False
    return True


def _filled(lines: list[str], begin: int, ends: str | None = None) -> Rows:
    """(line, text) of what is not empty from `begin` on; up to the first empty one where a separator is given."""
    empty = [not line.strip(f"{ends or ''} \t") for line in lines[begin:]]
    stop = begin + empty.index(True) if ends is not None and True in empty else len(lines)
    return [(k + 1, lines[k]) for k in range(begin, stop) if lines[k].strip()]
