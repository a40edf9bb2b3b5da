"""MOT and STO, OpenSim's tables of coordinates over time."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from exogauge.criteria.motion_import import USUAL
from exogauge.motion.files.captured import even_time, fault, lines_of, number
from exogauge.motion.human import Angles, HumanMotion

LENGTHS = ("_tx", "_ty", "_tz")


def read_storage(path: Path, angle: str | None = None) -> HumanMotion:
    """Raises BadMotion. Radians or degrees, as is stated or the header says; a table of forces is no motion."""
    lines = lines_of(path)
    end = next((k for k, line in enumerate(lines) if line.strip().lower() == "endheader"), None)
    if end is None or len(lines) < end + 3:
        raise fault(path, "no header ends here", "not_storage", "A MOT file has endheader, a line of names, then rows")
    pairs = (line.replace("=", " ").lower().split() for line in lines[:end])
    header = {pair[0]: pair[1] for pair in pairs if len(pair) == 2}
    names = lines[end + 1].split()
    rows = [(k, line.split()) for k, line in enumerate(lines[end + 2 :], start=end + 3) if line.strip()]
    stated = header.get("nrows", header.get("datarows", str(len(rows))))
    if stated != str(len(rows)):
        raise fault(path, f"{len(rows)} rows are there and {stated} announced", "frame_count",
                    "The file was cut off: export it again", column="nRows", value=stated)  # fmt: skip
    for row, words in rows:
        if len(words) != len(names):
            raise fault(
                path, f"{len(words)} numbers for {len(names)} columns", "row_length", "Export it again", row=row
            )
    if any("force" in name.lower() for name in names):
        raise fault(path, "these are forces of the ground and no motion", "forces", "Give the markers or the angles",
                    row=end + 2, column=names[1], value=names[1])  # fmt: skip
    data = np.array([[number(path, word, row, names[k]) for k, word in enumerate(words)] for row, words in rows])
    turning = np.array([not name.endswith(LENGTHS) for name in names[1:]])
    angle = angle or {"yes": "deg", "no": "rad"}.get(header.get("indegrees", ""))
    if angle is None:
        raise fault(path, "the header does not say whether angles are in degrees", "no_angle_unit",
                    "Say the unit of angles, rad or deg, or write inDegrees=yes or no above endheader",
                    column="angle")  # fmt: skip
    value = data[:, 1:]
    if angle == "deg":
        value[:, turning] = np.radians(value[:, turning])
    elif turning.any() and (most := np.abs(value[:, turning]).max(initial=0.0)) > USUAL.largest_angle_rad:
        t, k = np.argwhere(np.abs(value * turning) == most)[0]
        detail, advice = "an angle of more than two turns, said to be in radians", "Say the unit of angles: deg"
        raise fault(path, detail, "degrees_for_radians", advice, row=rows[t][0], column=names[k + 1],
                    value=f"{value[t, k]:g}")  # fmt: skip
    told = {"format": "MOT", "angles": "degrees" if angle == "deg" else "radians"}
    return HumanMotion(
        path.stem, even_time(path, data[:, 0]), angles=Angles(tuple(names[1:]), value, turning), told=told
    )
