"""In which order findings are told: what closes the widest gap first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from exogauge.discrepancy.result import Finding

OF_THE_LOGS = ("band_limited_log", "contact")  # what was done about the recordings before anything else was sought
OF_THE_MAKER = ("kt_gain", "link_mass", "band_stiffness", "band_length")
SINCE = "since"  # a payload that came in the middle shows in residuals; one that was always there does not


def by_importance(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """First what was done about the recordings, then effects by how much of the held-out error they leave, least first,
    then numbers of the maker that are wrong, which leave no residual. Steps of the chain keep the order of addition."""

    def place(finding: Finding) -> tuple[int, float]:
        left = finding.held_out.rmse_after / max(finding.held_out.rmse_before, 1e-300)
        always = finding.effect == "payload" and SINCE not in finding.parameters
        if finding.effect in OF_THE_LOGS:
            return 0, float(finding.rank)
        return (2 if always or finding.effect in OF_THE_MAKER else 1), left if np.isfinite(left) else 1.0

    return tuple(replace(each, rank=number) for number, each in enumerate(sorted(findings, key=place), 1))
