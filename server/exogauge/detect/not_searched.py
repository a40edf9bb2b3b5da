"""What is told of an identification where nothing is searched for: numbers that the logs contradict are let go, and
what no model explains makes doubtful what is fitted beside it. A search names what it can first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from exogauge.detect.nominal.let_go import let_go
from exogauge.identification.result import Identification
from exogauge.identification.settings import Recording, Settings
from exogauge.progress import unwatched
from exogauge.remarks import About, Remark
from exogauge.search.baseline import lay_ground
from exogauge.search.declared import left_over
from exogauge.search.final_numbers import with_doubt_of_what_is_left


def not_searched(found: Identification, recordings: Sequence[Recording], settings: Settings) -> Identification:
    """As doubtful as what is wrong in it, and left over by it, makes it, and told."""
    found = let_go(found, recordings, settings)
    ground = lay_ground(found.model, recordings, (), unwatched)
    left, _ = left_over(found, ground.residuals, recordings)
    if not left:
        return found
    doubted = with_doubt_of_what_is_left(found, left)
    channels, above = tuple(each.channel for each in left), tuple((each.rmse / each.noise_floor,) for each in left)
    return replace(doubted, remarks=(*doubted.remarks, Remark(About.LEFT_WITHOUT_SEARCH, channels, above)))
