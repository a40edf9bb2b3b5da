"""How parent and child speak: names of files in the child's own temporary folder, and what the fork server says."""

from __future__ import annotations

import struct

ANSWER = "answer.json"  # {"result": …}, {"error": class, "faults": […]}, or {"error": what stopped the child}
NO_ROOM = 28  # the child's exit code where the disk has no room for the answer
LOG = "log.parquet"  # the canonical table, written by the child
LOGS = "log-{}.parquet"  # the same where a child reads several logs, each by its place among them
URDF = "robot.urdf"  # the bytes to check, written by the parent

REQUEST_BYTES = 1 << 16  # of what the fork server is asked: a module's name and a folder, of 4096 bytes at most
TOLD = struct.Struct("<ii")  # a reader's process id and exit code, the latter 0 at its beginning
FORK_ERROR = 0  # in place of the process id, with the error's number: it could not be started
