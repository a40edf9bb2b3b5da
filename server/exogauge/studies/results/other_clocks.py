"""Logs whose efforts are of another clock than their positions: neither fitted nor judged by, where others are left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from exogauge.identification.settings import Recording
from exogauge.plausibility.examine import OTHER_CLOCK
from exogauge.remarks import About, Remark
from exogauge.studies.words.notices import Notice, notice


def without_other_clocks(
    recordings: Sequence[Recording], findings: Sequence[Mapping[str, Any]], kept: frozenset[str]
) -> tuple[list[Recording], list[Notice]]:
    """The recordings that are used, and what is told of the others. findings: of the doctor. kept: recordings
    that stay, as runs with the device are compared with them.

    All stay where no fitted log would be left.
    """
    late = {each["log"]: float(each["value"]) for each in findings if each["rule"] == OTHER_CLOCK}
    gone = [each for each in recordings if each.log.name in late and each.log.recording not in kept]
    used = [each for each in recordings if each not in gone]
    if not gone or all(each.held_out for each in used):
        return list(recordings), []
    names = tuple(each.log.name for each in gone)
    remark = Remark(About.LOGS_LEFT_OUT, names, tuple((late[name],) for name in names))
    return used, [notice(remark)]
