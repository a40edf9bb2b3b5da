"""The child process that reads what was captured of a person, or a plan's motion on its robot.

Asked by `captures` in a temporary folder of its own, where it leaves
files; the rest is its answer.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from exogauge.sandbox.answering import Tasks

SERIES, EXPORT = "motion.parquet", "export.zip"
MOST_NAMES = 500  # labels that are listed


def capture(folder: str) -> dict[str, Any]:
    """What motion.yaml in `folder` says, as it is read: frames, what it holds, what was guessed, when feet stand."""
    import numpy as np

    from exogauge.motion.intake import open_capture, spans_of
    from exogauge.motion.summary import summarise

    read = open_capture(Path(folder))
    motion = read.motion
    told = summarise(motion)
    shown = ("name", "frames", "rate_hz", "seconds")
    labels: tuple[str, ...] = ()
    segment: dict[str, Any] = {}
    gaps: dict[str, float] = {}
    if motion.markers is not None:
        labels, segment = motion.markers.labels, dict(motion.markers.segment)
        share = (~np.isfinite(motion.markers.position[..., 0])).mean(axis=0)
        gaps = {label: float(x) for label, x in zip(labels, share, strict=True) if x > 0.0}
    elif motion.tree is not None:
        labels, segment = motion.tree.names, dict(motion.tree.segment)
    elif motion.angles is not None:
        labels = motion.angles.names
    feet = motion.contacts
    return {
        **{key: told[key] for key in shown},
        "holds": "markers" if motion.markers else "skeleton" if motion.tree else "angles",
        "static": read.static is not None,
        "labels": [{"name": label, "segment": segment.get(label), "gaps": gaps.get(label, 0.0)}
                   for label in labels[:MOST_NAMES]],
        "told": {key: value for key, value in told.items() if key not in shown},
        "contacts": None if feet is None else {
            "left": spans_of(motion.time, feet.left), "right": spans_of(motion.time, feet.right)},
    }  # fmt: skip


def series(folder: str) -> dict[str, Any]:
    """The capture in `folder` as a series file."""
    import pyarrow as pa

    from exogauge.motion.channels import of_motion
    from exogauge.motion.intake import open_capture
    from exogauge.studies.series.write import write_table

    pa.set_cpu_count(1)
    write_table(of_motion(open_capture(Path(folder)).motion), Path(SERIES))
    return {}


def export(folder: str, motion: str, name: str, form: str, rate_hz: float | None, broken: list[str]) -> dict[str, Any]:
    """The table `motion` of the robot in `folder` in another format, judged at a rate, with what tells of it, as a zip.

    broken: what the plan broke already; it marks the files, whatever is found at this rate.
    """
    import json
    import zipfile
    from dataclasses import replace

    from exogauge.errors import BadMotion, Fault
    from exogauge.motion.plan.export import FORMATS, exported, sheet
    from exogauge.motion.plan.judge import judge
    from exogauge.motion.plan.written import read_written, swing
    from exogauge.motion.robot_file import load_motion_robot
    from exogauge.robots.moving.standing import standing

    if form not in FORMATS:
        known = f"One of {', '.join(FORMATS)}"
        raise BadMotion(Fault("there is no such format", "unknown_format", known, None, None, "format", form))
    robot = load_motion_robot(Path(folder) / "robot.yaml")
    table = Path(motion)
    written = read_written(robot, table)
    judged = judge(robot, written, standing(robot), rate=rate_hz, planned=written)
    judged = replace(judged, broken=tuple(dict.fromkeys((*broken, *judged.broken))))
    files = {name + end: data for end, data in exported(robot, written, judged, form).items()}
    told = sheet(robot, judged, form, files, {table.name: table.read_bytes()})
    if (beyond := swing(robot, written, judged.time, judged.q)) is not None:
        told["between_the_rows"] = beyond
    files[f"{name}.json"] = (json.dumps(told, indent=1, ensure_ascii=False) + "\n").encode()
    with zipfile.ZipFile(EXPORT, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in files.items():
            archive.writestr(path, data)
    return {"broken": list(judged.broken)}


TASKS: Tasks = {"capture": capture, "series": series, "export": export}
LOADED = ("exogauge.motion.intake", "exogauge.motion.summary")
