"""What a long computation says of itself while it runs: what it does, of what, and how far it is. No sentences."""

from __future__ import annotations

from enum import StrEnum
from typing import Protocol


class Stage(StrEnum):
    """A part of an evaluation, in the order of their beginning."""

    READING = "reading"
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
    WRITING_RESULTS = "writing_results"
    DONE = "done"


class Progress(Protocol):
    """share: 0…1. of: the log or device that it is done with, where there is one. May raise `Cancelled`."""

    def __call__(self, share: float, doing: Doing, of: str = "", /) -> None: ...


def unwatched(share: float, doing: Doing, of: str = "") -> None:
    """Progress that nobody watches."""
