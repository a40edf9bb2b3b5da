"""Doctor's rule on what is not in a log: signals that were low-passed before they were stored."""

from __future__ import annotations

from collections.abc import Iterator

from exogauge.logs.findings import Expectation, Finding, joint_channels
from exogauge.logs.model import Log
from exogauge.logs.stored_band import stored_edge


def stored_low_passed(log: Log, expected: Expectation) -> Iterator[Finding]:
    """One finding for all efforts: a recorder filters them alike."""
    edge = stored_edge(log)
    if edge is None:
        return
    kind = max(("tau.*", "i.*"), key=lambda each: len(joint_channels(log, each.partition(".")[0])))
    steep = (
        f"end at about {edge.hz:.2g} Hz: within an octave and a half their spectra fall by {edge.fall_db:.0f} dB, "
        "and no sensor's noise is left above"
    )
    gentle = f"fade with the positions: above {edge.hz:.2g} Hz the sensors' noise falls by {edge.fall_db:.0f} dB in all"
    detail = steep if edge.steep else gentle
    advice = (
        "log the signals as they are sampled. If these were low-passed before they were stored, friction looks soft "
        "where a joint turns round: run the step `discrepancy`, which filters the model alike, before you name anything"
    )
    yield Finding("warning", kind, "stored_low_passed", detail, advice, value=edge.hz)
