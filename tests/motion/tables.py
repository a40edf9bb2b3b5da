"""One motion written as the tables of other programs, by their documented formats."""

from __future__ import annotations

from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
Names = tuple[str, ...]
TO_Y_UP = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])  # as Motive has it


def _texts(row: Array, gap: str = "") -> list[str]:
    return [gap if np.isnan(x) else f"{x:.6f}" for x in row.ravel()]


def qualisys(points: Array, labels: Names, rate: float = 100.0, gap: str = "", head: bool = True) -> str:
    """points: (T, M, 3) [m], z up. head: with the row of columns, frames and times, as newer versions have it."""
    lines = [f"NO_OF_FRAMES\t{len(points)}", "NO_OF_CAMERAS\t8", f"NO_OF_MARKERS\t{len(labels)}",
             f"FREQUENCY\t{rate:g}", "NO_OF_ANALOG\t0", "ANALOG_FREQUENCY\t0", "DESCRIPTION\t--",
             "TIME_STAMP\t2024-03-05, 10:11:12.123\t4567.89", "DATA_INCLUDED\t3D", "EVENT\tstart\t1\t0.00000",
             "\t".join(["MARKER_NAMES", *labels]),
             "\t".join(["TRAJECTORY_TYPES", *["Measured"] * len(labels)])]  # fmt: skip
    if head:
        lines.append("\t".join(["Frame", "Time", *(f"{label} {axis}" for label in labels for axis in "XYZ"), ""]))
    for t, row in enumerate(points):
        before = [str(t + 1), f"{t / rate:.5f}"] if head else []
        lines.append("\t".join([*before, *_texts(1000.0 * row, gap)]))
    return "\n".join(lines) + "\n"


def motive(points: Array, labels: Names, rate: float = 120.0, unit: str = "Millimeters", beside: bool = True) -> str:
    """The same y up, of a skeleton Ann. beside: with a rigid body, its marker and an unlabelled one."""
    scale = {"Millimeters": 1000.0, "Centimeters": 100.0, "Meters": 1.0}[unit]
    columns = [("Marker", f"Ann:{label}", "Position", axis) for label in labels for axis in "XYZ"]
    body = [("Rigid Body", "Cart", "Rotation", axis) for axis in "XYZW"]
    body += [("Rigid Body", "Cart", "Position", axis) for axis in "XYZ"]
    body += [("Rigid Body", "Cart", "Mean Marker Error", "")]
    body += [("Rigid Body Marker", "Cart:Marker1", "Position", axis) for axis in "XYZ"]
    loose = [("Marker", "Unlabeled 1189", "Position", axis) for axis in "XYZ"]
    all_ = [*body, *columns, *loose] if beside else columns
    types, names, kinds, axes = zip(*all_, strict=True)
    lines = [f"Format Version,1.23,Take Name,\"bend, slow\",Capture Frame Rate,{rate:.6f},Export Frame Rate,{rate:.6f},"
             f"Total Exported Frames,{len(points)},Rotation Type,Quaternion,Length Units,{unit}",
             "", ",".join(["", "Type", *types]), ",".join(["", "Name", *names]),
             ",".join(["", "ID", *['"4CF0B31A"'] * len(all_)]),
             ",".join(["", "", *kinds]), ",".join(["Frame", "Time (Seconds)", *axes])]  # fmt: skip
    for t, row in enumerate(points @ TO_Y_UP.T * scale):
        cells = _texts(row)
        if beside:
            cells = [*["0.1"] * 8, *["0.2"] * 3, *cells, *(["7"] * 3 if t < 3 else [""] * 3)]
        lines.append(",".join([str(t), f"{t / rate:.6f}", *cells]))
    return "\n".join(lines) + "\n"


def optitrack(points: Array, labels: Names, rate: float = 120.0, beside: bool = True) -> str:
    """The same in the rows of 1.1, in metres. A frame lists what it shows, in whatever order. beside: with two rigid
    bodies, of which each third frame loses one, and a marker without a name."""
    lines = ['comment,"OptiTrack Export Data"', 'comment,"== frame: a frame, of markers x, y, z, id, name"',
             "righthanded", "info,version,1.1", f"info,framecount,{len(points)}",
             f"info,rigidbodycount,{2 if beside else 0}"]  # fmt: skip
    if beside:
        lines += [f'rigidbody,"Cart, {k}",{k},3,' + ",".join(["0.01"] * 9) for k in (1, 2)]
    for t, row in enumerate(points @ TO_Y_UP.T):
        bodies = range(1, 3 - (t % 3 == 2)) if beside else ()
        cells = [f"{k}," + ",".join(["0.5"] * 10) for k in bodies]
        shown = [(label, point) for label, point in zip(labels, row, strict=True) if not np.isnan(point[0])]
        markers = [f"{','.join(_texts(point))},{k},{label}" for k, (label, point) in enumerate(shown)]
        markers = markers[t % 2 :] + markers[: t % 2] + (["0.1,0.2,0.3,99,"] if beside else [])
        lines.append(
            ",".join(["frame", str(t), f"{t / rate:.8f}", str(len(cells)), *cells, str(len(markers)), *markers])
        )
        if beside:
            lines.append(f'rigidbody,{t},{t / rate:.8f},"Cart, 1",1,0,3,' + ",".join(["0.1"] * 12) + ",NAN,NAN,NAN")
    return "\n".join(lines) + "\n"


