"""The child process that looks at a payload before it is kept: what its files hold, and what the doctor says of it.

Asked by `checking` in a temporary folder of its own.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from exogauge.sandbox.answering import Tasks

if TYPE_CHECKING:
    from exogauge.robots.tree import RigidTree

SENSOR = "sensor"  # as the columns of a wrench are called in a suggestion: ft.sensor.fx


def look(folder: str, robots: list[str], logs: list[str]) -> dict[str, Any]:
    """{robots, logs, faults}: joints and frames of each URDF; columns of each log, and what they may be.

    A file that cannot be read is told in `faults`, and the others are looked at all the same.
    """
    import pyarrow as pa

    from exogauge.errors import BadInput, Fault
    from exogauge.robots.urdf import load_whole
    from exogauge.studies.import_log.column_words import JointFacts, Wearer
    from exogauge.studies.import_log.log_preview import preview

    pa.set_cpu_count(1)
    looks, faults = list[dict[str, Any]](), list[Fault]()
    trees: dict[str, RigidTree] = {}
    for name in robots:
        try:
            trees[name] = load_whole((Path(folder) / name).read_bytes(), name)
        except BadInput as bad:
            faults += bad.faults
    facts = [
        JointFacts(name, *limits)
        for tree in trees.values()
        for name, *limits in zip(tree.joints, tree.lower, tree.upper, tree.velocity_limit, strict=True)
    ]
    wearer = Wearer(tuple(facts) or None, sole=SENSOR)
    for name in logs:
        try:
            looks.append(preview(Path(folder) / name, name, wearer))
        except BadInput as bad:
            faults += bad.faults
    return {
        "robots": [{"file": name, **robot(tree)} for name, tree in trees.items()],
        "logs": [{key: each[key] for key in ("file", "rows", "columns")} for each in looks],
        "faults": [vars(fault) for fault in faults],
    }


def robot(tree: RigidTree) -> dict[str, Any]:
    """Joints in the URDF's order, with the limits that it states, and the frames that a sensor may have."""
    from math import isfinite

    limits = zip(tree.joints, tree.lower, tree.upper, tree.velocity_limit, tree.effort_limit, strict=True)
    keys = ("lower", "upper", "velocity", "effort")
    return {
        "joints": [
            {"name": name} | {key: float(x) if isfinite(x) else None for key, x in zip(keys, values, strict=True)}
            for name, *values in limits
        ],
        "frames": list(tree.frames),
        "fixed": [name for name, (body, _) in tree.frames.items() if body == -1],
    }


def examine(folder: str) -> dict[str, Any]:
    """The doctor's findings of the payload in `folder`, which was checked before."""
    from dataclasses import asdict

    from exogauge.payload import doctor
    from exogauge.payload.intake import open_payload

    opened = open_payload(Path(folder))
    return {"findings": [{"log": log, **asdict(each)} for log, each in doctor.examine(opened)]}


TASKS: Tasks = {"look": look, "examine": examine}
LOADED = (
    "exogauge.payload.doctor",
    "exogauge.payload.intake",
    "exogauge.robots.urdf",
    "exogauge.studies.import_log.log_preview",
)
