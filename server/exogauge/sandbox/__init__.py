"""The only place where a stranger's file is opened: a short-lived child process with little memory and time."""

from exogauge.sandbox.batches import parse_logs, read_each
from exogauge.sandbox.parent import (
    LogRequest,
    LogSummary,
    RobotRequest,
    RobotSummary,
    canonicalise,
    check_robot,
    parse_log,
)

__all__ = [
    "LogRequest",
    "LogSummary",
    "RobotRequest",
    "RobotSummary",
    "canonicalise",
    "check_robot",
    "parse_log",
    "parse_logs",
    "read_each",
]
