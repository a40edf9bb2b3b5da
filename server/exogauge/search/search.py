"""Forward step by step: try everything, add what explains most, identify again; then doubt what was added first.

Two effects at one place can look like a third before both are in the model. So where a place holds several, each of
the earlier ones is taken out once more, and whatever explains most beside the others takes its place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from exogauge.search.add import with_the_best
from exogauge.search.baseline import Ground
from exogauge.search.prune import identified_again, without_the_first_betters, without_what_is_not_needed
from exogauge.search.state import Problem, Search, Step


def searched(problem: Problem) -> Search:
    """All that may be named beside the base, one after the other."""
    search = _forward(Search(problem))
    if search.creeping.below:
        return search
    swapped = without_the_first_betters(search)
    return without_what_is_not_needed(search if swapped is None else _forward(swapped))


def resumed(search: Search, steps: Sequence[Step]) -> Search:
    """From what another search has named, or what is known better now, on."""
    return _forward(identified_again(search, steps))


def _forward(search: Search) -> Search:
    ground: Ground | None
    search, ground = search.screened(search.current)
    search = replace(search, first=search.first or ground)
    while ground is not None:
        search = replace(search, last=ground)
        search, ground = with_the_best(search, ground)
    return search
