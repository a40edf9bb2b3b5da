"""In which order findings are told: what closes the widest gap first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from exogauge.findings.result import Finding

OF_THE_LOGS = ("band_limited_log", "contact")  # what was done about the recordings before anything else was sought


def by_importance(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """First what was done about the recordings, then effects by what they take off the held-out error, in noise floors
    of the channel that shows them most. Of a number of the maker that is the error that it alone would make. Steps of
    the chain keep the order of addition."""

    def place(finding: Finding) -> tuple[int, float]:
        if finding.effect in OF_THE_LOGS:
            return 0, float(finding.rank)
        held = finding.held_out
        gone = np.sqrt(max(held.rmse_before**2 - held.rmse_after**2, 0.0)) / max(held.noise_floor, 1e-12)
        return 1, -float(gone) if np.isfinite(gone) else 0.0

    return tuple(replace(each, rank=number) for number, each in enumerate(sorted(findings, key=place), 1))
