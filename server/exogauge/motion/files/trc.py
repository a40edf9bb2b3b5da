"""TRC, the text file of markers that OpenSim reads; header oddities that are met in the wild are taken."""

from __future__ import annotations

from pathlib import Path

from exogauge.motion.files.captured import METRES, Captured, fault, lines_of, number
from exogauge.motion.files.table import Table, from_x, points_of


def read_trc(path: Path) -> Captured:
    """Raises BadMotion."""
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
    rate = number(path, header["DataRate"], 3, "DataRate") if "DataRate" in header else None
    columns = tuple(from_x(2 + 3 * k) for k in range(len(labels)))
    table = Table("TRC", labels, columns, 2 + 3 * len(labels), "\t", unit, rate, (3, "DataRate"), 1,
                  stated=(header.get("NumFrames", ""), 3, "NumFrames"))  # fmt: skip
    return points_of(path, table, rows)
