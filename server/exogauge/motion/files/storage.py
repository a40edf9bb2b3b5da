"""MOT and STO, OpenSim's tables of coordinates over time."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from exogauge.criteria.motion_import import USUAL
from exogauge.motion.files.captured import STILL, even_time, fault, lines_of, not_radians, number
from exogauge.motion.human import Angles, HumanMotion

LENGTHS = ("_tx", "_ty", "_tz")
VALUE = "/value"
OTHER = re.compile(  # what OpenSim calls its tables of anything but coordinates, in their first line
    r"(actuator)?(speeds|accelerations|forces|powers)|(position|velocity)errors|stresstermweight"
    r"|moment(arm)?_.*|\w*(fiber|tendon|pennation)\w*|length|musclepower|static optimization|inverse dynamics.*"
    r"|model marker (errors|locations) from ik",
    re.IGNORECASE,
)


def read_storage(path: Path, angle: str | None = None) -> HumanMotion:
    """Raises BadMotion. Radians or degrees, as is stated or the header says; a table of speeds, errors, forces or
    muscles is no motion."""
    lines = lines_of(path)
    end = next((k for k, line in enumerate(lines) if line.strip().lower() == "endheader"), None)
    if end is None or len(lines) < end + 3:
        raise fault(path, "no header ends here", "not_storage", "A MOT file has endheader, a line of names, then rows")
    pairs = [line.replace("=", " ").lower().split() for line in lines[:end]]
    header = {pair[0]: pair[1] for pair in pairs if len(pair) == 2}
    said_in = {pair[0]: row for row, pair in enumerate(pairs, start=1) if len(pair) == 2}
    if OTHER.fullmatch(lines[0].strip()):
        raise fault(path, "this table of OpenSim's holds no coordinates", "no_coordinates",
                    "Give the one called Coordinates: the .mot of inverse kinematics, or …_q.sto", row=1,
                    value=lines[0].strip())  # fmt: skip
    if header.get("datatype", "double") != "double":
        raise fault(path, "a cell holds several numbers, and no angle", "no_coordinates",
                    "Of orientations give the .mot that inverse kinematics makes of them; of markers a TRC",
                    column="DataType", value=header["datatype"])  # fmt: skip
    (head, words), *rows = [(k, line.split()) for k, line in enumerate(lines[end + 1 :], start=end + 2) if line.strip()]
    names = words
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise fault(path, "two columns have one name", "column_twice", "Name each once", row=head, column=twice)
    for keys, there, rule, advice in (
        (("nColumns", "datacolumns"), len(names), "column_count", "A column was lost or added: export it again"),
        (("nRows", "datarows"), len(rows), "frame_count", "The file was cut off: export it again"),
    ):
        key = next((key for key in keys if key.lower() in header), None)
        stated = str(there) if key is None else header[key.lower()]
        if key is not None and stated != str(there):
            raise fault(path, f"{there} {keys[0][1:].lower()} are there and {stated} announced", rule, advice,
                        row=said_in[key.lower()], column=key, value=stated)  # fmt: skip
    for row, words in rows:
        if len(words) != len(names):
            raise fault(
                path, f"{len(words)} numbers for {len(names)} columns", "row_length", "Export it again", row=row
            )
    data = np.array([[number(path, word, row, names[k]) for k, word in enumerate(words)] for row, words in rows])
    told = {"format": "MOT"}
    if any(name.endswith(VALUE) for name in names):  # a table of states: coordinates, speeds, muscles by their paths
        kept = [0, *(k for k, name in enumerate(names) if name.endswith(VALUE))]
        told["left_out"] = ", ".join(name for k, name in enumerate(names) if k not in kept)
        names, data = [names[0], *(names[k].removesuffix(VALUE).split("/")[-1] for k in kept[1:])], data[:, kept]
    if any("force" in name.lower() or name.endswith("_moment") for name in names):
        raise fault(path, "these are forces or moments and no motion", "forces", "Give the markers or the angles",
                    row=head, column=names[1], value=names[1])  # fmt: skip
    if turned := [name for name in names if name.endswith("_Ox")]:
        raise fault(path, "these are bodies in the world and no coordinates", "no_coordinates",
                    "Give the .mot of inverse kinematics, or …_Kinematics_q.sto", row=head, column=turned[0],
                    value=turned[0])  # fmt: skip
    turning = np.array([not name.endswith(LENGTHS) for name in names[1:]])
    time, stated_angle = even_time(path, data[:, 0], rows[0][0] if rows else 1), angle
    angle = angle or {"yes": "deg", "no": "rad"}.get(header.get("indegrees", ""))
    value = data[:, 1:]
    most = float(np.abs(value[:, turning]).max(initial=0.0))
    if angle is None:
        raise fault(path, "the header does not say whether angles are in degrees", "no_angle_unit",
                    "Say the unit of angles, rad or deg, or write inDegrees=yes or no above endheader",
                    column="angle")  # fmt: skip
    if angle == "deg" and stated_angle is None:
        not_radians(path, most)
    if angle == "deg":
        value[:, turning] = np.radians(value[:, turning])
    elif most > USUAL.largest_angle_rad:
        t, k = np.argwhere(np.abs(value * turning) == most)[0]
        detail, advice = "an angle of more than two turns, said to be in radians", "Say the unit of angles: deg"
        raise fault(path, detail, "degrees_for_radians", advice, row=rows[t][0], column=names[k + 1],
                    value=f"{value[t, k]:g}")  # fmt: skip
    if (value == value[0]).all():
        told["still"] = STILL
    told["angles"] = "degrees" if angle == "deg" else "radians"
    return HumanMotion(path.stem, time, angles=Angles(tuple(names[1:]), value, turning), told=told)
