"""The child process that reads a log, a few logs or a URDF.

Asked in a temporary folder of its own. What it imports, it imports for its
task alone, after its limits are set (`answering`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from exogauge.sandbox.answering import Tasks, answer
from exogauge.sandbox.protocol import LOG, LOGS, URDF


def _log(
    name: str,
    paths: Mapping[str, str],
    mapping: dict[str, Any] | None,
    joints: Sequence[str],
    motor_from_joint: Sequence[Sequence[float]] | None,
    rows: tuple[int, int] | None,
    allow_gaps: bool,
    left_out: str | None,
    out: str = LOG,
) -> dict[str, Any]:
    import numpy as np
    import pyarrow as pa

    from exogauge.logs.mapping import read_mapped
    from exogauge.logs.mapping_rules import LogMapping
    from exogauge.logs.parquet_table import write_log
    from exogauge.logs.reading import read_log

    pa.set_cpu_count(1)
    rows = None if rows is None else (int(rows[0]), int(rows[1]))
    if mapping is None:
        ((file, path),) = paths.items()
        log = read_log(Path(path), name, rows, file=file, allow_gaps=allow_gaps, left_out=left_out)
    else:
        log = read_mapped(
            {file: Path(path) for file, path in paths.items()},
            LogMapping.from_plain(mapping),
            joints=joints,
            motor_from_joint=None if motor_from_joint is None else np.array(motor_from_joint, dtype=np.float64),
            name=name,
            rows=rows,
            allow_gaps=allow_gaps,
        )
    write_log(log, Path(out))
    return {
        "channels": list(log.channels),
        "samples": log.samples,
        "rate_hz": log.rate_hz,
        "t0": float(log.time[0]),
        "t1": float(log.time[-1]),
        "notes": [vars(note) for note in log.notes],
    }


def _logs(logs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Each log as `_log` gives it, under a name of its own; None for one that gives nothing, whatever the reason."""
    return {"logs": [answer(_log, {**each, "out": LOGS.format(k)}).get("result") for k, each in enumerate(logs)]}


def _robot(
    joints: Sequence[str] | None, base_link: str, floating: bool, cut_frames: Sequence[str], file: str
) -> dict[str, Any]:
    from exogauge.robots.urdf import load_tree
    from exogauge.robots.urdf_check import check_urdf

    urdf = Path(URDF).read_bytes()
    check_urdf(urdf, file)
    if joints is None:
        return {"bodies": [], "joints": [], "mass": None}
    tree = load_tree(urdf, joints=joints, base_link=base_link, floating=floating, cut_frames=cut_frames, file=file)
    return {"bodies": list(tree.bodies), "joints": list(tree.joints), "mass": tree.mass}


TASKS: Tasks = {"log": _log, "logs": _logs, "robot": _robot}
LOADED = ("exogauge.logs.mapping", "exogauge.logs.parquet_table", "exogauge.logs.reading")
