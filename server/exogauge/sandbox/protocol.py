"""Names of the files through which parent and child speak, all in the child's own temporary folder."""

from __future__ import annotations

ANSWER = "answer.json"  # {"result": …}, {"error": class, "faults": […]}, or {"error": what stopped the child}
NO_ROOM = 28  # the child's exit code where the disk has no room for the answer
LOG = "log.parquet"  # the canonical table, written by the child
LOGS = "log-{}.parquet"  # the same where a child reads several logs, each by its place among them
URDF = "robot.urdf"  # the bytes to check, written by the parent
