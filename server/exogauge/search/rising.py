"""Progress that never falls, whatever share of the work each part of a search takes itself for."""

from __future__ import annotations

from functools import partial
from typing import final

from exogauge.progress import Doing, Progress

ALMOST = 0.99  # all is done when the search has ended, and not before


@final
class Rising:
    """Called as `Progress` is."""

    def __init__(self, progress: Progress) -> None:
        self._progress, self._done = progress, 0.0

    def __call__(self, share: float, doing: Doing, of: str = "") -> None:
        self._done = max(self._done, min(share, ALMOST))
        self._progress(self._done, doing, of)


def still(progress: Progress) -> Progress:
    """As it is told while all is sought once more."""
    return partial(_still, progress)


def _still(progress: Progress, _share: float, doing: Doing, of: str = "") -> None:
    progress(ALMOST, doing, of)