def excel(table: str, blank: int = 0) -> str:
    """A table as Excel saves it where commas are decimal, with empty rows below."""
    lines = [line.replace(",", ";").replace(".", ",") for line in table.splitlines()]
    return "\r\n".join([*lines, *[";" * lines[-1].count(";")] * blank]) + "\r\n"


def nexus(points: Array, labels: Names, rate: float = 100.0, separator: str = ",", beside: bool = True) -> str:
    """beside: a section of a force plate before it, of model outputs behind it, and an unlabelled trajectory."""
    all_ = [*(f"Ann:{label}" for label in labels), *(["*12"] if beside else [])]
    wide = [""] * (1 + 3 * len(all_))
    rows = [["Trajectories", *wide], [f"{rate:g}", *wide],
            ["", "", *(cell for name in all_ for cell in (name, "", ""))],
            ["Frame", "Sub Frame", *["X", "Y", "Z"] * len(all_)], ["", "", *["mm"] * 3 * len(all_)]]  # fmt: skip
    for t, row in enumerate(1000.0 * points):
        rows.append([str(t + 31), "0", *_texts(row), *(["1.5"] * 3 if beside else [])])
    plate = [["Devices"], ["1000"], ["", "", "Plate - Force", "", ""], ["Frame", "Sub Frame", "Fx", "Fy", "Fz"],
             ["", "", "N", "N", "N"], ["31", "0", "0", "0", "-700"], ["31", "1", "0", "0", "-701"], []]  # fmt: skip
    models = [[], ["Model Outputs"], [f"{rate:g}"], ["", "", "Ann:LKneeAngles", "", ""],
              ["Frame", "Sub Frame", "X", "Y", "Z"],
              ["", "", "deg", "deg", "deg"], ["31", "0", "1", "2", "3"], []]  # fmt: skip
    kept = [*plate, *rows, *models] if beside else rows
    return "\n".join(separator.join(row) for row in kept) + "\n"


def plain(
    points: Array, labels: Names, rate: float = 100.0, name: str = "{label}_{axis}", unit: float = 1.0,
    clock: str = "time", separator: str = ",", gap: str = "", above: str = "", below: str = "",
) -> str:  # fmt: skip
    """name: of a column, of its label and axis. unit: of length [m]. clock: the first column, of times [s], of
    milliseconds or of frames as it is called; none where it is empty. above, below: rows beside that of names."""
    names = [name.format(label=label, axis=axis, small=axis.lower()) for label in labels for axis in "XYZ"]
    lines = [*above.splitlines(), separator.join([clock, *names] if clock else names), *below.splitlines()]
    for t, row in enumerate(points / unit):
        first = str(t + 1) if "frame" in clock.lower() else f"{t / rate * (1000.0 if 'ms' in clock else 1.0):.6f}"
        lines.append(separator.join([first, *_texts(row, gap)] if clock else _texts(row, gap)))
    return "\n".join(lines) + "\n"


