"""Logs with a device, filtered as those without it were found to have been stored."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from exogauge.criteria.stored_filter import StoredFilter
from exogauge.identification.settings import Recording
from exogauge.logs.stored_band import stored_edge
from exogauge.support.settings import WornLog


def filtered_alike(
    worn: Sequence[WornLog], recordings: Sequence[Recording], criteria: StoredFilter
) -> tuple[WornLog, ...]:
    """recordings: without a device, with the band that was found in them, if any (`band_limits`).

    A log with a device gets the same band where its spectrum ends where theirs do: bands pull as slowly as the robot
    moves, so an end of the spectrum that is the recorder's own is seen with them on as well. Which cut-off it is cannot
    be found from such a log by itself, because no model of the wear is known yet.
    """
    limited = [each.log for each in recordings if each.log.stored is not None]
    if not limited:
        return tuple(worn)
    edges = [edge.hz for edge in map(stored_edge, limited) if edge]
    middle, stored = float(np.median(edges)), limited[0].stored

    def alike(each: WornLog) -> bool:
        edge = stored_edge(each.log)
        return edge is not None and middle / criteria.alike < edge.hz < middle * criteria.alike

    return tuple(replace(each, log=replace(each.log, stored=stored)) if alike(each) else each for each in worn)
