"""Progress that never falls, whatever share of the work each part of a search takes itself for."""

from __future__ import annotations

from functools import partial
from typing import final

from exogauge.identification.settings import Progress

ALMOST = 0.99  # all is done when the search has ended, and not before


@final
class Rising:
    """Called with a share of the work and a phrase."""

    def __init__(self, progress: Progress) -> None:
        self._progress, self._done = progress, 0.0

    def __call__(self, share: float, phrase: str) -> None:
        self._done = max(self._done, min(share, ALMOST))
        self._progress(self._done, phrase)


def still(progress: Progress) -> Progress:
    """As it is told while all is sought once more."""
    return partial(_still, progress)


def _still(progress: Progress, _fraction: float, phrase: str) -> None:
    progress(ALMOST, phrase)
