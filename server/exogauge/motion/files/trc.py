"""TRC, the text file of markers that OpenSim reads; header oddities that are met in the wild are taken."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from exogauge.criteria.motion_import import USUAL
from exogauge.motion.files.captured import METRES, Captured, fault, lines_of, number


def read_trc(path: Path) -> Captured:
    """Raises BadMotion. A point that is left empty, or at 0 0 0 exactly, was not seen."""
    lines = lines_of(path)
    if len(lines) < 6 or not lines[0].startswith("PathFileType"):
        raise fault(path, "the first line is not that of a TRC file", "not_trc", "It begins with PathFileType", row=1)
    names, said = ([text.strip() for text in line.rstrip().split("\t")] for line in lines[1:3])
    if len(names) != len(said):  # neither tabs nor all of them: as they follow
        names, said = lines[1].split(), lines[2].split()
    header = dict(zip(names, said, strict=False))
    labels = tuple(text.strip() for text in lines[3].split("\t")[2:] if text.strip())
    stated, unit = header.get("NumMarkers", ""), METRES.get(header.get("Units", "").lower())
    if not labels:
        raise fault(path, "no marker is named", "no_markers", "Line 4 holds Frame#, Time and a name per marker", row=4)
    if stated != str(len(labels)):
        raise fault(path, f"{len(labels)} markers are named and {stated or 'none'} announced", "marker_count",
                    "Line 3 announces what line 4 names", row=3, column="NumMarkers", value=stated)  # fmt: skip
    begin = 4 if lines[4].split("\t")[0].strip().isdigit() else 5  # some leave the line of X1 Y1 Z1 out
    rows = [(k, line) for k, line in enumerate(lines[begin:], start=begin + 1) if line.strip()]
    if header.get("NumFrames") != str(len(rows)):
        raise fault(path, f"{len(rows)} frames are there and {header.get('NumFrames')} announced", "frame_count",
                    "The file was cut off, or joined of two: export it again", row=3, column="NumFrames",
                    value=header.get("NumFrames"))  # fmt: skip
    wide = 3 * len(labels)
    time, position = np.empty(len(rows)), np.full((len(rows), wide), np.nan)
    for t, (row, line) in enumerate(rows):
        fields = line.split("\t")
        short = 2 + wide - len(fields)
        if short > 0 and short % 3 == 0 and t + 1 < len(rows) and all(len(text.split()) < 2 for text in fields):
            fields += [""] * short  # empty fields at the end of a line, which editors take off
        if len(fields) < 2 + wide or any(text.strip() for text in fields[2 + wide :]):
            raise fault(path, f"{max(len(fields) - 2, 0)} numbers for {wide} coordinates", "row_length",
                        "Every row holds frame, time and x, y, z of every marker, between tabs", row=row)  # fmt: skip
        time[t] = number(path, fields[1], row, "Time")
        try:
            position[t] = [float(text) if text.strip() else np.nan for text in fields[2 : 2 + wide]]
        except ValueError:
            for k, text in enumerate(fields[2 : 2 + wide]):
                if text.strip():
                    number(path, text, row, f"{labels[k // 3]} {'xyz'[k % 3]}")
    points = position.reshape(len(rows), len(labels), 3)
    points[(points == 0.0).all(axis=2)] = np.nan
    points[~np.isfinite(points).all(axis=2)] = np.nan
    rate = number(path, header.get("DataRate", "nan"), 3, "DataRate") if "DataRate" in header else 0.0
    runs = (len(time) - 1) / (time[-1] - time[0]) if len(time) > 1 and time[-1] > time[0] else 0.0
    if min(rate, runs) > 0.0 and abs(rate / runs - 1.0) > USUAL.same_rate:
        raise fault(path, f"DataRate says {rate:g} frames a second, Time {runs:g}", "two_rates",
                    "Time is in seconds: correct it, or DataRate", row=3, column="DataRate",
                    value=f"{rate:g}")  # fmt: skip
    return Captured("TRC", time, unit, None, labels, points)
