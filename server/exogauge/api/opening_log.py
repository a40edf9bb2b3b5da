"""The child process that takes a first look at a foreign log, and reads the mapping that somebody wrote for it.

Asked by `imports` in a temporary folder of its own.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from exogauge.sandbox.answering import Tasks

MAPPING = "mapping.yaml"


def look(folder: str, file: str, robot: str | None, mapping: str | None) -> dict[str, Any]:
    """What `log_preview.preview` says of log/`file` in the folder, and `judged` of a mapping. robot: its file there."""
    import pyarrow as pa

    from exogauge.studies.import_log.log_preview import preview, wearer

    pa.set_cpu_count(1)
    here = Path(folder)
    path = here / "log" / file
    described = entry = None
    if robot is not None:
        from exogauge.studies.intake.bundle import Bundle
        from exogauge.studies.intake.robot_file import read_robot

        described, entry, _ = read_robot(Bundle(here / "robot", robot), robot)
    if mapping is None:
        return preview(path, file, wearer(described)) | {"given": None}
    given, layout = judge(path, file, described, entry, (here / mapping).read_bytes())
    return preview(path, file, wearer(described), layout) | {"given": given}


def judge(path: Path, file: str, described: Any, entry: Any, text: bytes) -> tuple[dict[str, Any], Any]:
    """What becomes of the mapping `text`, and the layout that it gives the file, None where it gives none."""
    import numpy as np

    from exogauge.api.opening import joints_of
    from exogauge.errors import BadInput
    from exogauge.logs.findings import Expectation
    from exogauge.logs.tables import TextLayout
    from exogauge.studies.import_log.log_preview import NO_LOG, judged
    from exogauge.studies.intake.expected import expectation
    from exogauge.studies.intake.mapping_file import parse_mapping
    from exogauge.studies.intake.read_log import known_gears
    from exogauge.studies.intake.robot_file import motor_from_joint

    try:
        rules = parse_mapping(text, MAPPING)
        joints = joints_of(rules) if entry is None else [joint.name for joint in entry.joints]
        gears = np.eye(len(joints)) if entry is None else known_gears(rules, entry, motor_from_joint(entry), MAPPING)
    except BadInput as bad:
        return NO_LOG | {"faults": [vars(fault) for fault in bad.faults]}, None
    layout = rules.files[0].layout if len(rules.files) == 1 and rules.files[0].layout != TextLayout() else None
    expected = Expectation() if described is None else expectation(described)
    return judged(path, file, rules, joints, gears, expected), layout


def mapping(folder: str, file: str, joints: list[str] | None) -> dict[str, Any]:
    """The mapping `file` as plain content, after its own check and that of the joints it names."""
    import yaml

    from exogauge.api.opening import joints_of
    from exogauge.errors import BadStudy, Fault
    from exogauge.studies.intake.mapping_file import parse_mapping

    text = (Path(folder) / file).read_bytes()
    rules = parse_mapping(text, MAPPING)
    known = joints_of(rules) if joints is None else joints
    listed = ", ".join(known[:40])
    faults = [
        Fault("the robot has no such joint", "unknown_joint", f"Joints: {listed}.", MAPPING, value=name)
        for name in joints_of(rules)
        if name not in known
    ]
    if faults:
        raise BadStudy(faults)
    return {"content": yaml.safe_load(text)}


TASKS: Tasks = {"look": look, "mapping": mapping}
LOADED = ("exogauge.studies.import_log.log_preview", "exogauge.studies.intake.expected")
