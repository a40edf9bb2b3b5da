"""What an evaluation does while it runs, in words."""

from __future__ import annotations

from exogauge.progress import Doing

WORDS: dict[Doing, str] = {
    Doing.OPENING_STUDY: "opening the study",
    Doing.READING_LOGS: "reading the logs",
    Doing.COMPARING_MOTIONS: "comparing the motions with and without the device",
    Doing.EXAMINING_LOGS: "examining the logs",
    Doing.CHOOSING_BANDWIDTH: "choosing the bandwidth",
    Doing.FILTERING: "filtering and differentiating",
    Doing.COLLECTING_EQUATIONS: "collecting the equations",
    Doing.ESTIMATING_UNCERTAINTY: "estimating the uncertainty",
    Doing.MAKING_LINKS_POSSIBLE: "making every link physically possible",
    Doing.PREDICTING: "predicting",
    Doing.IDENTIFIED: "identified",
    Doing.LOOKING_FOR_STORED_FILTER: "looking for the band in which the logs were stored",
    Doing.IDENTIFYING_FILTERED_ALIKE: "identifying with both sides filtered alike",
    Doing.LOOKING_FOR_CONTACT: "looking for moments at which something touched the robot",
    Doing.IDENTIFYING_WITHOUT_CONTACT: "identifying without the moments at which something touched the robot",
    Doing.TRYING_EFFECTS: "trying what may be missing in",
    Doing.ADDING_EFFECT: "adding",
    Doing.COMPARED: "compared",
    Doing.GATHERING_RESIDUALS: "what is left in",
    Doing.COMPARING_WORN: "comparing",
    Doing.IDENTIFYING_BANDS: "identifying the bands",
    Doing.COMPARING_BAND_MODEL: "comparing with the band model",
    Doing.LOOKING_FOR_BAND_EFFECTS: "looking for effects of",
    Doing.FINDING_POSTURES: "finding the postures",
    Doing.IDENTIFYING_STILL: "identifying from postures",
    Doing.PLACING_IMU: "finding the axes and the delay of the IMU",
    Doing.SMOOTHING_MOTION: "smoothing the motion of",
    Doing.IDENTIFYING_MOVED: "identifying from motion",
    Doing.LOOKING_FOR_MISSING: "looking for what a rigid body lacks",
    Doing.IDENTIFYING_AGAIN: "identifying with what was found",
    Doing.LOOKING_FOR_TOUCHES: "looking for what touched the payload",
    Doing.COMPARING_METHODS: "comparing what three methods leave",
    Doing.WRITING_RESULTS: "writing the results",
    Doing.DONE: "done",
}


def phrase(doing: Doing, of: str = "") -> str:
    """`comparing bend_normal_1`"""
    return f"{WORDS[doing]} {of}".rstrip()
