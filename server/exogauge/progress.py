"""What a long computation says of itself while it runs: what it does, of what, and how far it is. No sentences."""

from __future__ import annotations

from enum import StrEnum
from functools import partial
from typing import Protocol, final


class Stage(StrEnum):
    """A part of an evaluation, or of a payload's identification, in the order of their beginning."""

    READING = "reading"
    POSTURES = "postures"
    KINEMATICS = "kinematics"
    EXCITATION = "excitation"
    MISSING = "missing"
    CONTACT = "contact"
    IDENTIFY = "identify"
    DISCREPANCY = "discrepancy"
    SUPPORT = "support"
    STIFFNESS = "stiffness"
    WRITING = "writing"


class Doing(StrEnum):
    """What is being done; `studies/words/progress_words.py` has the words."""

    OPENING_STUDY = "opening_study"
    READING_LOGS = "reading_logs"
    COMPARING_MOTIONS = "comparing_motions"
    EXAMINING_LOGS = "examining_logs"
    CHOOSING_BANDWIDTH = "choosing_bandwidth"
    FILTERING = "filtering"
    COLLECTING_EQUATIONS = "collecting_equations"
    ESTIMATING_UNCERTAINTY = "estimating_uncertainty"
    MAKING_LINKS_POSSIBLE = "making_links_possible"
    PREDICTING = "predicting"
    IDENTIFIED = "identified"
    LOOKING_FOR_STORED_FILTER = "looking_for_stored_filter"
    IDENTIFYING_FILTERED_ALIKE = "identifying_filtered_alike"
    LOOKING_FOR_CONTACT = "looking_for_contact"
    IDENTIFYING_WITHOUT_CONTACT = "identifying_without_contact"
    TRYING_EFFECTS = "trying_effects"
    ADDING_EFFECT = "adding_effect"
    COMPARED = "compared"
    GATHERING_RESIDUALS = "gathering_residuals"
    COMPARING_WORN = "comparing_worn"
    IDENTIFYING_BANDS = "identifying_bands"
    COMPARING_BAND_MODEL = "comparing_band_model"
    LOOKING_FOR_BAND_EFFECTS = "looking_for_band_effects"
    FINDING_POSTURES = "finding_postures"
    IDENTIFYING_STILL = "identifying_still"
    PLACING_IMU = "placing_imu"
    SMOOTHING_MOTION = "smoothing_motion"
    IDENTIFYING_MOVED = "identifying_moved"
    LOOKING_FOR_MISSING = "looking_for_missing"
    IDENTIFYING_AGAIN = "identifying_again"
    LOOKING_FOR_TOUCHES = "looking_for_touches"
    COMPARING_METHODS = "comparing_methods"
    WRITING_RESULTS = "writing_results"
    DONE = "done"


class Progress(Protocol):
    """share: 0…1. of: the log or device that it is done with, where there is one. May raise `Cancelled`."""

    def __call__(self, share: float, doing: Doing, of: str = "", /) -> None: ...


class Staged(Protocol):
    """The same of a computation that says itself at which stage it is."""

    def __call__(self, share: float, stage: Stage, doing: Doing, of: str = "", /) -> None: ...


def nobody(share: float, stage: Stage, doing: Doing, of: str = "") -> None:
    """Nobody watches the stages."""


def unwatched(share: float, doing: Doing, of: str = "") -> None:
    """Progress that nobody watches."""


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