SEGMENTS = (  # of MVN: name, parent, origin in its parent [m] in the T-pose: x ahead, y left, z up
    ("Pelvis", None, (0, 0, 0.95)), ("L5", "Pelvis", (0, 0, 0.1)), ("T8", "L5", (0, 0, 0.2)),
    ("Neck", "T8", (0, 0, 0.2)), ("Head", "Neck", (0, 0, 0.1)),
    ("RightShoulder", "T8", (0, -0.03, 0.15)), ("RightUpperArm", "RightShoulder", (0, -0.15, 0)),
    ("RightForeArm", "RightUpperArm", (0, -0.3, 0)), ("RightHand", "RightForeArm", (0, -0.25, 0)),
    ("LeftShoulder", "T8", (0, 0.03, 0.15)), ("LeftUpperArm", "LeftShoulder", (0, 0.15, 0)),
    ("LeftForeArm", "LeftUpperArm", (0, 0.3, 0)), ("LeftHand", "LeftForeArm", (0, 0.25, 0)),
    ("RightUpperLeg", "Pelvis", (0, -0.09, 0)), ("RightLowerLeg", "RightUpperLeg", (0, 0, -0.43)),
    ("RightFoot", "RightLowerLeg", (0, 0, -0.42)), ("RightToe", "RightFoot", (0.15, 0, -0.07)),
    ("LeftUpperLeg", "Pelvis", (0, 0.09, 0)), ("LeftLowerLeg", "LeftUpperLeg", (0, 0, -0.43)),
    ("LeftFoot", "LeftLowerLeg", (0, 0, -0.42)), ("LeftToe", "LeftFoot", (0.15, 0, -0.07)),
)  # fmt: skip
TIPS = {"Head": (0, 0, 0.2), "RightHand": (0, -0.15, 0), "LeftHand": (0, 0.15, 0), "RightToe": (0.06, 0, 0),
        "LeftToe": (0.06, 0, 0)}  # fmt: skip


def bent(angle: float, heading: float) -> tuple[Array, Array]:
    """(J, 3, 3) R_world_segment and (J, 3) [m] of somebody who faces `heading` and bends ahead at L5 and T8 by half of
    `angle` [rad] each."""
    names = [name for name, _, _ in SEGMENTS]
    turn, place = np.empty((len(names), 3, 3)), np.empty((len(names), 3))
    for j, (name, parent, offset) in enumerate(SEGMENTS):
        own = Rotation.from_euler("y", 0.5 * angle if name in ("L5", "T8") else 0.0)
        if parent is None:
            turn[j], place[j] = Rotation.from_euler("z", heading).as_matrix(), offset
        else:
            up = names.index(parent)
            turn[j] = turn[up] @ own.as_matrix()
            place[j] = place[up] + turn[up] @ np.array(offset)
    return turn, place


def mvnx(
    angles: Array,
    heading: float = 0.7,
    rate: float = 60.0,
    at_rest: bool = True,
    metres: float = 1.0,
    body: str = "FullBody",
) -> str:
    """(T,) [rad]. at_rest: with the calibration's frames. metres: in a unit of length. body: what of it
    was measured."""

    def frame(kind: str, index: str, time: float, turn: Array, place: Array) -> str:
        q = Rotation.from_matrix(turn).as_quat()[:, [3, 0, 1, 2]]
        known = f'index="{index}" ' if index else ""
        said = f'time="{time:.0f}" {known}tc="10:11:12:00" ms="1418227067039" type="{kind}"'
        turned, placed = " ".join(_texts(q)), " ".join(_texts(place / metres))
        return (f"<frame {said}><orientation>{turned}</orientation><position>{placed}</position>"
                "<velocity>0 0 0</velocity></frame>")  # fmt: skip

    segments, joints = [], []
    for k, (name, parent, _) in enumerate(SEGMENTS, start=1):
        on = {f"j{other}": of for other, above, of in SEGMENTS if above == name} or {"pTip": TIPS[name]}
        beside = {} if name in TIPS else {"pSkin": (0.9, 0.9, 0.9)}  # no joint, and farther than all
        points = "".join(f'<point label="{label}"><pos_b>{x} {y} {z}</pos_b></point>'
                         for label, (x, y, z) in {**beside, **on}.items())  # fmt: skip
        segments.append(f'<segment label={quoteattr(name)} id="{k}"><points>{points}</points></segment>')
        if parent is not None:
            joints.append(f'<joint label="j{name}"><connector1>{parent}/j{name}</connector1>'
                          f"<connector2>{name}/j{name}</connector2></joint>")  # fmt: skip
    still = bent(0.0, 0.0)
    frames = [frame(kind, "", 0.0, *still) for kind in (("identity", "tpose", "tpose-isb") if at_rest else ())]
    frames += [frame("normal", str(t), 1000.0 * t / rate, *bent(angle, heading)) for t, angle in enumerate(angles)]
    return ('<?xml version="1.0" encoding="UTF-8"?>\n<mvnx xmlns="http://www.xsens.com/mvn/mvnx" version="4">\n'
            f'<mvn version="2021.0"/>\n<subject label="Ann" frameRate="{rate:g}" configuration="{body}">\n'
            f"<segments>{''.join(segments)}</segments>\n<sensors><sensor label=\"Pelvis\"/></sensors>\n"
            f"<joints>{''.join(joints)}</joints>\n<frames segmentCount=\"{len(SEGMENTS)}\">\n"
            + "\n".join(frames) + "\n</frames></subject></mvnx>\n")  # fmt: skip
