"""The child process that reads what a what-if needs of an uploaded study: one log's positions, the robot, the device.

Asked by `benches` in a temporary folder of its own, where it leaves the
positions as bare numbers; the rest is its answer.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from exogauge.sandbox.answering import Tasks

MOTION = "motion.f64"  # time and positions, sample by sample, as float64


def motion(folder: str, log: str, device: str | None, most: int) -> dict[str, Any]:
    """log, device: as for `read_motion`. most: samples."""
    import numpy as np

    from exogauge.robots.plain_tree import to_plain
    from exogauge.studies.device_pages.device_content import device_content
    from exogauge.studies.intake.bundle import Bundle
    from exogauge.studies.series.recorded_motion import read_motion

    read = read_motion(Bundle(Path(folder), "study.yaml"), log, device, most)
    np.column_stack([read.time, read.q]).tofile(MOTION)
    return {
        "tree": to_plain(read.tree),
        "device": device_content(read.device),
        "device_file": read.device_file,
        "log": read.log,
        "samples": len(read.time),
        "of_samples": read.of_samples,
        "every": read.every,
        "cutoff_hz": read.cutoff_hz,
    }


TASKS: Tasks = {"motion": motion}
LOADED = (
    "exogauge.robots.plain_tree",
    "exogauge.studies.device_pages.device_content",
    "exogauge.studies.series.recorded_motion",
)
